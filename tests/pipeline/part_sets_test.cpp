// Objects of several materials: parts break as their entries say, and the pieces are one answer.
#include "common/pipeline/part_sets.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "common/contacts/contacts.hpp"
#include "common/mesh/material_library.hpp"
#include "common/pipeline/overlaps.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// Boxes of volume 4, 1 and 1 in a row, 0.1 mm apart. Their nodes are "Wall_1" (in the group "House"), "Wall_2" and "Window". The
/// materials are "Brick" (the walls) and "Glass".
Mesh house() {
  Mesh mesh = joined(
      {box({0, 0, 0}, {4, 1, 1}), box({4.0001, 0, 0}, {5.0001, 1, 1}), box({5.0002, 0, 0}, {6.0002, 1, 1})});
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"name", "Brick"}}, {{"name", "Glass"}}};
  mesh.library = library;
  mesh.node_names = {"Wall_1", "Wall_2", "Window"};
  mesh.groups = {{"House", kNoIndex}};
  mesh.group_of_node = {0, kNoIndex, kNoIndex};
  mesh.node.clear();
  mesh.material.clear();
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t of = t / 12;
    mesh.node.push_back(of);
    mesh.material.push_back(of == 2 ? 1 : 0);
  }
  return mesh;
}

Solid solid_of(Mesh mesh) {
  Solid solid = make_solid(std::make_shared<Mesh>(std::move(mesh)), {}, {}).value();
  keep_contacts(solid, {}, {});
  return solid;
}

AssignedParts entry(PartSelector selector, const FractureParameters& breaks, double density = 1,
                    double strength = 1) {
  return {std::move(selector), std::make_shared<const FractureParameters>(breaks), density, strength};
}

FractureParameters with_fragments(std::uint32_t count) {
  FractureParameters p;
  p.sites = p.size.fragments = count;
  return p;
}

FractureParameters grid() {
  FractureParameters p;
  p.pattern = GridPattern{};
  return p;
}

bool along_axis(const Vec3d& n) {
  return std::fmax(std::fabs(n.x), std::fmax(std::fabs(n.y), std::fabs(n.z))) > 1 - 1e-9;
}

TEST(PartSets, EachPartBreaksAsItsEntrySays) {
  FractureParameters p = with_fragments(60), cubes = grid();
  cubes.pattern = GridPattern{.cell = Vec3d{0.5, 0.5, 0.5}};
  p.assigned = {entry({.nodes = {"Window"}}, cubes, 2.5, 4)};
  const Fractured made = fracture_solid(solid_of(house()), p);
  const FragmentSet& set = made.set;
  EXPECT_NEAR(static_cast<double>(set.fragments.size()), 60, 6) << "the number holds for the whole";
  EXPECT_EQ(set.certificate.unmirrored_caps, 0u);
  EXPECT_NEAR(set.certificate.volume_out, 6, 1e-6);
  EXPECT_EQ(set.certificate.fragments, set.fragments.size());

  double volume[3] = {}, mass[3] = {};
  std::size_t pieces[3] = {};
  for (const Fragment& f : set.fragments) {
    ASSERT_LT(f.part, 3u);
    EXPECT_EQ(f.node, f.part);
    volume[f.part] += f.mass.volume;
    mass[f.part] += f.density_share * f.mass.volume;
    ++pieces[f.part];
  }
  EXPECT_NEAR(volume[0] + volume[1], 5, 1e-6);
  EXPECT_NEAR(volume[2], 1, 1e-6);
  EXPECT_NEAR(mass[0] + mass[1], 5, 1e-6);
  EXPECT_NEAR(mass[2], 2.5, 1e-6);
  EXPECT_NEAR(set.weighed_volume, 7.5, 1e-6);
  EXPECT_EQ(pieces[2], 8u) << "cubes of half a metre";

  std::size_t inside = 0, across = 0, askew = 0;
  for (const Bond& bond : set.bonds) {
    const bool a = set.fragments[bond.a].part == 2, b = set.fragments[bond.b].part == 2;
    if (a && b) {
      ++inside;
      EXPECT_EQ(bond.strength, 4);
      EXPECT_TRUE(along_axis(bond.normal)) << "a grid";
    } else {
      across += a != b;
      EXPECT_EQ(bond.strength, 1) << "the weaker of both";
      askew += !along_axis(bond.normal);
    }
  }
  EXPECT_GT(inside, 0u);
  EXPECT_GT(across, 0u);
  EXPECT_GT(askew, 0u) << "the walls are no grid";
}

