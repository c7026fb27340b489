#include "remaps/formats/gltf_accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

constexpr std::size_t kMostElements = 8192;
constexpr std::size_t kReplacements = 4096;

GltfComponent component_of(const GltfValue& value) {
  const std::uint64_t number = value.whole();
  for (const GltfComponent known : {GltfComponent::i8, GltfComponent::u8, GltfComponent::i16,
                                    GltfComponent::u16, GltfComponent::u32, GltfComponent::f32}) {
    if (number == static_cast<std::uint64_t>(known)) return known;
  }
  value.fail(fmt::format("expected a componentType (5120 to 5123, 5125, 5126), found {}", number));
}

/// Elements of a stride that a piece holds.
std::size_t elements_in_piece(std::size_t piece_bytes, std::uint64_t stride) {
  return std::clamp<std::size_t>(piece_bytes / static_cast<std::size_t>(stride), 1, kMostElements);
}

/// Reads n elements of an array, gaps left out.
void read_packed(const std::vector<GltfBuffer>& buffers, const GltfArray& array,
                 std::uint64_t first, std::size_t n, std::size_t element_bytes,
                 std::vector<char>& raw, std::vector<char>& packed) {
  packed.resize(n * element_bytes);
  if (n == 0) return;
  const GltfBuffer& buffer = buffers[array.buffer];
  const std::uint64_t begin = array.begin + first * array.stride;
  if (array.stride == element_bytes) {
    buffer.read(begin, packed);
    return;
  }
  const auto stride = static_cast<std::size_t>(array.stride);
  raw.resize((n - 1) * stride + element_bytes);
  buffer.read(begin, raw);
  for (std::size_t i = 0; i < n; ++i) {
    std::memcpy(packed.data() + i * element_bytes, raw.data() + i * stride, element_bytes);
  }
}

}  // namespace

std::size_t size_of(GltfComponent component) {
  switch (component) {
    case GltfComponent::i8:
    case GltfComponent::u8:
      return 1;
    case GltfComponent::i16:
    case GltfComponent::u16:
      return 2;
    default:
      return 4;
  }
}

std::uint64_t load_index(const char* from, GltfComponent component) {
  switch (size_of(component)) {
    case 1:
      return static_cast<std::uint8_t>(*from);
    case 2: {
      std::uint16_t value = 0;
      std::memcpy(&value, from, sizeof value);
      return value;
    }
    default: {
      std::uint32_t value = 0;
      std::memcpy(&value, from, sizeof value);
      return value;
    }
  }
}

GltfAccessor GltfAccessorReader::read(const GltfValue& json, std::string_view type) {
  GltfAccessor accessor;
  accessor.place = json.place();
  const GltfValue found = json.require("type");
  if (found.text() != type) found.fail(fmt::format("expected {}, found {}", type, found.text()));
  accessor.components = type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
  accessor.component = component_of(json.require("componentType"));
  const std::optional<GltfValue> normalized = json.find("normalized");
  accessor.normalized = normalized && normalized->flag();
  accessor.count = json.require("count").whole();
  if (accessor.count == 0) json.require("count").fail("expected at least 1, found 0");
  if (!json.find("bufferView")) {
    json.fail(
        "expected a bufferView: an array that is all zeros, or compressed by an extension, "
        "makes no surface");
  }
  accessor.base = read_array(json, accessor.count, accessor.element_bytes());
  if (const std::optional<GltfValue> sparse = json.find("sparse")) {
    accessor.sparse = read_sparse(*sparse, accessor);
  }
  return accessor;
}

GltfAccessor::Sparse GltfAccessorReader::read_sparse(const GltfValue& json,
                                                     const GltfAccessor& accessor) {
  GltfAccessor::Sparse sparse;
  const GltfValue count = json.require("count");
  sparse.count = count.whole();
  if (sparse.count > accessor.count) {
    count.fail(fmt::format("expected at most the {} elements of the accessor, found {}",
                           accessor.count, sparse.count));
  }
  if (sparse.count == 0) return sparse;
  const GltfValue indices = json.require("indices");
  const GltfValue type = indices.require("componentType");
  sparse.index_type = component_of(type);
  if (sparse.index_type != GltfComponent::u8 && sparse.index_type != GltfComponent::u16 &&
      sparse.index_type != GltfComponent::u32) {
    type.fail("expected an unsigned type (5121, 5123 or 5125)");
  }
  sparse.indices = read_array(indices, sparse.count, size_of(sparse.index_type));
  sparse.values = read_array(json.require("values"), sparse.count, accessor.element_bytes());
  return sparse;
}

