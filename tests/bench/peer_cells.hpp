// The input for the peer of bench_fracture: a solid's triangles, and for each site the vertices of its
// Voronoi cell within an enlarged box. So the cells cost the peer nothing.
#pragma once

#include <string>

#include "common/delaunay/tetrahedralization.hpp"
#include "common/solid/solid.hpp"

namespace fracture::bench {

/// Little-endian: u32 vertices, triangles, sites, points; f64 points[3]…; f32 positions[3]…; u32
/// triangles[3]…; u32 first point of each site (and the end).
void write_for_peer(const std::string& path, const Solid& solid, const Tetrahedralization& t);

}  // namespace fracture::bench