TEST(PartSets, IdsAndSitesAreThoseOfTheWhole) {
  FractureParameters p = with_fragments(40);
  p.assigned = {entry({.slots = {"Gl*"}}, grid())};
  const Fractured made = fracture_solid(solid_of(house()), p);
  std::set<std::uint64_t> ids;
  std::map<std::uint32_t, std::set<std::uint32_t>> parts_of_site;
  for (const Fragment& f : made.set.fragments) {
    EXPECT_TRUE(ids.insert(f.id).second);
    for (const SiteId s : f.sites) {
      ASSERT_LT(s, made.diagram.tetrahedralization.site_count());
      parts_of_site[s].insert(f.part == 2 ? 1u : 0u);
    }
  }
  for (const auto& [site, parts] : parts_of_site) EXPECT_EQ(parts.size(), 1u) << site;
  EXPECT_EQ(made.report.sites.used, made.diagram.tetrahedralization.site_count());
  const Fractured again = fracture_solid(solid_of(house()), p, 2);
  ASSERT_EQ(again.set.fragments.size(), made.set.fragments.size());
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
    EXPECT_EQ(again.set.fragments[k].id, made.set.fragments[k].id);
    EXPECT_EQ(again.set.fragments[k].positions, made.set.fragments[k].positions);
  }
}

/// Number of fragments in each part.
std::vector<std::size_t> pieces_of_parts(const std::vector<AssignedParts>& assigned) {
  FractureParameters p = with_fragments(30);
  p.parts = Parts::kApart;
  p.assigned = assigned;
  const Fractured made = fracture_solid(solid_of(house()), p);
  std::vector<std::size_t> pieces(3);
  for (const Fragment& f : made.set.fragments) ++pieces[f.part];
  return pieces;
}

TEST(PartSets, SelectorsAreNodesPatternsGroupsSlotsAndParts) {
  const Solid solid = solid_of(house());
  const auto chosen = [&](const PartSelector& selector) {
    std::set<std::uint32_t> parts;
    const PartChoice choice = choose_parts(solid, {selector}, {});
    for (std::uint32_t p = 0; p < choice.of_part.size(); ++p)
      if (choice.of_part[p] == 0) parts.insert(p);
    return parts;
  };
  using Set = std::set<std::uint32_t>;
  EXPECT_EQ(chosen({.nodes = {"Window"}}), Set{2});
  EXPECT_EQ(chosen({.nodes = {"Wall_*"}}), (Set{0, 1}));
  EXPECT_EQ(chosen({.nodes = {"House"}}), Set{0}) << "a group stands for the nodes below it";
  EXPECT_EQ(chosen({.nodes = {"Window", "Ho?se"}}), (Set{0, 2}));
  EXPECT_EQ(chosen({.nodes = {"1"}}), Set{1}) << "an index";
  EXPECT_EQ(chosen({.slots = {"Brick"}}), (Set{0, 1}));
  EXPECT_EQ(chosen({.slots = {"G*"}}), Set{2});
  EXPECT_EQ(chosen({.parts = {1, 2}}), (Set{1, 2}));
  EXPECT_EQ(chosen({.nodes = {"Wall_*"}, .parts = {1, 2}}), Set{1}) << "all lists must match";
  EXPECT_EQ(chosen({.nodes = {"Door"}}), Set{});
  EXPECT_EQ(chosen({}), Set{});
}

TEST(PartSets, TheFirstEntryThatMatchesDecides) {
  FractureParameters whole;
  whole.pattern = PointsPattern{{{0.5, 0.5, 0.5}}};
  const AssignedParts all_whole = entry({.nodes = {"*"}}, whole),
                      window = entry({.nodes = {"Window"}}, grid());
  EXPECT_EQ(pieces_of_parts({all_whole, window}), (std::vector<std::size_t>{1, 1, 1}));
  const std::vector<std::size_t> pieces = pieces_of_parts({window, all_whole});
  EXPECT_EQ(pieces[0], 1u);
  EXPECT_EQ(pieces[1], 1u);
  EXPECT_GT(pieces[2], 1u);
}

