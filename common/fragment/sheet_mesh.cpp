#include "common/fragment/sheet_mesh.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "common/base/pacer.hpp"
#include "common/fragment/cut_weights.hpp"
#include "common/fragment/fragment_mesh.hpp"
#include "common/fragment/vertex_attributes.hpp"

namespace fracture {
namespace {

/// A vertex of the mesh: a vertex of the cut sheet, and what its attributes come from. `a`: the wedge at an input
/// vertex, the wedge at the lower end of an edge, or the triangle for a point inside it. `b`: the wedge at the
/// higher end of the edge, otherwise kNoIndex.
struct Corner {
  CutVertexId vertex;
  std::uint32_t a, b;
  auto operator<=>(const Corner&) const = default;
};

class SheetMesh {
 public:
  SheetMesh(const RestrictedDiagram& sheets, const Vec3d& pivot, const Execution& execution)
      : d_(sheets), pivot_(pivot), pacer_(execution) {}

  Fragment make(std::span<const Face> faces) {
    std::vector<const Face*> sorted;
    sorted.reserve(faces.size());
    for (const Face& face : faces) sorted.push_back(&face);
    std::stable_sort(sorted.begin(), sorted.end(), [&](const Face* x, const Face* y) {
      return d_.solid.material[x->source] < d_.solid.material[y->source];  // none comes last
    });
    for (const Face* face : sorted) {
      pacer_.step(16);
      const std::uint32_t material = d_.solid.material[face->source];
      if (out_.primitives.empty() || out_.primitives.back().material != material)
        out_.primitives.push_back({material, static_cast<std::uint32_t>(out_.indices.size()), 0});
      out_.primitives.back().index_count += 3;
      for (const CutVertexId v : face->v) out_.indices.push_back(index_of(corner_of(v, face->source)));
    }
    write_vertices();
    return std::move(out_);
  }

 private:
  Corner corner_of(CutVertexId v, std::uint32_t triangle) const {
    const std::array<CutVertexId, 3> corners = d_.corners(triangle);
    const auto& wedges = d_.solid.wedges[triangle];
    if (v >= d_.cuts.first_c()) return {v, triangle, kNoIndex};
    if (v < d_.cuts.first_b()) return {v, wedges[corners[0] == v ? 0 : corners[1] == v ? 1 : 2], kNoIndex};
    const auto& [low, high] = edge_of(v);
    Corner at{v, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      if (corners[k] == cut_vertex(low)) at.a = wedges[k];
      if (corners[k] == cut_vertex(high)) at.b = wedges[k];
    }
    return at;
  }

  const std::array<VertexId, 2>& edge_of(CutVertexId v) const {
    return d_.solid.edge_vertices[d_.cuts.edge_cuts[v - d_.cuts.first_b()].edge];
  }

  std::uint32_t index_of(const Corner& corner) {
    const auto [at, is_new] = index_.try_emplace(corner, static_cast<std::uint32_t>(corners_.size()));
    if (is_new) corners_.push_back(corner);
    return at->second;
  }

  Vec3f local(CutVertexId v) const {
    const VertexPositions& positions = d_.positions;
    const Vec3d world = v < positions.first_constructed
                            ? to_double(d_.solid.positions[v])
                            : positions.lattice.to_world(positions.steps[v - positions.first_constructed]);
    const Vec3d p = world - pivot_;
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }

  void write_vertices() {
    AttributeWriter writer(d_.solid.source->attributes, out_.attributes, corners_.size());
    out_.positions.reserve(corners_.size());
    for (const Corner& c : corners_) {
      pacer_.step(4);
      out_.positions.push_back(local(c.vertex));
      if (c.vertex < d_.cuts.first_b()) {
        writer.copy(c.a);
      } else if (c.vertex >= d_.cuts.first_c()) {
        const std::array<CutVertexId, 3> v = d_.corners(c.a);
        writer.blend(d_.solid.wedges[c.a],
                     barycentric({d_.point(v[0]), d_.point(v[1]), d_.point(v[2])}, d_.point(c.vertex)));
      } else {
        const auto& [low, high] = edge_of(c.vertex);
        const double t = along(d_.point(cut_vertex(low)), d_.point(cut_vertex(high)), d_.point(c.vertex));
        writer.blend({c.a, c.b, c.a}, {1 - t, t, 0});
      }
    }
  }

  const RestrictedDiagram& d_;
  const Vec3d pivot_;
  Pacer pacer_;
  Fragment out_;
  std::vector<Corner> corners_;
  std::map<Corner, std::uint32_t> index_;
};

}  // namespace

Fragment sheet_mesh(const RestrictedDiagram& sheets, std::span<const Face> faces, const Vec3d& pivot,
                    const Execution& execution) {
  return SheetMesh(sheets, pivot, execution).make(faces);
}

Mesh mesh_of_sheet(const FragmentSet& set, const Fragment& f, const Execution& execution) {
  FragmentSet alone;
  alone.source = set.source;
  Fragment& copy = alone.fragments.emplace_back(*f.sheet);
  copy.pivot = f.pivot;
  copy.node = f.node;
  return fragment_mesh(alone, 0, execution);
}

}  // namespace fracture
