#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "exit_codes.h"
#include "help_text.h"
#include "options.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

constexpr const char* kFooter =
    "Example:\n"
    "  remaps remesh scan.ply remesh.ply --base-vertices 200 --level 5 --bundle scan.remaps\n"
    "\n"
    "Results go to standard output, messages and progress to standard error. Errors are fractions\n"
    "of the input's bounding-box diagonal.\n"
    "\n"
    "Exit codes: 0 done, 2 usage, 3 unreadable or malformed input, 4 surface refused,\n"
    "5 memory or disk budget, 6 verification failed, 130 cancelled.";

int report_usage(const CLI::App& program, const std::string& message) {
  const auto verbs = program.get_subcommands();
  log_line("error: " + message);
  log_line(
      fmt::format("try: remaps {}--help", verbs.empty() ? "" : verbs.front()->get_name() + " "));
  return static_cast<int>(ExitCode::kUsage);
}

int report_failure(const CLI::App& program, const std::exception& error) {
  const ExitCode code = exit_code_of(error);
  if (code == ExitCode::kUsage) return report_usage(program, error.what());
  const bool out_of_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  if (code == ExitCode::kCancelled) {
    log_line("cancelled");
  } else if (code == ExitCode::kInternal) {
    log_line(fmt::format("error: internal error: {}", error.what()));
  } else {
    log_line(
        fmt::format("error: {}", out_of_memory ? "the system has no more memory" : error.what()));
  }
  return static_cast<int>(code);
}

int run(int argc, char** argv) {
  CLI::App program(
      "Turns huge triangle meshes into semi-regular ones, with an exact map between "
      "the two, in a given amount of memory.",
      "remaps");
  program.footer(kFooter);
  program.set_version_flag("--version", "remaps " REMAPS_VERSION, "Print the version");
  program.formatter(std::make_shared<HelpFormatter>());
  program.require_subcommand(0, 1);
  Action action;
  add_remesh_commands(program, action);
  add_query_commands(program, action);
  add_measure_command(program, action);
  add_check_command(program, action);
  add_codec_commands(program, action);
  add_sphere_command(program, action);
  add_image_command(program, action);
  add_info_command(program, action);
  add_generate_command(program, action);

  try {
    program.parse(argc, argv);
    if (!action) {
      fmt::print(stderr, "{}", program.help());
      return static_cast<int>(ExitCode::kUsage);
    }
    action();
    flush_output();
    return static_cast<int>(ExitCode::kDone);
  } catch (const CLI::CallForVersion& version) {
    print(std::string(version.what()) + "\n");
  } catch (const CLI::CallForHelp&) {
    print(program.help());
  } catch (const CLI::ParseError& error) {
    return report_usage(program, error.what());
  } catch (const std::exception& error) {
    return report_failure(program, error);
  }
  flush_output();
  return static_cast<int>(ExitCode::kDone);
}

}  // namespace
}  // namespace remaps::cli

int main(int argc, char** argv) {
  // A reader of ours that goes away makes a write fail, so that temporary files are removed.
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return remaps::cli::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "remaps: error: %s\n", error.what());
    return static_cast<int>(remaps::cli::ExitCode::kInternal);
  }
}
