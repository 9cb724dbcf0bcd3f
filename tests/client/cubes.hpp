// Fragments whose motion and loads can be predicted: rows and walls of equal cubes.
#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/world/world.hpp"

namespace fracture::test {

inline world::Hull cube_hull(const glm::dvec3& center, double side) {
  world::Hull hull;
  for (int k = 0; k < 8; ++k)
    hull.push_back(center + 0.5 * side * glm::dvec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
  return hull;
}

inline world::MassProperties cube_mass(const glm::dvec3& center, double side, double density) {
  const double mass = density * side * side * side;
  return {mass, center, glm::dmat3(mass * side * side / 6)};
}

/// columns × rows cubes in the plane z = 0, bonded to their neighbours. The lower left one is at (side / 2,
/// side / 2). `strength` in Pa. The fragment number is row · columns + column; its id is 1000 + number.
inline world::FragmentSet cubes(int columns, int rows, double side = 0.5, double density = 1000,
                                double strength = 1e6) {
  world::FragmentSet set;
  const auto number = [&](int column, int row) { return static_cast<std::uint32_t>(row * columns + column); };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const glm::dvec3 center(side * (column + 0.5), side * (row + 0.5), 0);
      world::Fragment fragment;
      fragment.id = 1000 + number(column, row);
      fragment.volume = side * side * side;
      fragment.mass = cube_mass(center, side, density);
      fragment.hulls = {cube_hull(center, 0.999 * side)};
      set.fragments.push_back(std::move(fragment));
      const double area = side * side;
      if (column > 0)
        set.bonds.push_back({number(column - 1, row),
                             number(column, row),
                             area,
                             strength * area,
                             {1, 0, 0},
                             center - glm::dvec3(0.5 * side, 0, 0)});
      if (row > 0)
        set.bonds.push_back({number(column, row - 1),
                             number(column, row),
                             area,
                             strength * area,
                             {0, 1, 0},
                             center - glm::dvec3(0, 0.5 * side, 0)});
    }
  return set;
}

/// The intact object that breaks into `set`: one hull for each fragment.
inline world::ObjectSpec whole_of(const world::FragmentSet& set) {
  world::ObjectSpec spec;
  std::vector<world::MassProperties> masses;
  for (const world::Fragment& fragment : set.fragments) {
    masses.push_back(fragment.mass);
    spec.hulls.insert(spec.hulls.end(), fragment.hulls.begin(), fragment.hulls.end());
  }
  spec.mass = world::combine(masses);
  spec.strength = 1e9;
  return spec;
}

inline world::WorldSettings without_gravity() {
  world::WorldSettings settings;
  settings.gravity = glm::dvec3(0);
  return settings;
}

inline void run(world::World& world, double seconds) {
  const auto steps = static_cast<int>(std::lround(seconds / world.settings().step));
  for (int k = 0; k < steps; ++k) world.step();
}

/// Adds the intact object of a set, tilted, at a height of 10 m. A ball from the side made it move and turn
/// half a second ago.
inline world::ObjectId struck_from_aside(world::World& world, const world::FragmentSet& set) {
  world::ObjectSpec spec = whole_of(set);
  spec.pose = {{0, 10, 0}, glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3)))};
  const world::ObjectId object = world.add_object(spec);
  world.throw_ball({-2, 10.4, 0.3}, {15, 1, 0.5}, 0.2, 5000);
  run(world, 0.5);
  return object;
}

inline std::size_t groups_of(const world::World& world, world::ObjectId object) {
  std::vector<world::FragmentState> states;
  world.fragment_states(object, states);
  std::vector<std::uint32_t> groups;
  for (const world::FragmentState& state : states)
    if (state.present) groups.push_back(state.group);
  std::sort(groups.begin(), groups.end());
  return static_cast<std::size_t>(std::unique(groups.begin(), groups.end()) - groups.begin());
}

/// Two bonded cubes (ids 7 and 9) as the service writes them: JSON that tests can damage, and the binary
/// part.
struct GlbParts {
  nlohmann::json json;
  std::string binary;
  std::string bytes() const {
    std::string text = json.dump(), data = binary;
    text.append((4 - text.size() % 4) % 4, ' ');
    data.append((4 - data.size() % 4) % 4, '\0');
    std::string glb = "glTF";
    const auto put = [&](std::uint32_t x) { glb.append(reinterpret_cast<const char*>(&x), 4); };
    put(2);
    put(static_cast<std::uint32_t>(28 + text.size() + data.size()));
    put(static_cast<std::uint32_t>(text.size()));
    put(0x4E4F534Au);
    glb += text;
    put(static_cast<std::uint32_t>(data.size()));
    put(0x004E4942u);
    return glb + data;
  }
};