/// The array that bufferView and byteOffset of an accessor, or of a part of it, tell.
GltfArray GltfAccessorReader::read_array(const GltfValue& holder, std::uint64_t count,
                                         std::size_t element_bytes) {
  const GltfValue reference = holder.require("bufferView");
  const View view = read_view(reference.element(file_.root(), "bufferViews"));
  const std::uint64_t offset = holder.count("byteOffset", 0);
  const std::uint64_t stride = view.stride != 0 ? view.stride : element_bytes;
  if (stride < element_bytes) {
    reference.fail(fmt::format("its view has a byteStride of {}, less than an element of {} bytes",
                               stride, element_bytes));
  }
  const std::uint64_t left = offset <= view.bytes ? view.bytes - offset : 0;
  if (left < element_bytes || count - 1 > (left - element_bytes) / stride) {
    holder.fail(
        fmt::format("expected {} elements of {} bytes, a stride of {} apart, from byteOffset {}; "
                    "its bufferView "
                    "has only {} bytes",
                    count, element_bytes, stride, offset, view.bytes));
  }
  return {view.buffer, view.begin + offset, stride};
}

GltfAccessorReader::View GltfAccessorReader::read_view(const GltfValue& json) {
  if (const auto extensions = json.find("extensions")) {
    // Its data is compressed, unless the buffer has it a second time.
    const auto compressed = extensions->find("EXT_meshopt_compression");
    const GltfValue buffer = json.require("buffer").element(file_.root(), "buffers");
    if (compressed && !buffer.find("uri") && buffer.place() != "buffers[0]") {
      compressed->fail(
          "meshopt compression is not supported; decompress the file, for instance "
          "with gltf-transform copy");
    }
  }
  const GltfValue reference = json.require("buffer");
  View view{open(reference.element(file_.root(), "buffers")), json.count("byteOffset", 0),
            json.require("byteLength").whole(), 0};
  const std::uint64_t bytes = buffers_[view.buffer].bytes();
  if (view.begin > bytes || view.bytes > bytes - view.begin) {
    json.fail(fmt::format("expected {} bytes from byteOffset {}, but its buffer has only {}",
                          view.bytes, view.begin, bytes));
  }
  if (const auto stride = json.find("byteStride")) {
    view.stride = stride->whole();
    if (view.stride < 4 || view.stride > 252) {
      stride->fail(fmt::format("expected 4 to 252, found {}", view.stride));
    }
  }
  return view;
}

std::size_t GltfAccessorReader::open(const GltfValue& buffer) {
  const auto known = std::find(places_.begin(), places_.end(), buffer.place());
  if (known != places_.end()) return static_cast<std::size_t>(known - places_.begin());
  buffers_.push_back(file_.open_buffer(buffer));
  places_.push_back(buffer.place());
  return buffers_.size() - 1;
}

GltfElements::GltfElements(const std::vector<GltfBuffer>& buffers, const GltfAccessor& accessor,
                           const std::filesystem::path& file, std::size_t piece_bytes)
    : buffers_(buffers), accessor_(accessor), file_(file), piece_bytes_(piece_bytes) {}

std::span<const char> GltfElements::next() {
  const std::uint64_t first = next_;
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(
      elements_in_piece(piece_bytes_, accessor_.base.stride), accessor_.count - first));
  read_packed(buffers_, accessor_.base, first, n, accessor_.element_bytes(), raw_, packed_);
  next_ += n;
  if (accessor_.sparse) replace(packed_, first);
  return packed_;
}

/// Puts those replacements in whose turn it is.
void GltfElements::replace(std::span<char> elements, std::uint64_t first) {
  const std::size_t bytes = accessor_.element_bytes();
  for (;; ++at_) {
    if (at_ == numbers_.size()) {
      if (loaded_ == accessor_.sparse->count) return;
      load_replacements();
    }
    const std::uint64_t number = numbers_[at_];
    if (number >= next_) return;
    std::memcpy(elements.data() + (number - first) * bytes, values_.data() + at_ * bytes, bytes);
  }
}

void GltfElements::load_replacements() {
  const GltfAccessor::Sparse& sparse = *accessor_.sparse;
  const auto n =
      static_cast<std::size_t>(std::min<std::uint64_t>(kReplacements, sparse.count - loaded_));
  const std::size_t index_bytes = size_of(sparse.index_type);
  std::uint64_t least = numbers_.empty() ? 0 : numbers_.back() + 1;
  read_packed(buffers_, sparse.indices, loaded_, n, index_bytes, raw_, values_);
  numbers_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    numbers_[i] = load_index(values_.data() + i * index_bytes, sparse.index_type);
    if (numbers_[i] < least || numbers_[i] >= accessor_.count) {
      throw InputError(fmt::format(
          "{}: {}.sparse.indices: expected numbers below {} in rising order, found {} at {}",
          file_.string(), accessor_.place, accessor_.count, numbers_[i], loaded_ + i));
    }
    least = numbers_[i] + 1;
  }
  read_packed(buffers_, sparse.values, loaded_, n, accessor_.element_bytes(), raw_, values_);
  loaded_ += n;
  at_ = 0;
}

}  // namespace remaps
