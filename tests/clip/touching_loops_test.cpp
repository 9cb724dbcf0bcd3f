// Outlines of lattice cells that are fused at random. Holes touch each other and the ring around them at
// corners, rings return to places they passed before, and all points are rounded.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "common/base/random.hpp"
#include "common/clip/triangulate.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture {
namespace {

struct FusedLoops {
  std::vector<LatticePoint> points;
  std::vector<std::uint32_t> begin{0};
  void add(const std::vector<LatticePoint>& loop) {
    points.insert(points.end(), loop.begin(), loop.end());
    begin.push_back(static_cast<std::uint32_t>(points.size()));
  }
  std::size_t count() const { return begin.size() - 1; }
  std::uint32_t after(std::size_t l, std::uint32_t k) const {
    return k + 1 < begin[l + 1] ? k + 1 : begin[l];
  }
};

/// Expects a sound triangulation, as for the stretched bricks of a sphere and for a lattice of grouped cells.
/// It must be closed. No triangle may be turned over by more than the rounding of its corners explains.
void expect_sound(const FusedLoops& loops) {
  Triangulation t;
  triangulate(loops.points, loops.begin, t);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  const auto use = [&](std::uint32_t a, std::uint32_t b, int sign) {
    uses[{std::min(a, b), std::max(a, b)}] += a < b ? sign : -sign;
  };
  std::vector<std::map<std::pair<std::uint32_t, std::uint32_t>, int>> of_region(t.regions);
  const auto span = [](const LatticePoint& p, const LatticePoint& q) {
    return std::abs(p.x - q.x) + std::abs(p.y - q.y);
  };
  for (const auto& tri : t.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      ASSERT_NE(tri[e], tri[(e + 1) % 3]);
      use(tri[e], tri[(e + 1) % 3], 1);
    }
    const LatticePoint &a = loops.points[tri[0]], &b = loops.points[tri[1]], &c = loops.points[tri[2]];
    EXPECT_GE(orient2d(a, b, c), -2 * std::max({span(a, b), span(b, c), span(c, a)}));
  }
  for (std::size_t l = 0; l < loops.count(); ++l)
    for (std::uint32_t k = loops.begin[l]; k < loops.begin[l + 1]; ++k) use(k, loops.after(l, k), -1);
  for (const auto& [edge, sum] : uses) EXPECT_EQ(sum, 0) << "edge " << edge.first << " " << edge.second;

  // A region is closed by itself: triangles of two regions share no corner.
  ASSERT_EQ(t.region.size(), t.triangles.size());
  std::vector<std::uint32_t> region_of(loops.points.size(), t.regions);
  for (std::size_t k = 0; k < t.triangles.size(); ++k)
    for (const std::uint32_t corner : t.triangles[k]) {
      ASSERT_LT(t.region[k], t.regions);
      if (region_of[corner] == t.regions) region_of[corner] = t.region[k];
      EXPECT_EQ(region_of[corner], t.region[k]);
    }
}

/// The outline of lattice cells as the cutter makes it. At each place where four cells meet, two corners
/// coincide. They belong to the side of zero length between two opposite cells.
class CellOutline {
 public:
  CellOutline(Random& random, int columns, int rows) : columns_(columns), rows_(rows) {
    const auto nodes = static_cast<std::size_t>((columns + 1) * (rows + 1));
    for (std::size_t k = 0; k < nodes; ++k) rising_.push_back(random.below(2) == 0);
    const std::uint64_t part = 1 + random.below(4);  // of five
    for (int k = 0; k < columns * rows; ++k) taken_.push_back(random.below(5) < part);
  }

  FusedLoops loops(const std::array<double, 6>& affine) const {
    const auto place = [&](int corner) {
      const int node = corner / 2, x = node % (columns_ + 1), y = node / (columns_ + 1);
      const auto at = [&](std::size_t a) {
        return static_cast<std::int64_t>(std::nearbyint(affine[a] * x + affine[a + 1] * y + affine[a + 2]));
      };
      return LatticePoint{at(0), at(3)};
    };
    std::map<int, int> next = sides();
    FusedLoops out;
    while (!next.empty()) {
      std::vector<LatticePoint> loop;
      for (auto at = next.begin(); at != next.end();) {
        loop.push_back(place(at->first));
        const int to = at->second;
        next.erase(at);
        at = next.find(to);
      }
      out.add(loop);
    }
    return out;
  }

 private:
  bool taken(int x, int y) const {
    return x >= 0 && y >= 0 && x < columns_ && y < rows_ &&
           taken_[static_cast<std::size_t>(y * columns_ + x)];
  }
  bool inner(int x, int y) const { return x > 0 && y > 0 && x < columns_ && y < rows_; }
  int node(int x, int y) const { return y * (columns_ + 1) + x; }

