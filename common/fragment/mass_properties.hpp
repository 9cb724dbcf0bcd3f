// Volume, centre of mass and inertia of a closed triangle surface at density 1: exact polynomial integrals
// over the signed tetrahedra that the triangles span with an origin (Tonon 2004, "Explicit exact formulas for
// the 3-D tetrahedron inertia tensor in terms of its vertex coordinates"; here through second moments).
#pragma once

#include <array>

#include "common/fragment/fragments.hpp"

namespace fracture {

class MassIntegral {
 public:
  /// `origin` should lie near the surface: it cancels only algebraically.
  explicit MassIntegral(const Vec3d& origin) : origin_(origin) {}

  /// A triangle, counter-clockwise from outside.
  void add(const Vec3d& p, const Vec3d& q, const Vec3d& r) {
    const Vec3d a = p - origin_, b = q - origin_, c = r - origin_, s = a + b + c;
    const Vec3d ab = b - a, ac = c - a, normal = cross(ab, ac);
    const double det = dot(a, normal);  // = a . (b x c)
    six_volume_ += det;
    moment_ = moment_ + det * s;
    xx_ += det * (a.x * a.x + b.x * b.x + c.x * c.x + s.x * s.x);
    yy_ += det * (a.y * a.y + b.y * b.y + c.y * c.y + s.y * s.y);
    zz_ += det * (a.z * a.z + b.z * b.z + c.z * c.z + s.z * s.z);
    xy_ += det * (a.x * a.y + b.x * b.y + c.x * c.y + s.x * s.y);
    xz_ += det * (a.x * a.z + b.x * b.z + c.x * c.z + s.x * s.z);
    yz_ += det * (a.y * a.z + b.y * b.z + c.y * c.z + s.y * s.z);
    twice_area_ += length(normal);
  }

  double area() const { return 0.5 * twice_area_; }
  double volume() const { return six_volume_ / 6; }

  /// About the centre of mass. A surface without volume has its centre at the origin given and no inertia.
  MassProperties result() const {
    MassProperties m;
    m.volume = six_volume_ / 6;
    m.area = area();
    m.center_of_mass = origin_;
    if (!(m.volume > 0)) return m;
    const Vec3d c = (1.0 / (4 * six_volume_)) * moment_;
    m.center_of_mass = origin_ + c;
    // Second moments about the centre of mass: integral of x_i x_j, less V c_i c_j.
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
  Vec3d origin_;
  double six_volume_ = 0, twice_area_ = 0;
  Vec3d moment_;
  double xx_ = 0, yy_ = 0, zz_ = 0, xy_ = 0, xz_ = 0, yz_ = 0;
};

}  // namespace fracture
