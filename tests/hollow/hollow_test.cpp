#include "common/hollow/hollow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/pipeline/fracture.hpp"
#include "common/pipeline/refracture.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

FragmentSet fractured(const Solid& solid, std::uint32_t sites) {
  FractureParameters p;
  p.sites = sites;
  StageTimings timings;
  const Diagram diagram = make_diagram(solid, p, {}, timings).value();
  return fracture(solid, diagram, p, {}, timings).value().set;
}

double area_of_triangle(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  return length(cross(to_double(b) - to_double(a), to_double(c) - to_double(a))) / 2;
}

TEST(Hollow, APartBecomesAWall) {
  const Mesh mesh = ico_sphere(4);
  const Solid solid = solid_of(mesh), wall = hollowed(solid, {.thickness = 0.1}, {});
  wall.validate();
  const SolidReport& r = wall.report;
  EXPECT_EQ(r.parts_hollowed, 1u);
  EXPECT_EQ(r.cavities, 1u);
  EXPECT_EQ(r.shells, 2u);
  EXPECT_GE(r.least_thickness, 0.1);
  EXPECT_GT(r.mean_thickness, r.least_thickness);
  EXPECT_LT(r.mean_thickness, 0.17);
  EXPECT_NEAR(r.volume, solid.report.volume - r.hollow_volume, 1e-12);
  EXPECT_NEAR(wall.parts[0].volume, r.volume, 1e-12);
  EXPECT_EQ(r.source_triangles, solid.report.source_triangles);
}

using Corners = std::array<Vec3d, 3>;

/// The minimum of a convex function on [0, 1].
template <class Function>
double least_of(const Function& f) {
  double low = 0, high = 1;
  for (int k = 0; k < 50; ++k) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
  }
  return std::min({f((low + high) / 2), f(0), f(1)});
}

double from_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double s = dot(ab, ab) > 0 ? std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0) : 0;
  return length(p - (a + s * ab));
}

double from_triangle(const Vec3d& p, const Corners& t) {
  const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
  double least = HUGE_VAL;
  bool above = dot(n, n) > 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d &a = t[k], &b = t[(k + 1) % 3];
    above = above && dot(n, cross(b - a, p - a)) > 0;
    least = std::min(least, from_segment(p, a, b));
  }
  return above ? std::fabs(dot(n, p - t[0])) / length(n) : least;
}

/// The distance of two triangles that do not cross. The distance of a point on an edge from another edge is a
/// convex function.
double apart(const Corners& s, const Corners& t) {
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < 3; ++i) {
    least = std::min({least, from_triangle(s[i], t), from_triangle(t[i], s)});
    for (std::size_t k = 0; k < 3; ++k)
      least = std::min(least, least_of([&](double x) {
                         return from_segment(s[i] + x * (s[(i + 1) % 3] - s[i]), t[k], t[(k + 1) % 3]);
                       }));
  }
  return least;
}

/// The smallest distance over all pairs of triangles of the inner and the outer side.
double thinnest_place(const Solid& wall) {
  std::vector<Corners> inner, outer;
  for (std::size_t k = 0; k < wall.triangles.size(); ++k) {
    Corners corners;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = to_double(wall.positions[wall.triangles[k][c]]);
    (wall.material[k] == kCavityMaterial ? inner : outer).push_back(corners);
  }
  const auto ball = [](const Corners& t) {
    const Vec3d middle = (1.0 / 3) * (t[0] + t[1] + t[2]);
    return std::pair(middle, std::max({length(t[0] - middle), length(t[1] - middle), length(t[2] - middle)}));
  };
  double least = HUGE_VAL;
  for (const Corners& s : inner)
    for (const Corners& t : outer) {
      const auto [p, r] = ball(s);
      const auto [q, u] = ball(t);
      if (length(p - q) - r - u < least) least = std::min(least, apart(s, t));
    }
  return least;
}

