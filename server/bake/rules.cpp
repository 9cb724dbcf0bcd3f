#include "server/bake/rules.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <tuple>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/base/json_text.hpp"
#include "common/base/name_pattern.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "server/bake/rule_parameters.hpp"
#include "server/bake/wrong.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;

std::string text_of(const json& value) { return shortened(json_text(value)); }

Expected<std::vector<std::string>> patterns_of(const std::string& name, const json& value) {
  std::vector<std::string> patterns;
  const json list = value.is_array() ? value : json::array({value});
  if (list.empty() || list.size() > kMaxPatternsOfRule)
    return wrong("'" + name + "' must have 1 to " + std::to_string(kMaxPatternsOfRule) +
                 " patterns; it had " + std::to_string(list.size()));
  for (const json& pattern : list) {
    if (!pattern.is_string())
      return wrong("'" + name + "' must be a pattern or a list of patterns; it was " + text_of(value));
    const std::string& text = pattern.get_ref<const std::string&>();
    if (text.empty() || text.size() > kMaxPatternBytes)
      return wrong("a pattern of '" + name + "' must have 1 to " + std::to_string(kMaxPatternBytes) +
                   " bytes; it had " + std::to_string(text.size()));
    if (text.find('\0') != std::string::npos)
      return wrong("a pattern of '" + name + "' must not contain a NUL character; it was " +
                   text_of(pattern));
    patterns.push_back(text);
  }
  return patterns;
}

Expected<void> add_match(const json& match, Rule& rule) {
  if (!match.is_object() || match.empty())
    return wrong("'match' must be an object with at least one of path, node and material");
  for (const auto& [name, value] : match.items()) {
    std::vector<std::string>* list = name == "path"       ? &rule.paths
                                     : name == "node"     ? &rule.nodes
                                     : name == "material" ? &rule.materials
                                                          : nullptr;
    if (!list)
      return wrong("'match' has '" + shortened(name) + "'; only path, node and material are allowed");
    Expected<std::vector<std::string>> patterns = patterns_of(name, value);
    if (!patterns) return tl::unexpected(patterns.error());
    *list = std::move(*patterns);
  }
  return {};
}

Expected<Rule> rule_of(const json& value) {
  if (!value.is_object()) return wrong("it must be an object");
  for (const char* needed : {"match", "parameters"})
    if (!value.contains(needed)) return wrong(std::string("'") + needed + "' is missing");
  Rule rule;
  for (const auto& [name, member] : value.items()) {
    if (name == "match") {
      if (const auto added = add_match(member, rule); !added) return tl::unexpected(added.error());
    } else if (name == "parameters") {
      if (!member.is_object()) return wrong("'parameters' must be an object; it was " + text_of(member));
      for (const auto& [parameter, given] : member.items())
        rule.parameters.push_back({parameter, given, false});
    } else {
      return wrong("'" + shortened(name) + "' is not known; only match and parameters are allowed");
    }
  }
  return rule;
}

std::string name_of_rule(std::size_t index, const RuleFile& file) {
  return "Rule " + std::to_string(index + 1) + " of '" + file.path + "'";
}

bool fits_path(const std::string& pattern, const std::string& path, MatchBudget& budget) {
  const std::string_view whole = path;
  if (matches_pattern(pattern, whole, budget)) return true;
  for (std::size_t at = path.find('/'); at != std::string::npos; at = path.find('/', at + 1))
    if (matches_pattern(pattern, whole.substr(at + 1), budget)) return true;
  return false;
}

std::string quoted(const std::string& text) { return "'" + printable(shortened(text)) + "'"; }

