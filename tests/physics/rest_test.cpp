#include "common/physics/rest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "common/contacts/contacts.hpp"
#include "common/physics/hull_trim.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

constexpr double kTolerance = 1e-3;

CollisionHull box_hull(const Vec3d& low, const Vec3d& high) {
  CollisionHull hull;
  for (int k = 0; k < 8; ++k)
    hull.points.push_back({static_cast<float>(k & 1 ? high.x : low.x),
                           static_cast<float>(k & 2 ? high.y : low.y),
                           static_cast<float>(k & 4 ? high.z : low.z)});
  hull.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return hull;
}

/// Bodies with one box each. All share a cell.
struct Boxes {
  FragmentSet set;
  CollisionHulls hulls;

  void add(const Vec3d& low, const Vec3d& high) {
    Fragment& f = set.fragments.emplace_back();
    f.id = 100 + set.fragments.size();
    f.sites = {SiteId{7}};
    f.pivot = low;
    hulls.of_fragment.emplace_back().hulls.push_back(box_hull({}, high - low));
  }
  Rest rest(HullFilters filters = HullFilters::kSystems) {
    return bring_to_rest(set, hulls, {CellMap()}, kTolerance, filters, {});
  }
};

bool collide(const Rest& rest, std::uint32_t a, std::uint32_t b) {
  if (rest.filters.of_body.empty()) return true;
  const auto filter = [&](std::uint32_t k) -> const CollisionFilters::Filter* {
    const std::uint32_t number = rest.filters.of_body[k];
    return number == kNoIndex ? nullptr : &rest.filters.filters[number];
  };
  const auto *x = filter(a), *y = filter(b);
  const auto lists = [](const auto& one, std::uint32_t system) {
    return std::find(one.excluded.begin(), one.excluded.end(), system) != one.excluded.end();
  };
  return !x || !y || (!lists(*x, y->system) && !lists(*y, x->system));
}

TEST(Rest, ExcludesWhatOverlapsAndNoMore) {
  Boxes row;  // each reaches 0.1 into the next one
  for (int k = 0; k < 3; ++k) row.add({0.9 * k, 0, 0}, {0.9 * k + 1, 1, 1});
  const Rest rest = row.rest();
  EXPECT_EQ(rest.figures.pairs, 2u);
  EXPECT_EQ(rest.figures.filtered, 2u);
  EXPECT_EQ(rest.figures.left, 0u);
  EXPECT_EQ(rest.figures.trimmed, 0u);
  EXPECT_EQ(rest.figures.deepest, 0);
  EXPECT_FALSE(collide(rest, 0, 1));
  EXPECT_FALSE(collide(rest, 1, 2));
  EXPECT_TRUE(collide(rest, 0, 2));
  EXPECT_EQ(rest.filtered, (std::vector<std::array<std::uint64_t, 2>>{{101, 102}, {102, 103}}));
}

TEST(Rest, BodiesThatTouchAlmostMayCollide) {
  Boxes two;
  two.add({0, 0, 0}, {1, 1, 1});
  two.add({1 - 5e-4, 0, 0}, {2, 1, 1});
  const Rest rest = two.rest();
  EXPECT_EQ(rest.figures.pairs, 0u);
  EXPECT_NEAR(rest.figures.deepest, 5e-4, 3e-5);
  EXPECT_TRUE(rest.filters.filters.empty());
}

TEST(Rest, WithoutFiltersOverlapsAreCounted) {
  Boxes two;
  two.add({0, 0, 0}, {1, 1, 1});
  two.add({0.75, 0, 0}, {1.75, 1, 1});
  const Rest rest = two.rest(HullFilters::kNone);
  EXPECT_EQ(rest.figures.pairs, 1u);
  EXPECT_EQ(rest.figures.left, 1u);
  EXPECT_NEAR(rest.figures.deepest, 0.25, 3e-5);
  EXPECT_TRUE(rest.filtered.empty());
}