/// A prism of height 1 over an L. Large triangles of the inner side approach its inner edge.
Mesh angle() {
  Mesh mesh;
  const std::array<std::pair<float, float>, 6> outline{{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
  for (const float z : {0.0f, 1.0f})
    for (const auto& [x, y] : outline) mesh.positions.push_back({x, y, z});
  for (std::uint32_t k = 0; k < 6; ++k) {
    const std::uint32_t next = (k + 1) % 6;
    mesh.triangles.push_back({k, next, next + 6});
    mesh.triangles.push_back({k, next + 6, k + 6});
  }
  for (std::uint32_t k = 1; k + 1 < 6; ++k) {
    mesh.triangles.push_back({0, k + 1, k});
    mesh.triangles.push_back({6, k + 6, k + 7});
  }
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  return mesh;
}

TEST(Hollow, TheLeastThicknessIsThatOfTheThinnestPlace) {
  std::size_t input = 0;
  for (const auto& [mesh, fraction] : {std::pair{angle(), 0.0024},
                                       {angle(), 0.05},
                                       {cube(2), 0.05},
                                       {torus(12, 6), 0.03},
                                       {box({0, 0, 0}, {3, 1, 0.5}), 0.02},
                                       {ico_sphere(1), 0.04}}) {
    if (!has_turn(input++, 0, 2)) continue;
    SCOPED_TRACE(mesh.triangles.size());
    const Solid wall = hollowed(solid_of(mesh), {.fraction = fraction, .max_triangles = 2000}, {});
    ASSERT_EQ(wall.report.parts_hollowed, 1u);
    const double measured = thinnest_place(wall);
    EXPECT_NEAR(wall.report.least_thickness, measured, 1e-8);
    EXPECT_GE(wall.report.least_thickness, fraction * wall.box.longest_side() * (1 - 1e-9));
  }
}

TEST(Hollow, FragmentsOfAWallPartitionIt) {
  for (const Mesh& mesh : {ico_sphere(3), torus(48, 24), cube(4)}) {
    const Solid wall = hollowed(solid_of(mesh), {.fraction = 0.05}, {});
    wall.validate();
    ASSERT_EQ(wall.report.parts_hollowed, 1u);
    const FragmentSet set = fractured(wall, 40);
    expect_closed(set);
    expect_partition(set, wall.report.volume, wall.report.area);
    double cavity = 0, expected = 0;
    for (const Fragment& f : set.fragments)
      for (const FragmentPrimitive& p : f.primitives)
        for (std::uint32_t k = p.first_index;
             p.material == kCavityMaterial && k < p.first_index + p.index_count; k += 3)
          cavity += area_of_triangle(f.positions[f.indices[k]], f.positions[f.indices[k + 1]],
                                     f.positions[f.indices[k + 2]]);
    for (std::size_t t = 0; t < wall.triangles.size(); ++t)
      if (wall.material[t] == kCavityMaterial)
        expected +=
            area_of_triangle(wall.positions[wall.triangles[t][0]], wall.positions[wall.triangles[t][1]],
                             wall.positions[wall.triangles[t][2]]);
    EXPECT_NEAR(cavity, expected, 1e-5 * expected);
  }
}

TEST(Hollow, AttributesOfTheInnerSideAreComplete) {
  const Solid wall = hollowed(solid_of(cube_with_seams()), {.thickness = 0.05}, {});
  wall.validate();
  const Mesh& source = *wall.source;
  const std::size_t before = cube_with_seams().positions.size();
  ASSERT_GT(source.positions.size(), before);
  EXPECT_EQ(source.attributes.normals.size(), source.positions.size());
  for (const auto& set : source.attributes.uvs) EXPECT_EQ(set.size(), source.positions.size());
  for (std::size_t w = before; w < source.positions.size(); ++w) {
    const Vec3d n = to_double(source.attributes.normals[w]);
    EXPECT_NEAR(length(n), 1, 1e-6);
    EXPECT_LT(dot(n, to_double(source.positions[w]) - wall.box.center()), 0) << "into the hollow";
  }
}

TEST(Hollow, EachPartForItself) {
  const Solid field = hollowed(solid_of(cube_field(3)), {.fraction = 0.1}, {});
  field.validate();
  EXPECT_EQ(field.report.parts_hollowed, 27u);
  for (const Part& part : field.parts) {
    EXPECT_EQ(part.shells.size(), 2u);
    EXPECT_LT(part.volume, 0.125 * 0.6);
  }
  // The depth of large triangles is proved by their sides. Their middles alone, after 12 halvings, would not
  // suffice, and all triangles would stay.
  EXPECT_LT(field.report.hollow_triangles, 27u * 100);
}

TEST(Hollow, WhatHasACavityOrIsThinStaysAsItIs) {
  const Solid nested = hollowed(solid_of(nested_spheres(2, 500)), {.thickness = 0.05}, {});
  EXPECT_EQ(nested.report.parts_hollowed, 0u);
  const Solid plate = hollowed(solid_of(thin_plate(0.01)), {.thickness = 0.01}, {});
  EXPECT_EQ(plate.report.parts_hollowed, 0u);
  EXPECT_EQ(hollowed(solid_of(cube(2)), {}, {}).report.parts_hollowed, 0u) << "nobody asked";
}

TEST(Hollow, OnlyWhatHoldsTheBallWhereOneIsAskedFor) {
  Mesh ring = torus(48, 12, 1, 0.15);  // thin, in a box as wide as that of a ball
  for (Vec3f& p : ring.positions) p = {p.x, p.y + p.x, p.z + p.x};
  const Mesh things = joined({cube(4), box({5, 0, 0}, {6, 6, 1}, 2), translated(ring, {9, 0, 0})});
  const Solid walls = hollowed(solid_of(things), {.fraction = 0.01, .least_ball = 0.2}, {});
  walls.validate();
  EXPECT_EQ(walls.report.parts_hollowed, 1u) << "beam and ring hold none";
  EXPECT_NE(walls.report.remarks.notes.back().find("shell=0"), std::string::npos);
  EXPECT_EQ(hollowed(solid_of(things), {.fraction = 0.01}, {}).report.parts_hollowed, 3u);
}

TEST(Hollow, WallsThatDoNotFitAreNamedWithTheParameterAndItsLargestValue) {
  const auto warnings = [](const Mesh& mesh, const HollowOptions& options) {
    return hollowed(solid_of(mesh), options, {}).report.remarks.warnings;
  };
  const auto thick = warnings(cube(), {.thickness = 0.6});
  ASSERT_EQ(thick.size(), 1u);
  EXPECT_NE(thick[0].find("'shell'"), std::string::npos) << thick[0];
  EXPECT_TRUE(thick[0].starts_with("The closed part stays solid")) << thick[0];
  EXPECT_NE(thick[0].find("below 0.5 m"), std::string::npos) << thick[0];
  const auto fraction = warnings(cube(), {.fraction = 0.5});
  ASSERT_EQ(fraction.size(), 1u);
  EXPECT_NE(fraction[0].find("'shell_fraction'"), std::string::npos) << fraction[0];
  const auto nested = warnings(nested_spheres(2, 500), {.thickness = 0.05});
  ASSERT_EQ(nested.size(), 1u);
  EXPECT_NE(nested[0].find("a cavity already"), std::string::npos) << nested[0];
  // If other parts become hollow, it is only a note; a material's walls are not mentioned.
  const Mesh some = joined({cube(), translated(thin_plate(0.01), {3, 0, 0})});
  const Solid both = hollowed(solid_of(some), {.thickness = 0.1}, {});
  EXPECT_TRUE(both.report.remarks.warnings.empty());
  EXPECT_EQ(both.report.remarks.notes.size(), 1u);
  EXPECT_TRUE(warnings(thin_plate(0.01), {.fraction = 0.1, .least_ball = 0.2}).empty());
}

TEST(Hollow, TheSourceKeepsEverythingThatIsNotGeometry) {
  Mesh mesh = cube(2);
  mesh.node_extras = {"\"hp\":120"};
  mesh.empty_nodes = {{.name = "socket"}};
  mesh.dropped = {{"light", "Lamp", "why"}};
  const Solid solid = hollowed(solid_of(mesh), {.thickness = 0.1}, {});
  ASSERT_EQ(solid.report.parts_hollowed, 1u);
  EXPECT_EQ(solid.source->node_extras, mesh.node_extras);
  EXPECT_EQ(solid.source->empty_nodes, mesh.empty_nodes);
  EXPECT_EQ(solid.source->dropped, mesh.dropped);
}

TEST(Hollow, TheCopyOfTheSourceIsCounted) {
  const Solid solid = solid_of(ico_sphere(5));
  const std::size_t bytes = solid.source->positions.size() * sizeof(Vec3f);
  Allowance enough(0, 1u << 30, [](std::uint64_t) { return Allowance::Answer::kGranted; });
  hollowed(solid, {.fraction = 0.05}, {.allowance = &enough});
  EXPECT_GT(enough.made(Product::kMeshBytes), bytes);
  Allowance little(0, 1u << 20, [](std::uint64_t asked) {
    return asked < (1u << 18) ? Allowance::Answer::kGranted : Allowance::Answer::kNever;
  });
  EXPECT_THROW(hollowed(solid, {.fraction = 0.05}, {.allowance = &little}), Interrupted);
}

TEST(Hollow, ManyPartsShareTheTriangles) {
  const Solid field = hollowed(solid_of(cube_field(3)), {.fraction = 0.1, .max_all = 20'000}, {});
  field.validate();
  EXPECT_LE(field.report.hollow_triangles, 20'000u);
  EXPECT_GT(field.report.parts_hollowed, 20u);
  const Solid few = hollowed(solid_of(cube_field(3)), {.fraction = 0.1, .max_all = 5'000}, {});
  few.validate();
  EXPECT_LT(few.report.parts_hollowed, 27u);
  ASSERT_EQ(few.report.remarks.warnings.size(), 1u) << "nobody but the caller asked for walls";
  EXPECT_NE(few.report.remarks.warnings[0].find("of 27 closed parts stayed solid"), std::string::npos);
  EXPECT_NE(few.report.remarks.warnings[0].find("5,000 triangles"), std::string::npos);
}

TEST(Hollow, FewerTrianglesForEachPartAreLessWork) {
  const Solid balls = solid_of(joined({ico_sphere(3), translated(ico_sphere(3), {3, 0, 0})}));
  const auto polls = [&](std::uint32_t most) {
    std::uint64_t count = 0;
    EXPECT_EQ(hollowed(balls, {.fraction = 0.02, .max_all = most}, {.watch = [&] { ++count; }})
                  .report.parts_hollowed,
              2u);
    return count;
  };
  EXPECT_LT(2 * polls(2 * 1'000), polls(2 * 20'000));
}

TEST(Hollow, PartsThatShareTrianglesAreTheSameForAnyNumberOfThreads) {
  // The first cubes use fewer triangles than planned, so the balls after them become finer than planned.
  std::vector<Mesh> things;
  for (int k = 0; k < 14; ++k)
    things.push_back(translated(k < 6 ? cube(2) : ico_sphere(2, 0.5), {2.0 * k, 0, 0}));
  const Solid solid = solid_of(joined(things));
  const HollowOptions options{.fraction = 0.03, .max_all = 14 * 500};
  const Solid one = hollowed(solid, options, {}), three = hollowed(solid, options, {.threads = 3});
  EXPECT_EQ(one.report.parts_hollowed, 14u);
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.triangles, three.triangles);
  EXPECT_EQ(one.shell, three.shell);
  EXPECT_EQ(one.report.mean_thickness, three.report.mean_thickness);
  EXPECT_EQ(one.report.least_thickness, three.report.least_thickness);
  EXPECT_EQ(one.report.volume, three.report.volume);
}

TEST(Hollow, UnequalPartsAddUp) {
  const Solid parts =
      hollowed(solid_of(joined({box({0, 0, 0}, {1, 0.7, 0.9}, 3), box({3, 0, 0}, {3.3, 0.31, 0.37}, 2),
                                box({5, 1, 0}, {7.1, 3.3, 1.9}, 3)})),
               {.fraction = 0.08}, {});
  parts.validate();
  EXPECT_EQ(parts.report.parts_hollowed, 3u);
}

TEST(Hollow, AWallOfWhichAFragmentIsFracturedAgainStaysSound) {
  const Solid wall = hollowed(solid_of(ico_sphere(3)), {.fraction = 0.06}, {});
  FractureParameters p;
  p.sites = 10;
  StageTimings timings;
  const Diagram diagram = make_diagram(wall, p, {}, timings).value();
  const FragmentSet whole = fracture(wall, diagram, p, {}, timings).value().set;
  const auto pieces =
      refracture(wall, diagram, p, {.fragment = whole.fragments[3].id, .sites = 6}, {}, timings);
  ASSERT_TRUE(pieces) << pieces.error().detail;
  expect_closed(pieces->set);
  double volume = 0;
  for (const Fragment& f : pieces->set.fragments) volume += f.mass.volume;
  // The fragment is fractured in the form of the file, rounded to floats.
  EXPECT_NEAR(volume, whole.fragments[3].mass.volume, 1e-7);
}

}  // namespace
}  // namespace fracture::test
