// How the work of each stage grows, counted in polls. A loop polls once per fixed number of steps
// (base/pacer.hpp), so the number of polls measures the work on any machine. Also tests how long a thread
// computes between two polls.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/random.hpp"
#include "common/clip/caps.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/clip/triangulate.hpp"
#include "common/fragment/bonds.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

/// Counts polls by stage, and the longest time between two polls. It serves one thread.
class Watch {
 public:
  const Execution& execution() const { return gaps_here_.execution(); }
  /// Begins a stage and ends the one before it.
  void begin(const std::string& stage) {
    if (!stage_.empty()) {
      gaps_[stage_] = gaps_here_.longest_ms();
      polls_[stage_] = static_cast<double>(gaps_here_.polls());
    }
    stage_ = stage;
    gaps_here_.start();
  }
  std::map<std::string, double> polls_, gaps_;

 private:
  PollGaps gaps_here_;
  std::string stage_;
};

/// Runs all stages from sites to fragments.
void run(const GrowthInput& input, Watch& watch) {
  const Execution& execution = watch.execution();
  const Solid solid = *make_solid(std::make_shared<Mesh>(input.mesh), {}, {});
  const std::vector<Vec3d> sites =
      input.sites.empty() ? random_sites(solid.box, input.uniform, 1) : input.sites;
  watch.begin("delaunay");
  Expected<Tetrahedralization> t = tetrahedralize(sites, solid.box, execution);
  ASSERT_TRUE(t);
  canonicalize(*t, execution);
  watch.begin("voronoi");
  const VoronoiDiagram diagram(*t, solid.box, {}, execution);
  watch.begin("cuts");
  RestrictedDiagram r{solid, solid, diagram, cut_surface(solid, diagram, execution)};
  watch.begin("winding");
  r.winding = wind_voronoi_edges(solid, diagram, r.cuts, execution);
  watch.begin("positions");
  r.positions = place_vertices(solid, solid, diagram, r.cuts, r.winding, execution);
  watch.begin("caps");
  r.caps = build_caps(solid, diagram, r.cuts, r.winding, r.positions, execution);
  watch.begin("pieces");
  const Ownership ownership = Ownership::from_groups(t->site_count(), {});
  const Pieces pieces = gather_pieces(r, ownership, execution);
  watch.begin("bonds");
  std::vector<std::uint32_t> own(pieces.pieces.size());
  for (std::uint32_t k = 0; k < own.size(); ++k) own[k] = k;
  find_bonds(r, pieces, own, execution);
  watch.begin("end");
}

class Growth : public testing::TestWithParam<const char*> {};

TEST_P(Growth, WorkIsNearLinearAndPolledInEveryStage) {
  const GrowthFamily* family = find_growth_family(GetParam());
  ASSERT_NE(family, nullptr);
  // Four times the size may need four times the work, plus an allowance for logarithms and for fixed costs.
  const std::uint32_t small = family->sizes[0], large = 4 * small;
  Watch of_small, of_large;
  run(family->make(small, 1), of_small);
  run(family->make(large, 1), of_large);
  for (const auto& [stage, polls] : of_large.polls_)
    EXPECT_LE(polls, 6 * of_small.polls_[stage] + 50) << stage << " of " << large << " against " << small;
  const auto is_polled = [](const Watch& watch) {
    return std::all_of(watch.gaps_.begin(), watch.gaps_.end(),
                       [](const auto& stage) { return stage.second <= kMostPollGapMs; });
  };
  // A pause of the machine falls on a different place in each try.
  for (int tries = 1; tries < 4 && !is_polled(of_large); ++tries) {
    Watch again;
    run(family->make(large, 1), again);
    for (auto& [stage, gap] : of_large.gaps_) gap = std::min(gap, again.gaps_[stage]);
  }
  for (const auto& [stage, gap] : of_large.gaps_) EXPECT_LE(gap, kMostPollGapMs) << stage;
}

INSTANTIATE_TEST_SUITE_P(Families, Growth,
                         testing::Values("pane", "comb", "bars", "hub", "lissajous", "scribble", "matryoshka",
                                         "cavities", "needles", "overlaps", "bricks"),
                         [](const auto& family) { return std::string(family.param); });

/// A plane cuts n teeth off a bar. Each tooth has a cavity that the plane does not meet. So one cell has as
/// many islands as cavities.
TEST(GrowthOfIslands, ThousandsOfCavitiesFindTheirIslands) {
  const auto make = [](std::uint32_t n) {
    GrowthInput input = find_growth_family("comb")->make(n, 1);
    std::vector<Mesh> all{input.mesh};
    const double pitch = 10.0 / (2 * n);
    for (std::uint32_t k = 0; k < n; ++k) {
      const double x = 2 * k * pitch;
      all.push_back(reversed(box({x + 0.3 * pitch, 2.4, 0.4}, {x + 0.7 * pitch, 2.6, 0.6})));
    }
    input.mesh = joined(all);
    return input;
  };
  Watch of_small, of_large;
  run(make(500), of_small);
  run(make(2000), of_large);
  EXPECT_LE(of_large.polls_["pieces"], 6 * of_small.polls_["pieces"] + 50);

  // Each tooth gets its own cavity: no tooth is without one, and no cavity is left over.
  const GrowthInput input = make(50);
  const Solid solid = *make_solid(std::make_shared<Mesh>(input.mesh), {}, {});
  const Tetrahedralization t = *tetrahedralize(input.sites, solid.box, {});
  const VoronoiDiagram diagram(t, solid.box);
  const RestrictedDiagram r = restrict_to_solid(SeenSolid(solid), diagram, {});
  const Pieces pieces = gather_pieces(r, Ownership::from_groups(t.site_count(), {}), {});
  ASSERT_EQ(pieces.pieces.size(), 51u);
  const double pitch = 10.0 / 100, tooth = pitch * 1 * 1, cavity = 0.4 * pitch * 0.2 * 0.2;
  int teeth = 0;
  for (const Piece& p : pieces.pieces) {
    const double volume = signed_volume(r, p.faces.data(), p.faces.size(), r.point(p.faces[0].v[0]));
    if (volume > 2 * tooth) continue;  // the bar
    ++teeth;
    EXPECT_NEAR(volume, tooth - cavity, 1e-5 * tooth) << "up to the mesh's rounding to float";
  }
  EXPECT_EQ(teeth, 50);
}

