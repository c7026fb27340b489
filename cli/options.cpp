#include "options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/Option.hpp>
#include <optional>
#include <system_error>

#include "exit_codes.h"
#include "number_text.h"
#include "remaps/base/errors.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/pipeline/output_levels.h"

namespace remaps::cli {
namespace {

namespace fs = std::filesystem;

/// An option whose text is turned into a value by `parse`; what it throws names the option.
template <class T, class Parse>
CLI::Option* add_parsed(CLI::App& verb, const std::string& name, T& value, const char* type,
                        const std::string& description, Parse parse) {
  return verb
      .add_option_function<std::string>(
          name,
          [name, &value, parse](const std::string& text) {
            try {
              value = parse(text);
            } catch (const UsageError& error) {
              throw CLI::ValidationError(name, error.what());
            }
          },
          description)
      ->type_name(type);
}

/// "200k", when the number is round, else "200".
std::string default_count(std::uint64_t n) {
  if (n >= 1'000'000 && n % 1'000'000 == 0) return fmt::format("{}M", n / 1'000'000);
  if (n >= 10'000 && n % 1000 == 0) return fmt::format("{}k", n / 1000);
  return std::to_string(n);
}

bool is_writable_directory(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) && access(path.c_str(), W_OK | X_OK) == 0;
}

/// Where a new file of this name goes.
void check_place(const fs::path& path) {
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code ignored;
  if (!fs::is_directory(parent, ignored)) {
    throw UsageError(fmt::format("{}: no such directory: {}", path.string(), parent.string()));
  }
  if (!is_writable_directory(parent)) {
    throw UsageError(
        fmt::format("{}: the directory {} cannot be written to", path.string(), parent.string()));
  }
}

/// "a/b/" and "a/b" name one thing.
fs::path without_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

CLI::Option* add_path(CLI::App& verb, const std::string& name, fs::path& value,
                      const std::string& description) {
  return add_parsed(verb, name, value, "", description, [](const std::string& text) {
    if (text.empty()) throw UsageError("the name is empty");
    return fs::path(text);
  });
}

CLI::Option* add_count(CLI::App& verb, const std::string& name, std::uint64_t& value,
                       std::uint64_t least, const std::string& description) {
  return add_parsed(verb, name, value, "N", description,
                    [least](const std::string& text) {
                      const auto count = parse_count(text);
                      if (!count) {
                        throw UsageError(
                            fmt::format("\"{}\" is not a count such as 200, 10k or 5M", text));
                      }
                      if (*count < least) {
                        throw UsageError(fmt::format("{} is less than {}", text, least));
                      }
                      return *count;
                    })
      ->default_str(default_count(value));
}

CLI::Option* add_small(CLI::App& verb, const std::string& name, unsigned& value, unsigned most,
                       const std::string& description) {
  return add_parsed(verb, name, value, "N", description,
                    [most](const std::string& text) {
                      const auto number = parse_integer(text);
                      if (!number || *number > most) {
                        throw UsageError(
                            fmt::format("\"{}\" is not a whole number from 0 to {}", text, most));
                      }
                      return static_cast<unsigned>(*number);
                    })
      ->default_str(std::to_string(value));
}

CLI::Option* add_real(CLI::App& verb, const std::string& name, double& value, double least,
                      double most, const std::string& description) {
  return add_parsed(verb, name, value, "X", description,
                    [least, most](const std::string& text) {
                      const auto number = parse_real(text);
                      if (!number || *number < least || *number > most) {
                        throw UsageError(
                            fmt::format("\"{}\" is not a number from {} to {}", text, least, most));
                      }
                      return *number;
                    })
      ->default_str(fmt::format("{}", value));
}

CLI::Option* add_length(CLI::App& verb, const std::string& name, std::optional<double>& value,
                        const std::string& description) {
  return add_parsed(verb, name, value, "X", description, [](const std::string& text) {
    const auto number = parse_real(text);
    if (!number || !(*number >= 0)) {
      throw UsageError(
          fmt::format("\"{}\" is not a length, 0 or more, in the units of the file", text));
    }
    return *number;
  });
}

CLI::Option* add_angle(CLI::App& verb, const std::string& name, double& value,
                       const std::string& description) {
  return add_parsed(verb, name, value, "DEG", description, [](const std::string& text) {
    const auto number = parse_real(text);
    if (!number || !(*number > 0 && *number < 180)) {
      throw UsageError(
          fmt::format("\"{}\" is not an angle in degrees between 0 and 180, such as 30", text));
    }
    return *number;
  });
}

CLI::Option* add_input_mesh(CLI::App& verb, const std::string& name, fs::path& path) {
  return add_path(verb, name, path,
                  "Mesh to read: .ply, .obj, .off or .stl; .gz and .zst of them; .glb, .gltf");
}

void add_weld(CLI::App& verb, std::optional<double>& distance) {
  add_length(verb, "--weld", distance,
             "Join vertices within this distance of each other, in the units of the file; 0: those "
             "at exactly one place, as is always done for STL")
      ->type_name("EPS");
}

void add_levels(CLI::App& verb, unsigned& level, std::optional<unsigned>& coarsest) {
  static constexpr unsigned kMost = 14;
  CLI::Option* const one = add_small(
      verb, "--level", level, kMost,
      fmt::format("Subdivisions of the base, 0 to {}; each makes four faces of one", kMost));
  verb.add_option_function<std::string>(
          "--levels",
          [&level, &coarsest](const std::string& text) {
            const std::size_t dots = text.find("..");
            const auto first = parse_integer(text.substr(0, dots));
            const auto last =
                dots == std::string::npos ? first : parse_integer(text.substr(dots + 2));
            if (!first || !last || *first > *last || *last > kMost) {
              throw CLI::ValidationError(
                  "--levels", fmt::format("\"{}\" is not a range of levels such as 0..5, 0 to {}",
                                          text, kMost));
            }
            coarsest = static_cast<unsigned>(*first);
            level = static_cast<unsigned>(*last);
          },
          "One mesh for each of these levels: 0..5 makes out-l0.ply to out-l5.ply of OUTPUT "
          "out.ply. Errors are those of the finest")
      ->type_name("A..B")
      ->excludes(one);
}

void add_memory(CLI::App& verb, std::uint64_t& memory_bytes) {
  add_parsed(verb, "--memory", memory_bytes, "SIZE",
             "Memory budget: bytes, or K, M, G, T of 1024 (M = 2^20 bytes). Program and "
             "libraries take some 32M on top",
             [](const std::string& text) {
               const auto bytes = parse_bytes(text);
               if (!bytes || *bytes == 0) {
                 throw UsageError(
                     fmt::format("\"{}\" is not a size such as 256M, 1.5G or 268435456", text));
               }
               return *bytes;
             })
      ->default_str(fmt::format("{}M", memory_bytes >> 20));
}

void add_resources(CLI::App& verb, std::uint64_t& memory_bytes, unsigned& threads,
                   fs::path& temp_dir, const std::string& place) {
  add_memory(verb, memory_bytes);
  add_small(verb, "--threads", threads, 256,
            "Worker threads, 1 to 256; 0: one a processor. Makes no difference to the result");
  add_path(verb, "--temp-dir", temp_dir,
           fmt::format("Where temporary files go; they may need several times the input's size. "
                       "Default: {}",
                       place))
      ->type_name("DIR");
}

void add_samples(CLI::App& verb, std::uint64_t& samples) {
  add_count(verb, "--samples", samples, 1,
            "Sample points on each surface when errors are measured");
}

void add_feature_labels(CLI::App& verb, FaceLabelChoice& labels) {
  add_parsed(verb, "--feature-labels", labels, "LIST",
             "Keep edges between faces that differ in a label as edges of the base: all, none, or "
             "names separated by commas: group, object, material of OBJ, primitive, material of "
             "glTF, integers of faces in PLY by their names",
             [](const std::string& text) {
               try {
                 return FaceLabelChoice(text);
               } catch (const InputError& error) {
                 throw UsageError(error.what());
               }
             })
      ->default_str("none");
}

void add_attributes(CLI::App& verb, AttributeChoice& attributes, const std::string& what) {
  add_parsed(verb, "--attributes", attributes, "LIST",
             fmt::format("Attributes to carry {}: all, none, or names separated by commas, as "
                         "`remaps info` lists them",
                         what),
             [](const std::string& text) {
               try {
                 return AttributeChoice(text);
               } catch (const InputError& error) {
                 throw UsageError(error.what());
               }
             })
      ->default_str("all");
}

void add_quiet(CLI::App& verb, bool& quiet) {
  verb.add_flag("--quiet,-q", quiet, "No progress and no summary; errors only");
}

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json, "Write the result to standard output as JSON");
}

