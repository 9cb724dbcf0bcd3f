// Compares contacts with random points. Points on the surfaces measure the distance to the other part. Points
// in the boxes show which parts contain them. The test shares no code with common/contacts: it measures
// distances from the sides of a triangle, and finds inside points by solid angles (van Oosterom & Strackee
// 1983).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/base/random.hpp"
#include "tests/contacts/part_meshes.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {
namespace {

using Triangle = std::array<Vec3d, 3>;

struct Part {
  std::vector<Triangle> triangles;
  std::vector<double> areas;  ///< running totals
  Box box;
  double longest = 0;  ///< the longest edge of all
  double area() const { return areas.back(); }
};

std::array<Part, 2> parts_of(const Solid& solid) {
  std::array<Part, 2> parts;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    Part& part = parts[solid.part[t]];
    Triangle corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = to_double(solid.positions[solid.triangles[t][k]]);
      part.box.add(corners[k]);
    }
    for (std::size_t k = 0; k < 3; ++k)
      part.longest = std::max(part.longest, length(corners[(k + 1) % 3] - corners[k]));
    const double area = 0.5 * length(cross(corners[1] - corners[0], corners[2] - corners[0]));
    part.areas.push_back((part.areas.empty() ? 0 : part.areas.back()) + area);
    part.triangles.push_back(corners);
  }
  return parts;
}

double distance(const Vec3d& p, const Triangle& t) {
  const auto to_segment = [&](const Vec3d& a, const Vec3d& b) {
    const double s = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
    return length(p - (a + s * (b - a)));
  };
  const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
  bool over = true;
  for (std::size_t k = 0; k < 3; ++k) over &= dot(n, cross(t[(k + 1) % 3] - t[k], p - t[k])) >= 0;
  if (over) return std::fabs(dot(n, p - t[0])) / length(n);
  return std::min({to_segment(t[0], t[1]), to_segment(t[1], t[2]), to_segment(t[2], t[0])});
}

/// Whether test(triangle) is true for any triangle that may be within the gap.
template <class Test>
bool any_near(const Vec3d& p, const Part& part, double gap, const Test& test) {
  const double far = 1.01 * (gap + part.longest), square = far * far;
  return std::any_of(part.triangles.begin(), part.triangles.end(),
                     [&](const Triangle& t) { return dot(p - t[0], p - t[0]) <= square && test(t); });
}

bool is_within(const Vec3d& p, const Part& part, double gap) {
  return any_near(p, part, gap, [&](const Triangle& t) { return distance(p, t) <= gap; });
}

/// Whether the line from p along the normal meets, within the gap, a surface that faces the normal.
bool faces(const Vec3d& p, const Vec3d& normal, const Part& part, double gap) {
  return any_near(p, part, gap, [&](const Triangle& t) {
    const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
    const double slope = dot(n, normal);
    if (!(slope < 0)) return false;
    const double up = dot(n, t[0] - p) / slope;
    if (up < -1e-6 || up > gap) return false;
    const Vec3d x = p + up * normal;
    for (std::size_t k = 0; k < 3; ++k)
      if (dot(n, cross(t[(k + 1) % 3] - t[k], x - t[k])) < 0) return false;
    return true;
  });
}

bool is_inside(const Vec3d& p, const Part& part) {
  double angle = 0;
  for (const Triangle& t : part.triangles) {
    const Vec3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
    const double la = length(a), lb = length(b), lc = length(c);
    angle +=
        2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return angle > 6;  // 4π inside, 0 outside
}

/// The area of the surface on which visit(place, normal) is true, and its standard deviation.
struct Sampled {
  double value, error;
};
template <class Visit>
Sampled sampled_area(const Part& part, int count, Random& random, const Visit& visit) {
  int hits = 0;
  for (int k = 0; k < count; ++k) {
    const double at = part.area() * (k + random.uniform()) / count;
    const auto found = std::upper_bound(part.areas.begin(), part.areas.end() - 1, at);
    const Triangle& t = part.triangles[static_cast<std::size_t>(found - part.areas.begin())];
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3d across = cross(t[1] - t[0], t[2] - t[0]);
    hits += visit(t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]), (1 / length(across)) * across);
  }
  const double share = (hits + 0.5) / (count + 1);
  return {part.area() * hits / count, part.area() * std::sqrt(share * (1 - share) / count)};
}

Sampled smaller(const Sampled& a, const Sampled& b) { return a.value < b.value ? a : b; }

Turn random_turn(Random& random) {
  const auto direction = [&] {
    for (;;) {
      const double x = 2 * random.uniform() - 1, y = 2 * random.uniform() - 1, z = 2 * random.uniform() - 1;
      if (const double l = length({x, y, z}); l > 0.1 && l <= 1) return (1 / l) * Vec3d{x, y, z};
    }
  };
  const Vec3d a = direction();
  Vec3d b = direction();
  while (length(cross(a, b)) < 0.1) b = direction();
  const Vec3d c = (1 / length(cross(a, b))) * cross(a, b);
  return {a, cross(c, a), c};
}

const int kSamples = sized(600, 6000);
constexpr double kSigmas = 4.5;

