// An unsound answer is detected, whatever is wrong with it.
#include "common/pipeline/soundness.hpp"
#include "common/fragment/file_volume.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/fragment/assemble.hpp"
#include "common/fragment/closedness.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/fragment/mirror_sum.hpp"
#include "common/hits/delta.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

struct Answer : testing::Test {
  Answer() {
    FractureParameters p;
    p.sites = 20;
    p.seed = 3;
    answer = fracture_mesh(torus(24, 12), p);
  }
  FragmentSet& set() { return answer.set; }
  /// Judges the answer after a change, as the last stage of the pipeline would.
  Verdict judged(Promise promise = Promise::kPartition) {
    for (Fragment& f : set().fragments) {
      f.cap_sum = mirror_sum(f);
      f.open_edges = open_edges(f);
    }
    Certificate& c = set().certificate;
    c.volume_out = c.volume_file = 0;
    for (const Fragment& f : set().fragments) {
      c.volume_out += f.mass.volume;
      c.volume_file += file_volume(f).volume;
    }
    sum_up(answer.solid, set().fragments, c);
    return judge(set(), answer.solid, promise);
  }
  Fractured answer;
};

TEST_F(Answer, IsSound) {
  const Verdict verdict = judged();
  EXPECT_TRUE(verdict.sound()) << verdict.violations[0];
  EXPECT_GT(set().fragments.size(), 10u);
}

TEST_F(Answer, WithATriangleMissingIsOpen) {
  Fragment& f = set().fragments[4];
  f.indices.erase(f.indices.begin(), f.indices.begin() + 3);
  for (FragmentPrimitive& p : f.primitives) p.first_index -= p.first_index > 0 ? 3 : 0;
  for (IndexRange& range : f.caps) range.first -= 3;
  const Verdict verdict = judged();
  ASSERT_FALSE(verdict.sound());
  EXPECT_NE(verdict.violations[0].find("3 edges"), std::string::npos) << verdict.violations[0];
  EXPECT_EQ(verdict.fragments, std::vector<std::uint32_t>{4});
  EXPECT_FALSE(judged(Promise::kClosed).sound());
}

TEST_F(Answer, WithACapThatOneSideHasElsewhereHasNoMirrorImage) {
  // The whole fragment is moved by a few lattice steps. It stays closed and keeps its volume.
  set().fragments[7].pivot.x += 4 * set().lattice_step.x;
  const Verdict verdict = judged();
  ASSERT_FALSE(verdict.sound());
  EXPECT_NE(verdict.violations[0].find("no mirror image"), std::string::npos) << verdict.violations[0];
  EXPECT_GT(verdict.fragments.size(), 1u);
  EXPECT_TRUE(std::binary_search(verdict.fragments.begin(), verdict.fragments.end(), 7u));
  EXPECT_TRUE(judged(Promise::kClosed).sound());
}

// A sum over edges would cancel here, because the outline of the two triangles is unchanged.
TEST_F(Answer, WithACapThatIsTriangulatedOtherwiseOnOneSideHasNoMirrorImage) {
  bool flipped = false;
  for (Fragment& f : set().fragments) {
    for (const IndexRange& range : f.caps)
      for (std::uint32_t k = range.first; k + 6 <= range.first + range.count && !flipped; k += 3) {
        std::uint32_t *s = f.indices.data() + k, *t = s + 3;
        for (int turn = 0; turn < 9 && !(s[0] == t[1] && s[1] == t[0]); ++turn) {
          std::rotate(s, s + 1, s + 3);
          if (turn % 3 == 2) std::rotate(t, t + 1, t + 3);
        }
        if (!(s[0] == t[1] && s[1] == t[0])) continue;
        const std::uint32_t a = s[0], b = s[1], c = s[2], d = t[2];
        s[0] = c, s[1] = a, s[2] = d;
        t[0] = d, t[1] = b, t[2] = c;
        flipped = true;
      }
    if (flipped) break;
  }
  ASSERT_TRUE(flipped);
  const Verdict verdict = judged();
  ASSERT_FALSE(verdict.sound());
  EXPECT_EQ(set().certificate.open_edges, 0u);
  EXPECT_NE(verdict.violations[0].find("no mirror image"), std::string::npos) << verdict.violations[0];
}

