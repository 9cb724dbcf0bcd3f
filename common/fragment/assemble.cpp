#include "common/fragment/assemble.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"
#include "common/fragment/certain_volume.hpp"
#include "common/fragment/closedness.hpp"
#include "common/fragment/cut_weights.hpp"
#include "common/fragment/mass_properties.hpp"
#include "common/fragment/mirror_sum.hpp"
#include "common/fragment/repeated_edges.hpp"
#include "common/fragment/vertex_attributes.hpp"
#include "common/solid/cut_materials.hpp"

namespace fracture {
namespace {

/// Source of a vertex's attributes. Faces whose sources are equal share the vertex.
struct VertexSource {
  enum Kind : std::uint32_t {
    kPlain,     ///< the source has no attributes: the vertex has only a position
    kWedge,     ///< an input vertex: wedge a
    kOnEdge,    ///< a cut on an edge, between the wedges a (at its lower end vertex) and b (at the higher)
    kInside,    ///< in the interior of triangle a
    kInterior,  ///< on face a: one side of a cap region (if rough: its corner b), or a filled triangle
  };
  Kind kind;
  std::uint32_t a, b;
  friend bool operator==(const VertexSource&, const VertexSource&) = default;
};

/// Consecutive faces with the same material and, for cuts through several parts, the same part.
struct Run {
  std::uint32_t material, part, begin, end;
};

/// Working memory for assembling a fragment. Each thread reuses it for all its fragments, because
/// allocating it anew costs more than the work done in it.
struct Scratch {
  StampedMap at_position;  // CutVertexId -> its first vertex in the fragment
  StampedMap of_wedge;     // wedge -> vertex
  StampedMap on_face;      // CutVertexId -> vertex, within one flat face
  // Per vertex of the fragment.
  std::vector<CutVertexId> ids;
  std::vector<VertexSource> sources;
  std::vector<std::uint32_t> topology;
  std::vector<std::uint32_t>
      next;  // the next vertex at the same edge cut, of the same wedge or on the same face
  std::vector<Vec3d> points;
  std::vector<Run> runs;
  std::vector<IndexRange> caps, earlier_caps;

  std::size_t bytes() const {
    return at_position.bytes() + of_wedge.bytes() + on_face.bytes() +
           bytes_of_vectors(ids, sources, topology, next, points, runs, caps, earlier_caps);
  }
  void release() {
    at_position.release();
    of_wedge.release();
    on_face.release();
    release_vectors(ids, sources, topology, next, points, runs, caps, earlier_caps);
  }
};

class Assembler {
 public:
  Assembler(const RestrictedDiagram& diagram, const Execution& execution, Fragment& out)
      : d_(diagram), mesh_(*diagram.solid.source), execution_(execution), pacer_(execution), out_(out) {
    const Attributes& a = mesh_.attributes;
    plain_ = a.normals.empty() && a.tangents.empty() && a.uvs.empty() && a.colors.empty();
  }

  void run(const Piece& piece, Pivot pivot) {
    several_parts_ = !piece.part_owners.empty();
    collect_vertices(piece);
    points_.clear();
    points_.reserve(ids_.size());
    pacer_.each(0, ids_.size(), [&](std::size_t k) {
      points_.push_back(d_.point(ids_[k]));
      box_.add(points_.back());
    });
    write_attributes();
    measure();
    place(piece, pivot);
  }

 private:
  // -- vertices and triangles

  std::uint32_t material_of(FaceSource source) const {
    if (!is_cap(source)) return d_.solid.material[source];
    return d_.is_joint(d_.caps.regions[cap_region(source)]) ? kMortarMaterial : kInteriorMaterial;
  }

