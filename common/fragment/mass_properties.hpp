// Volume, centre of mass and inertia of a closed triangle surface at density 1: exact polynomial integrals
// over the signed tetrahedra that the triangles span with an origin (Tonon 2004, "Explicit exact formulas for
// the 3-D tetrahedron inertia tensor in terms of its vertex coordinates"; here through second moments).
#pragma once

#include <array>
#include <cmath>

#include "common/fragment/fragments.hpp"

namespace fracture {

class MassIntegral {
 public:
  /// `origin` should lie near the surface: it cancels algebraically, but rounding errors grow with its
  /// distance.
  explicit MassIntegral(const Vec3d& origin) : origin_(origin) {}

  /// Adds a triangle, counter-clockwise from outside.
  void add(const Vec3d& p, const Vec3d& q, const Vec3d& r) {
    add_terms(terms<double>(p - origin_, q - origin_, r - origin_), [](double x) { return x; });
  }

  /// Adds two triangles: bit for bit the same as add() for each in turn, in little more time than one.
  void add_both(const std::array<const Vec3d*, 3>& s, const std::array<const Vec3d*, 3>& t) {
    const Terms<Two> both = terms<Two>(abreast(*s[0], *t[0]), abreast(*s[1], *t[1]), abreast(*s[2], *t[2]));
    add_terms(both, [](const Two& x) { return x[0]; });
    add_terms(both, [](const Two& x) { return x[1]; });
  }

  double area() const { return 0.5 * twice_area_; }
  double volume() const { return six_volume_ / 6; }

  /// Returns the properties about the centre of mass. For a surface without volume, the centre is the given
  /// origin and the inertia is zero.
  MassProperties result() const {
    MassProperties m;
    m.volume = six_volume_ / 6;
    m.area = area();
    m.center_of_mass = origin_;
    if (!(m.volume > 0)) return m;
    const Vec3d c = (1.0 / (4 * six_volume_)) * moment_;
    m.center_of_mass = origin_ + c;
    // Second moments about the centre of mass: integral of x_i x_j, minus V c_i c_j.
    const double v = m.volume;
    const double xx = xx_ / 120 - v * c.x * c.x, yy = yy_ / 120 - v * c.y * c.y,
                 zz = zz_ / 120 - v * c.z * c.z;
    m.inertia = {yy + zz,
                 xx + zz,
                 xx + yy,
                 -(xy_ / 120 - v * c.x * c.y),
                 -(xz_ / 120 - v * c.x * c.z),
                 -(yz_ / 120 - v * c.y * c.z)};
    return m;
  }

 private:
  /// Two numbers in one register. g++ and clang compute with both at once and round each as if it were
  /// alone.
  using Two = double __attribute__((vector_size(2 * sizeof(double))));
  struct TwoPoints {
    Two x, y, z;
    friend TwoPoints operator-(const TwoPoints& a, const TwoPoints& b) {
      return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend TwoPoints operator+(const TwoPoints& a, const TwoPoints& b) {
      return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
  };
  TwoPoints abreast(const Vec3d& p, const Vec3d& q) const {
    return {Two{p.x, q.x} - origin_.x, Two{p.y, q.y} - origin_.y, Two{p.z, q.z} - origin_.z};
  }

  /// Contributions of a triangle (or of each of two) to all sums.
  template <class Real>
  struct Terms {
    Real six_volume, moment_x, moment_y, moment_z, xx, yy, zz, xy, xz, yz, squared_twice_area;
  };
  template <class Real, class Point>
  static Terms<Real> terms(const Point& a, const Point& b, const Point& c) {
    const Point s = a + b + c, ab = b - a, ac = c - a;
    const Real nx = ab.y * ac.z - ab.z * ac.y, ny = ab.z * ac.x - ab.x * ac.z, nz = ab.x * ac.y - ab.y * ac.x;
    const Real det = a.x * nx + a.y * ny + a.z * nz;  // = a . (b x c)
    return {det,
            det * s.x,
            det * s.y,
            det * s.z,
            det * (a.x * a.x + b.x * b.x + c.x * c.x + s.x * s.x),
            det * (a.y * a.y + b.y * b.y + c.y * c.y + s.y * s.y),
            det * (a.z * a.z + b.z * b.z + c.z * c.z + s.z * s.z),
            det * (a.x * a.y + b.x * b.y + c.x * c.y + s.x * s.y),
            det * (a.x * a.z + b.x * b.z + c.x * c.z + s.x * s.z),
            det * (a.y * a.z + b.y * b.z + c.y * c.z + s.y * s.z),
            nx * nx + ny * ny + nz * nz};
  }
  template <class Real, class Pick>
  void add_terms(const Terms<Real>& t, const Pick& pick) {
    six_volume_ += pick(t.six_volume);
    moment_.x += pick(t.moment_x);
    moment_.y += pick(t.moment_y);
    moment_.z += pick(t.moment_z);
    xx_ += pick(t.xx);
    yy_ += pick(t.yy);
    zz_ += pick(t.zz);
    xy_ += pick(t.xy);
    xz_ += pick(t.xz);
    yz_ += pick(t.yz);
    twice_area_ += std::sqrt(pick(t.squared_twice_area));
  }

  Vec3d origin_;
  double six_volume_ = 0, twice_area_ = 0;
  Vec3d moment_;
  double xx_ = 0, yy_ = 0, zz_ = 0, xy_ = 0, xz_ = 0, yz_ = 0;
};

}  // namespace fracture
