#include "remaps/image/image_encoding.h"

#include <ImathBox.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace remaps::image {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

/// Grows a string, at a position of its own.
class StringStream final : public Imf::OStream {
 public:
  StringStream() : OStream("image") {}

  void write(const char* data, int n) override {
    const auto bytes = static_cast<std::size_t>(n);
    if (at_ + bytes > text_.size()) text_.resize(at_ + bytes);
    std::memcpy(text_.data() + at_, data, bytes);
    at_ += bytes;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t at) override { at_ = at; }
  std::string release() { return std::move(text_); }

 private:
  std::string text_;
  std::size_t at_ = 0;
};

std::uint32_t to_integer(float value, float low, const IntegerRange& range) {
  const float most = range.bits == 8 ? 255.0f : 65535.0f;
  const float scaled = range.range > 0 ? (value - low) / range.range * most : 0.0f;
  return static_cast<std::uint32_t>(std::lround(std::clamp(scaled, 0.0f, most)));
}

/// A row as PNG has it: highest byte first.
void pack_row(const Image& image, std::uint32_t row, const IntegerRange& range,
              std::vector<png_byte>& out) {
  out.clear();
  const float* from = image.value.data() + std::size_t{3} * image.width * row;
  for (std::size_t i = 0; i < std::size_t{3} * image.width; ++i) {
    const std::uint32_t n = to_integer(from[i], range.low[i % 3], range);
    if (range.bits == 16) out.push_back(static_cast<png_byte>(n >> 8));
    out.push_back(static_cast<png_byte>(n & 0xFF));
  }
}

void append(png_structp png, png_bytep data, std::size_t n) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), n);
}

/// All that may jump out of libpng, with nothing in it that must be destroyed.
bool write_png(png_structp png, png_infop info, const Image& image, const IntegerRange& range,
               std::vector<png_byte>& row, std::array<png_text, 2>& text) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_IHDR(png, info, image.width, image.height, static_cast<int>(range.bits),
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_text(png, info, text.data(), static_cast<int>(text.size()));
  png_write_info(png, info);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    pack_row(image, y, range, row);
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

std::string encode_png(const Image& image, const IntegerRange& range) {
  std::string result;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr) {
    png_destroy_write_struct(&png, nullptr);
    throw std::bad_alloc();
  }
  png_set_write_fn(png, &result, append, nullptr);
  std::string low = fmt::format("{} {} {}", range.low[0], range.low[1], range.low[2]);
  std::string width = fmt::format("{}", range.range);
  std::array<png_text, 2> text{};
  char low_key[] = "remaps:low", range_key[] = "remaps:range";
  text[0].compression = text[1].compression = PNG_TEXT_COMPRESSION_NONE;
  text[0].key = low_key;
  text[0].text = low.data();
  text[0].text_length = low.size();
  text[1].key = range_key;
  text[1].text = width.data();
  text[1].text_length = width.size();
  std::vector<png_byte> row;
  row.reserve(std::size_t{6} * image.width);
  const bool done = write_png(png, info, image, range, row, text);
  png_destroy_write_struct(&png, &info);
  if (!done) throw std::runtime_error("libpng refuses the image");
  return result;
}

std::string encode_exr(const Image& image) {
  StringStream stream;
  {
    Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer frame;
    // OpenEXR takes the pixels as not const and does not change them.
    char* const base = const_cast<char*>(reinterpret_cast<const char*>(image.value.data()));
    for (std::size_t c = 0; c < 3; ++c) {
      const std::string name(1, image.channels[c]);
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      frame.insert(name, Imf::Slice(Imf::FLOAT, base + c * sizeof(float), 3 * sizeof(float),
                                    3 * sizeof(float) * image.width));
    }
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(frame);
    file.writePixels(static_cast<int>(image.height));
  }
  return stream.release();
}

std::string encode_npy(const Image& image) {
  std::string header =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}, 3), }}",
                  image.height, image.width);
  constexpr std::size_t kBefore = 10, kUnit = 64;
  header.resize((header.size() + kBefore + 1 + kUnit - 1) / kUnit * kUnit - kBefore - 1, ' ');
  header += '\n';
  std::string result("\x93NUMPY\x01\x00", 8);
  result += static_cast<char>(header.size() & 0xFF);
  result += static_cast<char>(header.size() >> 8);
  result += header;
  result.append(reinterpret_cast<const char*>(image.value.data()),
                image.value.size() * sizeof(float));
  return result;
}

}  // namespace remaps::image