TEST(PartSets, AnEntryWithoutEffectIsNamedWithTheNearestNames) {
  FractureParameters p = with_fragments(10);
  p.assigned = {entry({.nodes = {"Windov"}}, grid()), entry({.slots = {"Glas"}}, grid()),
                entry({.parts = {7}}, grid()), entry({.nodes = {"Wall_*"}}, grid()),
                entry({.nodes = {"House"}}, grid())};
  const Fractured made = fracture_solid(solid_of(house()), p);
  std::vector<std::string> warnings = made.report.remarks.warnings;
  std::erase_if(warnings, [](const std::string& warning) { return !warning.starts_with("Entry "); });
  ASSERT_EQ(warnings.size(), 4u);
  EXPECT_EQ(
      warnings[0],
      "Entry 1 of 'assign' (node 'Windov') matches no part, so it has no effect. Did you mean 'Window'? "
      "`fracture-server inspect --json` and GET /meshes/{id} list the names. Correct the entry, or leave it out.");
  EXPECT_NE(
      warnings[1].find("(slot 'Glas') matches no part, so it has no effect. The names are 'Glass', 'Brick'."),
      std::string::npos)
      << warnings[1];
  EXPECT_NE(warnings[2].find("The mesh has 3 parts; the first has the number 0."), std::string::npos)
      << warnings[2];
  EXPECT_NE(warnings[3].find("Entry 5 of 'assign' (node 'House') has no effect, because earlier entries"),
            std::string::npos)
      << warnings[3];
}

TEST(PartSets, AnEntryForAllPartsEqualsARequestWithItsParameters) {
  FractureParameters plain = with_fragments(20), assigned = plain;
  plain.pattern = GridPattern{};
  assigned.assigned = {entry({.nodes = {"*"}}, grid())};
  const Fractured a = fracture_solid(solid_of(house()), plain),
                  b = fracture_solid(solid_of(house()), assigned);
  ASSERT_EQ(a.set.fragments.size(), b.set.fragments.size());
  for (std::size_t k = 0; k < a.set.fragments.size(); ++k) {
    EXPECT_EQ(a.set.fragments[k].id, b.set.fragments[k].id);
    EXPECT_EQ(a.set.fragments[k].positions, b.set.fragments[k].positions);
  }
}

TEST(PartSets, OverlapsCountOnceAndMassesFollowTheMaterials) {
  // Volumes 1 and 1.44, of which 0.5 are common: both get 1.94 / 2.44 of their densities.
  Mesh mesh = joined({box({0, 0, 0}, {1, 1, 1}), box({0.5, -0.1, -0.1}, {1.5, 1.1, 1.1})});
  mesh.node_names = {"Wall", "Window"};
  mesh.node.assign(12, 0);
  mesh.node.resize(24, 1);
  FractureParameters p = with_fragments(10);
  p.assigned = {entry({.nodes = {"Window"}}, grid(), 3)};
  const Fractured made = fracture_solid(solid_of(std::move(mesh)), p);
  double mass = 0;
  for (const Fragment& f : made.set.fragments) mass += f.density_share * f.mass.volume;
  EXPECT_NEAR(mass, 1.94 / 2.44 * (1 + 3 * 1.44), 1e-5);
  EXPECT_NEAR(made.set.certificate.volume_once, 1.94, 1e-5);
  EXPECT_NEAR(made.set.weighed_volume, mass, 1e-6);
}

TEST(PartSets, AHitBreaksTheSetsThatItReaches) {
  FractureParameters p = with_fragments(20);
  p.assigned = {entry({.nodes = {"Window"}}, grid())};
  p.hits = {{.point = {6.0002, 0.5, 0.5}, .radius = 0.3, .sites = 10}};
  p.rest = LocalRest::kWhole;
  const Fractured made = fracture_solid(solid_of(house()), p);
  std::size_t pieces[3] = {};
  for (const Fragment& f : made.set.fragments) ++pieces[f.part];
  EXPECT_LE(pieces[0] + pieces[1], 2u) << "the walls stay whole";
  EXPECT_GT(pieces[2], 2u);
  EXPECT_FALSE(warns(made.report, "breaks nothing off"));
}