TEST(Rest, OfDifferentCellsOfOneDiagramNeedsNoLook) {
  Boxes two;
  two.add({0, 0, 0}, {1, 1, 1});
  two.add({0.5, 0, 0}, {1.5, 1, 1});
  two.set.fragments[1].sites = {SiteId{8}};
  EXPECT_EQ(two.rest().figures.pairs, 0u);
}

TEST(Rest, OfPartsWithDiagramsOfTheirOwnIsMeasured) {
  Boxes two;
  two.add({0, 0, 0}, {1, 1, 1});
  two.add({0.5, 0, 0}, {1.5, 1, 1});
  two.set.fragments[1].sites = {SiteId{8}};
  two.set.fragments[1].part = 1;
  const Matrix3 unit{};
  const std::array<Matrix3, 2> matrices{unit, unit};
  const std::array<Box, 2> boxes{Box{{0, 0, 0}, {1, 1, 1}}, Box{{0.5, 0, 0}, {1.5, 1, 1}}};
  const CellMap map(matrices, {0, 1}, boxes);
  const Rest rest = bring_to_rest(two.set, two.hulls, {map}, kTolerance, HullFilters::kSystems, {});
  EXPECT_EQ(rest.figures.filtered, 1u);
}

TEST(Rest, HullsAreTrimmedWhenFiltersRunOut) {
  Boxes pairs;  // 40 pairs, far from each other: 31 have a filter, 9 are trimmed
  for (int k = 0; k < 40; ++k) {
    pairs.add({3.0 * k, 0, 0}, {3.0 * k + 1, 1, 1});
    pairs.add({3.0 * k + 0.8, 0, 0}, {3.0 * k + 1.8, 1, 1});
  }
  const Rest rest = pairs.rest();
  EXPECT_TRUE(rest.trimmed_for_filters);
  EXPECT_EQ(rest.figures.pairs, 40u);
  EXPECT_EQ(rest.figures.filtered, 31u);
  EXPECT_EQ(rest.figures.left, 0u);
  EXPECT_EQ(rest.figures.trimmed, 18u);
  EXPECT_EQ(rest.figures.systems, 32u);
  EXPECT_LE(rest.figures.deepest, kTolerance);
  EXPECT_NEAR(rest.figures.least_share, 0.9 - 0.5 * kHullInset,
              1e-4);  // half of what overlaps, and of the gap
  EXPECT_EQ(pairs.rest().figures.pairs, 31u);
}

// Each body has two boxes, and both lose a tenth. So no hull keeps less than nine tenths.
TEST(Rest, TheLeastShareIsThatOfOneHull) {
  Boxes pairs;
  for (int k = 0; k < 40; ++k)
    for (const double x : {3.0 * k, 3.0 * k + 0.8}) {
      pairs.add({x, 0, 0}, {x + 1, 1, 1});
      pairs.hulls.of_fragment.back().hulls.push_back(box_hull({0, 0, 2}, {1, 1, 3}));
    }
  const Rest rest = pairs.rest();
  EXPECT_EQ(rest.figures.trimmed, 18u);
  EXPECT_NEAR(rest.figures.least_share, 0.9 - 0.5 * kHullInset, 1e-4);
  double least = 1;  // from the points that are written: the boxes had 1 m³
  for (const FragmentHulls& body : pairs.hulls.of_fragment)
    for (const CollisionHull& hull : body.hulls) {
      Box box;
      for (const Vec3f& p : hull.points) box.add(to_double(p));
      least = std::fmin(least, box.size().x * box.size().y * box.size().z);
    }
  EXPECT_NEAR(rest.figures.least_share, least, 1e-12);
}

