#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/base/random.hpp"
#include "common/exact/side.hpp"
#include "common/voronoi/barycentric_cell.hpp"
#include "common/voronoi/voronoi_diagram.hpp"
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
    SiteId start = 0;
    for (int k = 0; k < 2000; ++k) {
      // Every other point on the lattice itself: ties everywhere.
      Vec3d q;
      for (int a = 0; a < 3; ++a) q[a] = k % 2 ? random.uniform() : static_cast<double>(random.below(9)) / 8;
      SiteId best = 0;
      for (SiteId s = 1; s < t.site_count(); ++s)
        if (exact::side1(t.points[best], t.points[s], q) < 0) best = s;
      start = diagram.nearest(q, start);
      EXPECT_EQ(start, best);
    }
  }
}

// Sites so close that every product of their difference underflows: 2.45 + 2.45 - 4.6 steps of 2^-1074 are
// more than zero, but each product is rounded to whole steps, and 2 + 2 - 5 is less.
TEST(VoronoiDiagram, SideIsExactWhereABisectorsProductsUnderflow) {
  const double tiny = 0x8p-1074;
  const Vec3d i{0, 0, 0}, j{tiny, tiny, -tiny}, q{0.30625, 0.30625, 0.575};
  const Tetrahedralization t = tetrahedra_of({i, j});
  const VoronoiDiagram diagram(t, unit_box());
  const auto of = [&](const Vec3d& p) { return static_cast<SiteId>(t.points[0] == p ? 0 : 1); };
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
  for (SiteId i = 0; i < t.site_count(); ++i) {
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

TEST(VoronoiDiagram, FindFacetFindsEveryFacetOfEveryTetrahedron) {
  const Tetrahedralization t = tetrahedra_of(random_sites(unit_box(), 60, 4));
  const VoronoiDiagram diagram(t, unit_box());
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

TEST(BarycentricCell, IsTheHullOfTheBarycentres) {
  const Tetrahedralization t = tetrahedra_of(random_sites(unit_box(), 100, 5));
  const VoronoiDiagram diagram(t, unit_box());
  int made = 0;
  for (SiteId i = 0; i < t.site_count(); ++i) {
    const auto sites = barycentric_cell(diagram, i);
    if (!sites) continue;
    ++made;
    // Every barycentre is on the near side of every mirror plane (they span the hull), up to rounding.
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
  EXPECT_TRUE(barycentric_cell(VoronoiDiagram(t, unit_box()), 0).has_value());
}

}  // namespace
}  // namespace fracture::test
