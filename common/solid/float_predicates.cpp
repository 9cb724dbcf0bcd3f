#include "common/solid/float_predicates.hpp"

#include <cmath>

namespace fracture::solid_detail {

void ExactSum::add(double term) {
  // Grow-expansion (Shewchuk 1997, theorem 10) with elimination of zero components.
  double q = term;
  std::size_t kept = 0;
  for (const double e : parts_) {
    const double sum = q + e;
    const double virtual_e = sum - q;
    const double error = (q - (sum - virtual_e)) + (e - virtual_e);
    if (error != 0) parts_[kept++] = error;
    q = sum;
  }
  parts_.resize(kept);
  if (q != 0) parts_.push_back(q);
}

void ExactSum::add_product(double two, float third) {
  const double high = two * third;
  const double low = std::fma(two, static_cast<double>(third), -high);  // exact error of the product
  if (low != 0) add(low);
  if (high != 0) add(high);
}

double ExactSum::estimate() const {
  double sum = 0;
  for (const double e : parts_) sum += e;
  return sum;
}

int sign_orient2d(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
  const double ax = a.x, ay = a.y, bx = b.x, by = b.y, cx = c.x, cy = c.y;
  // The differences, the products and the final subtraction each have a relative error of at most 2^-53:
  // |error| <= 3.1 * 2^-53 * (|l|+|r|).
  const double left = (bx - ax) * (cy - ay), right = (by - ay) * (cx - ax);
  const double det = left - right, bound = 4e-16 * (std::fabs(left) + std::fabs(right));
  if (det > bound) return 1;
  if (det < -bound) return -1;
  ExactSum sum;
  for (const double term : {bx * cy, -(bx * ay), -(ax * cy), -(by * cx), by * ax, ay * cx}) sum.add(term);
  return sum.sign();
}

int sign_orient3d(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  const Vec3d u = to_double(b) - to_double(a), v = to_double(c) - to_double(a),
              w = to_double(d) - to_double(a);
  const double m0 = v.y * w.z, n0 = v.z * w.y, m1 = v.z * w.x, n1 = v.x * w.z, m2 = v.x * w.y, n2 = v.y * w.x;
  const double det = u.x * (m0 - n0) + u.y * (m1 - n1) + u.z * (m2 - n2);
  // Shewchuk's bound for this evaluation is (7 + 56 * 2^-53) * 2^-53 times the permanent, which is below 8 *
  // 2^-53.
  const double permanent = std::fabs(u.x) * (std::fabs(m0) + std::fabs(n0)) +
                           std::fabs(u.y) * (std::fabs(m1) + std::fabs(n1)) +
                           std::fabs(u.z) * (std::fabs(m2) + std::fabs(n2));
  const double bound = 8.9e-16 * permanent;
  if (det > bound) return 1;
  if (det < -bound) return -1;
  // [b c d] - [a c d] + [a b d] - [a b c], where each bracket is a 3x3 determinant of the original
  // coordinates.
  ExactSum sum;
  const auto bracket = [&sum](const Vec3f& p, const Vec3f& q, const Vec3f& r, double sign) {
    const double qy = sign * q.y, qz = sign * q.z, qx = sign * q.x;
    sum.add_product(qy * r.z, p.x);
    sum.add_product(-(qz * r.y), p.x);
    sum.add_product(qz * r.x, p.y);
    sum.add_product(-(qx * r.z), p.y);
    sum.add_product(qx * r.y, p.z);
    sum.add_product(-(qy * r.x), p.z);
  };
  bracket(b, c, d, 1);
  bracket(a, c, d, -1);
  bracket(a, b, d, 1);
  bracket(a, b, c, -1);
  return sum.sign();
}

}  // namespace fracture::solid_detail
