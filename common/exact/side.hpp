// Decides on which side of a bisector a point of the restricted Voronoi diagram is. The points are never
// computed. They are given by the objects that define them, and each decision is the exact sign of a
// polynomial in input coordinates.
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
// The numeric contract: filter (a double with a running error bound) -> exact integers -> the tie rule. The
// tie rule is that of in_sphere (in_sphere.hpp). Each site s has an infinitesimal weight w_s > 0; the
// lexicographically smallest site has the largest weight, and each is infinitely larger than the next.
// "Closer" compares |x - s|^2 - w_s. All polynomials below are linear in the weights. So an exact zero is
// decided by the first site, in lexicographic order, whose weight has a nonzero coefficient (Edelsbrunner &
// Shah 1996 for the weights; side.cpp has the coefficients). Coordinates are never perturbed. Therefore no
// sideN ever returns zero, and together they describe one true power diagram.
//
// Sites must be distinct; |coordinates| <= 2e13, including subnormal ones (no polynomial here overflows, and
// the filter's bound covers underflow: approx.hpp). A constructed point must exist (its line or plane crosses
// transversally). Callers guarantee this by classifying the end points first.
#pragma once

#include "common/base/vec.hpp"

namespace fracture::exact {

/// Returns +1 if q is closer to site i than to site j, otherwise -1.
int side1(const Vec3d& i, const Vec3d& j, const Vec3d& q);

/// For the point x = segment(a, b) ∩ bisector(i, k): +1 if x is closer to i than to j, otherwise -1. i, j, k
/// must be distinct.
int side2(const Vec3d& i, const Vec3d& j, const Vec3d& a, const Vec3d& b, const Vec3d& k);

/// For the point x = plane(a, b, c) ∩ bisector(i, k) ∩ bisector(i, l): +1 if x is closer to i than to j,
/// otherwise -1.
int side3(const Vec3d& i, const Vec3d& j, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& k,
          const Vec3d& l);

/// For the Voronoi vertex x of (i, k, l, m), not coplanar: +1 if x is closer to i than to j, otherwise -1.
int side4(const Vec3d& i, const Vec3d& j, const Vec3d& k, const Vec3d& l, const Vec3d& m);

/// Sign of (normal of abc) · ((j - i) x (k - i)): +1 if the line with direction (j - i) x (k - i) crosses the
/// plane of the counter-clockwise triangle abc outwards, -1 if inwards, 0 if it is parallel.
int crossing_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& i, const Vec3d& j,
                  const Vec3d& k);

struct Triangle {
  Vec3d a, b, c;
};

/// For the Voronoi line of (i, j, k) with direction (j - i) x (k - i): -1 if it meets the plane of t1 before
/// that of t2, +1 if after. 0 only if both planes are the same; the caller then orders by triangle id.
int order_on_edge(const Vec3d& i, const Vec3d& j, const Vec3d& k, const Triangle& t1, const Triangle& t2);

}  // namespace fracture::exact