  /// Returns the part of a cut or of a cavity's wall if the piece has several parts, otherwise kNoIndex.
  std::uint32_t part_of_cut(FaceSource source, std::uint32_t material) const {
    if (!several_parts_ || !(is_of_cuts(material) || material == kCavityMaterial)) return kNoIndex;
    return part_of(source);
  }
  std::uint32_t part_of(FaceSource source) const {
    const std::uint32_t part =
        is_cap(source) ? d_.caps.regions[cap_region(source)].part : d_.solid.part[source];
    return d_.part_in_whole ? (*d_.part_in_whole)[part] : part;
  }

  // Sorts faces by material, and cuts also by part; otherwise keeps their order. Faces without a material
  // come after those with one, then cuts, then mortar.
  void find_runs_by_material(const std::vector<Face>& faces) {
    std::vector<Run>& runs = s_.runs;
    runs.clear();
    pacer_.each(0, faces.size(), [&](std::size_t n) {
      const auto f = static_cast<std::uint32_t>(n);
      const FaceSource source = faces[f].source;
      const std::uint32_t material = material_of(source);
      const std::uint32_t part = part_of_cut(source, material);
      if (runs.empty() || runs.back().material != material || runs.back().part != part)
        runs.push_back({material, part, f, f});
      ++runs.back().end;
    });
    const auto rank = [](std::uint32_t m) -> std::uint64_t {
      return m == kMortarMaterial ? 0x1'0000'0001 : m == kInteriorMaterial ? 0x1'0000'0000 : m;
    };
    const auto before = [&](const Run& x, const Run& y) {
      return x.material != y.material ? rank(x.material) < rank(y.material) : x.part < y.part;
    };
    if (!std::is_sorted(runs.begin(), runs.end(), before)) std::stable_sort(runs.begin(), runs.end(), before);
  }

  void collect_vertices(const Piece& piece) {
    s_.at_position.next_epoch(d_.vertex_count());
    s_.of_wedge.next_epoch(mesh_.positions.size());
    ids_.clear();
    sources_.clear();
    s_.topology.clear();
    s_.next.clear();
    s_.caps.clear();
    s_.earlier_caps.clear();
    out_.indices.resize(3 * piece.faces.size());
    std::uint32_t* index = out_.indices.data();
    find_runs_by_material(piece.faces);
    out_.primitives.reserve(2);
    for (const Run& run : s_.runs) {
      if (out_.primitives.empty() || out_.primitives.back().material != run.material ||
          out_.primitives.back().part != run.part)
        out_.primitives.push_back(
            {run.material, static_cast<std::uint32_t>(index - out_.indices.data()), 0, run.part});
      out_.primitives.back().index_count += 3 * (run.end - run.begin);
      const Face *face = piece.faces.data() + run.begin, *end = piece.faces.data() + run.end;
      if (several_parts_)
        for (const Face* f = face; f != end; ++f) out_.triangle_parts.push_back(part_of(f->source));
      if (is_of_cuts(run.material)) {
        FaceSource flat = kNoIndex;
        std::uint32_t nth = 0;  // number of the triangle in its region
        for (; face != end; ++face, ++nth) {
          pacer_.step();
          if (is_mirrored(face->source))
            add_cap(static_cast<std::uint32_t>(index - out_.indices.data()), s_.earlier_caps);
          // Cut faces of an earlier fracture have the source's attributes and precede the caps.
          if (has_wedges(face->source)) {
            for (const CutVertexId v : face->v) *index++ = exterior_vertex(v, face->source);
            continue;
          }
          if (is_cap(face->source)) add_cap(static_cast<std::uint32_t>(index - out_.indices.data()), s_.caps);
          // Regions of one facet share their plane but not their vertices. The faces of a region are
          // consecutive and in the order of its triangles.
          if (face->source != flat) {
            s_.on_face.next_epoch(d_.vertex_count());
            nth = 0;
          }
          flat = face->source;
          for (std::uint32_t k = 0; k < 3; ++k)
            *index++ = interior_vertex(face->v[k], flat, rough_ ? corner_of(flat, nth, k) : 0);
        }
      } else if (plain_) {
        pacer_.each(run.begin, run.end, [&](std::size_t f) {
          for (const CutVertexId v : piece.faces[f].v) *index++ = plain_vertex(v);
        });
      } else {
        pacer_.each(run.begin, run.end, [&](std::size_t f) {
          const Face& at = piece.faces[f];
          for (const CutVertexId v : at.v) *index++ = exterior_vertex(v, at.source);
        });
      }
    }
    out_.topology = s_.topology;
    out_.caps = s_.caps;
    out_.earlier_caps = s_.earlier_caps;
  }

