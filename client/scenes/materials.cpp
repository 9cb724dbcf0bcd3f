// How materials break in the game, and the request for fragments after a hit.
#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "client/scenes/scene.hpp"

namespace fracture::scenes {
namespace {

struct GameMaterial {
  const char* name;
  double density;             ///< kg/m³, as in the server's preset
  double critical_speed;      ///< m/s: a change of speed that breaks an object
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
       {{{"material", "stone"}, {"pattern", "impact"}, {"share", 0.55}, {"exponent", 1.2}, {"max_hulls", 2}},
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

/// Maximum length of `assign` in a query, in bytes. The server's default limit for a whole target is 4,096 bytes.
constexpr std::size_t kMostInQuery = 2048;

/// For the value of a query (RFC 3986, 2.1).
std::string percent_encoded(const std::string& text) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  constexpr std::string_view kUnreserved =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
  std::string encoded;
  for (const char c : text) {
    if (kUnreserved.find(c) != std::string_view::npos) {
      encoded += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    encoded += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return encoded;
}

/// Rounds to a tenth of a millimetre, which is precise enough and gives similar hits the same request.
double rounded(double x) { return std::round(1e4 * x) / 1e4; }
nlohmann::json rounded(const glm::dvec3& p) {
  return nlohmann::json::array({rounded(p.x), rounded(p.y), rounded(p.z)});
}

/// Factor for counts and for the radius.
double growth_of(const Breakage& breakage, const world::Impact& impact) {
  return std::clamp(std::cbrt(std::max(impact.energy, 0.0) / breakage.energy), 0.6, 2.0);
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
  // Parameters that depend on the object's place are kept.
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
  // A hit cannot push a held object away. So a weaker hit breaks it, near the point of impact.
  if (object.held) object.strength = std::min(object.strength, 25 * material->critical_speed);
}

void set_material(Scene& scene, const std::string& name) {
  for (SceneObject& object : scene.objects) set_material(object, name);
}

std::string preparation_query(const SceneObject& object, const nlohmann::json& overrides) {
  const nlohmann::json& parameters = object.breakage.parameters;
  std::string query;
  const auto add = [&](const char* name, const std::string& value) {
    query += (query.empty() ? "" : "&") + std::string(name) + "=" + value;
  };
  if (const auto material = parameters.find("material"); material != parameters.end())
    add("material", material->get<std::string>());
  if (!object.mesh->unit.empty()) add("unit", object.mesh->unit);
  if (const auto assign = overrides.find("assign"); assign != overrides.end()) {
    const std::string text =
        percent_encoded(assign->is_string() ? assign->get<std::string>() : assign->dump());
    if (text.size() <= kMostInQuery) add("assign", text);
  }
  return query;
}

nlohmann::json fracture_parameters(const SceneObject& object, const world::Impact& impact, std::uint64_t seed,
                                   const nlohmann::json& overrides) {
  const Breakage& b = object.breakage;
  const double growth = growth_of(b, impact);
  nlohmann::json parameters = b.parameters;
  parameters["seed"] = seed;
  if (object.mesh && !object.mesh->unit.empty()) parameters["unit"] = object.mesh->unit;
  const bool counts = !parameters.contains("cell") && !parameters.contains("sites");
  if (counts) parameters["sites"] = std::lround(b.sites * growth);
  if (b.impacts && !parameters.contains("impacts"))
    parameters["impacts"] = nlohmann::json::array({rounded(impact.point)});
  if (b.radius) parameters["radius"] = rounded(b.reach * growth);
  if (overrides.is_object()) {
    // Another pattern has other parameters.
    if (overrides.contains("pattern") && overrides["pattern"] != parameters.value("pattern", ""))
      for (const char* key : {"impacts", "radius", "share", "exponent", "cell", "bond", "jitter"})
        parameters.erase(key);
    parameters.update(overrides);
  }
  return parameters;
}

LocalHit local_hit(const SceneObject& object, const world::Impact& impact) {
  constexpr double kShare = 0.5;
  const Breakage& b = object.breakage;
  const double growth = kShare * growth_of(b, impact);
  return {impact.point, rounded(growth * b.reach), static_cast<int>(std::lround(growth * b.sites))};
}

bool takes_hits(const nlohmann::json& parameters) {
  constexpr std::size_t kMostHits = 64;
  return !parameters.contains("levels") && parameters.value("interior_detail", "none") == "none" &&
         parameters.value("local_point", nlohmann::json::array()).size() < kMostHits;
}

nlohmann::json hit_parameters(const std::string& of, const LocalHit& hit) {
  return {{"of", of},
          {"delta", "only"},
          {"local_point", nlohmann::json::array({rounded(hit.point)})},
          {"local_radius", nlohmann::json::array({hit.radius})},
          {"local_sites", nlohmann::json::array({hit.sites})}};
}

nlohmann::json with_hit(nlohmann::json parameters, const LocalHit& hit) {
  parameters["local_point"].push_back(rounded(hit.point));
  parameters["local_radius"].push_back(hit.radius);
  parameters["local_sites"].push_back(hit.sites);
  parameters["local_rest"] = "fractured";
  return parameters;
}

}  // namespace fracture::scenes
