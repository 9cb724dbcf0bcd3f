// Turns a mesh into a solid: weld, orient, split, fill, nest (to handle the geometry of real assets). The
// exact part of the pipeline works on a Solid: a closed, consistently oriented triangle surface, in shells
// and parts.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "common/base/choice.hpp"
#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/remarks.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/source_tree.hpp"
#include "common/solid/contact_graph.hpp"
#include "common/solid/instances.hpp"
#include "common/solid/vertex_id.hpp"

namespace fracture {

enum class Repair {
  kFill,    ///< bounded holes are filled and marked as interior material (the default)
  kStrict,  ///< refuses meshes that are not already closed and consistently oriented
};

/// Treatment of sheets: pieces of the surface that bound no volume (panes, leaves, decals).
enum class SheetsMode {
  kAttach,  ///< each fragment carries its share of them, as geometry without volume (the default)
  kWhole,   ///< they stay whole, next to the fragments
  kSolid,   ///< they become slabs (SolidOptions::thickness)
  kDrop,    ///< they are left out
};

/// Thickness of slabs if none is given, as a share of the diagonal of the mesh's box: 4 mm for a flag of 2 m,
/// 2 cm for the panes of a house of 10 m.
inline constexpr double kSlabShare = 0.002;

struct SolidOptions {
  Repair repair = Repair::kFill;
  /// Vertices closer than this fraction of the box's diagonal may be welded if that closes open edges. 0 =
  /// weld only equal positions.
  double weld_tolerance = 1e-6;
  SheetsMode sheets = SheetsMode::kAttach;
  /// Metres. If positive, `sheets` is kSolid. Open sheets (panes, leaves, wall quads) then become slabs of this thickness behind
  /// their surface. These are pieces that bound no volume, whose filled holes would enclose less than this times their area, or
  /// that need a large lid; and with Repair::kFill rooms (solid/enclosures.hpp). 0 = with kSolid, kSlabShare times the diagonal of
  /// the mesh's box.
  double thickness = 0;
  /// Gap of the contact graph, m. keep_contacts() uses it; make_solid() does not. Empty: kContactGap times the longest side.
  std::optional<double> contact_gap{};
};

/// Material of triangles that were not in the source (filled holes): the interior material.
inline constexpr std::uint32_t kInteriorMaterial = 0xfffffffeu;
/// Material of the inner sides of walls (hollow/hollow.hpp), which belong to the outside: the cavity
/// material.
inline constexpr std::uint32_t kCavityMaterial = 0xfffffffdu;

/// A part: one outward shell with its cavities. Parts are fractured independently.
struct Part {
  std::vector<std::uint32_t> shells;  ///< shells[0] is the outward one
  double volume = 0;                  ///< m³, > 0
  Box box;
  /// Parts of one layer have pairwise disjoint boxes, so one pass of the clipper can process them as one
  /// surface.
  std::uint32_t layer = 0;
  std::uint32_t node = 0;  ///< index into Mesh::node_names: the source node that names its fragments
  std::optional<LinearColor> color{};  ///< main colour of its surface, if known
  bool translucent = false;            ///< most of its surface transmits light
  NodeRange nodes{};  ///< of all its triangles: several nodes if a file divides one surface among them
};

/// Changes to the input: counts and, for each kind of change, the first place if it has one.
struct SolidReport {
  std::uint64_t source_triangles = 0, source_vertices = 0;
  std::uint64_t welded = 0;           ///< vertices merged by exact position
  std::uint64_t welded_tolerant = 0;  ///< vertices merged within the tolerance
  std::uint64_t degenerate_dropped = 0, duplicates_dropped = 0;
  std::uint64_t flipped = 0;            ///< triangles whose orientation was reversed
  std::uint64_t open_edges = 0;         ///< before filling
  std::uint64_t nonmanifold_edges = 0;  ///< before splitting
  std::uint64_t holes_filled = 0, fill_triangles = 0;
  double filled_area = 0;  ///< m²: filled holes, and backs and rims of thickened sheets
  std::uint64_t sheets_thickened = 0;
  std::uint64_t rooms_walled = 0;  ///< of them: rooms (solid/enclosures.hpp)
  std::uint64_t shells = 0, parts = 0, cavities = 0;
  std::uint64_t shells_dropped = 0;   ///< shells that bound no volume and are left out
  std::uint64_t sheets = 0;           ///< shells that bound no volume and are kept (Solid::sheets)
  std::uint64_t sheet_triangles = 0;  ///< source triangles in shells without volume, kept or left out
  double sheet_area = 0;              ///< m², of these triangles
  double volume = 0;                  ///< m³, of the solid: the fragments add up to this
  double absolute_volume = 0;         ///< m³: the sum over all shells, with cavities added
  double edge_length = 0;             ///< m, of all edges; 0: not measured (measure_edges())
  double area = 0;  ///< m², of the kept source triangles, the fill and the inner sides of walls
  std::uint64_t parts_hollowed = 0;    ///< parts that became walls (hollow/hollow.hpp)
  std::uint64_t hollow_triangles = 0;  ///< triangles of the walls' inner sides
  double hollow_volume = 0;            ///< m³, enclosed by the inner sides
  double least_thickness = 0;          ///< m: minimum distance between the two sides of a wall
  double mean_thickness = 0;  ///< m, weighted by area: measured at the middles of the inner side's triangles
  Remarks remarks;            ///< each with a count and, if possible, a sample place
  std::vector<Choice> choices;  ///< repairs that were not done, because they would change what the mesh is
  struct Sample {
    std::string figure;  ///< name of the counter, as in each_figure()
    Vec3d place;
    bool operator==(const Sample&) const = default;
  };
  std::vector<Sample> samples;  ///< the first place for each kind of change
  /// Stores the place, unless the counter already has one.
  void add_sample(const char* figure, const Vec3f& place);

