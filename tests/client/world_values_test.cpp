// Parts of the world without a world: masses, loads on bonds, fragments from a file.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "client/world/bond_loads.hpp"
#include "client/world/fragments.hpp"
#include "client/world/mass.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cubes;
using test::GlbParts;

double distance(const glm::dmat3& a, const glm::dmat3& b) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += glm::dot(a[c] - b[c], a[c] - b[c]);
  return std::sqrt(sum);
}

// -- mass

TEST(Mass, OfABoxIsThatOfTheTextbook) {
  // 2 × 3 × 4 m at 5 kg/m³ around (10, 20, 30): 120 kg, m/12 (b² + c²).
  std::vector<glm::vec3> corners;
  for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1 ? 11 : 9, k & 2 ? 21.5f : 18.5f, k & 4 ? 32 : 28);
  const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                                               {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                                               {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const MassProperties mass = solid_mass(corners, triangles, 5);
  EXPECT_NEAR(mass.mass, 120, 1e-9);
  EXPECT_LT(glm::distance(mass.center, glm::dvec3(10, 20, 30)), 1e-12);
  EXPECT_LT(distance(mass.inertia, glm::dmat3(250, 0, 0, 0, 200, 0, 0, 0, 130)), 1e-9);
}

TEST(Mass, OfAnOpenMeshIsThatOfItsBox) {
  const std::vector<glm::vec3> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 1}};
  const MassProperties mass = solid_mass(corners, {}, 10);
  EXPECT_NEAR(mass.mass, 10, 1e-9);
  EXPECT_GT(mass.inertia[0][0], 0);
}

TEST(Mass, PartsAddUpToTheWhole) {
  // Eight cubes of side 1 are a cube of side 2: m a² / 6.
  std::vector<MassProperties> parts;
  for (int k = 0; k < 8; ++k)
    parts.push_back(test::cube_mass(glm::dvec3(k & 1, (k >> 1) & 1, k >> 2) + glm::dvec3(3), 1, 6));
  const MassProperties whole = combine(parts);
  EXPECT_NEAR(whole.mass, 48, 1e-12);
  EXPECT_LT(glm::distance(whole.center, glm::dvec3(3.5)), 1e-12);
  EXPECT_LT(distance(whole.inertia, glm::dmat3(32)), 1e-9);
}

TEST(Mass, PrincipalAxesGiveTheInertiaBack) {
  const glm::dquat turn = glm::normalize(glm::dquat(0.3, -0.5, 0.7, 0.2));
  const glm::dmat3 r = glm::mat3_cast(turn);
  const glm::dmat3 inertia = r * glm::dmat3(5, 0, 0, 0, 1, 0, 0, 0, 3) * glm::transpose(r);
  const PrincipalAxes axes = principal_axes(inertia);
  EXPECT_LT(glm::distance(axes.moments, glm::dvec3(1, 3, 5)), 1e-12);
  const glm::dmat3 a = glm::mat3_cast(axes.rotation);
  EXPECT_LT(distance(a * glm::dmat3(1, 0, 0, 0, 3, 0, 0, 0, 5) * glm::transpose(a), inertia), 1e-12);
}

TEST(Mass, MomentumCanBeSet) {
  std::vector<Motion> bodies;
  for (int k = 0; k < 5; ++k)
    bodies.push_back({test::cube_mass({k, k * k * 0.3, -k * 0.7}, 0.5 + 0.1 * k, 100),
                      glm::dvec3(k, 1 - k, 0.2), glm::dvec3(0.1 * k, 0, 1)});
  const glm::dvec3 linear(3, -70, 11), angular(5, 600, -7);
  set_momentum(bodies, linear, angular);
  const Momentum m = momentum(bodies);
  EXPECT_LT(glm::distance(m.linear, linear), 1e-9);
  EXPECT_LT(glm::distance(m.angular, angular), 1e-9);
}

// -- loads

std::vector<std::uint32_t> first(std::size_t count) {
  std::vector<std::uint32_t> all(count);
  for (std::size_t k = 0; k < count; ++k) all[k] = static_cast<std::uint32_t>(k);
  return all;
}

