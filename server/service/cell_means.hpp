// Means of random cells, and the figures of a solid, from which estimates follow.
#pragma once

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
SolidShape shape_of(const Solid& solid);

/// How many random cells of the volume `cell` (m³) meet a convex body, on average: one, and further ones that follow from the means of a
/// cell and of the body (Santaló 1976, III.15). `sides` (m): of a box with about the body's surface and width; `volume` (m³): of the body.
double cells_meeting(const Vec3d& sides, double volume, double cell);

/// Parts in contact with no other part, if they are much smaller than a cell of this volume (m³). None of them becomes part of another
/// fragment.
struct LooseParts {
  double count = 0;
  double pieces = 0;  ///< that random cells cut them into
};
/// `are_apart`: parts are loose although they are in contact. If contacts are not known, there are none. Linear in parts and contacts.
LooseParts loose_parts(const Solid& solid, double cell, bool are_apart);

/// The sides of a part's box, m, shrunk so that they have the part's volume.
Vec3d filled_sides(const Part& part, const Vec3d& sides);

/// Surface of a box of volume 1 that is `stretch` times as long as wide, relative to a cube's.
double surface_of_stretched(double stretch);

}  // namespace fracture
