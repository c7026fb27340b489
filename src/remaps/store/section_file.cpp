#include "remaps/store/section_file.h"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

namespace remaps::store {
namespace {

constexpr std::array<char, 8> kMagic{'r', 'e', 'm', 'a', 'p', 's', 'S', 'F'};
constexpr std::uint32_t kVersion = 1;
constexpr int kCompressionLevel = 1;
/// A zstd block of 4 bytes or more unpacks to 128 KiB or less.
constexpr std::uint64_t kMaxRatio = 32 << 10;

struct Header {
  std::array<char, 8> magic;
  std::array<char, 4> kind;
  std::uint32_t version;
};

struct Trailer {
  std::uint64_t index_offset;
  std::uint64_t sections;
  std::uint64_t index_checksum;
  std::array<char, 8> magic;
};

}  // namespace

PackedSection pack_section(ByteSpan raw) {
  PackedSection section;
  section.raw_bytes = raw.size();
  section.stored.resize(ZSTD_compressBound(raw.size()));
  const std::size_t size = ZSTD_compress(section.stored.data(), section.stored.size(), raw.data(),
                                         raw.size(), kCompressionLevel);
  if (ZSTD_isError(size)) throw Error(std::string("zstd: ") + ZSTD_getErrorName(size));
  section.stored.resize(size);
  section.checksum = XXH3_64bits(section.stored.data(), size);
  return section;
}

SectionFileWriter::SectionFileWriter(const std::filesystem::path& path, std::array<char, 4> kind)
    : path_(path), partial_(partial_name(path)), file_(File::create(partial_)) {
  const Header header{kMagic, kind, kVersion};
  file_.write_at(0, std::as_bytes(std::span(&header, 1)));
  end_ = sizeof header;
}

SectionFileWriter::~SectionFileWriter() {
  if (sealed_) return;
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

std::size_t SectionFileWriter::append(const PackedSection& section) {
  file_.write_at(end_, section.stored);
  index_.push_back({end_, section.stored.size(), section.raw_bytes, section.checksum});
  end_ += section.stored.size();
  return index_.size() - 1;
}

void SectionFileWriter::seal() {
  const auto index = std::as_bytes(std::span(index_));
  file_.write_at(end_, index);
  const Trailer trailer{end_, index_.size(), XXH3_64bits(index.data(), index.size()), kMagic};
  file_.write_at(end_ + index.size(), std::as_bytes(std::span(&trailer, 1)));
  file_.close();
  std::filesystem::rename(partial_, path_);
  sealed_ = true;
}

SectionFile::SectionFile(const std::filesystem::path& path, std::array<char, 4> kind)
    : file_(File::open_read(path)) {
  const auto refuse = [&](const std::string& why) {
    throw CorruptionError(path.string() + ": " + why);
  };
  const std::uint64_t size = file_.size();
  if (size < sizeof(Header) + sizeof(Trailer)) refuse("too short to be a section file");
  Header header{};
  Trailer trailer{};
  file_.read_at(0, std::as_writable_bytes(std::span(&header, 1)));
  file_.read_at(size - sizeof trailer, std::as_writable_bytes(std::span(&trailer, 1)));
  if (header.magic != kMagic || header.kind != kind) {
    refuse("not a section file of kind '" + std::string(kind.data(), kind.size()) + "'");
  }
  if (header.version != kVersion) {
    refuse("format version " + std::to_string(header.version) + ", this program reads " +
           std::to_string(kVersion));
  }
  const std::uint64_t room = size - sizeof header - sizeof trailer;
  if (trailer.magic != kMagic || trailer.sections > room / sizeof(Entry) ||
      trailer.index_offset != size - sizeof trailer - trailer.sections * sizeof(Entry)) {
    refuse("the trailer at byte " + std::to_string(size - sizeof trailer) + " is damaged");
  }
  index_.resize(static_cast<std::size_t>(trailer.sections));
  const auto index = std::as_writable_bytes(std::span(index_));
  file_.read_at(trailer.index_offset, index);
  if (XXH3_64bits(index.data(), index.size()) != trailer.index_checksum) {
    refuse("the index at byte " + std::to_string(trailer.index_offset) + " fails its checksum");
  }
  std::uint64_t end = sizeof header;
  for (const Entry& entry : index_) {
    if (entry.offset != end || entry.stored_bytes > trailer.index_offset - end) {
      refuse("the index names bytes outside the file, or leaves some out");
    }
    if (entry.raw_bytes / kMaxRatio > entry.stored_bytes) refuse("the index names absurd sizes");
    end += entry.stored_bytes;
  }
  if (end != trailer.index_offset) refuse("there are bytes between sections and index");
}

void SectionFile::read(std::size_t section, Bytes& out) const {
  const Entry& entry = index_[section];
  const auto refuse = [&](const std::string& why) {
    throw CorruptionError(file_.path().string() + ": section " + std::to_string(section) +
                          " at byte " + std::to_string(entry.offset) + ' ' + why);
  };
  thread_local Bytes stored;
  stored.resize(static_cast<std::size_t>(entry.stored_bytes));
  file_.read_at(entry.offset, stored);
  if (XXH3_64bits(stored.data(), stored.size()) != entry.checksum) refuse("fails its checksum");
  if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != entry.raw_bytes) {
    refuse("has another size than the index says");
  }
  out.resize(static_cast<std::size_t>(entry.raw_bytes));
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), stored.data(), stored.size());
  if (ZSTD_isError(size) || size != out.size()) refuse("does not unpack");
}

}  // namespace remaps::store
