#include "common/clip/cell_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "tests/support/repetitions.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kSeed = 20261127;

struct Counts {
  int asked = 0, held = 0, wrong = 0;
};

/// Compares the filter with the exact search at points of the box. One point in eight lies on a bisector or
/// within a few roundings of it.
Counts ask(const Box& box, const std::vector<Vec3d>& sites) {
  const Tetrahedralization dual = *tetrahedralize(sites, box, {});
  const VoronoiDiagram diagram(dual, box);
  const CellFilter filter(diagram, box, {});
  Random random(kSeed);
  Counts counts;
  const Vec3d size = box.size();
  for (int k = 0; k < test::repetitions(20'000); ++k) {
    Vec3d q =
        box.min + Vec3d{random.uniform() * size.x, random.uniform() * size.y, random.uniform() * size.z};
    SiteId cell = diagram.nearest(q, SiteId{0});
    if (k % 8 == 0) {
      const auto all = diagram.bisectors(cell);
      const Bisector& b = all[static_cast<std::size_t>(random.uniform() * static_cast<double>(all.size()))];
      const double off = diagram.value(cell, b, q) / (2 * b.half) * (1 + 1e-7 * (random.uniform() - 0.5));
      const Vec3d moved = q + off * b.u;
      for (int a = 0; a < 3; ++a) q[a] = std::fmin(std::fmax(moved[a], box.min[a]), box.max[a]);
    }
    const SiteId nearest = diagram.nearest(q, cell);
    ++counts.asked;
    const bool held = filter.surely_holds(cell, q);
    counts.held += held;
    counts.wrong += held && nearest != cell;
    for (const Bisector& b : diagram.bisectors(nearest))
      if (!dual.is_corner(b.neighbor)) counts.wrong += filter.surely_holds(b.neighbor, q);
  }
  return counts;
}

TEST(CellFilter, NeverTakesAPointForThatOfAnotherCell) {
  for (const double scale : {1e-30, 1e-3, 1.0, 1e8})
    for (const Vec3d& from : {Vec3d{}, Vec3d{1000, -30, 2}}) {
      Mesh mesh = cube();
      Box box;
      for (const Vec3f& p : mesh.positions) box.add(scale * (to_double(p) + from));
      for (const std::uint32_t sites : {4u, 50u, 1000u}) {
        SCOPED_TRACE(testing::Message() << "scale " << scale << ", from " << from.x << ", sites " << sites);
        const Counts counts = ask(box, random_sites(box, sites, kSeed));
        EXPECT_EQ(counts.wrong, 0);
        EXPECT_GT(counts.held,
                  0.85 * counts.asked);  // seven of eight points are at ordinary distances from bisectors
      }
    }
}

TEST(CellFilter, IsSilentBetweenSitesThatFloatsCannotTellApart) {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  const std::vector<Vec3d> sites{
      {0.5, 0.5, 0.5}, {0.5 + 1e-12, 0.5, 0.5}, {0.5, 0.5 + 1e-12, 0.5}, {0.1, 0.2, 0.9}};
  EXPECT_EQ(ask(box, sites).wrong, 0);
}

}  // namespace
}  // namespace fracture::test