  /// Notes that the triangle whose indices begin at `first` belongs to a cap.
  static void add_cap(std::uint32_t first, std::vector<IndexRange>& caps) {
    if (caps.empty() || caps.back().first + caps.back().count != first) caps.push_back({first, 0});
    caps.back().count += 3;
  }

  bool is_mirrored(FaceSource source) const {
    return !is_cap(source) && !d_.solid.mirrored.empty() && d_.solid.mirrored[source] != 0;
  }
  bool has_wedges(FaceSource source) const {
    return !is_cap(source) && (!plain_ || is_mirrored(source)) && d_.solid.wedges[source][0] != kNoIndex;
  }

  std::uint32_t add(CutVertexId v, const VertexSource& source) {
    const auto fresh = static_cast<std::uint32_t>(ids_.size());
    std::uint32_t& first = s_.at_position.slot(v);
    if (first == kNoIndex) first = fresh;
    ids_.push_back(v);
    sources_.push_back(source);
    s_.topology.push_back(first);
    return fresh;
  }

  void put_before(std::uint32_t fresh, std::uint32_t first) {
    s_.next.resize(fresh + 1, kNoIndex);
    s_.next[fresh] = first;
  }

  /// Returns the vertex for v on an interior face; rough cuts have one for each normal.
  std::uint32_t interior_vertex(CutVertexId v, FaceSource face, std::uint32_t corner) {
    const bool by_normal = rough_ && is_cap(face);
    std::uint32_t& first = s_.on_face.slot(v);
    for (std::uint32_t k = first; k != kNoIndex; k = k < s_.next.size() ? s_.next[k] : kNoIndex)
      if (!by_normal || d_.caps.normals[sources_[k].b] == d_.caps.normals[corner]) return k;
    const std::uint32_t fresh = add(v, {VertexSource::kInterior, face, corner});
    if (first != kNoIndex) put_before(fresh, first);
    return first = fresh;
  }

  /// Index into Caps::normals of corner k of the nth triangle of a cap region, as seen from this side.
  std::uint32_t corner_of(FaceSource face, std::uint32_t nth, std::uint32_t k) const {
    if (!is_cap(face)) return 0;
    const std::uint32_t triangle = d_.caps.regions[cap_region(face)].first_triangle + nth;
    return 3 * triangle + (cap_side(face) == 0 ? k : (3 - k) % 3);
  }

  // The interior comes last, so a vertex that is already at this position is an exterior one.
  std::uint32_t plain_vertex(CutVertexId v) {
    const std::uint32_t vertex = s_.at_position.slot(v);
    return vertex != kNoIndex ? vertex : add(v, {VertexSource::kPlain, 0, 0});
  }

