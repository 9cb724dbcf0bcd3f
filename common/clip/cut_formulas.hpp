// Positions of cuts as formulas for construction.hpp, over any type of number, from the input only.
#pragma once

#include <array>

#include "common/clip/construction.hpp"

namespace fracture::clip_detail {

using exact::Point;

// The three constructions; exact/side.cpp has the derivations. Each takes its input points in the order
// listed.
struct EdgeCutFormula {  // mesh edge (a, b) x bisector(i, k): a + e (c_k - 2 u·(a - i)) / (2 u·e)
  static constexpr bool kFromFirst = true;
  static constexpr int kDegree = 1;
  static constexpr int kBetweenFrom = 0, kBetweenTo = 2;
  std::array<Vec3d, 4> input;  // a, b, i, k
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 4>& p) const {
    const Point<T> e = p[1] - p[0], u = p[3] - p[2];
    const T ua = dot(u, p[0] - p[2]), ue = dot(u, e);
    const T t = dot(u, u) - (ua + ua);
    return {{e.x * t, e.y * t, e.z * t}, ue + ue};
  }
};
struct TriangleCutFormula {  // mesh triangle (a, b, c) x Voronoi edge (i, k, l), from origin i
  static constexpr bool kFromFirst = true;
  static constexpr int kDegree = 1;
  static constexpr int kBetweenFrom = 3, kBetweenTo = 6;
  std::array<Vec3d, 6> input;  // i, k, l, a, b, c
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 6>& p) const {
    const Point<T> uk = p[1] - p[0], ul = p[2] - p[0], n = cross(p[4] - p[3], p[5] - p[3]);
    const Point<T> d = cross(uk, ul), f = cross(ul, n), g = cross(n, uk);
    const T na = dot(n, p[3] - p[0]), ck = dot(uk, uk), cl = dot(ul, ul), na2 = na + na, delta = dot(n, d);
    return {
        {na2 * d.x + ck * f.x + cl * g.x, na2 * d.y + ck * f.y + cl * g.y, na2 * d.z + ck * f.z + cl * g.z},
        delta + delta};
  }
};
struct CircumcenterFormula {  // Voronoi vertex (i, j, k, l), from origin i
  static constexpr bool kFromFirst = true;
  static constexpr int kDegree = 1;
  static constexpr int kBetweenFrom = 0, kBetweenTo = 0;
  std::array<Vec3d, 4> input;
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 4>& p) const {
    const Point<T> uj = p[1] - p[0], uk = p[2] - p[0], ul = p[3] - p[0];
    const Point<T> f = cross(uk, ul), g = cross(ul, uj), h = cross(uj, uk);
    const T cj = dot(uj, uj), ck = dot(uk, uk), cl = dot(ul, ul), delta = dot(uj, f);
    return {{cj * f.x + ck * g.x + cl * h.x, cj * f.y + ck * g.y + cl * h.y, cj * f.z + ck * g.z + cl * h.z},
            delta + delta};
  }
};

}  // namespace fracture::clip_detail
