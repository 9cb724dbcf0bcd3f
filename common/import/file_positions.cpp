#include "common/import/file_positions.hpp"

#include <cmath>
#include <limits>

#include "common/import/transform.hpp"

namespace fracture {
namespace {

constexpr double kLargestFloat = std::numeric_limits<float>::max();
constexpr int kFloatBits = std::numeric_limits<float>::digits;

double largest(double a, double b, double c) {
  return std::fmax(std::fabs(a), std::fmax(std::fabs(b), std::fabs(c)));
}

/// The distance between floats of this size.
double float_step(double size) {
  int exponent = 0;
  std::frexp(size, &exponent);  // size < 2^exponent
  return std::ldexp(1.0, exponent - kFloatBits);
}

}  // namespace

Vec3d offset_for(const Box& box) {
  constexpr double kTolerated = 1e-6;  // of the longest side
  if (box.empty()) return {};
  const double side = box.longest_side();
  const double far =
      std::fmax(largest(box.min.x, box.min.y, box.min.z), largest(box.max.x, box.max.y, box.max.z));
  if (!(side > 0) || !(0.5 * float_step(far) > kTolerated * side)) return {};
  int exponent = 0;
  std::frexp(side, &exponent);
  // With this many bits, every multiple up to `far` is a float.
  const double step = std::fmax(std::ldexp(1.0, exponent), float_step(far));
  const Vec3d center = box.center();
  Vec3d offset;
  for (int axis = 0; axis < 3; ++axis) {
    offset[axis] = step * std::floor(center[axis] / step + 0.5);
    if (offset[axis] == 0) offset[axis] = 0;  // never -0
  }
  return offset;
}

bool FilePositions::fits(const Vec3d& p) {
  return std::fabs(p.x) <= kLargestFloat && std::fabs(p.y) <= kLargestFloat &&
         std::fabs(p.z) <= kLargestFloat;
}

std::vector<Vec3f> FilePositions::rounded(const Vec3d& offset) const {
  const bool moved = !(offset == Vec3d{});
  std::vector<Vec3f> floats;
  floats.reserve(positions_.size());
  for (const Vec3d& p : positions_) {
    const Vec3d at = moved ? p - offset : p;  // subtracting zero would turn -0 into 0
    floats.push_back(fits(p) && fits(at) ? to_float(at) : Vec3f{});
  }
  return floats;
}

}  // namespace fracture