  std::uint32_t exterior_vertex(CutVertexId v, std::uint32_t triangle) {
    const std::array<CutVertexId, 3> corners = d_.corners(triangle);
    const auto& wedges = d_.solid.wedges[triangle];
    if (v < d_.cuts.first_b()) {
      const std::uint32_t wedge = wedges[corners[0] == v ? 0 : corners[1] == v ? 1 : 2];
      // Usually a wedge has one vertex. If several fans of triangles share it, each has its own. If both
      // sides of a sheet share wedges in a file, the sheet's slab has them at its front and its back.
      std::uint32_t& first = s_.of_wedge.slot(wedge);
      for (std::uint32_t k = first; k != kNoIndex; k = k < s_.next.size() ? s_.next[k] : kNoIndex)
        if (ids_[k] == v) return k;
      const std::uint32_t fresh = add(v, {VertexSource::kWedge, wedge, 0});
      if (first != kNoIndex) put_before(fresh, first);
      return first = fresh;
    }
    if (v >= d_.cuts.first_c()) {  // inside this triangle only
      const std::uint32_t vertex = s_.at_position.slot(v);
      return vertex != kNoIndex ? vertex : add(v, {VertexSource::kInside, triangle, 0});
    }
    const auto [lo, hi] = edge_of(v);
    VertexSource source{VertexSource::kOnEdge, 0, 0};
    for (int k = 0; k < 3; ++k) {
      if (corners[k] == lo) source.a = wedges[k];
      if (corners[k] == hi) source.b = wedges[k];
    }
    // The triangles at an edge may have different wedges there.
    std::uint32_t last = kNoIndex;
    for (std::uint32_t k = s_.at_position.slot(v); k != kNoIndex;
         last = k, k = k < s_.next.size() ? s_.next[k] : kNoIndex)
      if (sources_[k] == source) return k;
    const std::uint32_t fresh = add(v, source);
    s_.next.resize(fresh + 1, kNoIndex);  // also covers `last`, which is an older vertex
    if (last != kNoIndex) s_.next[last] = fresh;
    return fresh;
  }

  std::array<CutVertexId, 2> edge_of(CutVertexId b) const {
    const auto& ends = d_.solid.edge_vertices[d_.cuts.edge_cuts[b - d_.cuts.first_b()].edge];
    return {cut_vertex(ends[0]), cut_vertex(ends[1])};
  }

  // -- attributes

  void write_attributes() {
    AttributeWriter writer(mesh_.attributes, out_.attributes, ids_.size());
    FlatFrame frame({0, 0, 1});
    FaceSource frame_of = kNoIndex;  // the vertices of a flat face are consecutive
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      pacer_.step();
      const VertexSource& s = sources_[k];
      switch (s.kind) {
        case VertexSource::kPlain:
          writer.blank();
          break;
        case VertexSource::kWedge:
          writer.copy(s.a);
          break;
        case VertexSource::kOnEdge: {
          const auto [lo, hi] = edge_of(ids_[k]);
          const double t = along(d_.point(lo), d_.point(hi), points_[k]);
          writer.blend({s.a, s.b, s.a}, {1 - t, t, 0});
          break;
        }
        case VertexSource::kInside:
          writer.blend(d_.solid.wedges[s.a], weights_in(s.a, points_[k]));
          break;
        case VertexSource::kInterior:
          if (s.a != frame_of) frame = FlatFrame(flat_normal(s.a), grain_at(s.a));
          frame_of = s.a;
          if (rough_ && is_cap(s.a)) {
            const Vec3d normal = (cap_side(s.a) == 0 ? 1.0 : -1.0) * to_double(d_.caps.normals[s.b]);
            writer.interior(frame, points_[k], &normal);
          } else {
            writer.interior(frame, points_[k]);
          }
          break;
      }
    }
  }

  std::optional<Vec3d> grain_at(FaceSource face) const {
    const CellMap& map = d_.diagram.map();
    if (!map || !is_cap(face)) return std::nullopt;
    return map.of_part(d_.caps.regions[cap_region(face)].part).grain;
  }

  Vec3d flat_normal(FaceSource face) const {
    if (is_cap(face)) {
      const CapRegion& r = d_.caps.regions[cap_region(face)];
      const Vec3d n = d_.diagram.facet_normal(r.lo, r.hi);
      return ((cap_side(face) == 0 ? 1.0 : -1.0) / length(n)) * n;
    }
    const std::array<CutVertexId, 3> v = d_.corners(face);
    const Vec3d n = cross(d_.point(v[1]) - d_.point(v[0]), d_.point(v[2]) - d_.point(v[0]));
    const double l = length(n);
    return l > 0 ? (1 / l) * n : Vec3d{0, 0, 1};
  }

