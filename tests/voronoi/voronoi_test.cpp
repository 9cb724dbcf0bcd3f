#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/base/random.hpp"
#include "common/exact/side.hpp"
#include "common/voronoi/barycentric_cell.hpp"
#include "common/voronoi/voronoi_diagram.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

Box unit_box() {
  Box box;
  box.add(Vec3d{0, 0, 0});
  box.add(Vec3d{1, 1, 1});
  return box;
}

Tetrahedralization tetrahedra_of(const std::vector<Vec3d>& sites) {
  return *tetrahedralize(sites, unit_box(), {});
}

TEST(VoronoiDiagram, NearestIsTheExactNearestOfAllSites) {
  for (const auto& sites : {random_sites(unit_box(), 200, 1), lattice_sites(unit_box(), 4)}) {
    const Tetrahedralization t = tetrahedra_of(sites);
    const VoronoiDiagram diagram(t, unit_box());
    Random random(2);
    SiteId start{0};
    for (int k = 0; k < 2000; ++k) {
      // Every second point lies on the lattice itself: ties everywhere.
      Vec3d q;
      for (int a = 0; a < 3; ++a) q[a] = k % 2 ? random.uniform() : static_cast<double>(random.below(9)) / 8;
      SiteId best{0};
      for (const SiteId s : ids<SiteId>(1, t.site_count()))
        if (exact::side1(t.points[best], t.points[s], q) < 0) best = s;
      start = diagram.nearest(q, start);
      EXPECT_EQ(start, best);
    }
  }
}

// Sites so close together that every product of their difference underflows. 2.45 + 2.45 - 4.6 steps of
// 2^-1074 are more than zero. But each product is rounded to whole steps, and 2 + 2 - 5 is less than zero.
TEST(VoronoiDiagram, SideIsExactWhereABisectorsProductsUnderflow) {
  const double tiny = 0x8p-1074;
  const Vec3d i{0, 0, 0}, j{tiny, tiny, -tiny}, q{0.30625, 0.30625, 0.575};
  const Tetrahedralization t = tetrahedra_of({i, j});
  const VoronoiDiagram diagram(t, unit_box());
  const auto of = [&](const Vec3d& p) { return SiteId{t.points[0] == p ? 0 : 1}; };
  const auto bisectors = diagram.bisectors(of(i));
  const auto bisector = std::find_if(bisectors.begin(), bisectors.end(),
                                     [&](const Bisector& b) { return b.neighbor == of(j); });
  ASSERT_NE(bisector, bisectors.end());
  EXPECT_EQ(diagram.side(of(i), *bisector, q), -1);
  EXPECT_EQ(diagram.nearest(q, of(i)), of(j));
}

TEST(VoronoiDiagram, NeighborsAreSymmetricAndAscending) {
  const Tetrahedralization t = tetrahedra_of(random_sites(unit_box(), 300, 3));
  const VoronoiDiagram diagram(t, unit_box());
  for (const SiteId i : ids<SiteId>(t.site_count())) {
    const auto bisectors = diagram.bisectors(i);
    for (std::size_t k = 0; k < bisectors.size(); ++k) {
      const bool ascending = k == 0 || bisectors[k - 1].neighbor < bisectors[k].neighbor;
      EXPECT_TRUE(ascending);
      const SiteId j = bisectors[k].neighbor;
      if (t.is_corner(j)) continue;
      const auto back = diagram.bisectors(j);
      EXPECT_TRUE(std::any_of(back.begin(), back.end(), [&](const Bisector& b) { return b.neighbor == i; }));
    }
  }
}

void expect_all_facets_found(const Tetrahedralization& t, const VoronoiDiagram& diagram) {
  for (const Tetrahedron& tet : t.tets)
    for (int f = 0; f < 4; ++f) {
      std::vector<SiteId> s;
      for (int k = 0; k < 4; ++k)
        if (k != f) s.push_back(tet.v[k]);
      if (std::any_of(s.begin(), s.end(), [&](SiteId v) { return t.is_corner(v); })) continue;
      const auto facet = diagram.find_facet(s[0], s[1], s[2]);
      std::set<SiteId> found;
      for (int k = 0; k < 4; ++k)
        if (k != facet.face) found.insert(t.tets[facet.tet].v[k]);
      EXPECT_EQ(found, std::set<SiteId>(s.begin(), s.end()));
    }
}

TEST(VoronoiDiagram, FindFacetFindsEveryFacetOfEveryTetrahedron) {
  const Tetrahedralization t = tetrahedra_of(random_sites(unit_box(), 60, 4));
  const VoronoiDiagram diagram(t, unit_box());
  expect_all_facets_found(t, diagram);
}

/// One site inside n sites on a sphere. The sphere is either a lattice sphere with ties everywhere, or a
/// general one.
std::vector<Vec3d> hub_sites(int n, bool lattice) {
  std::vector<Vec3d> sites{{0.5, 0.5, 0.5}};
  Random random(7);
  if (lattice) {
    // Integer points with x² + y² + z² = 369: 288 of them.
    for (int x = -20; x <= 20; ++x)
      for (int y = -20; y <= 20; ++y)
        for (int z = -20; z <= 20; ++z)
          if (x * x + y * y + z * z == 369) sites.push_back({0.5 + x / 64.0, 0.5 + y / 64.0, 0.5 + z / 64.0});
    return sites;
  }
  while (sites.size() < static_cast<std::size_t>(n) + 1) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    const Vec3d d = Vec3d{x, y, z} - Vec3d{0.5, 0.5, 0.5};
    if (length(d) < 0.5 && length(d) > 0.1) sites.push_back(Vec3d{0.5, 0.5, 0.5} + (0.45 / length(d)) * d);
  }
  return sites;
}

