// Rough cuts keep the promises of flat cuts: closed fragments that add up, mirrored seams, an untouched
// outside.
#include "common/rough/roughen.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "common/pipeline/fracture.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

Fractured fracture_roughly(const Mesh& mesh, const FractureParameters& p, int threads = 1) {
  return fracture_mesh(mesh, p, threads);
}

FractureParameters rough(std::uint32_t sites, double amplitude, double frequency, std::uint32_t octaves) {
  FractureParameters p;
  p.sites = sites;
  p.roughness = {amplitude, frequency, octaves};
  return p;
}

using Corner = std::array<double, 3>;

Corner world(const Fragment& f, std::uint32_t vertex) {
  const Vec3d p = to_double(f.positions[vertex]) + f.pivot;
  return {p.x, p.y, p.z};
}

/// The triangles of primitives with the interior material (or without it), in world space. Each begins at its
/// smallest corner.
std::multiset<std::array<Corner, 3>> triangles_of(const Fragment& f, bool interior, bool mirrored) {
  std::multiset<std::array<Corner, 3>> out;
  for (const FragmentPrimitive& p : f.primitives) {
    if ((p.material == kInteriorMaterial) != interior) continue;
    for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
      std::array<Corner, 3> t{world(f, f.indices[k]), world(f, f.indices[k + 1]), world(f, f.indices[k + 2])};
      if (mirrored) std::swap(t[1], t[2]);
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      out.insert(t);
    }
  }
  return out;
}

TEST(Roughen, TheOutsideIsThatOfFlatCuts) {
  FractureParameters p = rough(30, 0.03, 4, 3);
  p.pivot = Pivot::kSource;
  const FragmentSet uneven = fracture_roughly(torus(48, 24), p).set;
  p.roughness.amplitude = 0;
  const FragmentSet flat = fracture_roughly(torus(48, 24), p).set;
  ASSERT_EQ(uneven.fragments.size(), flat.fragments.size());
  for (std::size_t k = 0; k < flat.fragments.size(); ++k) {
    EXPECT_EQ(uneven.fragments[k].id, flat.fragments[k].id);
    EXPECT_EQ(triangles_of(uneven.fragments[k], false, false), triangles_of(flat.fragments[k], false, false));
    EXPECT_NE(uneven.fragments[k].mass.volume, flat.fragments[k].mass.volume) << "its cuts moved";
  }
}

TEST(Roughen, VerticesMoveByTheAmplitudeAtMostAndByMuchOfIt) {
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.2, 0, 0}, {0.2, 0, 0}}};
  p.roughness = {0.02, 8, 1};
  const FragmentSet set = fracture_roughly(cube(), p).set;
  ASSERT_EQ(set.fragments.size(), 2u);
  double most = 0;
  for (const auto& t : triangles_of(set.fragments[0], true, false))
    for (const Corner& c : t) most = std::fmax(most, std::fabs(c[0]));
  EXPECT_LE(most, 0.02);
  EXPECT_GT(most, 0.01);
}

// Walls of a fiftieth of the box. They have room for edges of a fortieth of the size, but not for edges of a
// quarter.
TEST(Roughen, AcrossAWallThatIsThinnerThanItsEdgesACutStaysFlat) {
  const Mesh walls = joined({cube(), reversed(scaled(cube(), {0.96, 0.96, 0.96}))});
  FractureParameters p = rough(20, 0.01, 5, 1);
  p.pivot = Pivot::kSource;
  const auto area_of_cuts = [&](double amplitude, double frequency) {
    p.roughness.amplitude = amplitude;
    p.roughness.frequency = frequency;
    double area = 0;
    for (const Fragment& f : fracture_roughly(walls, p).set.fragments) area += f.mass.area - f.exterior_area;
    return area;
  };
  const double flat = area_of_cuts(0, 5);
  EXPECT_NEAR(area_of_cuts(0.003, 2), flat, 1e-7 * flat);
  EXPECT_GT(area_of_cuts(0.003, 20), 1.0001 * flat);
}

TEST(Roughen, AmplitudeAndFrequencyAreInTermsOfTheSize) {
  FractureParameters p = rough(12, 0.03, 4, 2);
  const Fractured small = fracture_roughly(cube(), p);
  EXPECT_NEAR(small.report.rough_cuts.value().amplitude, 0.03, 1e-12);
  const Fractured large = fracture_roughly(scaled(cube(), {8, 8, 8}), p);
  EXPECT_NEAR(large.report.rough_cuts.value().amplitude, 0.24, 1e-12);
  EXPECT_EQ(large.report.rough_cuts->triangles, small.report.rough_cuts->triangles);
}