  std::array<double, 3> weights_in(std::uint32_t t, const Vec3d& x) const {
    const std::array<CutVertexId, 3> v = d_.corners(t);
    return barycentric({d_.point(v[0]), d_.point(v[1]), d_.point(v[2])}, x);
  }

  // -- measurements and final positions

  void measure() {
    MassIntegral all(points_[out_.indices[0]]);
    std::uint32_t next = 0;
    const auto add_until = [&](std::uint32_t end) {
      const std::uint32_t* const index = out_.indices.data();
      const auto corner = [&](std::size_t k) { return &points_[index[k]]; };
      const std::size_t pairs = end > next ? (end - next) / 6 : 0;
      pacer_.each(0, pairs, [&](std::size_t pair) {
        const std::size_t k = next + 6 * pair;
        all.add_both({corner(k), corner(k + 1), corner(k + 2)},
                     {corner(k + 3), corner(k + 4), corner(k + 5)});
      });
      if (next + 6 * pairs < end) all.add(*corner(end - 3), *corner(end - 2), *corner(end - 1));
      next = std::max(next, end);
    };
    const auto first_cut = std::find_if(out_.primitives.begin(), out_.primitives.end(),
                                        [](const FragmentPrimitive& p) { return is_of_cuts(p.material); });
    add_until(first_cut != out_.primitives.end() ? first_cut->first_index
                                                 : static_cast<std::uint32_t>(out_.indices.size()));
    out_.exterior_area = all.area();
    double caps = 0;
    for (const IndexRange& range : out_.caps) {
      add_until(range.first);
      const double before = all.area();
      add_until(range.first + range.count);
      caps += all.area() - before;
    }
    add_until(static_cast<std::uint32_t>(out_.indices.size()));
    out_.surface_area = all.area() - caps;
    for (const IndexRange& range : out_.earlier_caps)
      for (std::uint32_t k = range.first; k < range.first + range.count; k += 3) {
        const Vec3d& a = points_[out_.indices[k]];
        out_.earlier_cap_area +=
            0.5 * length(cross(points_[out_.indices[k + 1]] - a, points_[out_.indices[k + 2]] - a));
      }
    out_.mass = all.result();
    out_.mass.volume = certain_volume(out_.mass.volume, points_, box_, out_.indices, pacer_);
  }

  /// Centre of mass on the seam lattice, in the box even if rounding moves a sliver's centre out of it.
  std::array<std::int32_t, 3> center_on_lattice(const Vec3d& step) const {
    std::array<std::int32_t, 3> center;
    for (int a = 0; a < 3; ++a)
      center[a] = static_cast<std::int32_t>(
          std::nearbyint(std::clamp(out_.mass.center_of_mass[a], box_.min[a], box_.max[a]) / step[a]));
    return center;
  }

  void place(const Piece& piece, Pivot where) {
    const SeamLattice& lattice = d_.positions.lattice;
    const Vec3d step = lattice.step();
    const std::array<std::int32_t, 3> center = center_on_lattice(step);
    const std::array<std::int32_t, 3> pivot =
        where == Pivot::kSource ? std::array<std::int32_t, 3>{} : center;
    out_.center = lattice.to_world(center);
    out_.pivot = lattice.to_world(pivot);
    const auto local = [&](CutVertexId v) -> Vec3f {
      if (v < d_.positions.first_constructed) {
        const Vec3d p = d_.point(v) - out_.pivot;
        return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
      }
      const auto& s = d_.positions.steps[v - d_.positions.first_constructed];
      return {static_cast<float>((s[0] - pivot[0]) * step.x), static_cast<float>((s[1] - pivot[1]) * step.y),
              static_cast<float>((s[2] - pivot[2]) * step.z)};
    };
    out_.positions.reserve(ids_.size());
    pacer_.each(0, ids_.size(), [&](std::size_t k) { out_.positions.push_back(local(ids_[k])); });
    if (rough_) return place_flat_bodies(piece, pivot);
    for (const std::vector<CutVertexId>& body : piece.bodies) {
      out_.bodies.emplace_back();
      pacer_.step(body.size());
      for (const CutVertexId v : body) out_.bodies.back().push_back(local(v));
    }
  }

