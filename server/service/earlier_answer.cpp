#include "server/service/earlier_answer.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

namespace fracture {
namespace {

bool is_hit(std::string_view name) {
  return name == "local_point" || name == "local_radius" || name == "local_sites" || name == "local_rest";
}

tl::unexpected<Error> wrong(const std::string& name, std::string detail) {
  return fail(ErrorCode::kBadParameter, std::move(detail), name);
}

/// Erases all `interior_` parameters, because a new `interior_material` replaces the look of the inside. Keeps `interior`.
void drop_look(nlohmann::json& parameters) {
  for (auto it = parameters.begin(); it != parameters.end();)
    it = it.key().starts_with("interior_") ? parameters.erase(it) : std::next(it);
}

/// Returns the earlier list with the new values appended.
template <class T, class ToJson>
nlohmann::json continued(const nlohmann::json& earlier, const char* name, const std::vector<T>& more,
                         const ToJson& to_json) {
  nlohmann::json list = earlier.value(name, nlohmann::json::array());
  for (const T& value : more) list.push_back(to_json(value));
  return list;
}

}  // namespace

Expected<std::vector<RawParameter>> on_earlier_answer(const ParameterTable& table,
                                                      const std::vector<RawParameter>& given,
                                                      const RequestParameters& own,
                                                      const nlohmann::json& earlier) {
  const bool hits = !own.local_point.empty();
  const bool hit_before = earlier.contains("local_point");
  const auto given_delta =
      std::find_if(given.begin(), given.end(), [](const RawParameter& raw) { return raw.name == "delta"; });
  const bool compared = given_delta == given.end() || own.delta != DeltaAnswer::kNone;
  if (!hits && hit_before && given_delta != given.end())
    return wrong(
        "delta",
        "'delta' describes the changes that new hits cause: give 'local_point' and 'local_radius' with 'of'.");
  nlohmann::json taken = earlier;
  std::vector<RawParameter> result;
  for (const RawParameter& raw : given) {
    if (raw.name == "of" || (hits && is_hit(raw.name) && raw.name != "local_rest")) continue;
    if (raw.name == "local_new")
      return wrong(raw.name, "With 'of', all hits in this request are new: leave 'local_new' out.");
    if (raw.name == "local_rest") {
      const std::string rest = hit_before ? earlier.value("local_rest", "") : "fractured";
      if (raw.value != rest)
        return wrong(raw.name,
                     "For hits on this answer, 'local_rest' is always '" + rest + "': leave it out.");
      continue;
    }
    if (raw.name == "format") {  // says how to read the body, which is that of the earlier answer
      result.push_back(raw);
      continue;
    }
    const ParameterSpec* spec = table.find(raw.name);
    if (spec && (spec->decides != Decides::kAnswer || raw.name == "material"))
      return wrong(raw.name, "'" + raw.name +
                                 "' is determined by the earlier answer that 'of' refers to: leave it out.");
    // Fragments that the hits do not touch must stay as they are in the caller's answer.
    if (hits && compared && raw.name != "delta" && raw.name != "gravity" && raw.name != "broken")
      return wrong(raw.name, "'" + raw.name +
                                 "' would change fragments that the hits do not touch: leave it out, or set "
                                 "delta=none.");
    taken.erase(raw.name);
    // The new parameter replaces others that set the same thing.
    if (raw.name == "mass") taken.erase("density");
    if (raw.name == "density") taken.erase("mass");
    if (raw.name == "interior_color") taken.erase("interior_mix");
    if (raw.name == "interior_material") drop_look(taken);
    result.push_back(raw);
  }
  for (const char* name : {"delta", "local_new"})
    if (taken.contains(name)) taken.erase(name);
  if (hits) {
    if (earlier.contains("fragment"))
      return wrong(
          "of",
          "'of' refers to an answer with the pieces of one fragment, but hits need an answer for a whole mesh.");
    taken["local_point"] = continued(earlier, "local_point", own.local_point, [](const Vec3d& p) {
      return nlohmann::json{p.x, p.y, p.z};
    });
    const auto same = [](const auto& value) { return nlohmann::json(value); };
    taken["local_radius"] = continued(earlier, "local_radius", own.local_radius, same);
    taken["local_sites"] = continued(earlier, "local_sites", own.local_sites, same);
    if (!hit_before) taken["local_rest"] = "fractured";
    if (given_delta == given.end()) taken["delta"] = "stated";
    if (compared) taken["local_new"] = own.local_point.size();
  }
  for (const auto& [name, value] : taken.items()) result.push_back({name, value, false});
  return result;
}

}  // namespace fracture