  /// Maps each corner to the next one, along the sides between a taken cell and one that is not taken.
  std::map<int, int> sides() const {
    std::map<int, int> next;
    constexpr std::array<std::array<int, 2>, 4> kCorner{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    constexpr std::array<std::array<int, 2>, 4> kAcross{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < columns_; ++x) {
        if (!taken(x, y)) continue;
        // For each corner of a cell: the corner number with which its outline arrives at the node, and the
        // one with which it leaves.
        std::array<int, 4> arrives{}, leaves{};
        for (std::size_t c = 0; c < 4; ++c) {
          const int i = x + kCorner[c][0], j = y + kCorner[c][1], n = node(i, j);
          // A rising diagonal of cells (corners 2 and 0) or a falling one (3 and 1) shares both corners at
          // the node. One of the two other cells has corner 2n and the other has 2n + 1.
          constexpr std::array<std::array<int, 4>, 2> kArrives{{{1, 0, 0, 1}, {1, 1, 0, 0}}},
              kLeaves{{{1, 1, 0, 0}, {0, 1, 1, 0}}};
          const std::size_t rising = rising_[static_cast<std::size_t>(n)];
          arrives[c] = 2 * n + (inner(i, j) ? kArrives[rising][c] : 0);
          leaves[c] = 2 * n + (inner(i, j) ? kLeaves[rising][c] : 0);
          const int ox = c == 0 || c == 3 ? x - 1 : x + 1, oy = c < 2 ? y - 1 : y + 1;
          if (arrives[c] != leaves[c] && !taken(ox, oy)) next[arrives[c]] = leaves[c];
        }
        for (std::size_t c = 0; c < 4; ++c)
          if (!taken(x + kAcross[c][0], y + kAcross[c][1])) next[leaves[c]] = arrives[(c + 1) % 4];
      }
    return next;
  }

  int columns_, rows_;
  std::vector<bool> rising_;  ///< per node
  std::vector<bool> taken_;   ///< per cell
};

// The third ring of the surface of a sphere with eight rings, in bricks stretched 0.633 times. The tip of the
// hole is a corner of the ring around it, between two of its sides.
TEST(TouchingLoops, AHoleWhoseTipIsACornerOfTheRingIsNotTurnedOver) {
  FusedLoops loops;
  loops.add({{0, -2965821},
             {0, -2024012},
             {-349418, -1954508},
             {-838860, -2443951},
             {-838860, -2753897},
             {-1097383, -2702474},
             {-1134970, -2740061}});
  loops.add({{-838860, -2796204}, {-838860, -2753897}, {-626167, -2796204}, {-838860, -2796204}});
  expect_sound(loops);
}

// Groups of cells of a cubic lattice, on a sphere of four rings. One hole touches the ring, one has two
// corners at the same place, and one is free.
TEST(TouchingLoops, AHoleThatTouchesBesideOthersIsNotTurnedOver) {
  FusedLoops loops;
  loops.add({{-2965821, 2568476},
             {-2965821, 2017985},
             {-2097152, 2017985},
             {-2097152, 2017985},
             {-2097152, 1210791},
             {-2097152, 1210791},
             {-2097152, 1063898},
             {-659071, 2825180},
             {-1848387, 2825180},
             {-1446564, 3113463},
             {-2097152, 2880085},
             {-2097152, 2825180},
             {-2250210, 2825180}});
  loops.add({{-2965821, 0}, {-2636285, 403597}, {-2965821, 403597}});
  loops.add({{-2097152, 2646706}, {-2097152, 2825180}, {-1848387, 2825180}, {-2097152, 2646706}});
  expect_sound(loops);
}

TEST(TouchingLoops, CellsFusedAtRandomAreNotTurnedOver) {
  Random random(20261203);
  for (int k = 0; k < test::repetitions(4000); ++k) {
    SCOPED_TRACE(k);
    const int most = k % 20 == 0 ? 30 : 7;
    const CellOutline outline(random, 1 + static_cast<int>(random.below(static_cast<std::uint64_t>(most))),
                              1 + static_cast<int>(random.below(static_cast<std::uint64_t>(most))));
    // The lattice is either parallel to the axes or oblique. If it is oblique, rounding moves points that lie
    // on a line.
    std::array<double, 6> affine{1000, 0, 0, 0, 1000, 0};
    if (k % 4 > 0) {
      for (double& a : affine) a = 200'000 * (random.uniform() - 0.5);
      if (affine[0] * affine[4] < affine[1] * affine[3]) {
        std::swap(affine[0], affine[3]);
        std::swap(affine[1], affine[4]);
      }
      if (affine[0] * affine[4] - affine[1] * affine[3] < 1e8) continue;
    }
    const FusedLoops loops = outline.loops(affine);
    if (loops.count() > 0) expect_sound(loops);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace fracture
