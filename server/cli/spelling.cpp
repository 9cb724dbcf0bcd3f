#include "server/cli/spelling.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <vector>

#include "common/base/nearest_name.hpp"
#include "common/parameters/groups.hpp"

namespace fracture::cli {
namespace {

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
  for (std::string& name : names)
    std::replace(name.begin(), name.end(), '-', '_');  // as parameters are spelt
  std::string bare = given.substr(std::min(given.find_first_not_of('-'), given.size()));
  std::replace(bare.begin(), bare.end(), '-', '_');
  const std::optional<std::string> nearest = parameter_meant_by(bare, names);
  return "there is no option " + given + (nearest ? "; did you mean --" + with_dashes(*nearest) + "?" : "");
}

/// Returns the first option that the app did not recognize.
std::optional<std::string> unknown_option_of(const CLI::App& app) {
  for (const std::string& word : app.remaining())
    if (word.size() > 1 && word.front() == '-' && word != "--") return word;
  return std::nullopt;
}

}  // namespace

std::string with_dashes(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

std::string both_spellings(const std::string& parameter) {
  const std::string dashes = with_dashes(parameter);
  return "--" + dashes + (dashes == parameter ? "" : ",--" + parameter);
}

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
