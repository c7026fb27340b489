#include "remaps/image/image_encoding.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace remaps::image {
namespace {

/// 5 x 3 pixels, all numbers different.
Image small_image() {
  Image image;
  image.width = 5;
  image.height = 3;
  for (int i = 0; i < 45; ++i) image.value.push_back(static_cast<float>(std::sin(i * 1.7)) * 1.25f);
  return image;
}

class ByteStream final : public Imf::IStream {
 public:
  explicit ByteStream(const std::string& bytes) : IStream("bytes"), bytes_(bytes) {}
  bool read(char* to, int n) override {
    std::memcpy(to, bytes_.data() + at_, static_cast<std::size_t>(n));
    at_ += static_cast<std::size_t>(n);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t at) override { at_ = at; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

TEST(ImageEncoding, ExrHasEveryBit) {
  const Image image = small_image();
  const std::string bytes = encode_exr(image);
  ByteStream stream(bytes);
  Imf::InputFile file(stream);
  ASSERT_EQ(file.header().dataWindow().max.x, 4);
  ASSERT_EQ(file.header().dataWindow().max.y, 2);
  std::vector<float> value(45);
  Imf::FrameBuffer frame;
  const char* const names[] = {"X", "Y", "Z"};
  for (std::size_t c = 0; c < 3; ++c) {
    frame.insert(names[c],
                 Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(value.data() + c), 12, 60));
  }
  file.setFrameBuffer(frame);
  file.readPixels(0, 2);
  EXPECT_EQ(value, image.value);
}

TEST(ImageEncoding, NpyIsAHeaderAndTheNumbers) {
  const Image image = small_image();
  const std::string bytes = encode_npy(image);
  const std::size_t data = bytes.size() - 45 * sizeof(float);
  EXPECT_EQ(data % 64, 0u);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  EXPECT_EQ(static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]),
            data - 10);
  EXPECT_NE(bytes.find("'descr': '<f4', 'fortran_order': False, 'shape': (3, 5, 3)"),
            std::string::npos);
  EXPECT_EQ(bytes[data - 1], '\n');
  EXPECT_EQ(std::memcmp(bytes.data() + data, image.value.data(), 45 * sizeof(float)), 0);
}

struct DecodedPng {
  unsigned width = 0, height = 0, bits = 0;
  std::vector<unsigned> value;
};

DecodedPng decode_png(const std::string& bytes) {
  DecodedPng result;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0);
  result.width = image.width;
  result.height = image.height;
  result.bits = static_cast<unsigned char>(bytes[24]);
  // Raw numbers, without gamma: what the file has as 8 bits an encoded channel.
  image.format = PNG_FORMAT_RGB;
  std::vector<unsigned char> raw(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, raw.data(), 0, nullptr), 0);
  result.value.assign(raw.begin(), raw.end());
  return result;
}

TEST(ImageEncoding, PngRoundsIntoItsRange) {
  const Image image = small_image();
  const IntegerRange range{8, {-1, -1, -1}, 2};
  const DecodedPng png = decode_png(encode_png(image, range));
  EXPECT_EQ(png.width, 5u);
  EXPECT_EQ(png.height, 3u);
  EXPECT_EQ(png.bits, 8u);
  ASSERT_EQ(png.value.size(), 45u);
  for (std::size_t i = 0; i < 45; ++i) {
    const float expected = std::clamp((image.value[i] + 1) / 2 * 255, 0.0f, 255.0f);
    EXPECT_NEAR(static_cast<float>(png.value[i]), expected, 0.501);
  }
}

TEST(ImageEncoding, PngOf16BitsSaysItsRange) {
  const std::string bytes = encode_png(small_image(), {16, {-1.5, 0.25, 2}, 3});
  EXPECT_EQ(bytes[24], 16);
  EXPECT_NE(bytes.find(std::string("remaps:low\0-1.5 0.25 2", 22)), std::string::npos);
  EXPECT_NE(bytes.find(std::string("remaps:range\0003", 14)), std::string::npos);
}

TEST(ImageEncoding, ARangeOfNothingIsZeros) {
  Image image = small_image();
  std::fill(image.value.begin(), image.value.end(), 7.0f);
  const DecodedPng png = decode_png(encode_png(image, {8, {7, 7, 7}, 0}));
  EXPECT_EQ(png.value, std::vector<unsigned>(45, 0));
}

}  // namespace
}  // namespace remaps::image