TEST(Roughen, AnAmplitudeThatWouldLetCutsCrossIsLowered) {
  const Fractured made = fracture_roughly(cube(), rough(10, 0.25, 8, 2));
  const RoughCuts cuts = made.report.rough_cuts.value();
  EXPECT_LT(cuts.amplitude, cuts.amplitude_asked);
  EXPECT_EQ(cuts.crossing_triangles, 0u);
  EXPECT_EQ(made.set.certificate.open_edges, 0u);
  EXPECT_TRUE(has_note(made.report, "The amplitude of the rough cuts is"));
  EXPECT_FALSE(warns(made.report, "amplitude"));
}

TEST(Roughen, BondsAreMeasuredAcrossTheirCuts) {
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.2, 0, 0}, {0.2, 0, 0}}};
  p.roughness = {0.03, 5, 2};
  const FragmentSet set = fracture_roughly(cube(), p).set;
  ASSERT_EQ(set.bonds.size(), 1u);
  EXPECT_NEAR(set.bonds[0].area, 1, 1e-9) << "of the unit square that was cut, whatever its relief";
  EXPECT_GT(set.fragments[0].mass.area - set.fragments[0].exterior_area, 1.005) << "the relief has more";
}

TEST(Roughen, HullsAreThoseOfFlatCuts) {
  FractureParameters p = rough(15, 0.03, 5, 2);
  p.hulls = Hulls::kConvex;
  p.pivot = Pivot::kSource;
  const Fractured uneven = fracture_roughly(cube(), p);
  p.roughness.amplitude = 0;
  const Fractured flat = fracture_roughly(cube(), p);
  ASSERT_EQ(uneven.set.fragments.size(), flat.set.fragments.size());
  for (std::size_t k = 0; k < flat.set.fragments.size(); ++k) {
    ASSERT_EQ(uneven.hulls.of(k).size(), 1u);
    Box a, b;
    for (const Vec3f& q : uneven.hulls.of(k)[0].points) a.add(to_double(q));
    for (const Vec3f& q : flat.hulls.of(k)[0].points) b.add(to_double(q));
    EXPECT_LT(length(a.min - b.min) + length(a.max - b.max), 1e-5);
  }
}

TEST(Roughen, CutsWithinAGroupStayAwayAndItsSeamsAreSmooth) {
  // Two rows of cells on each side of x = 0. The wall between the groups is one cut of several facets.
  PointsPattern pattern;
  for (const double x : {-0.2, 0.2})
    for (const double y : {-0.3, 0.0, 0.3}) {
      pattern.points.push_back({x, y, 0});
      pattern.groups.push_back(x < 0 ? 0 : 1);
    }
  FractureParameters p;
  p.pattern = pattern;
  p.roughness = {0.03, 4, 2};
  const FragmentSet set = fracture_roughly(cube_with_seams(), p).set;
  ASSERT_EQ(set.fragments.size(), 2u);
  ASSERT_EQ(set.bonds.size(), 1u);
  EXPECT_NEAR(set.bonds[0].area, 1, 1e-9);
  EXPECT_EQ(set.fragments[0].bodies.size(), 3u);
  std::map<Corner, std::set<std::array<float, 3>>> at;
  for (const FragmentPrimitive& primitive : set.fragments[0].primitives)
    if (primitive.material == kInteriorMaterial)
      for (std::uint32_t k = primitive.first_index; k < primitive.first_index + primitive.index_count; ++k) {
        const std::uint32_t* t = set.fragments[0].indices.data() + k / 3 * 3;
        const auto local = [&](int c) { return to_double(set.fragments[0].positions[t[c]]); };
        if (length(cross(local(1) - local(0), local(2) - local(0))) < 1e-7)
          continue;  // from a facet no wider than the position lattice: four sites on a circle
        const Vec3f& n = set.fragments[0].attributes.normals[set.fragments[0].indices[k]];
        at[world(set.fragments[0], set.fragments[0].indices[k])].insert({n.x, n.y, n.z});
      }
  EXPECT_GT(at.size(), 100u);
  for (const auto& [place, normals] : at) EXPECT_EQ(normals.size(), 1u);
}

