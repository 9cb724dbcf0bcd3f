#include "server/service/cell_means.hpp"

#include <cmath>

namespace fracture {
namespace {

/// Total length of edges of n equal triangles with a total area of a: 2.28 sqrt(n a).
constexpr double kEdgesOfTriangles = 2.28;

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

double surface_of_stretched(double stretch) {
  const double root = std::cbrt(stretch);
  return (2 * root + 1 / (root * root)) / 3;
}

}  // namespace fracture
