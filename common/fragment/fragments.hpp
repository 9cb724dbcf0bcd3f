// The pieces of a solid: closed fragments with attributes and mass properties, the bonds between them, and
// the certificate. Other results are stored next to the set (pipeline/fractured_solid.hpp).
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/base/vec.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/fragment/size_limits.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/source_tree.hpp"

namespace fracture {

struct Sheets;  // solid/solid.hpp

/// Triangles of one fragment with one material: a range of Fragment::indices.
struct FragmentPrimitive {
  /// Index into the source's materials, kNoIndex (none), or one of solid/cut_materials.hpp
  std::uint32_t material;
  std::uint32_t first_index, index_count;
  std::uint32_t part =
      kNoIndex;  ///< part of this cut or cavity wall, if the fragment has pieces of several parts
};

/// A cell, restricted to a part of the solid.
struct PartCell {
  std::uint32_t part;
  SiteId site;
  auto operator<=>(const PartCell&) const = default;
};
/// Volume of a fragment's pieces that belong to one part.
struct PartVolume {
  std::uint32_t part;
  double volume;  ///< m³
};

/// A range of Fragment::indices that consists of whole triangles.
struct IndexRange {
  std::uint32_t first = 0, count = 0;
};

/// Mass properties for density 1 kg/m³, about the centre of mass, in the file's frame.
struct MassProperties {
  double volume = 0;                ///< m³
  double area = 0;                  ///< m², exterior and interior
  Vec3d center_of_mass;             ///< m
  std::array<double, 6> inertia{};  ///< kg·m² per kg/m³: xx, yy, zz, xy, xz, yz of the inertia tensor
};

/// Origin of a fragment's local frame.
enum class Pivot {
  kCenterOfMass,  ///< at the centre of mass, rounded to the seam lattice
  kSource,        ///< at the origin of the source: local positions are world positions
};

struct Fragment {
  std::uint64_t id = 0;       ///< depends only on sites, part and island (at most 2^53 - 1: exact in JSON)
  std::vector<SiteId> sites;  ///< of its cells, ascending
  std::uint32_t part =
      0;  ///< index into Solid::parts; if pieces of several parts were joined, of the first piece
  /// The fragment's cells in each part, ascending, if pieces of several parts were joined. Otherwise empty:
  /// all cells belong to `part`.
  std::vector<PartCell> part_cells{};
  std::vector<PartVolume> part_volumes{};  ///< ascending by part; empty if `part_cells` is
  /// Density as a share of the request's density. Less if the fragment's parts overlap others, so that the masses of all
  /// fragments count overlaps once (pipeline/overlaps.hpp). A part with a material of its own has the density of that.
  double density_share = 1;
  std::uint32_t source_part = 0;  ///< equal to `part`; after refracture, the part of the broken fragment
  std::uint32_t node = 0;         ///< index into Mesh::node_names
  NodeRange nodes{};              ///< of all its parts; with `node`, they decide the group node that holds it
  /// Part of each triangle, if pieces of different parts were joined. Otherwise empty.
  std::vector<std::uint32_t> triangle_parts{};
  /// Centre of mass on the seam lattice, m; `pivot`, unless that is the origin of the source.
  Vec3d center;
  Vec3d pivot;  ///< node translation: a multiple of the seam lattice's step on each axis, exact in float
  std::vector<Vec3f> positions;  ///< local: float32(world - pivot), exact for constructed vertices
  /// Per vertex, same arrays as the source's (interior vertices: own normals and UVs)
  Attributes attributes;
  std::vector<std::uint32_t> indices;  ///< 3 per triangle, counter-clockwise from outside
  /// Exterior ones in material order, then the interior, then the mortar
  std::vector<FragmentPrimitive> primitives;
  /// Per vertex: index of the first vertex with the same position key, or with the same copy of it
  /// (repeated_edges.hpp). It connects vertices across attribute seams. Between these vertices, each edge
  /// is used exactly once in each direction.
  std::vector<std::uint32_t> topology;
  MassProperties mass;  ///< from the unrounded positions
  /// Local points of each member cell's share, if the fragment has several cells. Empty if the fragment
  /// lies in one convex cell: then its own positions serve. Rough fragments always have bodies: their
  /// points before roughening, which lie in convex cells.
  std::vector<std::vector<Vec3f>> bodies;
  double exterior_area = 0;  ///< m², of all primitives except cuts
  /// The sheets that the fragment carries (carried_sheets.hpp); null if there are none. Only positions in the
  /// fragment's local frame, attributes, indices and primitives. Not part of the volume, the bonds or the hulls.
  std::shared_ptr<const Fragment> sheet{};
  /// Data that proves the result (pipeline/soundness.hpp).
  std::vector<IndexRange> caps;  ///< interior triangles that another fragment has mirrored
  double surface_area = 0;       ///< m², of all triangles except caps
  std::uint64_t cap_sum = 0;     ///< mirror_sum()
  /// Only of a fragment that is cut again: its triangles in the surface that are cuts of the first time and mirrored in
  /// another solid (Solid::mirrored), and their area, m². They are not in `caps`.
  std::vector<IndexRange> earlier_caps{};
  double earlier_cap_area = 0;
  std::uint64_t open_edges = 0;  ///< open_edges()
};

/// Two fragments that hold together through shared caps, through their share of the contacts between parts, or through both
/// (structure/contact_bonds.hpp). Two fragments have at most one bond.
struct Bond {
  std::uint32_t a, b;  ///< indices into FragmentSet::fragments, a < b
  double area = 0;  ///< m², > 0; rough caps are projected onto their cuts' planes, to which strength refers
  Vec3d centroid;   ///< m; mean of the caps and contacts, weighted by that area
  Vec3d normal;     ///< unit, from a to b; mean weighted by area, which for caps is the unprojected one
  double strength = 1;  ///< mean per area, as a multiple of the request's strength; area × strength adds up
};

/// Proof of the invariants, checked for every result (pipeline/soundness.hpp). A result that violates one
/// is not returned.
struct Certificate {
  std::uint64_t open_edges = 0;  ///< over all fragments, in topology and after welding (closedness.hpp): 0
  double volume_in = 0;          ///< m³, of the solid
  double volume_once = 0;        ///< m³: volume_in, but overlaps of parts count once (pipeline/overlaps.hpp)
  double volume_out = 0;         ///< m³, of all fragments, from the unrounded positions
  double volume_file = 0;        ///< m³, of all fragments, from the final rounded positions
  double relative_error = 0;     ///< |volume_out - volume_in| / volume_in
  /// A pocket is a region of negative winding that no positive piece contains: the surface crosses itself
  /// and turns inside out. Pockets are not emitted. Their signed volume, m³, is part of volume_out, and
  /// their area, m², is part of area_out. 0 for clean solids.
  double pocket_volume = 0, pocket_area = 0;
  /// Number of cap triangles without a mirror image in another fragment, bit for bit in world space; must
  /// be 0. (1 stands for any number, because they are counted only if the result is refused.)
  std::uint64_t unmirrored_caps = 0;
  /// m², of the solid's surface, and of the triangles that cover it in the fragments, including
  /// pocket_area.
  double area_in = 0, area_out = 0;
  /// m², of the sheets in the source that the answer should have, and of those in it: carried by fragments, or
  /// whole. Sheets are not part of the other areas.
  double sheet_area_in = 0, sheet_area_out = 0;
  /// The counts satisfy fragments = cells + islands - united - dropped.
  /// Cells (or groups of cells) count if they meet the solid. Islands are their further pieces. United
  /// pieces were united with a neighbour, because they have no volume or because of a size limit. Dropped
  /// pieces have neither volume nor a neighbour.
  std::uint32_t sites_asked = 0, cells = 0, islands = 0, united = 0, dropped = 0, fragments = 0;
  std::uint64_t crossing_caps = 0;  ///< caps whose loops cross: 0 for every embedded input
};

/// Geometry only: a partition of the solid, or of the requested part of it.
struct FragmentSet {
  std::shared_ptr<const Mesh> source;
  std::vector<Fragment> fragments;
  std::vector<Bond> bonds;
  Certificate certificate;
  /// m³: Certificate::volume_once, with each part's volume times its density as a share of the request's. Hulls of
  /// barycentres: their volumes before hits, with the same weights (pipeline/part_sets.hpp).
  double weighed_volume = 0;
  SizeFigures size;  ///< effect of the size limits
  /// Sheets that stay whole, if there are any: triangles of the source (solid/solid.hpp).
  std::shared_ptr<const Sheets> whole_sheets{};
  Vec3d lattice_step;        ///< h_a: step of the seam lattice, m
  double lattice_ratio = 0;  ///< max over axes of h/size; a value above 1e-5 causes a warning
};

}  // namespace fracture