/// Returns the explanation for the first pattern that matches a name, or nothing.
std::optional<std::string> any_fits(const char* what, const std::vector<std::string>& patterns,
                                    const std::set<std::string>& names, MatchBudget& budget) {
  for (const std::string& pattern : patterns) {
    const auto fit = is_plain(pattern)
                         ? names.find(pattern)
                         : std::find_if(names.begin(), names.end(), [&](const std::string& name) {
                             return matches_pattern(pattern, name, budget);
                           });
    if (fit != names.end()) return what + (" " + quoted(pattern)) + " matches " + quoted(*fit);
    if (!budget.step()) break;
  }
  return std::nullopt;
}

/// Returns the reasons why the rule matches, or nothing if it does not match or the budget runs out.
std::optional<std::string> why_it_matches(const Rule& rule, const std::string& path, const MeshNames& names,
                                          MatchBudget& budget) {
  std::string why;
  const auto add = [&why](const std::string& reason) { why += (why.empty() ? "" : ", ") + reason; };
  if (!rule.paths.empty()) {
    const auto fit = std::find_if(rule.paths.begin(), rule.paths.end(), [&](const std::string& pattern) {
      return fits_path(pattern, path, budget);
    });
    if (fit == rule.paths.end()) return std::nullopt;
    add("path " + quoted(*fit) + " matches");
  }
  for (const auto& [what, patterns, list] : {std::tuple("node", &rule.nodes, &names.nodes),
                                             std::tuple("material", &rule.materials, &names.materials)}) {
    if (patterns->empty()) continue;
    const std::optional<std::string> reason = any_fits(what, *patterns, *list, budget);
    if (!reason) return std::nullopt;
    add(*reason);
  }
  return why;
}

/// Returns `path "a*", node ["b", "c"]`, as in the rule file.
std::string patterns_in_words(const Rule& rule) {
  std::string text;
  for (const auto& [name, list] : {std::pair("path ", &rule.paths), std::pair("node ", &rule.nodes),
                                   std::pair("material ", &rule.materials)})
    if (!list->empty())
      text += (text.empty() ? "" : ", ") + std::string(name) +
              text_of(list->size() == 1 ? json(list->front()) : json(*list));
  return text;
}

}  // namespace

bool RuleFile::by_names() const {
  return std::any_of(rules.begin(), rules.end(),
                     [](const Rule& rule) { return !rule.nodes.empty() || !rule.materials.empty(); });
}

Expected<RuleFile> read_rules(const std::string& path) {
  const auto in_file = [&](const std::string& detail) {
    return wrong("The rules file '" + path + "': " + detail + ".");
  };
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  std::string text(kMaxRuleFileBytes + 1, '\0');
  if (stream) stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || (!stream && !stream.eof()))
    return wrong("The rules file '" + path + "' cannot be read: " + std::strerror(errno != 0 ? errno : EIO) +
                 ".");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kMaxRuleFileBytes)
    return in_file("the file has more than " + grouped(kMaxRuleFileBytes) + " bytes, which is the limit");
  const auto read = read_json(text, {});
  if (!read) {
    if (read.error().kind != JsonFault::Kind::kSyntax) return in_file("the file " + to_text(read.error()));
    // The last byte that was read is the one with the error.
    const std::string_view good =
        std::string_view(text).substr(0, std::max<std::size_t>(read.error().byte, 1) - 1);
    const std::size_t line_end = good.rfind('\n');
    const std::string place =
        "line " + std::to_string(1 + std::count(good.begin(), good.end(), '\n')) + ", column " +
        std::to_string(line_end == std::string_view::npos ? good.size() + 1 : good.size() - line_end);
    return in_file(read.error().at_end ? "the JSON ends before it is complete (" + place + ")"
                                       : place + ": not valid JSON");
  }
  const json& document = read->value;
  if (!document.is_object() || !document.contains("rules") || !document["rules"].is_array())
    return in_file("the file must be a JSON object with the list 'rules'");
  for (const auto& [name, value] : document.items())
    if (name != "rules") return in_file("'" + shortened(name) + "' is not known; only 'rules' is allowed");
  RuleFile file{.path = path};
  const json& list = document["rules"];
  if (list.empty() || list.size() > kMaxRules)
    return in_file("there must be 1 to " + grouped(kMaxRules) + " rules; it has " + grouped(list.size()));
  for (const json& value : list) {
    Expected<Rule> rule = rule_of(value);
    if (!rule) return wrong(name_of_rule(file.rules.size(), file) + ": " + rule.error().detail + ".");
    file.rules.push_back(std::move(*rule));
  }
  return file;
}

