// Filters for exact::side1..side3, which test many bisectors against the corners of one triangle's polygons.
// They use homogeneous barycentric coordinates of the triangle (q_0, q_1, q_2):
//
//   bisector of the cell    its values at q_0, q_1, q_2: a linear form L, positive on the cell's side
//   edge q_k q_(k+1)        the form of the third corner's coordinate, e_(k+2)
//   corner of a polygon     where two such lines meet: N = +-(L x L'), the sign so that N_0 + N_1 + N_2 > 0
//
// With exact values, the sign of N·L is the side on which the corner is. Each number has an error bound. If
// it does not certify the sign, the caller uses the exact predicate.
//
// Bounds, with u = 2^-53: the error of the components of L is at most e (Bisector::error). The error of a
// component of L x L' is at most 2 (|L| e' + |L'| e + e e') from these, where |.| is the largest component,
// plus 3 roundings of terms that together are 2 |L| |L'|. The error of N·L'' is |N|_1 e'' + 3 E (|L''| +
// e''), where E is the bound of N, plus 5 roundings of terms that together are |N|_1 |L''|. Factors are
// rounded up generously; 1e-300 covers underflow (of products of three values, 3 at a time, each below
// 1e-307).
#pragma once

#include <array>
#include <cmath>

#include "common/base/vec.hpp"
#include "common/voronoi/neighborhood.hpp"

namespace fracture::clip_detail {

struct Line {
  std::array<double, 3> value;
  double error;    ///< error of each value
  double largest;  ///< largest magnitude of the values

  static Line of_values(const std::array<double, 3>& v, double error) {
    const double a = std::fabs(v[0]), b = std::fabs(v[1]), c = std::fabs(v[2]), ab = a > b ? a : b;
    return {v, error, ab > c ? ab : c};
  }
  /// The error of the value at a corner is at most its norm times `by_norm` plus its error times `by_error`.
  struct Bounds {
    double by_norm, by_error;
  };
  Bounds bounds() const { return {1.001 * (error + 0x1.0p-50 * largest), 1.001 * 3 * (largest + error)}; }
  /// The line of the edge from corner k to the next corner.
  static Line of_edge(unsigned k) {
    Line line{{0, 0, 0}, 0, 1};
    line.value[(k + 2) % 3] = 1;
    return line;
  }
};

struct Corner {
  std::array<double, 3> coordinates;
  double sum = 0;    ///< sum of the coordinates, > 0; 0: the corner is unknown
  double error = 0;  ///< error of each coordinate
  double norm = 0;   ///< sum of the magnitudes of the coordinates

  static Corner of_triangle(unsigned k) {
    Corner c{{0, 0, 0}, 1, 0, 1};
    c.coordinates[k] = 1;
    return c;
  }
  static Corner meet(const Line& l, const Line& m) {
    const auto &a = l.value, &b = m.value;
    Corner c{{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}, 0, 0, 0};
    const double la = l.largest, lb = m.largest;
    c.error = 1.001 * 2 * (la * m.error + lb * l.error + l.error * m.error) + 0x1.0p-50 * la * lb;
    const auto& n = c.coordinates;
    c.sum = n[0] + n[1] + n[2];
    c.norm = std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2]);
    if (c.sum < 0) {
      for (double& x : c.coordinates) x = -x;
      c.sum = -c.sum;
    }
    if (!(c.sum > 4 * c.error + 0x1.0p-50 * c.norm + 1e-300)) c.sum = 0;
    return c;
  }
  /// The line's value at the corner, times `sum`. The corner must be known.
  Certified value(const Line& line, const Line::Bounds& bounds) const {
    const auto &n = coordinates, &l = line.value;
    return {n[0] * l[0] + n[1] * l[1] + n[2] * l[2],
            norm * bounds.by_norm + error * bounds.by_error + 1e-300};
  }
  Certified value(const Line& line) const { return value(line, line.bounds()); }
  /// Whether the corner is certainly on the positive side of the line.
  bool is_inside(const Line& line, const Line::Bounds& bounds) const {
    const Certified v = value(line, bounds);
    return v.value > v.error && sum > 0;
  }
  /// The side of the line on which the corner is; 0 if that is uncertain.
  int side(const Line& line) const {
    if (sum == 0) return 0;
    const Certified v = value(line);
    return v.value > v.error ? 1 : v.value < -v.error ? -1 : 0;
  }
  /// The position of the corner, and its maximum error: infinite if the corner is unknown.
  struct Place {
    Vec3d at;
    double off;
  };
  Place place(const std::array<Vec3d, 3>& q) const {
    if (sum == 0) return {q[0], HUGE_VAL};
    // The error of the shares is (error + share * 3 error) / (sum - 3 error) plus a few roundings; sum > 4
    // error.
    const double s = coordinates[1] / sum, t = coordinates[2] / sum;
    const Vec3d e = q[1] - q[0], f = q[2] - q[0];
    const double share = (1 + norm / sum) * (16 * error / sum + 0x1.0p-49);
    const auto norm1 = [](const Vec3d& v) { return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z); };
    return {q[0] + (s * e + t * f), share * (norm1(e) + norm1(f)) + 0x1.0p-50 * norm1(q[0])};
  }
};

}  // namespace fracture::clip_detail