void expect_overlap(const Solid& solid, Random& random, std::size_t& overlapping) {
  const ContactGraph graph = contacts_of(solid, 1e-4);
  const std::array<Part, 2> parts = parts_of(solid);
  const Sampled a = sampled_area(parts[0], kSamples, random,
                                 [&](const Vec3d&p, const Vec3d&) { return is_inside(p, parts[1]); }),
                b = sampled_area(parts[1], kSamples, random,
                                 [&](const Vec3d&p, const Vec3d&) { return is_inside(p, parts[0]); });
  if (graph.contacts.empty()) {
    EXPECT_EQ(a.value + b.value, 0);
    return;
  }
  const Contact& c = graph.contacts[0];
  ++overlapping;
  EXPECT_EQ(c.kind, ContactKind::kOverlapping);
  const Sampled least = std::min(a.value, b.value) > 0 ? smaller(a, b) : a.value > 0 ? a : b;
  EXPECT_NEAR(c.area, least.value, kSigmas * least.error);
  Box common;
  common.add(Vec3d{std::max(parts[0].box.min.x, parts[1].box.min.x),
                   std::max(parts[0].box.min.y, parts[1].box.min.y),
                   std::max(parts[0].box.min.z, parts[1].box.min.z)});
  const Vec3d size = Vec3d{std::min(parts[0].box.max.x, parts[1].box.max.x),
                           std::min(parts[0].box.max.y, parts[1].box.max.y),
                           std::min(parts[0].box.max.z, parts[1].box.max.z)} -
                     common.min;
  int hits = 0;
  for (int k = 0; k < kSamples; ++k) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    const Vec3d p = common.min + Vec3d{x * size.x, y * size.y, z * size.z};
    hits += is_inside(p, parts[0]) && is_inside(p, parts[1]);
  }
  const double whole = size.x * size.y * size.z, share = (hits + 0.5) / (kSamples + 1);
  EXPECT_NEAR(c.volume, whole * hits / kSamples, kSigmas * whole * std::sqrt(share * (1 - share) / kSamples));
}

TEST(ContactSamples, OverlapsOfBoxesAndSpheres) {
  Random random(11);
  std::size_t overlapping = 0;
  for (int round = 0; round < 24; ++round) {
    SCOPED_TRACE(round);
    const auto shape = [&](bool sphere) {
      const double x = 0.5 + random.uniform(), y = 0.5 + random.uniform(), z = 0.5 + random.uniform();
      return sphere ? ico_sphere(2, 0.5 * x) : box({-x / 2, -y / 2, -z / 2}, {x / 2, y / 2, z / 2});
    };
    const Mesh a = turned(shape(round % 3 == 1), random_turn(random));
    const Mesh b = turned(shape(round % 3 != 0), random_turn(random));
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    expect_overlap(solid_of(joined({a, translated(b, {0.8 * x, 0.8 * y, 0.8 * z})})), random, overlapping);
  }
  EXPECT_GT(overlapping, 15u);
}

/// Checks the facing area against its definition, and compares it with the whole surface within the gap.
/// Returns the latter.
Sampled expect_facing(const Solid& solid, double gap, const Contact& c, Random& random) {
  const std::array<Part, 2> parts = parts_of(solid);
  EXPECT_EQ(c.kind, ContactKind::kTouching);
  std::array<Sampled, 2> facing, within;
  for (std::size_t k = 0; k < 2; ++k) {
    const Part& other = parts[1 - k];
    facing[k] = sampled_area(parts[k], 20 * kSamples, random,
                             [&](const Vec3d& p, const Vec3d& n) { return faces(p, n, other, gap); });
    within[k] = sampled_area(parts[k], 20 * kSamples, random,
                             [&](const Vec3d& p, const Vec3d&) { return is_within(p, other, gap); });
  }
  const Sampled least = smaller(facing[0], facing[1]);
  EXPECT_NEAR(c.area, least.value, kSigmas * least.error);
  return smaller(within[0], within[1]);
}

TEST(ContactSamples, FacesOfBoxesWithinAGapAreAllSurfaceWithinItButForTheRim) {
  Random random(12);
  for (int round = 0; round < 6; ++round) {
    SCOPED_TRACE(round);
    const double gap = 0.01, apart = 0.002 * round, angle = random.uniform(), x = random.uniform(),
                 y = random.uniform();
    // Turns about z, moves to the place, and then turns everything.
    const Turn spin{
        Vec3d{std::cos(angle), std::sin(angle), 0}, Vec3d{-std::sin(angle), std::cos(angle), 0}, {0, 0, 1}};
    const Mesh b = translated(turned(cube(1 + round % 2), spin), {0.6 * x, 0.6 * y, 1 + apart});
    const Turn turn = random_turn(random);
    const Solid solid = solid_of(joined({turned(cube(), turn), turned(b, turn)}));
    const ContactGraph graph = contacts_of(solid, gap);
    if (round == 5 && graph.contacts.empty()) continue;  // the distance equals the gap: rounding decides
    ASSERT_EQ(graph.contacts.size(), 1u);
    const Contact& c = graph.contacts[0];
    const Sampled within = expect_facing(solid, gap, c, random);
    // The difference is a rim in the face, no wider than the gap, and a rim of the same width on the sides
    // along four edges.
    EXPECT_GT(within.value + kSigmas * within.error, c.area);
    EXPECT_LT(within.value - kSigmas * within.error, c.area + 2 * 4 * gap);
  }
}

TEST(ContactSamples, SpheresWithinAGapAreAllSurfaceWithinIt) {
  Random random(13);
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    const double gap = 0.05;
    const Turn turn = random_turn(random);
    const Mesh a = turned(ico_sphere(3), turn), b = turned(ico_sphere(3, 0.5), random_turn(random));
    const Solid solid = solid_of(joined({a, translated(b, {0.92, 1.12, 0.47})}));
    const ContactGraph graph = contacts_of(solid, gap);
    ASSERT_EQ(graph.contacts.size(), 1u);
    const Sampled within = expect_facing(solid, gap, graph.contacts[0], random);
    // Along the normal of one sphere, the other is farther than in a straight line, by a share of about gap /
    // radius.
    EXPECT_LT(std::fabs(graph.contacts[0].area / within.value - 1),
              gap / 0.5 + kSigmas * within.error / within.value);
  }
}

}  // namespace
}  // namespace fracture::test