void put_over(const std::vector<RawParameter>& over, std::vector<RawParameter>& parameters) {
  for (const RawParameter& given : over) {
    std::erase_if(parameters, [&](const RawParameter& p) { return p.name == given.name; });
    parameters.push_back(given);
  }
}

Expected<void> check_rules(const RuleFile& file, const std::vector<RawParameter>& command_line,
                           const ParseParameters& parse) {
  const BakeJob job{.input = {}, .output = {}, .parameters = command_line};
  for (std::size_t k = 0; k < file.rules.size(); ++k)
    if (auto parsed = parse(parameters_of(job, file, {RuleMatch{k, {}}}).all); !parsed) {
      Error error = std::move(parsed.error());
      error.detail = name_of_rule(k, file) + ": " + error.detail;
      return tl::unexpected<Error>(std::move(error));
    }
  return {};
}

Expected<std::vector<RuleMatch>> RuleTally::find(const std::string& path, const MeshNames& names,
                                                 const std::stop_token& stop) {
  MatchBudget budget(kMaxMatchSteps, stop);
  std::vector<RuleMatch> found;
  bool whole = false;  // a rule for the whole mesh was found: later rules decide nothing
  for (std::size_t k = 0; k < file_.rules.size(); ++k) {
    if (whole && seen_[k].matched) continue;  // its match is already recorded
    std::optional<std::string> why = why_it_matches(file_.rules[k], path, names, budget);
    if (budget.stopped()) return fail(ErrorCode::kCancelled, "Stopped.");
    if (budget.spent() && !why) {
      // The remaining rules only matter for warnings. Mark them as used, so that no warning is given for
      // them.
      for (std::size_t rest = k; rest < seen_.size(); ++rest)
        seen_[rest].matched = seen_[rest].decided = true;
      if (whole) break;
      return fail(ErrorCode::kTooLarge,
                  "Its " + grouped(names.nodes.size() + names.materials.size()) + " names need more than " +
                      grouped(kMaxMatchSteps) + " comparisons with the patterns of '" + file_.path +
                      "' up to rule " + std::to_string(k + 1) + ". Use simpler patterns.");
    }
    if (!why) continue;
    seen_[k].matched = true;
    if (whole) continue;
    seen_[k].decided = true;
    found.push_back({k, std::move(*why)});
    whole = !file_.rules[k].is_of_parts();
  }
  return found;
}

void RuleTally::add_unread(const std::string& path) {
  MatchBudget budget(kMaxMatchSteps, {});
  for (std::size_t k = 0; k < file_.rules.size(); ++k) {
    const std::vector<std::string>& paths = file_.rules[k].paths;
    if (paths.empty() || std::any_of(paths.begin(), paths.end(), [&](const std::string& pattern) {
          return fits_path(pattern, path, budget) || budget.spent();
        }))
      seen_[k].matched = seen_[k].decided = true;
  }
}

std::vector<std::string> RuleTally::warnings() const {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < seen_.size(); ++k)
    if (!seen_[k].decided)
      lines.push_back(
          name_of_rule(k, file_) + " (" + patterns_in_words(file_.rules[k]) + ") " +
          (seen_[k].matched
               ? "is never applied, because an earlier rule already applies to every mesh that this rule matches."
           : file_.rules[k].is_of_parts()
               ? "matches no mesh. Bake reads the names of nodes and materials only from glTF, GLB and OBJ files."
               : "matches no mesh."));
  return lines;
}

}  // namespace fracture::bake