TEST(Roughen, NormalsAreSmoothWithinACutAndPointOutwards) {
  Mesh mesh = cube_with_seams();
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.2, 0, 0}, {0.2, 0, 0}}};
  p.roughness = {0.03, 4, 2};
  const FragmentSet set = fracture_roughly(mesh, p).set;
  for (const Fragment& f : set.fragments) {
    const double outward = f.pivot.x < 0 ? 1 : -1;
    std::set<std::array<float, 3>> different;
    std::map<Corner, std::set<std::array<float, 3>>> at;
    for (const FragmentPrimitive& primitive : f.primitives) {
      if (primitive.material != kInteriorMaterial) continue;
      for (std::uint32_t k = primitive.first_index; k < primitive.first_index + primitive.index_count; ++k) {
        const Vec3f& n = f.attributes.normals[f.indices[k]];
        EXPECT_NEAR(length(to_double(n)), 1, 1e-6);
        EXPECT_GT(outward * n.x, 0);
        different.insert({n.x, n.y, n.z});
        at[world(f, f.indices[k])].insert({n.x, n.y, n.z});
      }
    }
    EXPECT_GT(different.size(), 50u);
    for (const auto& [place, normals] : at) EXPECT_EQ(normals.size(), 1u);
  }
}

// If a cut is steep, the mean of the triangles around a corner may point behind one of them.
TEST(Roughen, NoCornerIsLitFromBehindItsTriangle) {
  std::size_t corners = 0;
  for (const std::uint64_t seed : {1, 2}) {
    FractureParameters p = rough(40, 0.05, 10, 3);
    p.seed = seed;
    for (const Mesh& mesh : {cube_with_seams(), sphere_with_seams(12, 24)}) {
      const FragmentSet set = fracture_roughly(mesh, p).set;
      for (const Fragment& f : set.fragments)
        for (const IndexRange& caps : f.caps)
          for (std::uint32_t k = caps.first; k < caps.first + caps.count; k += 3) {
            const std::uint32_t* const t = f.indices.data() + k;
            const Vec3d a = to_double(f.positions[t[0]]);
            const Vec3d n = cross(to_double(f.positions[t[1]]) - a, to_double(f.positions[t[2]]) - a);
            if (!(length(n) > 0)) continue;
            for (int c = 0; c < 3; ++c, ++corners)
              EXPECT_GT(dot(to_double(f.attributes.normals[t[c]]), n), 0) << f.id << " " << k / 3;
          }
    }
  }
  EXPECT_GT(corners, 10000u);
}

TEST(Roughen, TheSameBytesForAnyNumberOfThreads) {
  const FractureParameters p = rough(40, 0.03, 5, 3);
  const FragmentSet one = fracture_roughly(sphere_with(2000), p, 1).set,
                    three = fracture_roughly(sphere_with(2000), p, 3).set;
  ASSERT_EQ(one.fragments.size(), three.fragments.size());
  for (std::size_t k = 0; k < one.fragments.size(); ++k) {
    EXPECT_EQ(one.fragments[k].positions, three.fragments[k].positions);
    EXPECT_EQ(one.fragments[k].indices, three.fragments[k].indices);
    EXPECT_EQ(one.fragments[k].attributes.normals, three.fragments[k].attributes.normals);
  }
}

TEST(Roughen, CellsThatStayTogetherAreInNobodysWay) {
  FractureParameters p = rough(300, 0.02, 5, 1);
  const auto calmed = [&] { return fracture_roughly(cube(), p).report.rough_cuts.value().calmed_vertices; };
  p.sites = 6 * 300;
  const std::uint64_t apart = calmed();
  p.sites = 300;
  p.aggregation.cells = 6;
  EXPECT_LE(calmed(), apart + 5);
}

TEST(Roughen, LongThinPiecesEndWithFlatCutsAndAWarning) {
  FractureParameters p = rough(1, 0.05, 5, 2);
  PointsPattern fibres;
  for (int x = 0; x < 3; ++x)
    for (int z = 0; z < 3; ++z) fibres.points.push_back({0.01 * (x + 0.5) / 3, 2.0, 0.01 * (z + 0.5) / 3});
  p.pattern = fibres;
  const Fractured made = fracture_roughly(box({0, 0, 0}, {0.01, 4, 0.01}), p);
  const FragmentSet& set = made.set;
  EXPECT_EQ(set.certificate.open_edges, 0u);
  EXPECT_EQ(set.fragments.size(), 9u);
  EXPECT_LT(set.certificate.relative_error, 1e-12);
  EXPECT_LT(static_cast<double>(made.report.rough_cuts.value().triangles), 4 * kMostRoughTriangles);
}

}  // namespace
}  // namespace fracture::test
