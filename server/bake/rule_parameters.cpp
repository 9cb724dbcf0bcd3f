#include "server/bake/rule_parameters.hpp"

#include <algorithm>
#include <utility>

#include "common/parameters/assignments.hpp"
#include "common/parameters/parameter_object.hpp"
#include "common/parameters/values.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;

const RawParameter* find(const std::vector<RawParameter>& parameters, std::string_view name) {
  const auto at = std::find_if(parameters.begin(), parameters.end(),
                               [&](const RawParameter& parameter) { return parameter.name == name; });
  return at == parameters.end() ? nullptr : &*at;
}

/// Whether parts with a material of their own do not use it.
bool is_of_material(const std::string& name) { return is_assignable(name) && !is_inherited(name); }

/// Returns the value of a parameter as JSON, because an entry of `assign` is JSON. A value that cannot be read stays text, and is
/// refused later.
json as_json(const RawParameter& parameter) {
  static const ParameterTable table(kMostSitesAnywhere, FormatSet::all());
  const ParameterSpec* const spec = parameter.is_text ? table.find(parameter.name) : nullptr;
  if (!spec) return parameter.value;
  const Expected<ParameterValue> value = to_value(*spec, parameter);
  return value ? to_json(*spec, *value) : parameter.value;
}

/// Appends the entries of a parameter `assign`.
void append_entries(const RawParameter* assign, json& list) {
  if (!assign) return;
  const Expected<std::vector<RawAssignment>> entries = to_assignments(*assign);
  if (!entries) {  // is refused later
    list.push_back(assign->value);
    return;
  }
  for (const RawAssignment& given : *entries) {
    json entry = to_json(given.selector);
    for (const RawParameter& parameter : given.parameters) entry[parameter.name] = parameter.value;
    list.push_back(std::move(entry));
  }
}

}  // namespace

JobParameters parameters_of(const BakeJob& job, const RuleFile& rules, std::vector<RuleMatch> matches) {
  JobParameters result{job.parameters, std::move(matches)};
  if (result.matches.empty()) return result;
  std::vector<RawParameter> whole;
  for (const RuleMatch& match : result.matches) {
    const Rule& rule = rules.rules[match.rule];
    for (const RawParameter& parameter : rule.parameters)
      if (!(rule.is_of_parts() && is_assignable(parameter.name)) && !find(whole, parameter.name))
        whole.push_back(parameter);
  }
  put_over(whole, result.all);
  put_over(job.own, result.all);

  json entries = json::array();
  append_entries(find(job.own, "assign"), entries);
  for (const RuleMatch& match : result.matches) {
    const Rule& rule = rules.rules[match.rule];
    if (!rule.is_of_parts()) continue;
    json entry = to_json(PartSelector{.nodes = rule.nodes, .slots = rule.materials});
    const std::size_t selectors = entry.size();
    for (const RawParameter& parameter : rule.parameters)
      if (is_assignable(parameter.name)) entry[parameter.name] = as_json(parameter);
    if (entry.size() == selectors) continue;  // it has only parameters for the whole mesh
    if (!entry.contains("material"))
      for (const RawParameter& parameter : result.all)
        if (is_of_material(parameter.name) && !entry.contains(parameter.name))
          entry[parameter.name] = as_json(parameter);
    for (const RawParameter& parameter : job.own)
      if (is_of_material(parameter.name)) entry[parameter.name] = as_json(parameter);
    entries.push_back(std::move(entry));
  }
  if (entries.empty()) return result;
  const RawParameter* rest = find(whole, "assign");
  if (!rest && !find(job.own, "assign")) rest = find(job.parameters, "assign");
  append_entries(rest, entries);
  put_over({{"assign", std::move(entries), false}}, result.all);
  return result;
}

}  // namespace fracture::bake
