#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

/// What is fuzzed, as plain functions. The programs of the preset `fuzz` feed them with libFuzzer,
/// the tests with every file of tests/fuzz_corpus.
namespace remaps::fuzz {

using Input = std::span<const std::byte>;

/// A law that must hold for any input does not. Nobody catches it.
class LawBroken : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void expect(bool holds, std::string_view law) {
  if (!holds) throw LawBroken(std::string(law));
}

/// Feeds an input to one target: "sections", "bundle", "archive", or else a mesh reader, named by
/// the extension of a file (`ply`). Returns when the input was read, or refused as it should be.
/// @throws LawBroken, or whatever came out of the library that should not have
void run_target(std::string_view name, Input input);

/// A mesh file with this extension, whose content may be of another format.
///
/// Laws: it is read or refused (InputError naming the file and the place); the same is delivered
/// again, and in the other order of passes; indices are below the number of vertices; no more
/// vertices or triangles than the file has bytes; positions that are said to be floats, or to be an
/// array in the file, are.
void fuzz_mesh(Input input, std::string_view extension);

/// A section file, the sections of one log segment, or a tile: the first byte chooses.
///
/// Laws: read or refused (CorruptionError); what was decoded is encoded and decoded again the same;
/// a segment that LevelMap takes carries points, either way, to faces that exist.
void fuzz_sections(Input input);

/// A small sound bundle with one of its parts replaced, and all checksums put right: the first byte
/// chooses the part (see BundlePart).
///
/// Laws: opening, locating and verifying succeed or refuse (CorruptionError, InputError,
/// GeometryError, BudgetError); what verify calls sound, locate can follow.
void fuzz_bundle(Input input);

/// An archive of the codec, as it is and with all checksums put right.
///
/// Laws: parsed or refused (InputError, CorruptionError); decoding a prefix succeeds or is refused
/// (CorruptionError, BudgetError); if all of it can be decoded, so can every part, to one base; a
/// file that ends decodes as that prefix; what was decoded is coded again and decoded to the same
/// base.
void fuzz_archive(Input input);

/// A directory in memory where the system has one, removed at the end of the process.
const std::filesystem::path& scratch_directory();
void write_file(const std::filesystem::path& path, Input bytes);

}  // namespace remaps::fuzz