constexpr double kReach = 0.5;

std::vector<double> loads_of(const FragmentSet& set, const std::vector<glm::dvec3>& forces,
                             const glm::dvec3& gravity = glm::dvec3(0), bool hit = false) {
  const auto members = first(set.fragments.size()), bonds = first(set.bonds.size());
  LoadCase load{.members = members, .bonds = bonds, .reach = kReach, .gravity = gravity};
  (hit ? load.hits : load.lasting).on_member = forces;
  return bond_loads(set, load);
}

TEST(BondLoads, AHangingChainBearsWhatHangsBelow) {
  FragmentSet chain = cubes(1, 4, 1, 1000, 1e6);  // 1 t each, strength 1 MN
  chain.fragments[3].anchored = true;             // held at the top
  const auto loads = loads_of(chain, std::vector<glm::dvec3>(4, glm::dvec3(0)), {0, -10, 0});
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(loads[k], kStressConcentration * 1e4 * static_cast<double>(k + 1) / 1e6, 1e-3) << k;
}

TEST(BondLoads, AStandingChainIsPressedWhichBreaksLess) {
  FragmentSet chain = cubes(1, 4, 1, 1000, 1e6);
  chain.fragments[0].anchored = true;
  const auto loads = loads_of(chain, std::vector<glm::dvec3>(4, glm::dvec3(0)), {0, -10, 0});
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(loads[k], kCompressionShare * kStressConcentration * 1e4 * static_cast<double>(3 - k) / 1e6,
                1e-3)
        << k;
}

TEST(BondLoads, NothingIsLoadedInFreeFall) {
  const FragmentSet wall = cubes(4, 3);
  for (const double load : loads_of(wall, std::vector<glm::dvec3>(12, glm::dvec3(0)), {0, -9.81, 0}))
    EXPECT_NEAR(load, 0, 1e-9);
}

TEST(BondLoads, AFreeChainThatIsPulledAtItsEndBearsTheMassBehind) {
  // F = 4 kN at the first of four: the bond behind it carries three quarters, the next ones a half and a
  // quarter.
  const FragmentSet chain = cubes(4, 1, 1, 1000, 1e6);
  std::vector<glm::dvec3> forces(4, glm::dvec3(0));
  forces[0] = {-4000, 0, 0};
  const auto loads = loads_of(chain, forces);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(loads[k], kStressConcentration * 1000 * static_cast<double>(3 - k) / 1e6, 1e-4) << k;
}

TEST(BondLoads, ABondAtTheHitBearsMost) {
  FragmentSet wall = cubes(7, 7);
  for (std::size_t k = 0; k < 7; ++k) wall.fragments[k].anchored = true;
  std::vector<glm::dvec3> forces(49, glm::dvec3(0));
  forces[24] = {0, 0, -1e5};  // the middle one
  const auto loads = loads_of(wall, forces);
  double at_hit = 0, elsewhere = 0;
  for (std::size_t k = 0; k < wall.bonds.size(); ++k) {
    const bool touches = wall.bonds[k].a == 24 || wall.bonds[k].b == 24;
    if (touches)
      at_hit = std::max(at_hit, loads[k]);
    else
      elsewhere = std::max(elsewhere, loads[k]);
  }
  EXPECT_GT(at_hit, elsewhere);
}

TEST(BondLoads, AHitDiesAwayWithDistanceWhereALastingForceGoesToTheAnchors) {
  // A long chain of half-metre cubes that is held at its far end and pushed at the other. The screened
  // equation u'' = u / reach² has the solution exp(-x / reach). On a lattice with step d that is a ratio r
  // with r + 1/r = 2 + (d / reach)².
  FragmentSet chain = cubes(12, 1, 0.5);
  chain.fragments[11].anchored = true;
  std::vector<glm::dvec3> forces(12, glm::dvec3(0));
  forces[0] = {0, 0, -1e5};
  const auto lasting = loads_of(chain, forces), hit = loads_of(chain, forces, glm::dvec3(0), true);
  for (std::size_t k = 0; k < 11; ++k) EXPECT_NEAR(lasting[k], lasting[0], 1e-2 * lasting[0]) << k;
  const double s = 2 + std::pow(0.5 / kReach, 2), ratio = 0.5 * (s - std::sqrt(s * s - 4));
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(hit[k + 1] / hit[k], ratio, 0.02) << k;
}

