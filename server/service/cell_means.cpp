#include "server/service/cell_means.hpp"

#include <cmath>

namespace fracture {
namespace {

/// Total length of edges of n equal triangles with a total area of a: 2.28 sqrt(n a).
constexpr double kEdgesOfTriangles = 2.28;
/// The mean integral of curvature of a cell of volume 1, by 4π. (The integral is 2π times the mean width of 1.458.) Then the mean surface
/// of such a cell, 5.82, by 4: the integral of curvature of a box is π times the sum of its sides.
constexpr double kCellsBySurface = 0.729, kCellsByWidth = 1.455;

}  // namespace

SolidShape shape_of(const Solid& solid) {
  SolidShape shape;
  double largest = 0;
  for (const Part& part : solid.parts) {
    shape.volume += part.volume;
    largest = std::fmax(largest, part.volume);
  }
  const Vec3d sides = solid.parts.empty() ? Vec3d{} : solid.box.size();
  shape.box = sides.x * sides.y * sides.z;
  shape.area = solid.report.area;
  shape.triangles = static_cast<double>(solid.triangles.size());
  shape.edges = solid.report.edge_length > 0 ? solid.report.edge_length
                                             : kEdgesOfTriangles * std::sqrt(shape.triangles * shape.area);
  shape.size = std::cbrt(largest);
  shape.parts = static_cast<double>(solid.parts.size());
  return shape;
}

double cells_meeting(const Vec3d& sides, double volume, const CellSize& cell) {
  const double surface = 2 * (sides.x * sides.y + sides.y * sides.z + sides.z * sides.x);
  return 1 + volume / cell.volume + kCellsBySurface * surface / (cell.width * cell.width) +
         kCellsByWidth * (sides.x + sides.y + sides.z) / cell.width;
}

double fill_of(const Part& part) {
  const Vec3d box = part.box.size();
  const double whole = box.x * box.y * box.z;
  return std::cbrt(whole > 0 ? std::fmin(1, part.volume / whole) : 1);
}

double surface_of_stretched(double stretch) {
  const double root = std::cbrt(stretch);
  return (2 * root + 1 / (root * root)) / 3;
}

}  // namespace fracture