TEST(VoronoiDiagram, CellsOfManyNeighborsHaveTheSameNearestSites) {
  for (const bool lattice : {false, true}) {
    const Tetrahedralization t = tetrahedra_of(hub_sites(300, lattice));
    const VoronoiDiagram diagram(t, unit_box());
    ASSERT_TRUE(diagram.has_many_neighbors(SiteId{0}));
    Random random(8);
    VoronoiDiagram::Walk walk;
    SiteId start{0};
    for (int k = 0; k < 3000; ++k) {
      // Some points are half-way between the hub and a neighbour, or between two neighbours and the hub.
      const Vec3d& p = t.points[random.below(t.site_count())];
      const Vec3d& r = t.points[random.below(t.site_count())];
      Vec3d q;
      for (int a = 0; a < 3; ++a)
        q[a] = k % 3 == 0 ? random.uniform() : k % 3 == 1 ? (p[a] + 0.5) / 2 : (p[a] + r[a] + 0.5) / 3;
      SiteId best{0};
      for (const SiteId s : ids<SiteId>(1, t.site_count()))
        if (exact::side1(t.points[best], t.points[s], q) < 0) best = s;
      start = diagram.nearest(q, k % 2 ? SiteId{0} : start, walk);
      EXPECT_EQ(start, best);
    }
  }
}

TEST(VoronoiDiagram, APointInACellOfManyNeighborsIsFoundByLookingAtFew) {
  for (const int n : {500, 2000, 8000}) {
    const Tetrahedralization t = tetrahedra_of(hub_sites(n, false));
    const VoronoiDiagram diagram(t, unit_box());
    // Points along a spiral that stays near the facets.
    VoronoiDiagram::Walk walk;
    constexpr int kPoints = 4000;
    for (int k = 0; k < kPoints; ++k) {
      const CirclePoint a = circle_point(k * 37 % 1000, 1000), b = circle_point(k, 2 * kPoints);
      const Vec3d q = Vec3d{0.5, 0.5, 0.5} + 0.22 * Vec3d{a.cos * b.sin, a.sin * b.sin, b.cos};
      EXPECT_EQ(diagram.nearest(q, SiteId{0}, walk), SiteId{0});
    }
    EXPECT_LT(walk.looked_at, 300u * kPoints) << n << " neighbours";
  }
}

TEST(VoronoiDiagram, ALongWalkIsCutShort) {
  // Sites in a row: a walk from one end to the other meets all of them.
  std::vector<Vec3d> sites;
  constexpr int kSites = 4000;
  for (int k = 0; k < kSites; ++k) sites.push_back({(k + 0.5) / kSites, 0.5, 0.5});
  const Tetrahedralization t = tetrahedra_of(sites);
  const VoronoiDiagram diagram(t, unit_box());
  VoronoiDiagram::Walk walk;
  Random random(9);
  for (int k = 0; k < 1000; ++k) {
    const double x = random.uniform();
    const SiteId found = diagram.nearest({x, 0.25, 0.75}, SiteId{random.below(kSites)}, walk);
    EXPECT_EQ(found, SiteId{std::min(static_cast<int>(x * kSites), kSites - 1)});
  }
  EXPECT_LT(walk.looked_at, 1000u * 1000u) << "a third of 4000 sites each, with several neighbours, was more";
}

TEST(VoronoiDiagram, FindFacetFindsEveryFacetAtCellsOfManyNeighbors) {
  const Tetrahedralization t = tetrahedra_of(hub_sites(0, true));
  const VoronoiDiagram diagram(t, unit_box());
  expect_all_facets_found(t, diagram);
}

TEST(VoronoiDiagram, NoFacetOfSitesThatHaveNone) {
  const Tetrahedralization t = tetrahedra_of(lattice_sites(unit_box(), 4));
  const VoronoiDiagram diagram(t, unit_box());
  EXPECT_THROW(diagram.find_facet(SiteId{0}, SiteId{t.site_count() / 2}, SiteId{t.site_count() - 1}),
               InternalError);
}

TEST(BarycentricCell, IsTheHullOfTheBarycentres) {
  const Tetrahedralization t = tetrahedra_of(random_sites(unit_box(), 100, 5));
  const VoronoiDiagram diagram(t, unit_box());
  int made = 0;
  for (const SiteId i : ids<SiteId>(t.site_count())) {
    const auto sites = barycentric_cell(diagram, i);
    if (!sites) continue;
    ++made;
    // Every barycentre is on the near side of every mirror plane (these planes bound the hull), up to
    // rounding.
    for (const TetId tet : diagram.tetrahedra(i)) {
      Vec3d b;
      for (const SiteId v : t.tets[tet].v) b = b + 0.25 * t.points[v];
      for (std::size_t k = 1; k < sites->size(); ++k) {
        const double near = length(b - (*sites)[0]), far = length(b - (*sites)[k]);
        EXPECT_LE(near, far * (1 + 1e-9) + 1e-9);
      }
    }
  }
  EXPECT_EQ(made, 100);
}

TEST(BarycentricCell, OneSiteHasTheHullOfItsFourTetrahedra) {
  // Their other corners are those of the big tetrahedron.
  const Tetrahedralization t = tetrahedra_of({{0.5, 0.5, 0.5}});
  EXPECT_TRUE(barycentric_cell(VoronoiDiagram(t, unit_box()), SiteId{0}).has_value());
}

}  // namespace
}  // namespace fracture::test
