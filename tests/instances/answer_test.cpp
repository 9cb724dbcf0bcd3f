// Answers that contain a shape once, and a node for each instance that stays whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/gltf/gltf_writer.hpp"
#include "common/hits/delta.hpp"
#include "common/outputs/answer.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/hits/delta_checks.hpp"
#include "tests/instances/scenes.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

constexpr const char* kRigidBodies = "KHR_physics_rigid_bodies";

FractureParameters wanted(std::uint32_t fragments) {
  FractureParameters p;
  p.sites = fragments;
  p.size.fragments = fragments;
  p.seed = 7;
  p.hulls = Hulls::kConvex;
  return p;
}

Similarity place_of(const json& node) {
  Similarity place;
  if (node.contains("translation"))
    place.move = {node["translation"][0], node["translation"][1], node["translation"][2]};
  if (node.contains("rotation"))
    for (std::size_t k = 0; k < 4; ++k) place.rotation[k] = node["rotation"][k];
  if (node.contains("scale")) place.scale = node["scale"][0];
  return place;
}

double distance_to(const std::vector<Vec3d>& points, const Vec3d& p) {
  double least = HUGE_VAL;
  for (const Vec3d& q : points) least = std::min(least, length(p - q));
  return least;
}

TEST(InstanceAnswer, ThreeThousandTuftsAreAsManyBodiesInASmallFile) {
  const Grass grass(18);
  const std::vector<Place> places = meadow(3001);
  const Fractured made = fracture_solid(solid_of_glb(grass.glb(places)), wanted(30));
  EXPECT_EQ(made.solid.parts.size(), 18u * 3001u);
  EXPECT_EQ(made.set.fragments.size(), 3001u);
  const std::vector<std::uint8_t> bytes = write_glb(made, {});
  EXPECT_LT(bytes.size(), 5'000'000u);
  const Glb glb(bytes);
  const std::vector<json> bodies = bodies_of(glb.document);
  ASSERT_EQ(bodies.size(), 3001u);
  std::set<std::size_t> meshes;
  for (const json& node : bodies) {
    meshes.insert(node["mesh"].get<std::size_t>());
    EXPECT_GT(node["extensions"][kRigidBodies]["motion"]["mass"].get<double>(), 0);
  }
  EXPECT_EQ(meshes.size(), 1u);
  const json& report = glb.document["nodes"][0]["extras"]["fracture"]["report"];
  EXPECT_EQ(report["instances"], (json{{"fragments", 3001}, {"shapes", 1}}));
}

/// A few tufts with the answer's nodes in the order of the places.
struct SmallMeadow {
  Grass grass{6};
  std::vector<Place> places = meadow(12);
  Fractured made = fracture_solid(solid_of_glb(grass.glb(places)), wanted(4));
  Glb glb{write_glb(made, {})};
  std::vector<json> nodes = bodies_of(glb.document);  // node for each place, nearest first

  const json& node_at(const Place& place) const {
    return *std::min_element(nodes.begin(), nodes.end(), [&](const json& a, const json& b) {
      return length(place_of(a).move - place.translation) < length(place_of(b).move - place.translation);
    });
  }
};

TEST(InstanceAnswer, PlacesTheShapeWhereTheFileHasIt) {
  const SmallMeadow m;
  ASSERT_EQ(m.nodes.size(), m.places.size());
  const double tolerance = 2 * kInstanceTolerance * 4;  // the largest coordinate is less than 4 m
  for (const Place& place : m.places) {
    const json& node = m.node_at(place);
    const Similarity here = place_of(node), given{place.rotation, place.scale.x, place.translation};
    const json& mesh = m.glb.document["meshes"].at(node["mesh"].get<std::size_t>());
    const auto points = m.glb.read<Vec3f>(mesh["primitives"][0]["attributes"]["POSITION"]);
    ASSERT_EQ(points.size(), m.grass.points().size());
    std::vector<Vec3d> written;
    for (const Vec3f& p : points) written.push_back(here.point(to_double(p)));
    for (const Vec3f& p : m.grass.points())
      EXPECT_LT(distance_to(written, given.point(to_double(p))), tolerance);
  }
}