// A body that barely overlaps the first one of a pair no longer does so when that one has been trimmed.
TEST(Rest, TheDeepestOverlapIsThatOfTrimmedHulls) {
  const auto pairs = [] {
    Boxes boxes;
    for (int k = 0; k < 40; ++k) {
      boxes.add({3.0 * k, 0, 0}, {3.0 * k + 1, 1, 1});
      boxes.add({3.0 * k + 0.8, 0, 0}, {3.0 * k + 1.8, 0.4, 1});
    }
    return boxes;
  };
  Boxes boxes = pairs();
  boxes.rest();
  double x = -1;  // of the first body of a pair that is trimmed
  for (std::size_t k = 0; k < 80 && x < 0; k += 2)
    if (boxes.hulls.of(k)[0].untrimmed > 0) x = boxes.set.fragments[k].pivot.x;
  ASSERT_GE(x, 0) << "nothing is trimmed";
  boxes = pairs();
  boxes.add({x + 1 - 5e-4, 0.6, 0}, {x + 1.9, 1, 1});
  EXPECT_NEAR(boxes.rest(HullFilters::kNone).figures.deepest, 0.2, 1e-3);
  const Rest rest = boxes.rest();
  EXPECT_TRUE(rest.trimmed_for_filters);
  EXPECT_EQ(rest.figures.left, 0u);
  EXPECT_EQ(rest.figures.deepest, 0);
}

// Four posts stick into each of 36 beams. The pairs of a beam wait for each other.
TEST(Rest, TrimmingDoesNotDependOnTheThreads) {
  const auto rest_with = [](int threads) {
    Boxes boxes;
    for (int k = 0; k < 36; ++k) {
      boxes.add({0, 3.0 * k, 0}, {50, 3.0 * k + 1, 1});
      for (int post = 0; post < 4; ++post)
        boxes.add({2.0 + 10 * post, 3.0 * k + 0.7, 0.2}, {3.0 + 10 * post, 3.0 * k + 2, 0.6});
    }
    Execution execution;
    execution.threads = threads;
    const Rest rest =
        bring_to_rest(boxes.set, boxes.hulls, {CellMap()}, kTolerance, HullFilters::kSystems, execution);
    return std::pair(rest, std::move(boxes.hulls));
  };
  const auto [one, of_one] = rest_with(1);
  const auto [four, of_four] = rest_with(4);
  EXPECT_TRUE(one.trimmed_for_filters);
  EXPECT_EQ(one.figures.left, 0u);
  EXPECT_EQ(one.figures, four.figures);
  EXPECT_EQ(one.filtered, four.filtered);
  for (std::size_t k = 0; k < of_one.of_fragment.size(); ++k) {
    ASSERT_EQ(of_one.of(k).size(), of_four.of(k).size());
    for (std::size_t h = 0; h < of_one.of(k).size(); ++h)
      EXPECT_EQ(of_one.of(k)[h].points, of_four.of(k)[h].points) << k;
  }
}

// Combs of 64 teeth each, which are apart except for one pair of teeth.
TEST(Rest, TheDeepestOfManyHullsIsFound) {
  Boxes combs;
  combs.add({0, 0, 0}, {0.5, 1, 1});
  combs.add({0.5, 0.5, 0}, {1, 1.5, 1});
  for (int k = 1; k < 64; ++k)
    for (std::size_t body : {0u, 1u}) {
      const double reach = body == 1 && k == 40 ? 0.125 : 0;
      combs.hulls.of_fragment[body].hulls.push_back(
          box_hull({1.0 * k - reach, 0, 0}, {1.0 * k + 0.4375, 1, 1}));
    }
  const std::vector<Overlap> found =
      find_overlaps({{&combs.set.fragments[0], &combs.set.fragments[1]},
                     {&combs.hulls.of_fragment[0], &combs.hulls.of_fragment[1]}},
                    {CellMap()}, {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].hull_a, 40u);
  EXPECT_EQ(found[0].hull_b, 40u);
  EXPECT_NEAR(found[0].depth, 0.0625, 1e-4);
}

TEST(Rest, OneBodyInsideAnotherCanBeTrimmedToo) {
  Boxes boxes;
  for (int k = 0; k < 32; ++k) {
    boxes.add({3.0 * k, 0, 0}, {3.0 * k + 1, 1, 1});
    boxes.add({3.0 * k + 0.1, 0.4, 0.4}, {3.0 * k + 0.3, 0.6, 0.6});
  }
  const Rest rest = boxes.rest();
  EXPECT_EQ(rest.figures.left, 0u);
  EXPECT_GT(rest.figures.least_share, 0.3);
}

