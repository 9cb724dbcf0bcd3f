// On which side of a bisector does a point of the restricted Voronoi diagram lie? The points are never
// computed: they are named by what defines them, and each decision is the exact sign of a polynomial in input
// coordinates.
//
//   side1   a mesh vertex q
//   side2   mesh edge (a, b)  x  bisector(i, k)
//   side3   mesh triangle (a, b, c)  x  Voronoi edge (i, k, l)
//   side4   the Voronoi vertex (i, k, l, m)
//   order_on_edge   which of two mesh triangles meets the Voronoi edge (i, j, k) first
//
// Names and idea: Lévy 2016, "Robustness and efficiency of geometric programs: the Predicate Construction
// Kit".
//
// The numeric contract. Filter (a double with running error bound) -> exact integers -> the tie rule. The tie
// rule is that of in_sphere (in_sphere.hpp): site s carries an infinitesimal weight w_s > 0, the
// lexicographically smallest site the largest, each infinitely larger than the next, and "closer" compares |x
// - s|^2 - w_s. All polynomials below are linear in the weights, so an exact zero is decided by the first
// site, in lexicographic order, whose weight has a non-zero coefficient (Edelsbrunner & Shah 1996 for the
// weights; the coefficients stand in side.cpp). Coordinates are never perturbed. Hence no sideN ever returns
// zero, and together they describe one true power diagram.
//
// Sites must be distinct; |coordinates| <= 2e13, subnormal ones included (no polynomial here overflows, and
// the filter's bound covers underflow: approx.hpp). A constructed point must exist (its line or plane crosses
// transversally); the callers guarantee it by having classified the end points first.
#pragma once

#include "common/base/vec.hpp"

namespace fracture::exact {

/// +1 when q is closer to site i than to site j, -1 otherwise.
int side1(const Vec3d& i, const Vec3d& j, const Vec3d& q);

/// The point x = segment(a, b) ∩ bisector(i, k): +1 when x is closer to i than to j. j, k, i distinct.
int side2(const Vec3d& i, const Vec3d& j, const Vec3d& a, const Vec3d& b, const Vec3d& k);

/// The point x = plane(a, b, c) ∩ bisector(i, k) ∩ bisector(i, l): +1 when x is closer to i than to j.
int side3(const Vec3d& i, const Vec3d& j, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& k,
          const Vec3d& l);

/// The Voronoi vertex x of (i, k, l, m), not coplanar: +1 when x is closer to i than to j.
int side4(const Vec3d& i, const Vec3d& j, const Vec3d& k, const Vec3d& l, const Vec3d& m);

/// Sign of (normal of abc) · ((j - i) x (k - i)): +1 when the line directed by (j - i) x (k - i) passes the
/// plane of the counter-clockwise triangle abc outwards, -1 inwards, 0 when it runs parallel.
int crossing_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& i, const Vec3d& j,
                  const Vec3d& k);

struct Triangle {
  Vec3d a, b, c;
};

/// Along the Voronoi line of (i, j, k) directed by (j - i) x (k - i): -1 when it meets the plane of t1 before
/// that of t2, +1 after. 0 only when both planes are the same one; the caller then orders by triangle id.
int order_on_edge(const Vec3d& i, const Vec3d& j, const Vec3d& k, const Triangle& t1, const Triangle& t2);

}  // namespace fracture::exact