TEST(BondLoads, AForceOnlyAnchorsBearLoadsNothingBetween) {
  FragmentSet chain = cubes(3, 1);
  for (Fragment& f : chain.fragments) f.anchored = true;
  std::vector<glm::dvec3> forces(3, glm::dvec3(0));
  forces[1] = {1e6, 0, 0};
  for (const double load : loads_of(chain, forces)) EXPECT_EQ(load, 0);
}

TEST(Components, AreFoundInOrder) {
  const FragmentSet row = cubes(5, 1);
  const std::vector<std::uint32_t> members = {0, 1, 2, 4}, bonds = {0};
  const auto parts = components(members, bonds, row);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0], (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(parts[1], (std::vector<std::uint32_t>{2}));
  EXPECT_EQ(parts[2], (std::vector<std::uint32_t>{4}));
}

// -- files

Expected<FragmentSet> read(const GlbParts& parts) {
  const std::string bytes = parts.bytes();
  return read_fragments(std::as_bytes(std::span(bytes.data(), bytes.size())));
}

TEST(ReadFragments, TakesBodiesHullsAndBondsFromTheFile) {
  const auto set = read(test::two_cubes_glb());
  ASSERT_TRUE(set) << set.error().detail;
  ASSERT_EQ(set->fragments.size(), 2u);
  EXPECT_EQ(set->fragments[0].id, 7u);
  EXPECT_EQ(set->fragments[1].id, 9u);
  EXPECT_TRUE(set->fragments[0].anchored);
  EXPECT_FALSE(set->fragments[1].anchored);
  EXPECT_EQ(set->fragments[1].mass.mass, 2000);
  EXPECT_LT(glm::distance(set->fragments[1].mass.center, glm::dvec3(1, 0, 0)), 1e-12);
  EXPECT_LT(distance(set->fragments[1].mass.inertia, glm::dmat3(333)), 1e-9);
  ASSERT_EQ(set->fragments[1].hulls.size(), 1u);
  EXPECT_EQ(set->fragments[1].hulls[0].size(), 8u);
  ASSERT_EQ(set->bonds.size(), 1u);
  EXPECT_EQ(set->bonds[0].a, 0u);
  EXPECT_EQ(set->bonds[0].b, 1u);
  EXPECT_EQ(set->bonds[0].strength, 1e6);
  EXPECT_EQ(set->bonds[0].center, glm::dvec3(0.5, 0, 0));
  EXPECT_EQ(set->friction, 0.4);
  EXPECT_EQ(set->restitution, 0.25);
}

TEST(ReadFragments, AllPlacesAreBelowTheRoot) {
  GlbParts far = test::two_cubes_glb();
  far.json["nodes"][0]["translation"] = {500000, 30, 4649776};
  const auto set = read(far);
  ASSERT_TRUE(set) << set.error().detail;
  EXPECT_LT(glm::distance(set->fragments[1].mass.center, glm::dvec3(500001, 30, 4649776)), 1e-8);
  EXPECT_EQ(set->bonds[0].center, glm::dvec3(500000.5, 30, 4649776));
}

struct Spoilt {
  const char* name;
  std::function<void(GlbParts&)> spoil;
  ErrorCode code;
};

class ReadSpoiltFragments : public testing::TestWithParam<Spoilt> {};

nlohmann::json& motion(GlbParts& p) {
  return p.json["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["motion"];
}
nlohmann::json& bonds(GlbParts& p) { return p.json["nodes"][0]["extras"]["fracture"]["bonds"]; }

TEST_P(ReadSpoiltFragments, IsATypedErrorThatSaysWhat) {
  GlbParts parts = test::two_cubes_glb();
  GetParam().spoil(parts);
  const auto set = read(parts);
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, GetParam().code) << slug(set.error().code) << ": " << set.error().detail;
  EXPECT_FALSE(set.error().detail.empty());
}