TEST_F(Answer, WithoutOneOfItsFragmentsLosesVolumeAndSurface) {
  set().fragments.pop_back();
  const Verdict verdict = judged();
  std::string all;
  for (const std::string& v : verdict.violations) all += v + "\n";
  EXPECT_NE(all.find("no mirror image"), std::string::npos) << all;
  EXPECT_NE(all.find("volumes before rounding"), std::string::npos) << all;
  EXPECT_NE(all.find("volumes in the file"), std::string::npos) << all;
  EXPECT_NE(all.find("of the surface"), std::string::npos) << all;
}

TEST_F(Answer, WithATriangleTurnedOverOutsideCoversMoreThanTheSurface) {
  set().fragments[0].surface_area *= 1.01;
  const Verdict verdict = judged();
  ASSERT_EQ(verdict.violations.size(), 1u);
  EXPECT_NE(verdict.violations[0].find("of the surface"), std::string::npos) << verdict.violations[0];
}

TEST_F(Answer, WhoseVolumeIsNoNumberIsNotSound) {
  set().certificate.volume_out = std::nan("");
  EXPECT_FALSE(judge(set(), answer.solid, Promise::kPartition).sound());
}

TEST(MirrorSum, DoesNotDependOnTheCornerATriangleBeginsWith) {
  FractureParameters p;
  p.sites = 9;
  FragmentSet set = fracture_mesh(cube(), p).set;
  for (Fragment& f : set.fragments) {
    const std::uint64_t before = mirror_sum(f);
    for (std::size_t k = 0; k < f.indices.size(); k += 3)
      std::rotate(f.indices.begin() + static_cast<std::ptrdiff_t>(k),
                  f.indices.begin() + static_cast<std::ptrdiff_t>(k) + 1,
                  f.indices.begin() + static_cast<std::ptrdiff_t>(k) + 3);
    EXPECT_EQ(mirror_sum(f), before);
    EXPECT_NE(before, 0u);
  }
}

// The kept sums represent the fragments that the delta leaves out.
TEST(Soundness, ADeltaAloneIsJudgedAsTheWhole) {
  Execution execution;
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(torus(48, 24)), {}, execution);
  ASSERT_TRUE(solid);
  FractureParameters p;
  p.sites = 60;
  p.rest = LocalRest::kFractured;
  Expected<KeptAnswer> whole = fracture_and_keep(*solid, p, execution, timings);
  ASSERT_TRUE(whole);
  p.hits = {{whole->fractured.set.fragments[5].mass.center_of_mass, 0.2, 6}};
  const NewHits only{1, /*only_changed=*/true};
  const Expected<KeptAnswer> hit = fracture_delta(*solid, whole->base, p, only, execution, timings);
  ASSERT_TRUE(hit) << hit.error().detail;
  EXPECT_LT(hit->fractured.set.fragments.size(), 40u);
  EXPECT_EQ(hit->fractured.set.certificate.unmirrored_caps, 0u);
  // A hit cuts fragments whose vertices are rounded, so the area changes by about that rounding.
  EXPECT_NEAR(hit->fractured.set.certificate.area_out, solid->report.area, 1e-7 * solid->report.area);

  // If kept data is damaged, the answer is refused.
  FracturedBase damaged = whole->base;
  KeptFragment wrong = *damaged.broken.fragments[40];
  wrong.fragment.cap_sum += 1;
  damaged.broken.fragments[40] = std::make_shared<const KeptFragment>(std::move(wrong));
  const Expected<KeptAnswer> again = fracture_delta(*solid, damaged, p, only, execution, timings);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kUnsound);
}

TEST(Soundness, BodiesThatMayCollideAndOverlapAreNoAnswer) {
  Rest rest;
  rest.figures = {.pairs = 3, .filtered = 3, .deepest = 0.0002, .tolerance = 0.0002};
  EXPECT_TRUE(judge_rest(rest, HullFilters::kSystems).sound());
  rest.figures.filtered = 2;
  rest.figures.deepest = 0.01;
  const Verdict verdict = judge_rest(rest, HullFilters::kSystems);
  ASSERT_EQ(verdict.violations.size(), 1u);
  EXPECT_EQ(unsound(verdict, {}).code, ErrorCode::kUnsound);
  EXPECT_TRUE(judge_rest(rest, HullFilters::kNone).sound()) << "a format without filters: a warning";
  rest.figures.left = 1;
  EXPECT_TRUE(judge_rest(rest, HullFilters::kSystems).sound())
      << "filters ran out: a warning counts the pair";
}

}  // namespace
}  // namespace fracture::test
