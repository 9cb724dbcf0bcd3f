// Reduces the number of triangles of a closed surface.
#pragma once

#include "common/bvh/surface_tree.hpp"
#include "common/hollow/inner_surface.hpp"

namespace fracture::hollow_detail {

/// Merges corners one after another into their neighbours, in the order of the least change to the surface
/// (quadrics: Garland & Heckbert 1997, "Surface simplification using quadric error metrics"). No new points
/// are created, so the remaining corners are as deep as before, and floats represent them. A corner is not
/// merged if
/// - the surface would deviate by more than `tolerance` (m; root mean square over the original surface),
/// - a triangle would turn by more than 60 degrees, become a needle, or come nearer to `outside` than `depth`
///   (m) at its middle or at the middle of an edge,
/// - the result would not be a surface (link condition: Dey, Edelsbrunner, Guha & Nekhayev 1999, "Topology
///   preserving edge contraction").
/// `surface`: closed, with two triangles at each edge. Its corners and triangles keep their order. Throws
/// Interrupted.
InnerSurface simplified(const InnerSurface& surface, double tolerance, const SurfaceTree& outside,
                        double depth, const Execution& execution);

/// Whether the whole surface is certainly no nearer to `outside` than `depth`. Divides triangles until the
/// distance of their middles proves it, or until so few triangles of the outside are near that each can be
/// tested. Throws Interrupted.
bool is_deep(const InnerSurface& surface, const SurfaceTree& outside, double depth,
             const Execution& execution);

/// Whether two triangles without a common edge cross. Throws Interrupted.
bool crosses_itself(const InnerSurface& surface, const Execution& execution);

}  // namespace fracture::hollow_detail