void put_float(std::string& binary, std::size_t offset, float x) {
  binary.replace(offset, 4, reinterpret_cast<const char*>(&x), 4);
}

INSTANTIATE_TEST_SUITE_P(
    Files, ReadSpoiltFragments,
    testing::Values(
        Spoilt{"NanInAHull", [](GlbParts& p) { put_float(p.binary, 12, NAN); }, ErrorCode::kNotFinite},
        Spoilt{"InfinityInAHull", [](GlbParts& p) { put_float(p.binary, 0, INFINITY); },
               ErrorCode::kNotFinite},
        Spoilt{"NoMass", [](GlbParts& p) { motion(p).erase("mass"); }, ErrorCode::kMalformedMesh},
        Spoilt{"NegativeMass", [](GlbParts& p) { motion(p)["mass"] = -1; }, ErrorCode::kMalformedMesh},
        Spoilt{"MassIsText", [](GlbParts& p) { motion(p)["mass"] = "2"; }, ErrorCode::kMalformedMesh},
        Spoilt{"NoInertia",
               [](GlbParts& p) {
                 motion(p)["inertiaDiagonal"] = {0, 0, 0};
               },
               ErrorCode::kMalformedMesh},
        Spoilt{"NoRotation",
               [](GlbParts& p) {
                 motion(p)["inertiaOrientation"] = {0, 0, 0, 0};
               },
               ErrorCode::kMalformedMesh},
        Spoilt{"ShortVector",
               [](GlbParts& p) {
                 motion(p)["centerOfMass"] = {0, 0};
               },
               ErrorCode::kMalformedMesh},
        Spoilt{
            "HullDoesNotExist",
            [](GlbParts& p) {
              p.json["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"]["mesh"] =
                  99;
            },
            ErrorCode::kMalformedMesh},
        Spoilt{"HullIndexOutOfRange",
               [](GlbParts& p) {
                 const std::uint16_t far = 800;
                 p.binary.replace(96, 2, reinterpret_cast<const char*>(&far), 2);
               },
               ErrorCode::kMalformedMesh},
        Spoilt{"NoCollider",
               [](GlbParts& p) {
                 p.json["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"].erase("collider");
               },
               ErrorCode::kMalformedMesh},
        Spoilt{"NoBody", [](GlbParts& p) { p.json["nodes"][2].erase("extensions"); },
               ErrorCode::kMalformedMesh},
        Spoilt{"TwiceTheSameId", [](GlbParts& p) { p.json["nodes"][2]["extras"]["fracture"]["id"] = 7; },
               ErrorCode::kMalformedMesh},
        Spoilt{"BondNamesNobody", [](GlbParts& p) { bonds(p)["b"] = {8}; }, ErrorCode::kMalformedMesh},
        Spoilt{"BondWithItself", [](GlbParts& p) { bonds(p)["b"] = {7}; }, ErrorCode::kMalformedMesh},
        Spoilt{"BondColumnsDiffer",
               [](GlbParts& p) {
                 bonds(p)["area"] = {1.0, 2.0};
               },
               ErrorCode::kMalformedMesh},
        Spoilt{"BondIsNowhere", [](GlbParts& p) { bonds(p).erase("centroid"); }, ErrorCode::kMalformedMesh},
        Spoilt{"BondStrengthNegative", [](GlbParts& p) { bonds(p)["strength"] = {-1.0}; },
               ErrorCode::kMalformedMesh},
        Spoilt{"UnevenlyScaledNode",
               [](GlbParts& p) {
                 p.json["nodes"][1]["scale"] = {2, 2, 1};
               },
               ErrorCode::kMalformedMesh},
        Spoilt{"RestitutionAboveOne",
               [](GlbParts& p) {
                 p.json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"][0]["restitution"] = 2;
               },
               ErrorCode::kMalformedMesh},
        Spoilt{"NoFragments",
               [](GlbParts& p) {
                 p.json["nodes"][1].erase("extras");
                 p.json["nodes"][2].erase("extras");
               },
               ErrorCode::kNoFragments},
        Spoilt{"CutOff", [](GlbParts& p) { p.binary.resize(100); }, ErrorCode::kMalformedMesh}),
    [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace fracture::world
