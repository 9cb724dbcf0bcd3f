// Means of random cells, and the figures of a solid, from which estimates follow.
#pragma once

#include <cmath>

#include "common/solid/solid.hpp"

namespace fracture {

// Means for Voronoi cells of random sites (Meijering 1953; Møller 1994, Lectures on Random Voronoi Tessellations). The cells have a
// volume of 1: the area of the faces per cell, then the length of edges, the vertices and the cells per area of a plane section.
inline constexpr double kFaceArea = 2.91, kEdgesOnSection = 2.285, kVerticesOnSection = 2.92,
                        kCellsOnSection = 1.458;
inline constexpr double kTetrahedraPerSite = 6.77, kFacesPerCell = 7.77, kTrianglesPerFace = 3.23;
// In a wall that is thinner than its cells, these are prisms: three faces of about two triangles for each cell.
inline constexpr double kFacesPerPrism = 3, kTrianglesPerPrismFace = 2;
/// Lines of lengths l and m in an area a cross 2 l m / (π a) times (Buffon).
inline constexpr double kCrossings = 2 / 3.14159265358979;
/// Triangles that are made, relative to those that are left after merging.
inline constexpr double kCountedOfMerged = 1.4;

struct SolidShape {
  double volume = 0, area = 0, box = 0, triangles = 0;
  double edges = 0;  ///< m: total length
  double size = 0;   ///< m: cube root of the largest part's volume
  double parts = 0;
  /// m: of a wall with this volume and area.
  double thickness() const { return 2 * volume / area; }
};
/// Linear in the parts.
SolidShape shape_of(const Solid& solid);

/// The volume of a cell, m³, and the side of a cube with that volume, m.
struct CellSize {
  explicit CellSize(double cell) : volume(cell), width(std::cbrt(cell)) {}
  double volume, width;
};
/// How many random cells meet a convex body, on average: one, and further ones that follow from the means of a
/// cell and of the body (Santaló 1976, III.15). `sides` (m): of a box with about the body's surface and width; `volume` (m³): of the body.
double cells_meeting(const Vec3d& sides, double volume, const CellSize& cell);

/// The factor that shrinks the sides of a part's box so that they have the part's volume.
double fill_of(const Part& part);

/// Surface of a box of volume 1 that is `stretch` times as long as wide, relative to a cube's.
double surface_of_stretched(double stretch);

}  // namespace fracture
