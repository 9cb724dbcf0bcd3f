#include "server/bake/explain.hpp"

#include <algorithm>
#include <utility>

#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"
#include "common/parameters/assignments.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {
namespace {

bool has(const std::vector<RawParameter>& parameters, const std::string& name) {
  return std::any_of(parameters.begin(), parameters.end(),
                     [&](const RawParameter& parameter) { return parameter.name == name; });
}

std::string source_of(const std::string& name, const BakeJob& job, const RuleFile& rules,
                      const JobParameters& parameters) {
  if (has(job.own, name)) return "line " + std::to_string(job.line) + " of the manifest";
  std::string numbers;
  for (const RuleMatch& match : parameters.matches) {
    const Rule& rule = rules.rules[match.rule];
    const bool of_parts =
        rule.is_of_parts() && std::any_of(rule.parameters.begin(), rule.parameters.end(),
                                          [](const RawParameter& p) { return is_assignable(p.name); });
    if (name == "assign" && of_parts)
      numbers += (numbers.empty() ? "" : ", ") + std::to_string(match.rule + 1);
    const bool gives = has(rule.parameters, name) && !(rule.is_of_parts() && is_assignable(name));
    if (gives && name != "assign") return "rule " + std::to_string(match.rule + 1);
  }
  if (!numbers.empty()) return (numbers.find(',') == std::string::npos ? "rule " : "rules ") + numbers;
  return "command line";
}

std::string text_of(const RawParameter& parameter) {
  if (parameter.name == "assign" && parameter.value.is_array()) return assignments_as_text(parameter.value);
  return parameter.is_text && parameter.value.is_string() ? parameter.value.get<std::string>()
                                                          : json_text(parameter.value);
}

}  // namespace

std::optional<MeshFormat> format_given(const BakeJob& job) {
  for (const RawParameter& parameter : job.parameters)
    if (parameter.name == "format" && parameter.value.is_string())
      return format_from_extension(parameter.value.get_ref<const std::string&>());
  return std::nullopt;
}

std::string explanation_of(const BakeJob& job, const RuleFile& rules, const JobParameters& parameters) {
  const std::string materials = materials_beside(job.output);
  std::string text = printable(job.input) + " -> " + printable(job.output) +
                     (materials.empty() ? "" : " with " + printable(materials)) + "\n";
  for (const RuleMatch& match : parameters.matches)
    text +=
        "  rule " + std::to_string(match.rule + 1) + " of " + printable(rules.path) + ": " + match.why + "\n";
  if (parameters.matches.empty() && !rules.path.empty())
    text += "  no rule of " + printable(rules.path) + " matches\n";
  std::vector<RawParameter> sorted = parameters.all;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const RawParameter& a, const RawParameter& b) { return a.name < b.name; });
  for (const RawParameter& parameter : sorted)
    text += "  " + printable(parameter.name) + "=" + printable(text_of(parameter)) + "  (" +
            source_of(parameter.name, job, rules, parameters) + ")\n";
  return text + (sorted.empty() ? "  every parameter has its default value\n" : "");
}

}  // namespace fracture::bake
