// Parts near an impact get pieces by their distance to it, whatever their volumes, so they break.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/materials/materials.hpp"
#include "common/sites/part_shares.hpp"
#include "tests/structure/in_contact.hpp"
#include "tests/structure/seed.hpp"
#include "tests/support/pattern_requests.hpp"

namespace fracture::test {
namespace {

/// A house of 6 m: four walls, a roof of eight planks, and a window pane of 1 m in an opening of the front wall.
constexpr std::uint32_t kPane = 0;
const Vec3d kHit{0, 1.5, 3};
std::vector<Mesh> house() {
  std::vector<Mesh> parts{box({-0.5, 1, 2.997}, {0.5, 2, 3.003}, 4)};
  parts.push_back(box({-3, 0, 2.9}, {-0.5, 3, 3.1}));  // the front wall, around the window
  parts.push_back(box({0.5, 0, 2.9}, {3, 3, 3.1}));
  parts.push_back(box({-0.5, 0, 2.9}, {0.5, 1, 3.1}));
  parts.push_back(box({-0.5, 2, 2.9}, {0.5, 3, 3.1}));
  parts.push_back(box({-3, 0, -3.1}, {3, 3, -2.9}));
  parts.push_back(box({-3.2, 0, -3.1}, {-3, 3, 3.1}));
  parts.push_back(box({3, 0, -3.1}, {3.2, 3, 3.1}));
  for (int k = 0; k < 8; ++k) parts.push_back(box({-3.2 + 0.8 * k, 3, -3.2}, {-2.4 + 0.8 * k, 3.05, 3.2}));
  return parts;
}

std::size_t fragments_with(const FragmentSet& set, std::uint32_t part) {
  return static_cast<std::size_t>(
      std::count_if(set.fragments.begin(), set.fragments.end(), [&](const Fragment& f) {
        if (f.part_volumes.empty()) return f.part == part;
        return std::any_of(f.part_volumes.begin(), f.part_volumes.end(),
                           [&](const PartVolume& v) { return v.part == part; });
      }));
}

FractureParameters hit_house(const char* material, std::uint32_t fragments, std::uint64_t seed) {
  FractureParameters p = of_material(*find_material_preset(material), fragments, seed);
  p.roughness = {};
  p.size.fragments = fragments;
  p.size.min_of_mean = kLeastOfMean;
  std::visit(
      [](auto& pattern) {
        if constexpr (requires { pattern.impacts; }) pattern.impacts = {kHit};
      },
      p.pattern);
  return p;
}

TEST(HitParts, APaneThatIsHitBreaksAlthoughItIsAThousandthOfTheHouse) {
  const Solid solid = solid_in_contact(house());
  double all = 0;
  for (const Part& part : solid.parts) all += part.volume;
  ASSERT_LT(solid.parts[kPane].volume, all / 1000);
  for (const char* material : {"glass", "ceramic"})
    for (const Parts parts : {Parts::kTogether, Parts::kApart})
      for (const std::uint64_t seed : {kSeed, kSeed + 1, kSeed + 2}) {
        SCOPED_TRACE(std::string(material) + " " + std::to_string(seed));
        FractureParameters p = hit_house(material, 100, seed);
        p.parts = parts;
        const Fractured hit = fracture_solid(solid, p);
        EXPECT_GE(fragments_with(hit.set, kPane), 8u);
        EXPECT_NEAR(static_cast<double>(hit.set.fragments.size()), 100, 10);
        EXPECT_NEAR(hit.set.certificate.volume_out, hit.set.certificate.volume_in,
                    1e-9 * hit.set.certificate.volume_in);
      }
}

TEST(HitParts, FragmentsNearTheHitAreManyMoreThanWithoutIt) {
  const Solid solid = solid_in_contact(house());
  const auto near = [&](const FractureParameters& p) {
    const Fractured f = fracture_solid(solid, p);
    return std::count_if(f.set.fragments.begin(), f.set.fragments.end(), [&](const Fragment& fragment) {
      return length(fragment.mass.center_of_mass - kHit) < 2;
    });
  };
  FractureParameters evenly;
  evenly.sites = evenly.size.fragments = 100;
  for (const char* material : {"glass", "ceramic"}) {
    SCOPED_TRACE(material);
    EXPECT_GT(near(hit_house(material, 100, kSeed)), 2 * near(evenly));
  }
}

TEST(HitParts, SharesFallWithTheSquareOfTheDistanceAndNotWithVolume) {
  // A pane of 1 m at the hit, a block 1 m away, and a block beyond the radius.
  const Solid solid = solid_of(joined(
      {box({-0.5, -0.5, 0}, {0.5, 0.5, 0.01}), box({-1, -1, 1}, {1, 1, 2}), box({-1, -1, 9}, {1, 1, 10})}));
  const ImpactPattern pattern{.impacts = {{0, 0, 0}}, .radius = 2, .share = 0.5};
  const auto shares = shares_of_parts(solid, pattern, {});
  ASSERT_TRUE(shares);
  // With s = 2 / 8 = 0.25 m, the block weighs 1 / (1 + 16).
  EXPECT_NEAR(shares->near[0], 17.0 / 18, 1e-9);
  EXPECT_NEAR(shares->near[1], 1.0 / 18, 1e-9);
  EXPECT_EQ(shares->near[2], 0);
  EXPECT_NEAR(shares->share[2], 0.5 * 4 / 8.01, 1e-6);
  EXPECT_EQ(shares->nearest, 0u);
  // An impact inside a block is at the distance 0.
  const auto inside = shares_of_parts(solid, ImpactPattern{.impacts = {{0, 0, 1.5}}, .radius = 2}, {});
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->nearest, 1u);
  EXPECT_NEAR(inside->near[0] / inside->near[1], 1 / (1 + std::pow(1.49 / 0.25, 2)), 1e-6);
  EXPECT_FALSE(shares_of_parts(solid, ImpactPattern{.impacts = {{50, 0, 0}}, .radius = 2}, {}));
  EXPECT_FALSE(shares_of_parts(solid, UniformPattern{}, {}));
  EXPECT_FALSE(shares_of_parts(solid_of(cube()), pattern, {})) << "one part";
}

}  // namespace
}  // namespace fracture::test
