// The pieces of a solid: closed fragments with attributes and figures, the bonds between them, and the
// certificate. What else is known of them stands beside the set (pipeline/fractured_solid.hpp).
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

namespace fracture {

/// Triangles of one fragment with one material: a range of Fragment::indices.
struct FragmentPrimitive {
  std::uint32_t
      material;  ///< index into the source's materials, kNoIndex (none), or one of solid/cut_materials.hpp
  std::uint32_t first_index, index_count;
  std::uint32_t part =
      kNoIndex;  ///< of cuts and cavities, if the fragment has pieces of several parts: their part
};

/// A cell, restricted to a part of the solid.
struct PartCell {
  std::uint32_t part;
  SiteId site;
  auto operator<=>(const PartCell&) const = default;
};
/// The volume of a fragment's pieces of one part.
struct PartVolume {
  std::uint32_t part;
  double volume;  ///< m³
};

/// A range of Fragment::indices, whole triangles.
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

/// Where the origin of a fragment's local frame is.
enum class Pivot {
  kCenterOfMass,  ///< at the centre of mass, rounded to the seam lattice
  kSource,        ///< at the origin of the source: local positions are world positions
};

struct Fragment {
  std::uint64_t id = 0;       ///< function of its sites and part only (at most 2^53 - 1: exact in JSON)
  std::vector<SiteId> sites;  ///< of its cells, ascending
  std::uint32_t part =
      0;  ///< index into Solid::parts; if pieces of several parts were joined, of the first piece
  /// If pieces of several parts were joined: the cells of each part in the fragment, ascending. Otherwise empty: all
  /// cells are of `part`.
  std::vector<PartCell> part_cells{};
  std::vector<PartVolume> part_volumes{};  ///< ascending by part; empty if `part_cells` is
  /// Mass per volume, as a share of the material's density. Less than 1 if the fragment's parts overlap others, so that
  /// the masses of all fragments count overlaps once (pipeline/overlaps.hpp).
  double density_share = 1;
  std::uint32_t source_part = 0;  ///< the same; of pieces of a fragment the part of that fragment
  std::uint32_t node = 0;         ///< index into Mesh::node_names
  Vec3d pivot;  ///< node translation: a multiple of the seam lattice's step on each axis, exact in float
  std::vector<Vec3f> positions;  ///< local: float32(world - pivot), exact for constructed vertices
  Attributes
      attributes;  ///< per vertex, same arrays as the source's (interior vertices: own normals and UVs)
  std::vector<std::uint32_t> indices;  ///< 3 per triangle, counter-clockwise from outside
  std::vector<FragmentPrimitive>
      primitives;  ///< exterior ones in material order, then the interior, then the mortar
  /// Per vertex: the index of the first vertex with the same position key (topology across attribute seams), or of the same
  /// copy of it (repeated_edges.hpp). Between them each edge is used exactly once in each direction.
  std::vector<std::uint32_t> topology;
  MassProperties mass;  ///< from the unrounded positions
  /// Local points of each member cell's share, for fragments of several cells; empty when the fragment lies
  /// in one convex cell (then its own positions serve). Of rough fragments always: as they are with flat
  /// cuts, in their convex cells.
  std::vector<std::vector<Vec3f>> bodies;
  double exterior_area = 0;  ///< m², of the primitives with a material of the source
  /// What proves the answer (pipeline/soundness.hpp).
  std::vector<IndexRange> caps;  ///< of the interior triangles those that another fragment has mirrored
  double surface_area = 0;       ///< m², of all that is no cap: exterior_area and what repairs filled
  std::uint64_t cap_sum = 0;     ///< mirror_sum()
  std::uint64_t open_edges = 0;  ///< open_edges()
};

/// Two fragments that hold together: by their shared caps, or by their share in the contact of two parts
/// (structure/contact_bonds.hpp). Fragments with pieces of several parts can have a bond of each kind.
struct Bond {
  std::uint32_t a, b;  ///< indices into FragmentSet::fragments, a < b
  double area = 0;  ///< m², > 0; of rough caps across their cuts' planes, which is what strength refers to
  Vec3d centroid;   ///< m; the mean of the caps, by that area
  Vec3d normal;     ///< unit, from a to b, the mean of the caps by their own area
  double strength = 1;        ///< per area, as a multiple of the material's strength
  bool across_parts = false;  ///< the contact of two parts, not shared caps
};

/// Proof of the invariants, checked on every answer (pipeline/soundness.hpp): one that does not hold is not
/// given.
struct Certificate {
  std::uint64_t open_edges = 0;  ///< over all fragments, in their topology and welded (closedness.hpp): 0
  double volume_in = 0;          ///< m³, of the solid
  double volume_once = 0;        ///< m³: volume_in, if overlaps of parts count once (pipeline/overlaps.hpp)
  double volume_out = 0;         ///< m³, of all fragments, from the unrounded positions
  double volume_file = 0;        ///< m³, of all fragments, from the final rounded positions
  double relative_error = 0;     ///< |volume_out - volume_in| / volume_in
  /// Pockets of negative winding that no positive piece contains (the surface turned inside out by crossing
  /// itself) are not emitted; their signed volume, m³, is part of volume_out, and their area, m², is stated.
  /// 0 for clean solids.
  double pocket_volume = 0, pocket_area = 0;
  /// Cap triangles without a mirror image in another fragment, bit for bit in world space: 0. (1 stands for
  /// any number; only where the answer is refused, all are looked for.)
  std::uint64_t unmirrored_caps = 0;
  /// m², of the solid's surface, and of what covers it in the fragments: pocket_area, too.
  double area_in = 0, area_out = 0;
  /// fragments = cells + islands - united - dropped: cells (or groups) that meet the solid, further pieces of
  /// them, pieces united with a neighbour (without volume, or because of a limit of size), pieces without
  /// volume or neighbour.
  std::uint32_t sites_asked = 0, cells = 0, islands = 0, united = 0, dropped = 0, fragments = 0;
  std::uint64_t crossing_caps = 0;  ///< caps whose loops crossed: 0 on every embedded input
};

/// Geometry alone: a partition of the solid, or of what is asked of it.
struct FragmentSet {
  std::shared_ptr<const Mesh> source;
  std::vector<Fragment> fragments;
  std::vector<Bond> bonds;
  Certificate certificate;
  SizeFigures size;          ///< what the limits of size did
  Vec3d lattice_step;        ///< h_a: the seam lattice, m
  double lattice_ratio = 0;  ///< max over axes of h/size; above 1e-5 a warning
};

}  // namespace fracture
