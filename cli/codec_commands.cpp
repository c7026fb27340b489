#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "archive_text.h"
#include "exit_codes.h"
#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/base/errors.h"
#include "remaps/pipeline/codec_files.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

struct EncodeArguments {
  pipeline::EncodeOptions options;
  std::string wavelet = "butterfly-lifted";
  bool no_measure = false, quiet = false, json = false;
};

struct DecodeArguments {
  pipeline::DecodeOptions options;
  bool quiet = false, json = false;
};

void encode(EncodeArguments& a) {
  pipeline::EncodeOptions& o = a.options;
  std::error_code ignored;
  if (!std::filesystem::is_directory(o.input, ignored)) check_input_file(o.input);
  check_output_file(o.archive);
  check_distinct(o.input, "input", o.archive, "archive");
  check_temp_dir(o.temp_dir);
  if (a.no_measure && o.target_psnr) {
    throw UsageError("--target-psnr needs measurements, which --no-measure leaves out");
  }
  o.wavelet = wavelet_named(a.wavelet);
  o.measure = !a.no_measure;
  pipeline::ArchiveSummary summary;
  {
    ProgressBar bar(a.quiet);
    summary = pipeline::encode_file(o, bar.progress());
  }
  if (a.json) {
    print(archive_json(summary, o.archive));
  } else if (!a.quiet) {
    print(archive_table(summary, o.archive));
  }
}

void decode(DecodeArguments& a) {
  pipeline::DecodeOptions& o = a.options;
  check_input_file(o.archive);
  check_output_mesh(o.output);
  check_distinct(o.archive, "archive", o.output, "output");
  pipeline::DecodeSummary summary;
  {
    ProgressBar bar(a.quiet);
    summary = pipeline::decode_file(o, bar.progress());
  }
  if (a.json) {
    nlohmann::ordered_json json;
    json["path"] = o.output.string();
    json["bytes"] = summary.bytes;
    json["level"] = summary.level;
    json["vertices"] = summary.vertices;
    json["faces"] = summary.faces;
    print(json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  } else if (!a.quiet) {
    print(decoded_text(summary, o.output));
  }
}

template <class T>
void add_optional_count(CLI::App& verb, const std::string& name, std::optional<T>& value,
                        const std::string& type, const std::string& description,
                        std::optional<std::uint64_t> (*parse)(std::string_view), T most) {
  verb.add_option_function<std::string>(
          name,
          [&value, name, parse, most](const std::string& text) {
            const auto number = parse(text);
            if (!number || *number > most) {
              throw CLI::ValidationError(
                  name, fmt::format("expected a number of at most {}, got \"{}\"", most, text));
            }
            value = static_cast<T>(*number);
          },
          description)
      ->type_name(type);
}

void add_decibels(CLI::App& verb, const std::string& name, std::optional<double>& value,
                  const std::string& description) {
  verb.add_option_function<std::string>(
          name,
          [&value, name](const std::string& text) {
            const auto number = parse_real(text);
            if (!number || !(*number > 0 && *number < 400)) {
              throw CLI::ValidationError(
                  name, fmt::format("expected decibels, 0 to 400, got \"{}\"", text));
            }
            value = *number;
          },
          description)
      ->type_name("DB");
}

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 62;

}  // namespace

void add_codec_commands(CLI::App& program, Action& action) {
  CLI::App& encode_verb = add_verb(
      program, "encode",
      "Compress a semi-regular mesh into an archive of which every beginning can be decoded",
      "encode scan.remaps scan.archive --max-bytes 40k");
  auto e = std::make_shared<EncodeArguments>();
  pipeline::EncodeOptions& o = e->options;
  add_path(encode_verb, "INPUT", o.input,
           "Bundle, or a mesh with subdivision connectivity of any program")
      ->required();
  add_path(encode_verb, "ARCHIVE", o.archive, "Archive to write")->required();
  add_optional_count<unsigned>(
      encode_verb, "--level", o.level, "J",
      "Level of the mesh that is coded; by default one of about 12 faces for each of the input's, "
      "and all levels of a mesh",
      parse_integer, 14);
  encode_verb
      .add_option("--wavelet", e->wavelet,
                  "butterfly-lifted (best), butterfly (coarse levels lie on the surface) or "
                  "loop (smooth where bytes are few)")
      ->check(CLI::IsMember(wavelet_names()))
      ->type_name("KIND")
      ->capture_default_str();
  add_small(encode_verb, "--bitplanes", o.bitplanes, 30,
            "Bits of the largest detail: each one more halves the error and nearly doubles the "
            "bytes");
  add_optional_count<std::uint64_t>(encode_verb, "--max-bytes", o.max_bytes, "N",
                                    "Most bytes of the archive (20000, 40k)", parse_count,
                                    kMostBytes);
  add_decibels(encode_verb, "--target-psnr", o.target_psnr,
               "End the archive where it reaches this PSNR: 20 log10(diagonal / L2 error)");
  encode_verb
      .add_option_function<std::string>(
          "--attributes",
          [&o](const std::string& text) {
            try {
              o.attributes = AttributeChoice(text);
            } catch (const InputError& error) {
              throw CLI::ValidationError("--attributes", error.what());
            }
          },
          "Colours and normals of vertices to be coded: all, none or names; by default colours. Of "
          "--max-bytes they get a third")
      ->type_name("LIST");
  add_small(encode_verb, "--attribute-bitplanes", o.attribute_bitplanes, 30,
            "Bits of attributes: each one more halves their error and nearly doubles their bytes");
  encode_verb.add_flag("--no-measure", e->no_measure,
                       "Leave the rate-distortion table out, which takes most of the time");
  add_samples(encode_verb, o.samples);
  add_resources(encode_verb, o.memory_bytes, o.threads, o.temp_dir, "the system's");
  add_json(encode_verb, e->json);
  add_quiet(encode_verb, e->quiet);
  encode_verb.callback([e, &action] { action = [e] { encode(*e); }; });

  CLI::App& decode_verb =
      add_verb(program, "decode", "Make a mesh of an archive, or of its beginning",
               "decode scan.archive scan.ply --bytes 5000");
  auto d = std::make_shared<DecodeArguments>();
  pipeline::DecodeOptions& p = d->options;
  add_path(decode_verb, "ARCHIVE", p.archive, "Archive, or the beginning of one")->required();
  add_path(decode_verb, "OUTPUT", p.output, "Mesh to write: .ply, .obj, .off, .stl, .glb or .vtp")
      ->required();
  add_optional_count<std::uint64_t>(decode_verb, "--bytes", p.bytes, "N",
                                    "Use this many bytes of the archive (5000, 20k)", parse_count,
                                    kMostBytes);
  add_optional_count<unsigned>(decode_verb, "--level", p.level, "J",
                               "Level of the mesh; by default the finest", parse_integer, 14);
  add_decibels(decode_verb, "--psnr", p.psnr,
               "Use as many bytes as the archive's table says that this PSNR takes");
  add_memory(decode_verb, p.memory_bytes);
  add_json(decode_verb, d->json);
  add_quiet(decode_verb, d->quiet);
  decode_verb.callback([d, &action] { action = [d] { decode(*d); }; });
}

}  // namespace remaps::cli
