#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <string>

namespace remaps::cli {

/// Adds a verb. `example` ends its help.
CLI::App& add_verb(CLI::App& program, const std::string& name, const std::string& description,
                   const std::string& example);

/// Lays help out in two columns, with lines of at most 100 characters.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
};

}  // namespace remaps::cli