  // Uses the points before roughening as bodies, because these lie in disjoint convex cells.
  void place_flat_bodies(const Piece& piece, const std::array<std::int32_t, 3>& pivot) {
    const Vec3d step = d_.positions.lattice.step();
    const auto& flat = d_.positions.flat_steps;
    const auto add_body = [&](const std::vector<CutVertexId>& body) {
      std::vector<Vec3f>& points = out_.bodies.emplace_back();
      pacer_.step(body.size());
      for (const CutVertexId v : body) {
        if (v < d_.positions.first_constructed) {
          const Vec3d p = d_.point(v) - out_.pivot;
          points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
        } else if (const std::size_t k = v - d_.positions.first_constructed; k < flat.size()) {
          points.push_back({static_cast<float>((flat[k][0] - pivot[0]) * step.x),
                            static_cast<float>((flat[k][1] - pivot[1]) * step.y),
                            static_cast<float>((flat[k][2] - pivot[2]) * step.z)});
        }
      }
    };
    for (const std::vector<CutVertexId>& body : piece.bodies) add_body(body);
    if (!piece.bodies.empty()) return;
    std::vector<CutVertexId> all = ids_;
    sort_with_polls(execution_, all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    add_body(all);
  }

  const RestrictedDiagram& d_;
  const Mesh& mesh_;
  const Execution& execution_;
  Pacer pacer_;
  Fragment& out_;
  const bool rough_ = d_.positions.are_rough();
  bool plain_;
  bool several_parts_ = false;
  Box box_;  // of the points
  Scratch& s_ = thread_scratch<Scratch>();
  std::vector<CutVertexId>& ids_ = s_.ids;
  std::vector<VertexSource>& sources_ = s_.sources;
  std::vector<Vec3d>& points_ = s_.points;
};

}  // namespace

Fragment assemble(const RestrictedDiagram& diagram, const Ownership& ownership, const Piece& piece,
                  Pivot pivot, const Execution& execution) {
  Fragment out;
  for (const std::uint32_t o : piece.owners)
    out.sites.insert(out.sites.end(), ownership.sites_of_owner[o].begin(), ownership.sites_of_owner[o].end());
  sort_with_polls(execution, out.sites.begin(), out.sites.end());
  const auto in_whole = [&](std::uint32_t part) {
    return diagram.part_in_whole ? (*diagram.part_in_whole)[part] : part;
  };
  out.part = out.source_part = in_whole(piece.part);
  for (const PartOwner& share : piece.part_owners)
    for (const SiteId s : ownership.sites_of_owner[share.owner])
      out.part_cells.push_back({in_whole(share.part), s});
  sort_with_polls(execution, out.part_cells.begin(), out.part_cells.end());
  out.node = diagram.solid.parts[piece.part].node;
  const auto add_nodes = [&](std::uint32_t part) {
    out.nodes.add(diagram.solid.parts[part].node);
    out.nodes.add(diagram.solid.parts[part].nodes);
  };
  add_nodes(piece.part);
  for (const PartOwner& share : piece.part_owners) add_nodes(share.part);
  if (piece.faces.empty())
    return out;  // the surfaces of the united pieces cancel: the fragment is empty and will be dropped
  Assembler(diagram, execution, out).run(piece, pivot);
  out.cap_sum = mirror_sum(out, execution);
  out.open_edges = open_edges(out, execution);
  if (out.open_edges > 0 && split_repeated_edges(out, execution)) out.open_edges = open_edges(out, execution);
  return out;
}

}  // namespace fracture