TEST(InstanceAnswer, MassPropertiesAreThoseOfThePlacedShape) {
  const SmallMeadow m;
  for (std::size_t k = 0; k < m.made.set.fragments.size(); ++k) {
    const Fragment& f = m.made.set.fragments[k];
    const auto at = std::find_if(m.nodes.begin(), m.nodes.end(),
                                 [&](const json& node) { return node["extras"]["fracture"]["id"] == f.id; });
    ASSERT_NE(at, m.nodes.end());
    const json& motion = (*at)["extensions"][kRigidBodies]["motion"];
    const Similarity place = place_of(*at);
    EXPECT_NEAR(motion["mass"].get<double>(), 1000 * f.mass.volume, 1e-6 * 1000 * f.mass.volume);
    const json& c = motion["centerOfMass"];
    EXPECT_LT(length(place.point({c[0], c[1], c[2]}) - f.mass.center_of_mass), 1e-6);
    // The tensor in the scene's directions, from the principal axes in the node's frame.
    Quaternion q;
    for (std::size_t i = 0; i < 4; ++i) q[i] = motion["inertiaOrientation"][i];
    q = product(place.rotation, q);
    double xx = 0, xz = 0, trace = 0;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d unit;
      unit[axis] = 1;
      const Vec3d along = rotated(q, unit);
      const double moment = motion["inertiaDiagonal"][static_cast<std::size_t>(axis)];
      xx += moment * along.x * along.x;
      xz += moment * along.x * along.z;
      trace += moment;
    }
    EXPECT_NEAR(xx, 1000 * f.mass.inertia[0], 1e-5 * trace);
    EXPECT_NEAR(xz, 1000 * f.mass.inertia[4], 1e-5 * trace);
  }
}

TEST(InstanceAnswer, HullsAreThoseOfThePlacedShape) {
  const SmallMeadow m;
  for (std::size_t k = 0; k < m.made.set.fragments.size(); ++k) {
    const InstancedBodies::Body* const body = m.made.instances.of(k);
    ASSERT_NE(body, nullptr);
    const FragmentHulls& shape = m.made.instances.hulls[body->shape];
    const FragmentHulls& placed = m.made.hulls.of_fragment[k];
    ASSERT_EQ(shape.hulls.size(), placed.hulls.size());
    EXPECT_TRUE(placed.shared);
    for (std::size_t h = 0; h < shape.hulls.size(); ++h)
      for (std::size_t p = 0; p < shape.hulls[h].points.size(); ++p) {
        const Vec3d world = body->place().point(to_double(shape.hulls[h].points[p]));
        EXPECT_LT(length(world - m.made.set.fragments[k].pivot - to_double(placed.hulls[h].points[p])), 1e-6);
      }
  }
}

TEST(InstanceAnswer, SeparateAndPivotSourceWriteAMeshForEachFragment) {
  const Grass grass(6);
  const Solid solid = solid_of_glb(grass.glb(meadow(12)));
  FractureParameters p = wanted(4);
  p.instances = InstanceUse::kSeparate;
  const Fractured separate = fracture_solid(solid, p);
  EXPECT_GE(separate.set.fragments.size(), 12u * 6u);
  EXPECT_TRUE(separate.instances.of_fragment.empty());
  p = wanted(4);
  p.pivot = Pivot::kSource;
  const Fractured source = fracture_solid(solid, p);
  EXPECT_EQ(source.set.fragments.size(), 12u);
  EXPECT_TRUE(source.instances.of_fragment.empty());
  const json document = Glb(write_glb(source, {})).document;
  for (const json& node : bodies_of(document)) EXPECT_FALSE(node.contains("rotation"));
}

TEST(InstanceAnswer, GodotGetsNoScaledBodies) {
  const SmallMeadow m;
  GltfOptions options;
  options.physics = Physics::kOmi;
  const json document = Glb(write_glb(m.made, options)).document;
  std::size_t turned = 0;
  for (const json& node : bodies_of(document)) {
    EXPECT_FALSE(node.contains("scale"));
    turned += node.contains("rotation");
  }
  EXPECT_GT(turned, 0u) << "two places of the meadow have the largest scale";
}

TEST(InstanceAnswer, CutInstancesKeepMeshesOfTheirOwn) {
  const Grass grass(1);
  std::vector<Place> places = meadow(6);
  for (Place& place : places) place.scale = {1, 1, 1};
  places.push_back({{20, 0, 0}, about_y(0), {3, 3, 3}});  // 27 of 33 volumes
  const Fractured made = fracture_solid(solid_of_glb(grass.glb(places)), wanted(12));
  std::size_t whole = 0;
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) whole += made.instances.of(k) != nullptr;
  EXPECT_EQ(whole, 6u);
  EXPECT_GT(made.set.fragments.size(), 10u);
  const Glb glb(write_glb(made, {}));
  std::set<std::size_t> meshes;
  for (const json& node : bodies_of(glb.document)) meshes.insert(node["mesh"].get<std::size_t>());
  EXPECT_EQ(meshes.size(), made.set.fragments.size() - 5);
}