// -- trimming at contacts

/// A top of 2 x 0.2 x 2 with its lower face at y = 1, and a leg from the ground that sticks 0.1 into it.
Mesh table() { return joined({box({0, 1, 0}, {2, 1.2, 2}), box({0.2, 0, 0.2}, {0.5, 1.1, 0.5})}); }

Solid solid_of(const Mesh& mesh) {
  Solid solid = *make_solid(std::make_shared<Mesh>(mesh), {}, {});
  keep_contacts(solid, {}, {});
  return solid;
}

TEST(HullTrim, ALegEndsAtTheTopThatItSticksInto) {
  const Solid solid = solid_of(table());
  const std::uint32_t leg = solid.parts[0].volume < solid.parts[1].volume ? 0 : 1;
  FragmentSet set;
  Fragment& f = set.fragments.emplace_back();
  f.part = leg;
  f.pivot = {0.2, 0, 0.2};
  CollisionHulls hulls;
  hulls.of_fragment.emplace_back().hulls.push_back(box_hull({}, {0.3, 1.1, 0.3}));
  trim_at_contacts(set, solid, hulls, {});
  double top = 0;
  for (const Vec3f& p : hulls.of(0)[0].points) top = std::fmax(top, p.y);
  EXPECT_NEAR(top, 1 - kHullInset, 1e-6);
  EXPECT_NEAR(least_share(hulls.of(0)), (1 - kHullInset) / 1.1, 1e-5);
  const CollisionHulls once = hulls;
  trim_at_contacts(set, solid, hulls, {});
  EXPECT_EQ(hulls.of(0)[0].points, once.of(0)[0].points);
}

TEST(HullTrim, AHullThatWouldLoseMoreThanATenthStays) {
  const Solid solid = solid_of(table());
  const std::uint32_t leg = solid.parts[0].volume < solid.parts[1].volume ? 0 : 1;
  FragmentSet set;
  CollisionHulls hulls;
  for (const std::uint32_t part : {leg, 1 - leg}) {
    Fragment& f = set.fragments.emplace_back();
    f.part = part;
    f.pivot = {0.2, 0.5, 0.2};
    hulls.of_fragment.emplace_back().hulls.push_back(
        box_hull({}, {0.3, 0.6, 0.3}));  // a sixth of it is in the top
  }
  trim_at_contacts(set, solid, hulls, {});
  EXPECT_EQ(hulls.of(0)[0].points, box_hull({}, {0.3, 0.6, 0.3}).points);
  EXPECT_EQ(hulls.of(1)[0].points, box_hull({}, {0.3, 0.6, 0.3}).points);  // of the part that receives it
}

TEST(Rest, IsInTheCertificateOfPartsWithTheirOwnGrain) {
  const Solid solid = solid_of(table());
  FractureParameters p;
  p.sites = 30;
  p.anisotropy = {6, GrainOf::kPart};
  p.hulls = Hulls::kConvex;
  StageTimings timings;
  const auto rest_with = [&](HullFilters filters) {
    p.filters = filters;
    const Expected<Diagram> diagram = make_diagram(solid, p, {}, timings);
    return fracture(solid, *diagram, p, {}, timings)->rest.value().figures;
  };
  const RestFigures rest = rest_with(HullFilters::kSystems);
  EXPECT_GT(rest.pairs, 0u);
  EXPECT_EQ(rest.filtered, rest.pairs);
  EXPECT_EQ(rest.left, 0u);
  EXPECT_LE(rest.deepest, rest.tolerance);
  EXPECT_NEAR(rest.tolerance, 2e-4 * 2, 1e-12);
  const RestFigures without = rest_with(HullFilters::kNone);
  EXPECT_EQ(without.left, rest.pairs);
  EXPECT_GT(without.deepest, rest.tolerance);
  p.hulls = Hulls::kNone;
  EXPECT_FALSE(fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings)->rest);
}

}  // namespace
}  // namespace fracture::test
