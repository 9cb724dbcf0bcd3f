// How options are spelt: --max-fragments in the help, --max_fragments (as in a request) taken too, and what a
// misspelt option or command was meant to be.
#pragma once

#include <memory>
#include <optional>
#include <string>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace fracture::cli {

/// The names of an option for a parameter, for CLI::App::add_option: "--max-fragments,--max_fragments".
std::string both_spellings(const std::string& parameter);

/// For help: of two spellings of one name it shows that with dashes.
std::shared_ptr<CLI::FormatterBase> help_formatter();

/// After a parse that failed: the first option or command that does not exist, in a sentence, with the
/// nearest one that does. Nothing: something else was wrong. No error of its own: CLI11's, in better words.
std::optional<std::string> unknown_word(const CLI::App& app);

}  // namespace fracture::cli
