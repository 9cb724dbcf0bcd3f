#include "server/cli/help.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <vector>

#include "common/parameters/as_text.hpp"
#include "common/parameters/values.hpp"
#include "server/cli/spelling.hpp"

namespace fracture::cli {
namespace {

/// Characters per line if the output is not a terminal, and the most that is easy to read.
constexpr std::size_t kUsualWidth = 100, kGreatestWidth = 120, kLeastWidth = 50;
/// Characters before a description. Longer names have a line of their own.
constexpr std::size_t kNameWidth = 26;

std::size_t width_of_output() {
  winsize size{};
  if (::isatty(STDOUT_FILENO) == 0 || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
    return kUsualWidth;
  return std::clamp<std::size_t>(size.ws_col, kLeastWidth, kGreatestWidth);
}

/// Returns the number of characters of UTF-8 text.
std::size_t characters(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

/// Appends the words to `line`, which is `used` characters long. Further lines begin with `indent` spaces.
void wrap(std::string& out, std::size_t used, std::string_view words, std::size_t indent, std::size_t width) {
  bool first = true;
  while (!words.empty()) {
    const std::size_t space = words.find(' ');
    const std::string_view word = words.substr(0, space);
    words = space == std::string_view::npos ? std::string_view() : words.substr(space + 1);
    const std::size_t length = characters(word);
    if (!first && used + 1 + length > width) {
      out += "\n" + std::string(indent, ' ');
      used = indent;
    } else if (!first) {
      out += ' ';
      ++used;
    }
    out += word;
    used += length;
    first = false;
  }
  out += '\n';
}

/// Splits a type such as "N:INT in [0 - 1024]", which CLI11 makes of a type and a check, into "N" and "0 to 1024".
std::pair<std::string, std::string> type_and_range(const std::string& type) {
  const std::size_t colon = type.find(":INT in ["), dash = type.find(" - ", colon);
  if (colon == std::string::npos || dash == std::string::npos) return {type, ""};
  const std::size_t low = colon + std::string_view(":INT in [").size();
  return {type.substr(0, colon),
          type.substr(low, dash - low) + " to " + type.substr(dash + 3, type.size() - dash - 4)};
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

  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    const auto [type, range] = type_and_range(option->get_type_name());
    std::string out = "  " + make_option_name(option, is_positional);
    if (option->get_type_size() != 0 && !type.empty()) out += " " + type;
    if (option->get_type_size() != 0 && option->get_expected_max() == CLI::detail::expected_max_vector_size)
      out += " ...";
    std::string facts = range;
    const auto add = [&facts](const std::string& fact) { facts += (facts.empty() ? "" : "; ") + fact; };
    if (option->get_type_size() != 0 && !option->get_default_str().empty())
      add("default " + option->get_default_str());
    if (!option->get_envname().empty()) add("or the variable " + option->get_envname());
    const std::string words = (facts.empty() ? "" : "[" + facts + "] ") + option->get_description();
    std::size_t used = characters(out);
    if (used > kNameWidth) {
      out += '\n';
      used = 0;
    }
    out += std::string(kNameWidth + 2 - used, ' ');
    wrap(out, kNameWidth + 2, words, kNameWidth + 2, width_);
    return out;
  }

  std::string make_footer(const CLI::App* app) const override {
    std::string out;
    const std::string footer = app->get_footer();
    std::string_view text = footer;
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      wrap(out, 0, text.substr(0, end), 0, width_);
      text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    }
    return out;
  }

 private:
  const std::size_t width_ = width_of_output();
};

/// Returns numbers such as "0.0,1.0,0.0" without decimals that are zero: "0,1,0".
std::string without_zeros(const std::string& text) {
  std::string shorter;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const bool zero =
        text.compare(k, 2, ".0") == 0 && (k + 2 == text.size() || text[k + 2] == ',' || text[k + 2] == ';');
    if (zero)
      ++k;
    else
      shorter += text[k];
  }
  return shorter;
}

/// Choices that are written out in the placeholder; more are listed with the values.
constexpr std::size_t kShortChoices = 24;

std::string choices_of(const ParameterSpec& spec) {
  std::string text;
  for (const std::string& choice : spec.choices) text += (text.empty() ? "" : "|") + choice;
  return text;
}

bool is_short(const ParameterSpec& spec) { return choices_of(spec).size() <= kShortChoices; }

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() { return std::make_shared<HelpFormatter>(); }

std::string placeholder_of(const ParameterSpec& spec) {
  switch (spec.type) {
    case ParameterSpec::Type::kInteger:
      return "N";
    case ParameterSpec::Type::kNumber:
      return "X";
    case ParameterSpec::Type::kIntegers:
      return "N,N,...";
    case ParameterSpec::Type::kNumbers:
      return "X,X,...";
    case ParameterSpec::Type::kChoice:
      return is_short(spec) ? choices_of(spec) : "NAME";
    case ParameterSpec::Type::kNames:
      return "NAME,...";
    case ParameterSpec::Type::kText:
      return "TEXT";
    case ParameterSpec::Type::kColor:
      return "#RRGGBB";
    case ParameterSpec::Type::kVector:
    case ParameterSpec::Type::kDirection:
      return "X,Y,Z";
    case ParameterSpec::Type::kVectors:
      return "X,Y,Z;...";
    case ParameterSpec::Type::kMatrix:
      return "A,B,C;D,E,F;G,H,I";
    case ParameterSpec::Type::kAssignments:
      return "SELECTOR:MATERIAL;...";
  }
  return "";
}

std::string values_of(const ParameterSpec& spec) {
  std::string facts;
  const auto add = [&facts](const std::string& fact) { facts += (facts.empty() ? "" : "; ") + fact; };
  const bool is_written_out = spec.type == ParameterSpec::Type::kChoice && is_short(spec);
  if (!is_written_out && spec.type != ParameterSpec::Type::kNames) {  // the placeholder lists these values
    const std::string values = expectation(spec);
    add(values.substr(0, values.find(", as text")) + (spec.unit.empty() ? "" : ", in " + spec.unit));
  }
  if (!spec.default_value.is_null())
    add("default " + without_zeros(as_text(spec.default_value).value_or("")));
  if (!spec.patterns.empty()) add("only with " + join(spec.patterns));
  return facts.empty() ? "" : "[" + facts + "] ";
}

}  // namespace fracture::cli
