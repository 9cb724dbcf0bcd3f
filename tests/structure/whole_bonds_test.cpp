// Bonds with nodes that stay whole, computed by hand: boxes whose contacts are rectangles.
#include "common/structure/whole_bonds.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/contacts/scenery.hpp"
#include "common/gltf/fracture_extras.hpp"
#include "common/hits/delta.hpp"
#include "common/mesh/selection.hpp"
#include "tests/structure/in_contact.hpp"

namespace fracture::test::whole_bonds {
namespace {

/// A scene with a node for each mesh, of which only the first one is fractured.
Solid first_of(const std::vector<Mesh>& nodes) {
  Mesh mesh = joined(nodes);
  mesh.node.clear();
  mesh.node_names.clear();
  for (std::uint32_t k = 0; k < nodes.size(); ++k) {
    mesh.node.resize(mesh.node.size() + nodes[k].triangles.size(), k);
    mesh.node_names.push_back("node" + std::to_string(k));
  }
  const Expected<void> restricted = restrict_to(mesh, {.nodes = {"node0"}});
  if (!restricted) throw std::runtime_error(restricted.error().detail);
  Solid solid = solid_of(mesh);
  keep_contacts(solid, {}, {});
  keep_scenery(solid, {}, {});
  return solid;
}

void expect_bond(const WholeBond& bond, std::uint32_t node, double area, const Vec3d& centroid,
                 const Vec3d& normal) {
  EXPECT_EQ(bond.node, node);
  EXPECT_NEAR(bond.area, area, 1e-12);
  EXPECT_NEAR(length(bond.centroid - centroid), 0, 1e-12);
  EXPECT_NEAR(length(bond.normal - normal), 0, 1e-12);
}

// A box of 2 x 1 x 1 in two halves stands on a wide floor. A box of half its width stands on it.
const Mesh kBroken = box({0, 0, 0}, {2, 1, 1});
const Mesh kFloor = box({-3, -1, -3}, {5, 0, 4});
const Mesh kOnTop = box({0.5, 1, 0}, {1.5, 2, 1});
const std::vector<Vec3d> kLeftAndRight{{0.5, 0.5, 0.5}, {1.5, 0.5, 0.5}};

TEST(WholeBonds, OfAHalvedBoxBetweenTwoWholeNodes) {
  const Fractured made = fracture_solid(first_of({kBroken, kFloor, kOnTop}), cut_by(kLeftAndRight));
  ASSERT_EQ(made.set.fragments.size(), 2u);
  EXPECT_EQ(made.set.bonds.size(), 1u) << "nodes that stay whole are not fragments";
  ASSERT_EQ(made.whole_bonds.size(), 4u);
  for (std::uint32_t k = 0; k < 2; ++k) {
    const bool left = made.set.fragments[k].mass.center_of_mass.x < 1;
    EXPECT_EQ(made.whole_bonds[2 * k].fragment, k);
    EXPECT_EQ(made.whole_bonds[2 * k + 1].fragment, k);
    expect_bond(made.whole_bonds[2 * k], 1, 1, {left ? 0.5 : 1.5, 0, 0.5}, {0, -1, 0});
    expect_bond(made.whole_bonds[2 * k + 1], 2, 0.5, {left ? 0.75 : 1.25, 1, 0.5}, {0, 1, 0});
  }
}

TEST(WholeBonds, AreTheSameWithUnitedPartsAndInTheFile) {
  FractureParameters p = cut_by(kLeftAndRight);
  p.parts = Parts::kTogether;
  const Fractured made = fracture_solid(first_of({kBroken, kFloor}), p);
  GltfOptions options;
  options.bond_strength = 100;
  const nlohmann::json bonds = fracture_extras(made, options).at("whole_bonds");
  EXPECT_EQ(bonds.at("node"), (nlohmann::json{1, 1}));
  EXPECT_EQ(bonds.at("area"), (nlohmann::json{1, 1}));
  EXPECT_EQ(bonds.at("strength"), (nlohmann::json{100, 100}));
  EXPECT_EQ(bonds.at("a")[0], made.set.fragments[0].id);
  p.contact_strength = 0;
  EXPECT_TRUE(fracture_solid(made.solid, p).whole_bonds.empty());
}

TEST(WholeBonds, NeedAContactAndScenery) {
  EXPECT_TRUE(fracture_solid(first_of({kBroken, box({4, 0, 0}, {5, 1, 1})}), cut_by(kLeftAndRight))
                  .whole_bonds.empty());
  EXPECT_FALSE(first_of({kBroken}).scenery);
  Mesh open = kFloor;
  open.triangles.resize(1);
  if (!open.material.empty()) open.material.resize(1);
  EXPECT_FALSE(first_of({kBroken, open}).scenery) << "a triangle encloses no volume";
}

// Each part has its own grain, so each has its own image.
TEST(WholeBonds, WithSeveralDiagramsAddUpToTheContact) {
  FractureParameters p;
  p.sites = 40;
  p.seed = 3;
  p.anisotropy = {.stretch = 3, .grain_of = GrainOf::kPart};
  const Mesh two = joined({kBroken, box({2.5, 0, 0}, {2.9, 1, 0.5})});
  const Fractured made = fracture_solid(first_of({two, kFloor}), p);
  double area = 0;
  for (const WholeBond& bond : made.whole_bonds) area += bond.area;
  EXPECT_NEAR(area, 2 + 0.4 * 0.5, 1e-6);
}

TEST(WholeBonds, AreInDeltasForChangedFragments) {
  const Solid solid = first_of({kBroken, kFloor});
  FractureParameters p;
  p.sites = 20;
  p.seed = 5;
  p.rest = LocalRest::kFractured;
  StageTimings timings;
  const Expected<KeptAnswer> before = fracture_and_keep(solid, p, {}, timings);
  ASSERT_TRUE(before);
  p.hits = {{{0.2, 0.1, 0.2}, 0.2, 10}};
  const Expected<KeptAnswer> after = fracture_delta(solid, before->base, p, {1, true}, {}, timings);
  ASSERT_TRUE(after);
  EXPECT_TRUE(after->local);
  const Expected<KeptAnswer> whole = fracture_and_keep(solid, p, {}, timings);
  ASSERT_TRUE(whole);
  const FracturedSolid &delta = after->fractured, &all = whole->fractured;
  ASSERT_FALSE(delta.whole_bonds.empty());
  for (const WholeBond& bond : delta.whole_bonds) {
    const std::uint64_t id = delta.set.fragments[bond.fragment].id;
    EXPECT_TRUE(std::any_of(all.whole_bonds.begin(), all.whole_bonds.end(), [&](const WholeBond& other) {
      return all.set.fragments[other.fragment].id == id && other.area == bond.area &&
             other.centroid == bond.centroid && other.node == bond.node;
    })) << id;
  }
}

}  // namespace
}  // namespace fracture::test::whole_bonds
