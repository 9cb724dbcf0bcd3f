// The same closed surface in fewer triangles.
#pragma once

#include "common/bvh/surface_tree.hpp"
#include "common/hollow/inner_surface.hpp"

namespace fracture::hollow_detail {

/// Corners go, one after the other, each into a neighbour of its own, where that changes the surface least (quadrics:
/// Garland & Heckbert 1997, "Surface simplification using quadric error metrics"; nothing new is placed, so what is left
/// is as deep as it was, and floats hold it). None goes where
/// - the surface would be farther than `tolerance` (m; root of the mean square over what was there) from what it was,
/// - a triangle would turn by more than 60 degrees, become a needle, or, at its middle or that of an edge, come nearer to
///   `outside` than `depth` (m),
/// - it would not be a surface any more (link condition: Dey, Edelsbrunner, Guha & Nekhayev 1999, "Topology preserving
///   edge contraction").
/// `surface`: closed, each edge of two triangles. Its corners and triangles keep their order. Throws Interrupted.
InnerSurface simplified(const InnerSurface& surface, double tolerance, const SurfaceTree& outside,
                        double depth, const Execution& execution);

/// Whether nothing of it is nearer to `outside` than `depth`, for sure: triangles are divided until the distance of
/// their middles proves it, or until so few of the outside are near that each is asked. Throws Interrupted.
bool is_deep(const InnerSurface& surface, const SurfaceTree& outside, double depth,
             const Execution& execution);

/// Whether two triangles without a common edge cross. Throws Interrupted.
bool crosses_itself(const InnerSurface& surface, const Execution& execution);

}  // namespace fracture::hollow_detail
