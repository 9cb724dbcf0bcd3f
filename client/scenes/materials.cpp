// How materials break in the game, and the request that a hit becomes.
#include <algorithm>
#include <cmath>

#include "client/scenes/scene.hpp"

namespace fracture::scenes {
namespace {

struct GameMaterial {
  const char* name;
  double density;             ///< kg/m³, as the server's preset
  double critical_speed;      ///< m/s: a change of an object's speed that breaks it
  double reach, crack_front;  ///< as in world::ObjectSpec
  render::SolidLook look;
  Breakage breakage;
};

const std::vector<GameMaterial>& game_materials() {
  using render::SolidLook;
  static const std::vector<GameMaterial> all = {
      {"glass", 2500, 0.7, 4, 0.02, SolidLook::kGlass, {{{"material", "glass"}}, true, false, 70, 0.4, 300}},
      {"wood", 500, 2.2, 0.5, 0.4, SolidLook::kWood, {{{"material", "wood"}}, false, false, 40, 0.5, 500}},
      {"concrete",
       2400,
       1.4,
       1,
       0.3,
       SolidLook::kConcrete,
       {{{"material", "concrete"}}, false, false, 90, 0.6, 2000}},
      {"stone",
       2700,
       1.5,
       2,
       0.08,
       SolidLook::kStone,
       {{{"material", "stone"}, {"pattern", "impact"}, {"share", 0.55}, {"exponent", 1.2}},
        true,
        true,
        70,
        0.6,
        2000}},
      {"brick",
       1900,
       1.2,
       0.5,
       0.4,
       SolidLook::kBrick,
       {{{"material", "brick"}}, false, false, 90, 0.5, 1000}},
      {"ceramic",
       2400,
       0.9,
       4,
       0.002,
       SolidLook::kCeramic,
       {{{"material", "ceramic"}}, true, true, 80, 0.45, 1000}},
      {"metal", 7850, 6, 5, 0.5, SolidLook::kMetal, {{{"material", "metal"}}, false, false, 30, 0.5, 5000}},
      {"ice", 917, 0.8, 3, 0.01, SolidLook::kIce, {{{"material", "ice"}}, true, false, 90, 0.5, 500}},
  };
  return all;
}

}  // namespace

const std::vector<std::string>& material_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const GameMaterial& material : game_materials()) list.emplace_back(material.name);
    return list;
  }();
  return names;
}

void set_material(SceneObject& object, const std::string& name) {
  const auto& all = game_materials();
  const auto material =
      std::find_if(all.begin(), all.end(), [&](const GameMaterial& m) { return m.name == name; });
  if (material == all.end()) return;
  // What the place of the object demands stays.
  nlohmann::json kept = nlohmann::json::object();
  for (const char* key : {"anchor_plane", "anchor_box", "anchor_points"})
    if (object.breakage.parameters.contains(key)) kept[key] = object.breakage.parameters[key];
  object.breakage = material->breakage;
  object.breakage.parameters.update(kept);
  object.density = material->density;
  object.reach = material->reach;
  object.crack_front = material->crack_front;
  object.look = material->look;
  object.at_start = false;
  object.strength = material->critical_speed * object.density * object.mesh->unit_mass.mass;
  // A held thing does not get faster as a whole: it breaks where it is hit.
  if (object.held) object.strength = std::min(object.strength, 25 * material->critical_speed);
}

void set_material(Scene& scene, const std::string& name) {
  for (SceneObject& object : scene.objects) set_material(object, name);
}

std::string preparation_query(const SceneObject& object) {
  const nlohmann::json& parameters = object.breakage.parameters;
  std::string query;
  const auto add = [&](const char* name, const std::string& value) {
    query += (query.empty() ? "" : "&") + std::string(name) + "=" + value;
  };
  if (const auto material = parameters.find("material"); material != parameters.end())
    add("material", material->get<std::string>());
  if (!object.mesh->unit.empty()) add("unit", object.mesh->unit);
  return query;
}

nlohmann::json fracture_parameters(const SceneObject& object, const world::Impact& impact, std::uint64_t seed,
                                   const nlohmann::json& overrides) {
  const Breakage& b = object.breakage;
  const double growth = std::clamp(std::cbrt(std::max(impact.energy, 0.0) / b.energy), 0.6, 2.0);
  nlohmann::json parameters = b.parameters;
  parameters["seed"] = seed;
  if (object.mesh && !object.mesh->unit.empty()) parameters["unit"] = object.mesh->unit;
  const bool counts = !parameters.contains("cell") && !parameters.contains("sites");
  if (counts) parameters["sites"] = std::lround(b.sites * growth);
  // A tenth of a millimetre is enough, and keeps requests of like hits alike.
  const auto rounded = [](double x) { return std::round(1e4 * x) / 1e4; };
  if (b.impacts && !parameters.contains("impacts"))
    parameters["impacts"] = nlohmann::json::array(
        {nlohmann::json::array({rounded(impact.point.x), rounded(impact.point.y), rounded(impact.point.z)})});
  if (b.radius) parameters["radius"] = rounded(b.reach * growth);
  if (overrides.is_object()) {
    // Another pattern takes other parameters.
    if (overrides.contains("pattern") && overrides["pattern"] != parameters.value("pattern", ""))
      for (const char* key : {"impacts", "radius", "share", "exponent", "cell", "bond", "jitter"})
        parameters.erase(key);
    parameters.update(overrides);
  }
  return parameters;
}

}  // namespace fracture::scenes
