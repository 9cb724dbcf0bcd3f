// Compares the rounding of constructed vertices to the seam lattice with rational arithmetic.
#include "common/clip/positions.hpp"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>

#include "common/clip/restricted_diagram.hpp"
#include "common/sites/sites.hpp"
#include "common/solid/image.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

using Q = boost::multiprecision::cpp_rational;
using QVec = std::array<Q, 3>;

QVec q(const Vec3d& p) { return {Q(p.x), Q(p.y), Q(p.z)}; }
QVec operator-(const QVec& a, const QVec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Q dot(const QVec& a, const QVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
QVec cross(const QVec& a, const QVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The nearest lattice coordinate. Ties go to even.
Q round_to_lattice(const Q& x, int exponent) {
  const Q step = exponent >= 0 ? Q(boost::multiprecision::cpp_int(1) << exponent)
                               : Q(1, boost::multiprecision::cpp_int(1) << -exponent);
  const Q y = x / step;
  boost::multiprecision::cpp_int floor = numerator(y) / denominator(y);
  if (y < 0 && Q(floor) != y) --floor;
  const Q rest = y - Q(floor);
  const bool up = rest > Q(1, 2) || (rest == Q(1, 2) && floor % 2 != 0);
  return up ? Q(floor + 1) : Q(floor);
}

struct Plane {
  QVec n;
  Q d;
};
Plane bisector(const Vec3d& i, const Vec3d& j) {
  return {q(j) - q(i), (dot(q(j), q(j)) - dot(q(i), q(i))) / 2};
}
QVec meet(const Plane& a, const Plane& b, const Plane& c) {
  const Q det = dot(a.n, cross(b.n, c.n));
  EXPECT_NE(det, 0);
  const QVec u = cross(b.n, c.n), v = cross(c.n, a.n), w = cross(a.n, b.n);
  QVec x;
  for (int k = 0; k < 3; ++k) x[k] = (a.d * u[k] + b.d * v[k] + c.d * w[k]) / det;
  return x;
}

void expect_rounded(const VertexPositions& p, std::size_t n, const QVec& exact) {
  for (int a = 0; a < 3; ++a) {
    EXPECT_EQ(Q(p.steps[n][a]), round_to_lattice(exact[a], p.lattice.exponent[a]))
        << "vertex " << n << " axis " << a;
    EXPECT_NEAR(p.points[n][a], static_cast<double>(exact[a]), std::ldexp(0.002, p.lattice.exponent[a]));
  }
}

TEST(SeamLattice, StepIsTheFloatSpacingOfTheLargestCoordinate) {
  Box box;
  box.add(Vec3d{-1, 0, 1000});
  box.add(Vec3d{1, 3, 1001});
  const SeamLattice l(box);
  EXPECT_EQ(l.exponent[0], 1 - 23) << "extent 2 decides";
  EXPECT_EQ(l.exponent[1], 2 - 23);
  EXPECT_EQ(l.exponent[2], 10 - 23) << "distance 1001 decides";
}

TEST(SeamLattice, EveryConstructedVertexIsTheExactPositionRoundedOnce) {
  // Aligned lattices make exact half-way cases and points on the lattice. Random sites make general cases.
  std::size_t input = 0;
  for (const NamedMesh& shape : {NamedMesh{"cube", cube(2)}, NamedMesh{"torus", torus(12, 8)}}) {
    ++input;
    std::size_t turn = 0;
    for (const SiteFamily& family : small_site_families(shape.mesh, 3)) {
      if (!has_turn(input, turn++, 2)) continue;
      SCOPED_TRACE(shape.name + " " + family.name);
      const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(shape.mesh), {}, {});
      ASSERT_TRUE(solid);
      const Expected<Tetrahedralization> t = tetrahedralize(family.sites, solid->box, {});
      ASSERT_TRUE(t);
      const VoronoiDiagram diagram(*t, solid->box);
      const RestrictedDiagram r = restrict_to_solid(SeenSolid(*solid), diagram, {});
      const auto vertex = [&](VertexId v) { return to_double(solid->positions[v]); };
      std::size_t n = 0;
      for (const EdgeCut& c : r.cuts.edge_cuts) {
        const auto [lo, hi] = solid->edge_vertices[c.edge];
        const QVec a = q(vertex(lo)), e = q(vertex(hi)) - a;
        const Plane p = bisector(diagram.site(c.from), diagram.site(c.to));
        const Q s = (p.d - dot(p.n, a)) / dot(p.n, e);
        expect_rounded(r.positions, n++, {a[0] + s * e[0], a[1] + s * e[1], a[2] + s * e[2]});
      }
      for (const TriangleCut& c : r.cuts.triangle_cuts) {
        const auto& v = solid->triangles[c.triangle];
        const QVec a = q(vertex(v[0])), normal = cross(q(vertex(v[1])) - a, q(vertex(v[2])) - a);
        expect_rounded(
            r.positions, n++,
            meet({normal, dot(normal, a)}, bisector(diagram.site(c.sites[0]), diagram.site(c.sites[1])),
                 bisector(diagram.site(c.sites[0]), diagram.site(c.sites[2]))));
      }
      for (const InnerVertex& d : r.winding.inner_vertices) {
        const auto& v = t->tets[d.tet].v;
        expect_rounded(r.positions, n++,
                       meet(bisector(diagram.site(v[0]), diagram.site(v[1])),
                            bisector(diagram.site(v[0]), diagram.site(v[2])),
                            bisector(diagram.site(v[0]), diagram.site(v[3]))));
      }
      EXPECT_EQ(n, r.positions.steps.size());
    }
  }
}

TEST(SeamLattice, CutsDecidedInAnImageAreCarriedBackExactly) {
  // A diagonal map makes half-way cases on aligned lattices. A skew map makes general cases.
  const Matrix3 halved{{Vec3d{0.5, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 2}}},
      skew{{Vec3d{0.3, 0.1, 0}, Vec3d{-0.2, 1.1, 0.4}, Vec3d{0, 0.5, 0.7}}};
  std::size_t input = 0;
  for (const NamedMesh& shape : {NamedMesh{"cube", cube(2)}, NamedMesh{"torus", torus(12, 8)}})
    for (const Matrix3& map : {halved, skew}) {
      ++input;
      std::size_t turn = 0;
      const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(shape.mesh), {}, {});
      ASSERT_TRUE(solid);
      const SeenSolid whole(*solid, map, {});
      const Solid& image = whole.seen();
      Mesh seen = shape.mesh;
      seen.positions = image.positions;
      for (const SiteFamily& family : small_site_families(seen, 3)) {
        if (!has_turn(input, turn++, 4)) continue;
        SCOPED_TRACE(shape.name + " " + family.name);
        const Expected<Tetrahedralization> t = tetrahedralize(family.sites, image.box, {});
        ASSERT_TRUE(t);
        const VoronoiDiagram diagram(*t, image.box, map);
        const RestrictedDiagram r = restrict_to_solid(whole, diagram, {});
        const auto at = [&](VertexId v) { return q(to_double(solid->positions[v])); };
        const auto image_at = [&](VertexId v) { return q(to_double(image.positions[v])); };
        const auto plane = [&](SiteId i, SiteId j) { return bisector(diagram.site(i), diagram.site(j)); };
        std::size_t n = 0;
        for (const EdgeCut& c : r.cuts.edge_cuts) {
          const auto [lo, hi] = solid->edge_vertices[c.edge];
          const QVec a = at(lo), e = at(hi) - a, b = image_at(lo), f = image_at(hi) - b;
          const Plane p = plane(c.from, c.to);
          const Q s = (p.d - dot(p.n, b)) / dot(p.n, f);
          expect_rounded(r.positions, n++, {a[0] + s * e[0], a[1] + s * e[1], a[2] + s * e[2]});
        }
        for (const TriangleCut& c : r.cuts.triangle_cuts) {
          const auto& v = solid->triangles[c.triangle];
          const QVec b = image_at(v[0]), e = image_at(v[1]) - b, f = image_at(v[2]) - b, normal = cross(e, f);
          const QVec x =
              meet({normal, dot(normal, b)}, plane(c.sites[0], c.sites[1]), plane(c.sites[0], c.sites[2])) -
              b;
          // x = s e + t f. The coefficients are quotients of areas measured along the normal.
          const Q s = dot(cross(x, f), normal) / dot(normal, normal),
                  u = dot(cross(e, x), normal) / dot(normal, normal);
          const QVec a = at(v[0]), g = at(v[1]) - a, h = at(v[2]) - a;
          expect_rounded(
              r.positions, n++,
              {a[0] + s * g[0] + u * h[0], a[1] + s * g[1] + u * h[1], a[2] + s * g[2] + u * h[2]});
        }
        for (const InnerVertex& d : r.winding.inner_vertices) {
          const auto& v = t->tets[d.tet].v;
          const QVec x = meet(plane(v[0], v[1]), plane(v[0], v[2]), plane(v[0], v[3]));
          expect_rounded(r.positions, n++,
                         meet({q(map.rows[0]), x[0]}, {q(map.rows[1]), x[1]}, {q(map.rows[2]), x[2]}));
        }
        EXPECT_EQ(n, r.positions.steps.size());
      }
    }
}

}  // namespace
}  // namespace fracture::test
