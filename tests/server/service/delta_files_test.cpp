// Fragments in the files of hits: a fragment that a hit leaves alone keeps every bit, and the fragments of a
// delta equal those of the whole answer.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "tests/gltf/glb_file.hpp"
#include "tests/server/service/hits_fixture.hpp"

namespace fracture::test {
namespace {

/// The mass and the inertia of each fragment, by id.
std::map<std::uint64_t, json> motions_of(const FractureResult& glb) {
  std::map<std::uint64_t, json> motions;
  const json document = document_of(glb);
  for (const json& node : document.at("nodes"))
    if (const json::json_pointer id("/extras/fracture/id"); node.contains(id))
      motions[node.at(id).get<std::uint64_t>()] =
          node.at("extensions").at("KHR_physics_rigid_bodies").at("motion");
  return motions;
}

// The total mass is a parameter, and a hit does not change it.
TEST_F(HitsTest, WhatAHitLeavesAloneKeepsItsMassToTheBit) {
  for (const char* dual : {"circumcenter", "barycenter"})
    for (const double mass : {5.0, 0.37, 80.1}) {
      SCOPED_TRACE(std::string(dual) + " " + std::to_string(mass));
      const json whole = {{"sites", 40}, {"mass", mass}, {"physics", "khr"}, {"dual", dual}};
      const FractureAnswer before = ask(whole);
      const FractureAnswer after = ask({{"of", address(before)},
                                        {"local_point", {2, 0.5, 0.5}},
                                        {"local_radius", 0.2},
                                        {"local_sites", 7}});
      const json delta = figures_of(*after.result).at("delta");
      std::set<std::uint64_t> named;
      for (const char* list : {"new", "changed", "gone"})
        for (const std::uint64_t id : ids(delta, list)) named.insert(id);
      const auto was = motions_of(*before.result), is = motions_of(*after.result);
      std::size_t kept = 0;
      double sum = 0;
      for (const auto& [id, motion] : is) {
        sum += motion.at("mass").get<double>();
        if (named.contains(id)) continue;
        ++kept;
        EXPECT_EQ(motion, was.at(id));
      }
      EXPECT_GT(kept, 10u);
      EXPECT_FALSE(named.empty());
      EXPECT_NEAR(sum, mass, 1e-6 * mass);
    }
}

/// The attributes of each primitive of each fragment: by id, then by attribute name.
std::map<std::uint64_t, std::vector<std::map<std::string, std::vector<float>>>> attributes_of(
    const FractureResult& result) {
  std::map<std::uint64_t, std::vector<std::map<std::string, std::vector<float>>>> all;
  const std::vector<std::uint8_t> bytes(result.file.begin(), result.file.end());
  const Glb glb(bytes);
  for (const json& node : glb.document.at("nodes")) {
    const json::json_pointer id("/extras/fracture/id");
    if (!node.contains(id)) continue;
    auto& primitives = all[node.at(id).get<std::uint64_t>()];
    for (const json& primitive :
         glb.document.at("meshes").at(node.at("mesh").get<std::size_t>()).at("primitives")) {
      auto& attributes = primitives.emplace_back();
      for (const auto& [semantic, accessor] : primitive.at("attributes").items()) {
        const std::string type = glb.document.at("accessors").at(accessor.get<std::size_t>()).at("type");
        std::vector<float>& values = attributes[semantic];
        const auto append = [&](const auto& vectors) {
          for (const auto& v : vectors) {
            const auto* const first = reinterpret_cast<const float*>(&v);
            values.insert(values.end(), first, first + sizeof(v) / sizeof(float));
          }
        };
        if (type == "VEC2") append(glb.read<Vec2f>(accessor));
        if (type == "VEC3") append(glb.read<Vec3f>(accessor));
        if (type == "VEC4") append(glb.read<Vec4f>(accessor));
      }
    }
  }
  return all;
}

/// The index of the group that holds each fragment, by id; -1: the root holds it.
std::map<std::uint64_t, int> groups_of(const FractureResult& result) {
  const json document = document_of(result), nodes = document.at("nodes");
  const json::json_pointer id("/extras/fracture/id"), index("/extras/fracture/source/index");
  std::map<std::uint64_t, int> groups;
  for (const json& node : nodes) {
    const int group = node.contains(index) && !node.contains(id) ? node.at(index).get<int>() : -1;
    for (const json& child : node.value("children", json::array()))
      if (const json& below = nodes.at(child.get<std::size_t>()); below.contains(id))
        groups[below.at(id).get<std::uint64_t>()] = group;
  }
  return groups;
}

// A client puts the fragments of a delta into the groups that it has.
TEST_F(HitsTest, FragmentsOfADeltaAreInTheGroupsThatTheWholeAnswerHas) {
  const std::string boxes =
      "o left\n" + box_obj(1) +
      "o right\nv 2 0 0\nv 3 0 0\nv 3 1 0\nv 2 1 0\nv 2 0 1\nv 3 0 1\nv 3 1 1\nv 2 1 1\n"
      "f 25 28 27 26\nf 29 30 31 32\nf 25 26 30 29\nf 26 27 31 30\nf 27 28 32 31\nf 28 25 29 32\n";
  const FractureAnswer first = ask(service, boxes, {{"sites", 40}}).value();
  json hit = {
      {"of", address(first)}, {"local_point", {1, 0.5, 0.5}}, {"local_radius", 0.3}, {"local_sites", 8}};
  const FractureAnswer whole = ask(service, boxes, hit).value();
  hit["delta"] = "only";
  const FractureAnswer changed = ask(service, boxes, hit).value();
  const std::map<std::uint64_t, int> before = groups_of(*first.result), after = groups_of(*whole.result),
                                     only = groups_of(*changed.result);
  EXPECT_EQ(after.size(), fragment_ids(*whole.result).size()) << "each has one parent";
  EXPECT_EQ(only.size(), fragment_ids(*changed.result).size());
  EXPECT_GT(only.size(), 3u);
  EXPECT_LT(only.size(), after.size());
  std::set<int> groups;
  for (const auto& [id, group] : after) {
    groups.insert(group);
    EXPECT_EQ(only.contains(id) ? only.at(id) : before.at(id), group) << id;
  }
  EXPECT_TRUE(groups.contains(0) && groups.contains(1)) << "left and right";
}

// A client shows the fragments of a delta together with those that it has.
TEST_F(HitsTest, FragmentsOfADeltaAreUnderTheReliefThatAClientHas) {
  const json hit = {{"local_point", {2, 0.5, 0.5}}, {"local_radius", 0.3}, {"local_sites", 8}};
  // The box has no normals. The fragments of the first answer have normals, tangents and a normal map.
  const FractureAnswer box = ask({{"sites", 3}, {"interior_detail", "stone"}});
  const std::string with_tangents(box.result->file.begin(), box.result->file.end());
  for (const auto& [name, file, format] :
       {std::tuple{"box", mesh, MeshFormat::kObj}, {"fragments", with_tangents, MeshFormat::kGlb}}) {
    SCOPED_TRACE(name);
    const auto answer = [&](json parameters) {
      std::vector<RawParameter> given;
      for (const auto& [key, value] : parameters.items()) given.push_back({key, value, false});
      const FractureRequest request{bytes(file), format, service.parse(given).value()};
      return service.fracture(request, {}).value();
    };
    const FractureAnswer first = answer({{"sites", 30}, {"interior_detail", "stone"}});
    json parameters = hit;
    parameters["of"] = address(first);
    const auto whole = attributes_of(*answer(parameters).result);
    parameters["delta"] = "only";
    const auto changed = attributes_of(*answer(parameters).result);
    EXPECT_GT(changed.size(), 3u);
    EXPECT_LT(changed.size(), whole.size());
    for (const auto& [id, primitives] : changed) {
      EXPECT_TRUE(primitives.back().contains("TANGENT")) << "of the cuts";
      EXPECT_TRUE(primitives == whole.at(id));
    }
  }
}

}  // namespace
}  // namespace fracture::test
