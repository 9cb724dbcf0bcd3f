#include "common/base/long_axis.hpp"

#include <cmath>

namespace fracture {
namespace {

double trace(const Matrix3& m) { return m.rows[0].x + m.rows[1].y + m.rows[2].z; }

Matrix3 squared(const Matrix3& m) {  // of a symmetric matrix, after scaling it to trace 1
  Matrix3 product;
  const double scale = 1 / trace(m);
  for (std::size_t i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      product.rows[i][j] = scale * scale * dot(m.rows[i], m.rows[static_cast<std::size_t>(j)]);
  return product;
}

}  // namespace

std::optional<LongAxis> long_axis(const Matrix3& m) {
  if (!(trace(m) > 0)) return std::nullopt;
  Matrix3 power = m;
  for (int k = 0; k < 10; ++k) {
    power = squared(power);
    if (!(trace(power) > 0)) return std::nullopt;
  }
  Vec3d axis = power.rows[0];
  for (const Vec3d& row : power.rows)
    if (dot(row, row) > dot(axis, axis)) axis = row;
  axis = (1 / length(axis)) * axis;
  const double largest = dot(axis, m * axis), rest = trace(m) - largest;
  // The other two eigenvalues add up to `rest`, and the product of all three is the determinant.
  const double product = largest > 0 ? m.determinant() / largest : 0;
  const double next = (rest + std::sqrt(std::fmax(0, rest * rest - 4 * product))) / 2;
  return LongAxis{axis, next > 0 ? largest / next : HUGE_VAL};
}

std::optional<ShortAxis> short_axis(const Matrix3& m) {
  // trace - m has the same axes in reverse order.
  Matrix3 others;
  for (std::size_t i = 0; i < 3; ++i) {
    others.rows[i] = -1.0 * m.rows[i];
    others.rows[i][static_cast<int>(i)] += trace(m);
  }
  const std::optional<LongAxis> longest = long_axis(others);
  if (!longest) return std::nullopt;
  const Vec3d& axis = longest->axis;
  const double least = std::fmax(0, dot(axis, m * axis)), rest = trace(m) - least;
  // The other two eigenvalues add up to `rest`. The squares of all three add up to the sum of the squared
  // entries of m.
  double squares = -least * least;
  for (const Vec3d& row : m.rows) squares += dot(row, row);
  const double difference = std::sqrt(std::fmax(0, 2 * squares - rest * rest));
  const double next = (rest - difference) / 2;
  return ShortAxis{axis, next > 0 ? std::fmin(1, least / next) : 1};
}

}  // namespace fracture
