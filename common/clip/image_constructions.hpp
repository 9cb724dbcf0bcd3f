// Maps cuts that were computed in an image of the solid (solid/image.hpp) back to the solid. The parameter
// along the edge and the barycentric coordinates in the triangle are those in the image, and are applied to
// the original corners. Voronoi vertices are mapped back by the inverse map. Primes mark images. Private to
// clip/.
#pragma once

#include "common/clip/construction.hpp"

namespace fracture::clip_detail {

/// a + e t, with t = (c_k - 2 u·(a' - i)) / (2 u·e') from edge (a', b') x bisector(i, k).
struct ImageEdgeCutFormula {
  static constexpr bool kFromFirst = true;
  static constexpr int kDegree = 1;
  static constexpr int kBetweenFrom = 0, kBetweenTo = 2;
  std::array<Vec3d, 6> input;  // a, b, a', b', i, k
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 6>& p) const {
    const Point<T> e = p[1] - p[0], image = p[3] - p[2], u = p[5] - p[4];
    const T ua = dot(u, p[2] - p[4]), ue = dot(u, image);
    const T t = dot(u, u) - (ua + ua);
    return {{e.x * t, e.y * t, e.z * t}, ue + ue};
  }
};

/// a + s (b - a) + t (c - a), where the image a' + s e' + t f' is on the bisectors (i, k) and (i, l):
///   s (u_k·e') + t (u_k·f') = r_k,  s (u_l·e') + t (u_l·f') = r_l,  r = |u|²/2 - u·(a' - i).
struct ImageTriangleCutFormula {
  static constexpr bool kFromFirst = true;
  static constexpr int kDegree = 1;
  static constexpr int kBetweenFrom = 0, kBetweenTo = 3;
  std::array<Vec3d, 9> input;  // a, b, c, a', b', c', i, k, l
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 9>& p) const {
    const Point<T> e = p[1] - p[0], f = p[2] - p[0], image_e = p[4] - p[3], image_f = p[5] - p[3];
    const Point<T> uk = p[7] - p[6], ul = p[8] - p[6], w = p[3] - p[6];
    const T ke = dot(uk, image_e), kf = dot(uk, image_f), le = dot(ul, image_e), lf = dot(ul, image_f);
    const T kw = dot(uk, w), lw = dot(ul, w);
    const T rk = dot(uk, uk) - (kw + kw), rl = dot(ul, ul) - (lw + lw);  // twice r
    const T s = rk * lf - rl * kf, t = ke * rl - le * rk, delta = ke * lf - kf * le;
    return {{s * e.x + t * f.x, s * e.y + t * f.y, s * e.z + t * f.z}, delta + delta};
  }
};

/// A^-1 x' = adj(A) (i + N / 2d) / det A for the Voronoi vertex x' of (i, j, k, l). The matrix is scaled like
/// the points, so the scale cancels.
struct ImageCircumcenterFormula {
  static constexpr bool kFromFirst = false;
  static constexpr int kDegree = 0;
  static constexpr int kBetweenFrom = 0, kBetweenTo = 0;
  std::array<Vec3d, 7> input;  // i, j, k, l, the rows of A
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 7>& p) const {
    const Point<T> uj = p[1] - p[0], uk = p[2] - p[0], ul = p[3] - p[0];
    const Point<T> f = cross(uk, ul), g = cross(ul, uj), h = cross(uj, uk);
    const T cj = dot(uj, uj), ck = dot(uk, uk), cl = dot(ul, ul), delta = dot(uj, f), twice = delta + delta;
    const Point<T> x{twice * p[0].x + (cj * f.x + ck * g.x + cl * h.x),
                     twice * p[0].y + (cj * f.y + ck * g.y + cl * h.y),
                     twice * p[0].z + (cj * f.z + ck * g.z + cl * h.z)};
    // The columns of adj(A) are the cross products of A's rows.
    const Point<T> a = cross(p[5], p[6]), b = cross(p[6], p[4]), c = cross(p[4], p[5]);
    return {{a.x * x.x + b.x * x.y + c.x * x.z, a.y * x.x + b.y * x.y + c.y * x.z,
             a.z * x.x + b.z * x.y + c.z * x.z},
            twice * dot(p[4], a)};
  }
};

}  // namespace fracture::clip_detail