  /// Calls visit(name, value) for each published value, in the order of the names.
  template <class Visit>
  void each_figure(const Visit& visit) const {
    visit("area", area);
    visit("cavities", cavities);
    visit("degenerate_dropped", degenerate_dropped);
    visit("duplicates_dropped", duplicates_dropped);
    visit("fill_triangles", fill_triangles);
    visit("filled_area", filled_area);
    visit("flipped", flipped);
    visit("holes_filled", holes_filled);
    visit("hollow_triangles", hollow_triangles);
    visit("hollow_volume", hollow_volume);
    visit("least_thickness", least_thickness);
    visit("mean_thickness", mean_thickness);
    visit("nonmanifold_edges", nonmanifold_edges);
    visit("open_edges", open_edges);
    visit("parts", parts);
    visit("parts_hollowed", parts_hollowed);
    visit("samples", samples);
    if (sheet_triangles > 0) {
      visit("sheet_area", sheet_area);
      visit("sheet_triangles", sheet_triangles);
      visit("sheets", sheets);
    }
    visit("sheets_thickened", sheets_thickened);
    visit("shells", shells);
    visit("shells_dropped", shells_dropped);
    visit("source_triangles", source_triangles);
    visit("source_vertices", source_vertices);
    visit("volume", volume);
    visit("welded", welded);
    visit("welded_tolerant", welded_tolerant);
  }
  nlohmann::json to_json() const;
  bool operator==(const SolidReport&) const = default;
};

struct Scenery;  // contacts/scenery.hpp
struct Solid;

/// The sheets that a solid's answer keeps: triangles of the source as they are in the file.
struct Sheets {
  bool whole = false;                    ///< they stay whole; otherwise fragments carry them
  std::vector<std::uint32_t> triangles;  ///< of the source; ascending
  /// The same triangles as an open surface, in this order. Vertices have the source's positions, bit for bit, and
  /// vertices with equal positions are one. An edge may have any number of triangles. `box` also contains the
  /// solid, so that both have the same seam lattice if the sheets lie in the solid's box. There is one part,
  /// without a volume.
  std::shared_ptr<const Solid> surface;
  double area = 0;  ///< m²
};

struct Solid {
  std::shared_ptr<const Mesh> source;
  /// Per vertex; vertices that touch several fans of triangles are split (umbrellas)
  std::vector<Vec3f> positions;
  std::vector<std::array<VertexId, 3>> triangles;  ///< counter-clockwise from outside, grouped by part
  /// Per triangle: the wedges of the source at its corners, or kNoIndex three times for filled triangles.
  std::vector<std::array<std::uint32_t, 3>> wedges;
  std::vector<std::uint32_t> material;  ///< per triangle: source material, kNoIndex or kInteriorMaterial
  /// edges[t][k] = id of the edge from corner k to corner (k+1)%3. Each edge id is used by exactly two
  /// triangles, in opposite directions. This is the meaning of "closed" here, after non-manifold edges have
  /// been split.
  std::vector<std::array<std::uint32_t, 3>> edges;
  /// edge_vertices[e] = its two vertices, lower id first.
  std::vector<std::array<VertexId, 2>> edge_vertices;
  std::vector<std::uint32_t> shell;  ///< per triangle
  std::vector<std::uint32_t> part;   ///< per triangle: index into parts
  /// Per triangle: whether another solid has its mirror image, and both are cut by the same planes. Empty: none. Only a
  /// fragment that is cut again has such triangles (fragment/fragment_solid.hpp).
  std::vector<char> mirrored{};
  std::vector<Part> parts;
  std::uint32_t layers = 0;  ///< 1 + the largest Part::layer
  Box box;
  SolidReport report;
  /// Null until keep_contacts() (contacts/contacts.hpp). Copies, images and extracts of the solid share it or have none.
  std::shared_ptr<const ContactGraph> contacts{};
  /// Null if there are none, and in images and patches.
  std::shared_ptr<const Sheets> sheets{};
  /// Null until keep_instances() (solid/instances.hpp), or if there are none. Copies share it; images and patches have none.
  std::shared_ptr<const Instances> instances{};
  /// Null until keep_scenery() (contacts/scenery.hpp), and without scenery. Copies share it; images and patches do not have it.
  std::shared_ptr<const Scenery> scenery{};

  /// The remarks of the importer, followed by those of make_solid().
  Remarks remarks() const;
  /// Throws InternalError with the first violated statement of the comments above (with ids).
  void validate() const;
};

/// The range of a mesh's coordinates, metres. kMaxCoordinate is a tenth of the limit for sites (kMaxSiteCoordinate,
/// on which the filters of the exact predicates depend), because rings of sites and backs of slabs can be outside
/// the mesh. On each axis, the largest coordinate must be at least kLeastReach, so that the steps of the seam
/// lattice (2^-23 of it) are floats.
inline constexpr double kMaxCoordinate = 1e11, kLeastReach = 0x1p-126;

/// Sets SolidReport::edge_length, by which the cost of a fracture is estimated. Throws Interrupted.
void measure_edges(Solid& solid, const Execution& execution);

/// Makes solids from a mesh. Errors: kEmptyMesh; kNotFinite (with the vertex that is not finite or exceeds
/// kMaxCoordinate, or with the axis on which no coordinate reaches kLeastReach); kMeshNotClosed (with counts
/// and the first faulty edge).
Expected<Solid> make_solid(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                           const Execution& execution);

}  // namespace fracture
