// Spelling of options: --max-fragments in the help, with --max_fragments (as in a request) accepted too.
// Suggests corrections for misspelt options and commands.
#pragma once

#include <optional>
#include <string>

namespace CLI {
class App;
}  // namespace CLI

namespace fracture::cli {

/// Returns the name with dashes instead of underscores.
std::string with_dashes(std::string name);

/// Returns the names of a parameter's option for CLI::App::add_option(): "--max-fragments,--max_fragments".
std::string both_spellings(const std::string& parameter);

/// Called after parsing failed. Returns a sentence with the first option or command that does not exist and
/// the most similar one or the one with this synonym, or nothing if something else was wrong. The sentence replaces the less clear one of
/// CLI11.
std::optional<std::string> unknown_word(const CLI::App& app);

}  // namespace fracture::cli