inline GlbParts two_cubes_glb() {
  using nlohmann::json;
  GlbParts parts;
  std::vector<float> corners;
  for (int k = 0; k < 8; ++k)
    for (const int bit : {1, 2, 4}) corners.push_back(k & bit ? 0.5f : -0.5f);
  // 12 triangles of the cube with corner k at (bit 0, bit 1, bit 2), counter-clockwise seen from outside
  const std::vector<std::uint16_t> triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  parts.binary.assign(reinterpret_cast<const char*>(corners.data()), 96);
  parts.binary.append(reinterpret_cast<const char*>(triangles.data()), 72);
  const auto node = [](const char* name, int hull, double x, std::uint64_t id, bool anchored) {
    return json{
        {"name", name},
        {"mesh", 0},
        {"translation", {x, 0, 0}},
        {"extras",
         {{"fracture",
           {{"id", id}, {"volume", 1.0}, {"mass", 2000.0}, {"level", 0}, {"anchored", anchored}}}}},
        {"extensions",
         {{"KHR_physics_rigid_bodies",
           {{"motion",
             {{"mass", 2000.0},
              {"centerOfMass", {0.0, 0.0, 0.0}},
              {"inertiaDiagonal", {333.0, 333.0, 333.0}},
              {"inertiaOrientation", {0.0, 0.0, 0.0, 1.0}}}},
            {"collider", {{"geometry", {{"mesh", hull}, {"convexHull", true}}}, {"physicsMaterial", 0}}}}}}}};
  };
  const json primitive = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}};
  parts.json = {
      {"asset", {{"version", "2.0"}}},
      {"extensionsUsed", {"KHR_physics_rigid_bodies"}},
      {"extensions",
       {{"KHR_physics_rigid_bodies",
         {{"physicsMaterials",
           {{{"staticFriction", 0.5}, {"dynamicFriction", 0.4}, {"restitution", 0.25}}}}}}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes",
       {{{"name", "Fracture"},
         {"children", {1, 2}},
         {"extras",
          {{"fracture",
            {{"version", 1},
             {"bonds",
              {{"a", {7}},
               {"b", {9}},
               {"area", {1.0}},
               {"centroid", {{0.5, 0, 0}}},
               {"normal", {{1.0, 0.0, 0.0}}},
               {"strength", {1e6}}}}}}}}},
        node("a", 1, 0, 7, true),
        node("b", 1, 1, 9, false)}},
      {"meshes",
       {{{"name", "cube"}, {"primitives", {primitive}}}, {{"name", "hull"}, {"primitives", {primitive}}}}},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", 8},
         {"type", "VEC3"},
         {"min", {-0.5, -0.5, -0.5}},
         {"max", {0.5, 0.5, 0.5}}},
        {{"bufferView", 1}, {"componentType", 5123}, {"count", 36}, {"type", "SCALAR"}}}},
      {"bufferViews",
       {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 96}},
        {{"buffer", 0}, {"byteOffset", 96}, {"byteLength", 72}}}},
      {"buffers", {{{"byteLength", 168}}}}};
  return parts;
}

/// The change after a hit on the second of the two cubes, as the service writes it with delta=only. The cube
/// has become two slabs with ids 11 and 12.
inline GlbParts halved_cube_glb() {
  using nlohmann::json;
  GlbParts parts = two_cubes_glb();
  std::vector<float> corners;
  for (int k = 0; k < 8; ++k)
    for (const int bit : {1, 2, 4}) corners.push_back((k & bit ? 0.5f : -0.5f) * (bit == 1 ? 0.5f : 1.f));
  const std::size_t offset = parts.binary.size();
  parts.binary.append(reinterpret_cast<const char*>(corners.data()), 96);
  json& document = parts.json;
  document["buffers"][0]["byteLength"] = parts.binary.size();
  document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", 96}});
  document["accessors"].push_back({{"bufferView", 2},
                                   {"componentType", 5126},
                                   {"count", 8},
                                   {"type", "VEC3"},
                                   {"min", {-0.25, -0.5, -0.5}},
                                   {"max", {0.25, 0.5, 0.5}}});
  for (json& mesh : document["meshes"]) mesh["primitives"][0]["attributes"]["POSITION"] = 2;
  for (const int k : {1, 2}) {
    json& node = document["nodes"][k];
    node["translation"] = {k == 1 ? 0.75 : 1.25, 0, 0};
    json& own = node["extras"]["fracture"];
    own["id"] = 10 + k;
    own["volume"] = 0.5;
    own["mass"] = 1000;
    own["anchored"] = false;
    json& motion = node["extensions"]["KHR_physics_rigid_bodies"]["motion"];
    motion["mass"] = 1000.0;
    motion["inertiaDiagonal"] = {1000.0 / 6, 1250.0 / 12, 1250.0 / 12};
  }
  json& root = document["nodes"][0]["extras"]["fracture"];
  const double strength = root["bonds"]["strength"][0];
  root["delta"] = {{"new", {11, 12}}, {"changed", json::array()}, {"gone", {9}}};
  root["bonds"] = {{"a", {7, 11}},
                   {"b", {11, 12}},
                   {"area", {1.0, 1.0}},
                   {"centroid", {{0.5, 0, 0}, {1.0, 0, 0}}},
                   {"normal", {{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}},
                   {"strength", {strength, strength}}};
  return parts;
}

}  // namespace fracture::test
