#include "server/bake/explain.hpp"

#include <algorithm>
#include <utility>

#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"

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
  if (parameters.match && has(rules.rules[parameters.match->rule].parameters, name))
    return "rule " + std::to_string(parameters.match->rule + 1);
  return "command line";
}

std::string text_of(const RawParameter& parameter) {
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

JobParameters parameters_of(const BakeJob& job, const RuleFile& rules, std::optional<RuleMatch> match) {
  JobParameters result{job.parameters, std::move(match)};
  if (!result.match) return result;
  put_over(rules.rules[result.match->rule].parameters, result.all);
  put_over(job.own, result.all);
  return result;
}

std::string explanation_of(const BakeJob& job, const RuleFile& rules, const JobParameters& parameters) {
  const std::string materials = materials_beside(job.output);
  std::string text = printable(job.input) + " -> " + printable(job.output) +
                     (materials.empty() ? "" : " with " + printable(materials)) + "\n";
  if (parameters.match)
    text += "  rule " + std::to_string(parameters.match->rule + 1) + " of " + printable(rules.path) + ": " +
            parameters.match->why + "\n";
  else if (!rules.path.empty())
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