void check_input_file(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) throw InputError(path.string() + ": no such file");
  if (fs::is_directory(status)) {
    throw InputError(path.string() + ": is a directory, expected a mesh file");
  }
}

void check_bundle(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) throw InputError(path.string() + ": no such bundle");
  if (!fs::is_directory(status)) {
    throw InputError(path.string() + ": is a file, expected a bundle, which is a directory");
  }
}

void check_output_file(const fs::path& path) {
  std::error_code ignored;
  if (!path.has_filename() || fs::is_directory(path, ignored)) {
    throw UsageError(path.string() + ": is a directory, expected the name of a file to write");
  }
  check_place(path);
}

void check_output_mesh(const fs::path& path) {
  if (!is_writable_mesh(path)) {
    throw UsageError(
        fmt::format("{}: meshes are written as one of {}", path.string(), kWritableMeshes));
  }
  check_output_file(path);
}

std::vector<fs::path> output_meshes(const fs::path& output, std::optional<unsigned> coarsest,
                                    unsigned level) {
  if (output.empty()) return {};
  if (!coarsest) return {output};
  std::vector<fs::path> paths;
  for (unsigned l = *coarsest; l <= level; ++l) paths.push_back(pipeline::level_path(output, l));
  return paths;
}

void check_output_bundle(const fs::path& path) {
  const fs::path bundle = without_slash(path);
  std::error_code ignored;
  const fs::file_status status = fs::status(bundle, ignored);
  if (fs::exists(status) && !fs::is_directory(status)) {
    throw UsageError(path.string() + ": is a file, a bundle is a directory");
  }
  if (fs::exists(status) && !fs::is_empty(bundle, ignored) &&
      !fs::exists(bundle / "manifest.json", ignored)) {
    throw UsageError(path.string() + ": is a directory with other things in it, not a bundle");
  }
  check_place(bundle);
}

void check_temp_dir(const fs::path& path) {
  if (!path.empty() && !is_writable_directory(path)) {
    throw UsageError(path.string() + ": not a directory that can be written to");
  }
}

void check_distinct(const fs::path& a, const char* role_a, const fs::path& b, const char* role_b) {
  if (a.empty() || b.empty()) return;
  std::error_code ignored;
  const bool same_name = fs::weakly_canonical(without_slash(a), ignored) ==
                         fs::weakly_canonical(without_slash(b), ignored);
  if (same_name || fs::equivalent(a, b, ignored)) {
    throw UsageError(fmt::format("{} and {} are the same file: {}", role_a, role_b, b.string()));
  }
}

}  // namespace remaps::cli