TEST(InstanceAnswer, IsReadBackAsInstances) {
  const SmallMeadow m;
  const std::vector<std::uint8_t> bytes = write_glb(m.made, {});
  const std::string text(bytes.begin(), bytes.end());
  const Solid again = solid_of_glb(text);
  ASSERT_TRUE(again.instances);
  EXPECT_EQ(again.instances->all.size(), 12u);
  EXPECT_NEAR(again.report.volume, m.made.solid.report.volume, 1e-3 * again.report.volume);

  const Expected<outputs::Answer> answer = outputs::read_answer(bytes);
  ASSERT_TRUE(answer) << answer.error().detail;
  double volume = 0;
  for (const outputs::Object& object : answer->objects)
    for (const outputs::Primitive& primitive : object.primitives)
      for (std::size_t t = 0; t < primitive.indices.size(); t += 3) {
        const auto corner = [&](std::size_t k) {
          return to_double(object.position(primitive.indices[t + k]));
        };
        volume += dot(corner(0), cross(corner(1), corner(2))) / 6;
      }
  EXPECT_NEAR(volume, m.made.solid.report.volume, 1e-3 * volume);
}

/// A point in the middle of the first blade, at three tenths of its height.
Vec3d on_blade(const Place& place) {
  return Similarity{place.rotation, place.scale.x, place.translation}.point({0.0429, 0.06, 0.0009});
}

std::size_t whole_in(const FracturedSolid& made) {
  std::size_t whole = 0;
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) whole += made.instances.of(k) != nullptr;
  return whole;
}

// The reach of the hit is 0.024 m, less than its distance from the other blades, and the tufts are 1 m apart.
TEST(InstanceAnswer, AHitOnTheWholeCutsOneTuft) {
  const Grass grass(3);
  const std::vector<Place> places = meadow(25);
  FractureParameters p = wanted(6);
  p.rest = LocalRest::kWhole;
  p.hits = {{on_blade(places[12]), 0.02, 12}};
  const Fractured made = fracture_solid(solid_of_glb(grass.glb(places)), p);
  EXPECT_EQ(whole_in(made), 24u);
  EXPECT_GE(made.set.fragments.size(), 24u + 4u) << "two whole blades, and at least two pieces of the third";
  const json document = Glb(write_glb(made, {})).document;
  std::size_t own = 0;
  for (const json& node : bodies_of(document)) own += !node["extras"]["fracture"].contains("shape");
  EXPECT_EQ(own, made.set.fragments.size() - 24);
}

TEST(InstanceAnswer, ADeltaContainsNoWholeInstance) {
  const Grass grass(3);
  const std::vector<Place> places = meadow(25);
  const Solid solid = solid_of_glb(grass.glb(places));
  FractureParameters p = wanted(6);
  p.rest = LocalRest::kFractured;
  StageTimings timings;
  const Expected<KeptAnswer> before = fracture_and_keep(solid, p, {}, timings);
  ASSERT_TRUE(before) << before.error().detail;
  EXPECT_EQ(whole_in(before->fractured), 25u);
  p.hits = {{on_blade(places[12]), 0.02, 12}};
  const Expected<KeptAnswer> after = fracture_delta(solid, before->base, p, {1, true}, {}, timings);
  ASSERT_TRUE(after) << after.error().detail;
  const FracturedSolid& only = after->fractured;
  ASSERT_TRUE(only.delta);
  EXPECT_EQ(only.delta->changed.size(), 1u) << "the largest rest keeps the tuft's id";
  EXPECT_TRUE(only.delta->gone.empty());
  EXPECT_GE(only.set.fragments.size(), 4u);
  EXPECT_EQ(whole_in(only), 0u);
  EXPECT_EQ(only.report.instances, (InstanceFigures{24, 1})) << "of the whole answer";
}

TEST(InstanceAnswer, HitsLeaveOtherInstancesAsTheyAre) {
  const Grass grass(2);
  const std::vector<Place> places = meadow(25);
  const Expected<Mesh> mesh = import_text(grass.glb(places), MeshFormat::kGlb);
  ASSERT_TRUE(mesh);
  FractureParameters p = wanted(6);
  for (const LocalRest rest : {LocalRest::kFractured, LocalRest::kWhole}) {
    SCOPED_TRACE(rest == LocalRest::kWhole ? "whole" : "fractured");
    p.rest = rest;
    p.hits = {{on_blade(places[12]), 0.02, 12}, {on_blade(places[4]), 0.02, 12}};
    // With a whole rest, the first hit does not continue the answer without hits.
    EXPECT_EQ(expect_hits(*mesh, p), rest == LocalRest::kWhole ? 1 : 2);
  }
}

}  // namespace
}  // namespace fracture::test
