#include "common/base/name_pattern.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

namespace fracture {
namespace {

struct CharacterClass {
  std::string_view name;
  int (*has)(int);
};
constexpr std::array<CharacterClass, 12> kClasses{{{"alnum", std::isalnum},
                                                   {"alpha", std::isalpha},
                                                   {"blank", std::isblank},
                                                   {"cntrl", std::iscntrl},
                                                   {"digit", std::isdigit},
                                                   {"graph", std::isgraph},
                                                   {"lower", std::islower},
                                                   {"print", std::isprint},
                                                   {"punct", std::ispunct},
                                                   {"space", std::isspace},
                                                   {"upper", std::isupper},
                                                   {"xdigit", std::isxdigit}}};

struct Bracket {
  bool has;         ///< whether the bracket matches the byte
  std::size_t end;  ///< position after the ']'
};

/// Parses the bracket expression whose '[' is at `at` - 1. Returns nothing if it is not closed: then '[' is
/// an ordinary character.
std::optional<Bracket> bracket(std::string_view pattern, std::size_t at, unsigned char byte) {
  const bool without = at < pattern.size() && (pattern[at] == '!' || pattern[at] == '^');
  if (without) ++at;
  bool has = false;
  for (bool first = true; at < pattern.size(); first = false) {
    if (pattern[at] == ']' && !first) return Bracket{has != without, at + 1};
    if (pattern.substr(at).starts_with("[:")) {
      const std::size_t end = pattern.find(":]", at + 2);
      if (end != std::string_view::npos) {
        const std::string_view name = pattern.substr(at + 2, end - at - 2);
        const auto* const found = std::find_if(kClasses.begin(), kClasses.end(),
                                               [&](const CharacterClass& c) { return c.name == name; });
        if (found != kClasses.end()) {
          has = has || found->has(byte) != 0;
          at = end + 2;
          continue;
        }
      }
    }
    const auto one = [&]() -> std::optional<unsigned char> {
      if (pattern[at] == '\\') ++at;
      if (at >= pattern.size()) return std::nullopt;
      return static_cast<unsigned char>(pattern[at++]);
    };
    const std::optional<unsigned char> low = one();
    if (!low) return std::nullopt;
    std::optional<unsigned char> high = low;
    if (at + 1 < pattern.size() && pattern[at] == '-' && pattern[at + 1] != ']') {
      ++at;
      high = one();
      if (!high) return std::nullopt;
    }
    has = has || (*low <= byte && byte <= *high);
  }
  return std::nullopt;
}

/// Returns the position after the pattern element at `at` if that element matches `c`, else nothing.
std::optional<std::size_t> taken(std::string_view pattern, std::size_t at, char c) {
  switch (pattern[at]) {
    case '?':
      return at + 1;
    case '\\':
      if (at + 1 < pattern.size() && pattern[at + 1] == c) return at + 2;
      return std::nullopt;
    case '[':
      if (const auto found = bracket(pattern, at + 1, static_cast<unsigned char>(c)))
        return found->has ? std::optional(found->end) : std::nullopt;
      [[fallthrough]];
    default:
      return pattern[at] == c ? std::optional(at + 1) : std::nullopt;
  }
}

}  // namespace

bool matches_pattern(std::string_view pattern, std::string_view text, MatchBudget& budget) {
  // Backtracking to the last asterisk is enough: if an earlier asterisk matched more text, the later ones
  // would only have less left to match.
  std::size_t p = 0, t = 0, taken_by_star = 0;
  std::optional<std::size_t> star;  // position after the last asterisk
  if (!budget.step()) return false;
  while (t < text.size()) {
    if (!budget.step()) return false;
    if (p < pattern.size() && pattern[p] == '*') {
      star = ++p;
      taken_by_star = t;
      continue;
    }
    if (const auto next = p < pattern.size() ? taken(pattern, p, text[t]) : std::nullopt) {
      p = *next;
      ++t;
    } else if (star) {
      p = *star;
      t = ++taken_by_star;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

}  // namespace fracture
