#include "server/cli/command_line_words.hpp"

#include <string_view>

#include "server/cli/settings.hpp"

namespace fracture::cli {
namespace {

/// Returns "--port is given more than once. Give it once." for "--port: At Most 1 required but received 2".
std::string plain(const CLI::Error& error) {
  const std::string text = error.what(), name = text.substr(0, text.find(": "));
  if (error.get_name() == "ArgumentMismatch") {
    if (text.find(": At Most 1 ") != std::string::npos)
      return name + " is given more than once. Give it once.";
    if (text.ends_with(" missing")) return name + " needs a value.";
  }
  if (text == "A subcommand is required") return "Give a command: serve, bake, inspect or health.";
  return text;
}

}  // namespace

CLI::Validator in_range(std::uint64_t low, std::uint64_t high) {
  return CLI::Validator(
      [low, high](const std::string& text) {
        return detail::parse_number(text, false, low, high)
                   ? std::string()
                   : detail::requirement(false, low, high) + "; it was '" + text + "'";
      },
      "INT in [" + std::to_string(low) + " - " + std::to_string(high) + "]");
}

std::string words_of_failure(const CLI::App* app, const CLI::Error& error) {
  std::string usage = CLI::FailureMessage::simple(app, error);
  const std::string_view text = error.what();
  if (usage.starts_with(text)) usage.erase(0, text.size());
  return plain(error) + usage;
}

}  // namespace fracture::cli
