#include "server/cli/spelling.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <vector>

#include "common/base/nearest_name.hpp"

namespace fracture::cli {
namespace {

std::string with_dashes(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    if (is_positional) return CLI::Formatter::make_option_name(option, is_positional);
    std::vector<std::string> names;
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : option->get_lnames())
      if (const std::string shown = "--" + with_dashes(name);
          std::find(names.begin(), names.end(), shown) == names.end())
        names.push_back(shown);
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
    return text;
  }
};

/// Adds the long names of all options, including those in option groups, spelt with dashes.
void add_options(const CLI::App& app, std::vector<std::string>& names) {
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back(with_dashes(name));
  for (const CLI::App* group :
       app.get_subcommands([](const CLI::App* sub) { return sub->get_name().empty(); }))
    add_options(*group, names);
}

std::string unknown_option(const CLI::App& app, const std::string& word) {
  const std::string given = word.substr(0, word.find('='));
  std::vector<std::string> names;
  add_options(app, names);
  const std::string bare = given.substr(std::min(given.find_first_not_of('-'), given.size()));
  const std::optional<std::string> nearest = nearest_name(with_dashes(bare), names);
  return "there is no option " + given + (nearest ? "; did you mean --" + *nearest + "?" : "");
}

/// Returns the first option that the app did not recognize.
std::optional<std::string> unknown_option_of(const CLI::App& app) {
  for (const std::string& word : app.remaining())
    if (word.size() > 1 && word.front() == '-' && word != "--") return word;
  return std::nullopt;
}

}  // namespace

std::string both_spellings(const std::string& parameter) {
  const std::string dashes = with_dashes(parameter);
  return "--" + dashes + (dashes == parameter ? "" : ",--" + parameter);
}

std::shared_ptr<CLI::FormatterBase> help_formatter() { return std::make_shared<HelpFormatter>(); }

std::optional<std::string> unknown_word(const CLI::App& app) {
  const std::vector<CLI::App*> commands = app.get_subcommands();
  if (!commands.empty()) {
    const CLI::App& command = *commands.front();
    if (const auto word = unknown_option_of(command)) return unknown_option(command, *word);
    if (const auto word = unknown_option_of(app))
      return "there is no option " + *word + " before the command " + command.get_name();
    return std::nullopt;
  }
  for (const std::string& word : app.remaining()) {
    if (word.empty() || word.front() == '-') continue;
    std::vector<std::string> names;
    std::string all;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
      names.push_back(command->get_name());
      all += (all.empty() ? "" : ", ") + command->get_name();
    }
    const std::optional<std::string> nearest = nearest_name(word, names);
    return "there is no command '" + word + "'" +
           (nearest ? "; did you mean " + *nearest + "?" : ": there are " + all);
  }
  if (const auto word = unknown_option_of(app)) return unknown_option(app, *word);
  return std::nullopt;
}

}  // namespace fracture::cli
