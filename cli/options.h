#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "remaps/mesh/attributes.h"
#include "remaps/mesh/face_labels.h"

namespace remaps::cli {

/// What a parsed command line asks for; main runs it after parsing.
using Action = std::function<void()>;

/// Each adds its verbs to the program; a verb that is called sets `action`.
void add_remesh_commands(CLI::App& program, Action& action);
void add_query_commands(CLI::App& program, Action& action);
void add_measure_command(CLI::App& program, Action& action);
void add_info_command(CLI::App& program, Action& action);
void add_check_command(CLI::App& program, Action& action);
void add_generate_command(CLI::App& program, Action& action);
void add_codec_commands(CLI::App& program, Action& action);
void add_sphere_command(CLI::App& program, Action& action);
void add_image_command(CLI::App& program, Action& action);

/// Options that hold a path, a count (200, 10k, 5M), a size (256M, 1.5G) or a number in a range.
/// The help shows the value's default; bad values end parsing with a message that names the option.
CLI::Option* add_path(CLI::App& verb, const std::string& name, std::filesystem::path& value,
                      const std::string& description);
CLI::Option* add_count(CLI::App& verb, const std::string& name, std::uint64_t& value,
                       std::uint64_t least, const std::string& description);
CLI::Option* add_small(CLI::App& verb, const std::string& name, unsigned& value, unsigned most,
                       const std::string& description);
CLI::Option* add_real(CLI::App& verb, const std::string& name, double& value, double least,
                      double most, const std::string& description);

/// An optional length of 0 or more.
CLI::Option* add_length(CLI::App& verb, const std::string& name, std::optional<double>& value,
                        const std::string& description);

/// A mesh file, with the formats in its help; and --weld.
CLI::Option* add_input_mesh(CLI::App& verb, const std::string& name, std::filesystem::path& path);
void add_weld(CLI::App& verb, std::optional<double>& distance);
/// --level and --levels, one of which may be given: the second, "A..B", sets both values, to B and
/// A.
void add_levels(CLI::App& verb, unsigned& level, std::optional<unsigned>& coarsest);
/// An angle in degrees, above 0 and below 180; the help says what happens without it.
CLI::Option* add_angle(CLI::App& verb, const std::string& name, double& value,
                       const std::string& description);

void add_memory(CLI::App& verb, std::uint64_t& memory_bytes);
/// --memory, --threads and --temp-dir, the same for all verbs. `place` is the default place of
/// temporary files.
void add_resources(CLI::App& verb, std::uint64_t& memory_bytes, unsigned& threads,
                   std::filesystem::path& temp_dir, const std::string& place);
void add_samples(CLI::App& verb, std::uint64_t& samples);
/// --attributes; `what` says of what.
void add_attributes(CLI::App& verb, AttributeChoice& attributes, const std::string& what);
void add_feature_labels(CLI::App& verb, FaceLabelChoice& labels);
void add_quiet(CLI::App& verb, bool& quiet);
void add_json(CLI::App& verb, bool& json);

/// @throws InputError  there is no such file, or it is a directory
void check_input_file(const std::filesystem::path& path);
/// @throws InputError  there is no such directory
void check_bundle(const std::filesystem::path& path);

/// @throws UsageError  not a format that is written, a directory, or in a place that cannot be
/// written to
void check_output_mesh(const std::filesystem::path& path);
/// The meshes that a job writes: `output`, or one for each level.
std::vector<std::filesystem::path> output_meshes(const std::filesystem::path& output,
                                                 std::optional<unsigned> coarsest, unsigned level);
/// @throws UsageError  a directory, or in a place that cannot be written to
void check_output_file(const std::filesystem::path& path);
/// @throws UsageError  something else is there, or the place cannot be written to
void check_output_bundle(const std::filesystem::path& path);
/// Empty is fine. @throws UsageError  not a directory that can be written to
void check_temp_dir(const std::filesystem::path& path);
/// @throws UsageError  both paths name one file
void check_distinct(const std::filesystem::path& a, const char* role_a,
                    const std::filesystem::path& b, const char* role_b);

}  // namespace remaps::cli
