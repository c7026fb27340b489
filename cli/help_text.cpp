#include "help_text.h"

#include <string_view>

namespace remaps::cli {
namespace {

constexpr std::size_t kFirstColumn = 28, kColumns = 100;

/// Breaks a text into lines at blanks.
std::string wrapped(std::string_view text, std::size_t columns) {
  std::string lines;
  while (text.size() > columns) {
    const std::size_t blank = text.rfind(' ', columns);
    if (blank == std::string_view::npos) break;
    lines.append(text.substr(0, blank)).push_back('\n');
    text.remove_prefix(blank + 1);
  }
  return lines.append(text);
}

}  // namespace

CLI::App& add_verb(CLI::App& program, const std::string& name, const std::string& description,
                   const std::string& example) {
  CLI::App& verb = *program.add_subcommand(name, description);
  verb.footer("Example:\n  remaps " + example);
  return verb;
}

HelpFormatter::HelpFormatter() {
  column_width(kFirstColumn);
  label("REQUIRED", "");
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  return wrapped(option->get_description(), kColumns - kFirstColumn);
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  std::string text = option->get_type_name().empty() ? "" : " " + option->get_type_name();
  if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + "]";
  return text;
}

}  // namespace remaps::cli