TEST(GrowthOfCrossings, LoopsThatCrossEverywhereAreTriangulatedInNearLinearWork) {
  const auto polls = [](std::uint32_t n, int family) {
    Random random(5);
    std::vector<LatticePoint> points;
    std::int64_t x = 0, y = 0;
    for (std::uint32_t k = 0; k < n; ++k) {
      const auto r = [&](std::uint64_t below) { return static_cast<std::int64_t>(random.below(below)); };
      const CirclePoint p = circle_point(7 * k, n), q = circle_point(5 * k + n / 9, n);
      if (family == 0) x = std::llround(8e6 * p.cos), y = std::llround(8e6 * q.sin);
      if (family == 1) x = r(1 << 24), y = r(1 << 24);
      if (family == 2) x += r(2001) - 1000, y += r(2001) - 1000;
      if (family == 3) x = r(16), y = r(16);
      if (family == 4) {  // the loop winds twice
        const CirclePoint c = circle_point(2 * k, n), radius = circle_point(9 * k, n);
        x = std::llround(8e6 * c.cos * (1 + 0.2 * radius.cos));
        y = std::llround(8e6 * c.sin * (1 + 0.2 * radius.cos));
      }
      points.push_back({x, y});
    }
    Watch watch;
    watch.begin("loop");
    Triangulation t;
    triangulate(points, std::array<std::uint32_t, 2>{0, n}, t, watch.execution());
    watch.begin("end");
    return watch.polls_["loop"];
  };
  for (int family = 0; family < 5; ++family) {
    SCOPED_TRACE("family " + std::to_string(family));
    // At most a thousand steps for each point at any size: the search for ears is limited.
    for (const std::uint32_t n : {4000u, 32'000u, 128'000u}) {
      if (short_tests() && n > 100'000) continue;
      EXPECT_LE(polls(n, family), 200 + n * 1000.0 / 8192) << n;
    }
  }
}

TEST(Products, AreCountedWhileTheyAreMade) {
  const GrowthInput input = find_growth_family("pane")->make(2000, 1);
  const Solid solid = *make_solid(std::make_shared<Mesh>(input.mesh), {}, {});
  const Tetrahedralization t = *tetrahedralize(random_sites(solid.box, 2000, 1), solid.box, {});
  // The limit is a quarter of the bytes of the polygons alone. The stage must refuse by name before it makes
  // more.
  const VoronoiDiagram diagram(t, solid.box);
  const std::size_t polygons = cut_surface(solid, diagram, {}).polygons.size();
  const std::uint64_t limit = polygons * bytes_of(Product::kPolygons) / 4;
  Allowance allowance(0, limit, [&](std::uint64_t bytes) {
    return bytes <= limit ? Allowance::Answer::kGranted : Allowance::Answer::kNever;
  });
  Execution execution;
  execution.allowance = &allowance;
  try {
    cut_surface(solid, diagram, execution);
    FAIL() << "made more than it may hold";
  } catch (const Interrupted& interrupted) {
    EXPECT_EQ(interrupted.code, ErrorCode::kTooComplex);
    ASSERT_TRUE(interrupted.error);
    EXPECT_EQ(interrupted.error->extra->at("grew"), "polygons");
    EXPECT_LE(interrupted.error->extra->at("count").get<std::uint64_t>(), polygons / 4 + 2048);
  }

  // The full amount is granted each time.
  std::atomic<std::uint64_t> granted{0};
  Allowance all(0, 1ull << 40, [&](std::uint64_t bytes) {
    granted = bytes;
    return Allowance::Answer::kGranted;
  });
  execution.allowance = &all;
  const std::uint64_t before_tetrahedra = all.bytes();
  const Tetrahedralization again = *tetrahedralize(random_sites(solid.box, 2000, 1), solid.box, execution);
  EXPECT_GE(all.bytes() - before_tetrahedra, again.tets.size() * bytes_of(Product::kTetrahedra));
  const std::uint64_t before = all.bytes();
  const RestrictedDiagram r = restrict_to_solid(SeenSolid(solid), diagram, execution);
  const Pieces pieces = gather_pieces(r, Ownership::from_groups(t.site_count(), {}), execution);
  std::uint64_t faces = 0, surface_segments = 0;
  for (const Piece& p : pieces.pieces) faces += p.faces.size();
  for (const CutPolygon& p : r.cuts.polygons)
    for (std::uint32_t k = 0; k < p.count; ++k) {
      const PolygonSide side = r.cuts.sides[p.first + k];
      surface_segments += !is_mesh_edge(side) && side > p.cell;
    }
  const std::uint64_t known = r.cuts.polygons.size() * bytes_of(Product::kPolygons) +
                              (r.winding.segments.size() + surface_segments) * bytes_of(Product::kSegments) +
                              faces * bytes_of(Product::kFragmentTriangles) +
                              r.caps.triangles.size() * bytes_of(Product::kCapTriangles);
  EXPECT_GE(all.bytes() - before, known);
  EXPECT_LE(all.bytes() - before, known + known / 4) << "caps are counted by their loops' points";
}

}  // namespace
}  // namespace fracture::test