TEST(PartSets, AHitBreaksThePiecesOfEachSetAndTheyKeepTheirMaterial) {
  FractureParameters p = with_fragments(20);
  p.parts = Parts::kApart;
  p.assigned = {entry({.nodes = {"Window"}}, grid(), 2, 0.5)};
  const Solid solid = solid_of(house());
  const Fractured whole = fracture_solid(solid, p);
  // Within the radius of both Wall_2 and the window, which are 0.1 mm apart.
  p.hits = {{.point = {5.00015, 0.5, 0.5}, .radius = 0.4, .sites = 10}};
  p.rest = LocalRest::kFractured;
  const Fractured made = fracture_solid(solid, p);
  std::size_t before[3] = {}, after[3] = {};
  double volume[3] = {};
  for (const Fragment& f : whole.set.fragments) ++before[f.part];
  for (const Fragment& f : made.set.fragments) {
    ++after[f.part];
    volume[f.part] += f.mass.volume;
    EXPECT_EQ(f.density_share, f.part == 2 ? 2 : 1);
  }
  EXPECT_EQ(after[0], before[0]) << "4 m of the wall are out of reach";
  EXPECT_GT(after[1], before[1] + 3);
  EXPECT_GT(after[2], before[2] + 3);
  EXPECT_NEAR(volume[1], 1, 1e-5);
  EXPECT_NEAR(volume[2], 1, 1e-5);
  for (const Bond& bond : made.set.bonds) {
    const bool window = made.set.fragments[bond.a].part == 2 || made.set.fragments[bond.b].part == 2;
    EXPECT_EQ(bond.strength, window ? 0.5 : 1);
  }
  EXPECT_FALSE(warns(made.report, "breaks nothing off"));
}

TEST(PartSets, FragmentsOfEachSetCarryTheSheetsNearThem) {
  Mesh mesh = house();
  const auto triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  // Two squares of 0.5 m x 0.5 m above the long wall and above the window.
  for (const double x : {1.0, 5.25}) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [dx, dz] : {std::pair{0.0, 0.25}, {0.0, 0.75}, {0.5, 0.75}, {0.5, 0.25}})
      mesh.positions.push_back({static_cast<float>(x + dx), 1.25f, static_cast<float>(dz)});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  for (std::size_t t = triangles; t < mesh.triangles.size(); ++t) {
    mesh.node.push_back(t < triangles + 2 ? 0 : 2);
    mesh.material.push_back(0);
  }
  FractureParameters p = with_fragments(20);
  p.assigned = {entry({.nodes = {"Window"}}, grid())};
  const Solid solid = solid_of(mesh);
  ASSERT_TRUE(solid.sheets);
  const Fractured made = fracture_solid(solid, p);
  bool carries[3] = {};
  for (const Fragment& f : made.set.fragments) carries[f.part] = carries[f.part] || f.sheet;
  EXPECT_TRUE(carries[0]);
  EXPECT_FALSE(carries[1]);
  EXPECT_TRUE(carries[2]);
  EXPECT_NEAR(made.set.certificate.sheet_area_in, 0.5, 1e-6);
  EXPECT_NEAR(made.set.certificate.sheet_area_out, 0.5, 1e-6);
}

TEST(PartSets, AFragmentBreaksAgainLikeItsPart) {
  FractureParameters p = with_fragments(12);
  FractureParameters rough = grid();
  rough.roughness = {0.02, 4, 1};
  p.assigned = {entry({.nodes = {"Window"}}, rough, 2, 0.5)};
  const Solid solid = solid_of(house());
  const Fractured made = fracture_solid(solid, p);
  std::uint64_t id = 0;
  for (const Fragment& f : made.set.fragments)
    if (f.part == 2) id = f.id;
  StageTimings timings;
  const Expected<FracturedSolid> again =
      refracture(solid, made.diagram, p, {.fragment = id, .sites = 4}, {}, timings);
  ASSERT_TRUE(again) << again.error().detail;
  ASSERT_TRUE(again->report.rough_cuts);
  for (const Fragment& f : again->set.fragments) EXPECT_EQ(f.density_share, 2);
  for (const Bond& bond : again->set.bonds) EXPECT_EQ(bond.strength, 0.5);
}

}  // namespace
}  // namespace fracture::test
