// From a mesh to solids: weld, orient, split, fill, nest (geometry of real assets). A Solid is what the exact
// part of the pipeline works on: a closed, consistently oriented triangle surface, in shells and parts.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/remarks.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/contact_graph.hpp"
#include "common/solid/vertex_id.hpp"

namespace fracture {

enum class Repair {
  kFill,    ///< bounded holes are filled and marked as interior material (the default)
  kStrict,  ///< refuse whatever is not already closed and consistently oriented
};

struct SolidOptions {
  Repair repair = Repair::kFill;
  /// Vertices closer than this fraction of the box's diagonal may be welded when that closes open edges. 0 =
  /// exact only.
  double weld_tolerance = 1e-6;
  /// Metres. When positive, open sheets (panes, leaves, wall quads: pieces that bound no volume, or whose
  /// filled holes would enclose less than this times their area) become slabs of this thickness behind their
  /// surface. 0 = such pieces are dropped.
  double thickness = 0;
  /// Gap of the contact graph, m. keep_contacts() uses it; make_solid() does not. Empty: kContactGap times the longest side.
  std::optional<double> contact_gap{};
};

/// Per-triangle material of triangles that were not in the source (filled holes): the interior material.
inline constexpr std::uint32_t kInteriorMaterial = 0xfffffffeu;
/// And of the inner sides of walls (hollow/hollow.hpp), which are part of the outside: the cavity material.
inline constexpr std::uint32_t kCavityMaterial = 0xfffffffdu;

/// A part: one outward shell with its cavities. Parts are fractured independently of one another.
struct Part {
  std::vector<std::uint32_t> shells;  ///< shells[0] is the outward one
  double volume = 0;                  ///< m³, > 0
  Box box;
  /// Parts of one layer have pairwise disjoint boxes, so one pass of the clipper can treat them as one
  /// surface.
  std::uint32_t layer = 0;
  std::uint32_t node = 0;  ///< index into Mesh::node_names: the source node that names its fragments
  std::optional<LinearColor> color{};  ///< what most of its surface shows, where that is known
  bool translucent = false;            ///< light comes through most of it
};

/// What was done to the input. Counts, and where an intervention touches a place, the first place.
struct SolidReport {
  std::uint64_t source_triangles = 0, source_vertices = 0;
  std::uint64_t welded = 0;           ///< vertices merged by exact position
  std::uint64_t welded_tolerant = 0;  ///< vertices merged within the tolerance
  std::uint64_t degenerate_dropped = 0, duplicates_dropped = 0;
  std::uint64_t flipped = 0;            ///< triangles whose orientation was reversed
  std::uint64_t open_edges = 0;         ///< before filling
  std::uint64_t nonmanifold_edges = 0;  ///< before splitting
  std::uint64_t holes_filled = 0, fill_triangles = 0;
  double filled_area = 0;  ///< m², of the filled holes and of the backs and rims of thickened sheets
  std::uint64_t sheets_thickened = 0;
  std::uint64_t shells = 0, parts = 0, cavities = 0;
  std::uint64_t shells_dropped = 0;  ///< shells that bound no volume
  double volume = 0;                 ///< m³, of the solid: what the fragments add up to
  double absolute_volume = 0;        ///< m³, of all shells, those of cavities added
  double area = 0;  ///< m², of the kept source triangles, the fill and the inner sides of walls
  std::uint64_t parts_hollowed = 0;    ///< that became walls (hollow/hollow.hpp)
  std::uint64_t hollow_triangles = 0;  ///< of their inner sides
  double hollow_volume = 0;            ///< m³, of what they enclose
  double least_thickness = 0;          ///< metres: the least distance between the two sides of a wall
  double mean_thickness = 0;  ///< metres, by area: measured in the middles of the inner side's triangles
  Remarks remarks;            ///< each with a count and, if there is one, a sample place
  struct Sample {
    std::string figure;  ///< the name of the figure above, as each_figure() has it
    Vec3d place;
    bool operator==(const Sample&) const = default;
  };
  std::vector<Sample> samples;  ///< one place for each kind of intervention: the first met
  /// Keeps the place unless the figure has one already.
  void add_sample(const char* figure, const Vec3f& place);

  /// visit(name, figure) for all that is published, in the order of the names.
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

struct Solid {
  std::shared_ptr<const Mesh> source;
  std::vector<Vec3f>
      positions;  ///< per vertex; vertices that touch several fans of triangles are split (umbrellas)
  std::vector<std::array<VertexId, 3>> triangles;  ///< counter-clockwise from outside, grouped by part
  /// Per triangle: the wedges of the source at its corners, or kNoIndex three times for filled triangles.
  std::vector<std::array<std::uint32_t, 3>> wedges;
  std::vector<std::uint32_t> material;  ///< per triangle: source material, kNoIndex or kInteriorMaterial
  /// edges[t][k] = id of the edge from corner k to corner (k+1)%3. Each edge id is used by exactly two
  /// triangles, in opposite directions (this is what "closed" means here, after non-manifold edges have been
  /// split).
  std::vector<std::array<std::uint32_t, 3>> edges;
  /// edge_vertices[e] = its two vertices, lower id first.
  std::vector<std::array<VertexId, 2>> edge_vertices;
  std::vector<std::uint32_t> shell;  ///< per triangle
  std::vector<std::uint32_t> part;   ///< per triangle: index into parts
  std::vector<Part> parts;
  std::uint32_t layers = 0;  ///< 1 + the largest Part::layer
  Box box;
  SolidReport report;
  /// Null until keep_contacts() (contacts/contacts.hpp). Copies, images and extracts of the solid share it or have none.
  std::shared_ptr<const ContactGraph> contacts{};

  /// Those of the importer, then those of make_solid().
  Remarks remarks() const;
  /// Throws InternalError naming the first broken statement of the comments above (with ids).
  void validate() const;
};

/// The range of coordinates. Metres: the largest that a coordinate may be (sites have the same limit, and the filters of
/// the exact predicates rest on it), and the least that the largest one on each axis must be, so that the steps of the
/// seam lattice (2^-23 of it) are floats.
inline constexpr double kMaxCoordinate = 1e12, kLeastReach = 0x1p-126;

/// Makes solids of a mesh. Errors: kEmptyMesh, kNotFinite (with the vertex that is not finite or beyond kMaxCoordinate, or
/// with the axis on which nothing is as far out as kLeastReach), kMeshNotClosed (with counts and the first offending edge).
Expected<Solid> make_solid(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                           const Execution& execution);

}  // namespace fracture
