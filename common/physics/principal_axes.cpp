#include "common/physics/principal_axes.hpp"

#include <algorithm>
#include <cmath>

#include "common/fragment/file_volume.hpp"

namespace fracture {
namespace {

/// Unit quaternion of a proper rotation matrix (columns = axes); Shepperd 1978: divides by the largest
/// component.
std::array<double, 4> to_quaternion(const double r[3][3]) {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  std::array<double, 4> q;
  if (trace >= r[0][0] && trace >= r[1][1] && trace >= r[2][2]) {
    const double s = 2 * std::sqrt(1 + trace);
    q = {(r[2][1] - r[1][2]) / s, (r[0][2] - r[2][0]) / s, (r[1][0] - r[0][1]) / s, s / 4};
  } else if (r[0][0] >= r[1][1] && r[0][0] >= r[2][2]) {
    const double s = 2 * std::sqrt(1 + r[0][0] - r[1][1] - r[2][2]);
    q = {s / 4, (r[0][1] + r[1][0]) / s, (r[0][2] + r[2][0]) / s, (r[2][1] - r[1][2]) / s};
  } else if (r[1][1] >= r[2][2]) {
    const double s = 2 * std::sqrt(1 + r[1][1] - r[0][0] - r[2][2]);
    q = {(r[0][1] + r[1][0]) / s, s / 4, (r[1][2] + r[2][1]) / s, (r[0][2] - r[2][0]) / s};
  } else {
    const double s = 2 * std::sqrt(1 + r[2][2] - r[0][0] - r[1][1]);
    q = {(r[0][2] + r[2][0]) / s, (r[1][2] + r[2][1]) / s, s / 4, (r[1][0] - r[0][1]) / s};
  }
  const double l = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& c : q) c /= q[3] < 0 ? -l : l;  // the representative with w >= 0
  return q;
}

/// Inertia of a solid box with this mass, about the origin.
std::array<double, 6> inertia_of_box(const Box& box, double mass) {
  const Vec3d size = box.size(), c = box.center();
  const Vec3d second{size.x * size.x / 12 + c.x * c.x, size.y * size.y / 12 + c.y * c.y,
                     size.z * size.z / 12 + c.z * c.z};
  return {mass * (second.y + second.z),
          mass * (second.x + second.z),
          mass * (second.x + second.y),
          -mass * c.x * c.y,
          -mass * c.x * c.z,
          -mass * c.y * c.z};
}

}  // namespace

PrincipalAxes body_inertia(const Fragment& f) {
  const PrincipalAxes axes = principal_axes(f.mass.inertia);
  const auto [a, b, c] = axes.moments;
  // Each moment is less than the sum of the others, unless the body is infinitely thin. A body so thin that half of
  // its tensor may be rounding is treated as impossible.
  const double least = 1e-9 * (a + b + c);
  if (f.mass.volume > 0 && a + b - c > least && b + c - a > least && c + a - b > least) return axes;
  Box box;
  for (const Vec3f& p : f.positions) box.add(to_double(p) + f.pivot - f.mass.center_of_mass);
  return principal_axes(inertia_of_box(box, body_volume(f)));
}

double body_volume(const Fragment& f) {
  if (!(f.mass.volume <= 0)) return f.mass.volume;  // NaN, too, so that bugs are not hidden
  if (const FileVolume in_file = file_volume(f); in_file.sign > 0) return in_file.volume;
  Box box;
  for (const Vec3f& p : f.positions) box.add(to_double(p));
  return 0.5e-6 * f.mass.area * box.longest_side();
}

PrincipalAxes principal_axes(const std::array<double, 6>& inertia) {
  double a[3][3] = {{inertia[0], inertia[3], inertia[4]},
                    {inertia[3], inertia[1], inertia[5]},
                    {inertia[4], inertia[5], inertia[2]}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  // Converges quadratically; six sweeps suffice for any 3 x 3 matrix, and twelve leave a margin.
  for (int sweep = 0; sweep < 12; ++sweep) {
    bool diagonal = true;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (std::fabs(a[p][q]) <= 0x1.0p-60 * (std::fabs(a[p][p]) + std::fabs(a[q][q]))) continue;
        diagonal = false;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta >= 0 ? 1 : -1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
        }
        for (int k = 0; k < 3; ++k) {
          const double kp = v[k][p], kq = v[k][q];
          v[k][p] = c * kp - s * kq;
          v[k][q] = s * kp + c * kq;
        }
      }
    if (diagonal) break;
  }
  // Products of rotations: det v = +1 up to rounding.
  PrincipalAxes out;
  for (int k = 0; k < 3; ++k) out.moments[static_cast<std::size_t>(k)] = std::max(0.0, a[k][k]);
  out.rotation = to_quaternion(v);
  return out;
}

}  // namespace fracture
