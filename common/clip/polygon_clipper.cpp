#include "common/clip/polygon_clipper.hpp"

#include <algorithm>
#include <string>

#include "common/exact/side.hpp"

namespace fracture {

void PolygonClipper::divide(std::uint32_t t) {
  triangle_ = t;
  if (divide_between_two(t)) return;

  for (int k = 0; k < 3; ++k) corner_[k] = to_double(solid_.positions[solid_.triangles[t][k]]);
  first_c_ = out_.triangle_cuts.size();
  cells_.clear();
  for (const std::uint32_t v : solid_.triangles[t])
    if (std::find(cells_.begin(), cells_.end(), cuts_.label[v]) == cells_.end())
      cells_.push_back(cuts_.label[v]);
  // The cells' parts tile the triangle, and the diagram is generic: parts that meet share a whole segment. So
  // every cell is found across some bisector side of another.
  const std::size_t first_polygon = out_.polygons.size();
  for (std::size_t n = 0; n < cells_.size(); ++n) clip_to_cell(cells_[n]);
  std::sort(out_.polygons.begin() + static_cast<std::ptrdiff_t>(first_polygon), out_.polygons.end(),
            [](const CutPolygon& a, const CutPolygon& b) { return a.cell < b.cell; });
}

// The common case on fine meshes: two edges of the triangle are cut once, by the same bisector, and the third
// is not. The corners of both parts lie in their (closed, convex) cell, hence so do the parts, and no other
// cell takes part.
bool PolygonClipper::divide_between_two(std::uint32_t t) {
  const auto& v = solid_.triangles[t];
  const std::array<SiteId, 3> label{cuts_.label[v[0]], cuts_.label[v[1]], cuts_.label[v[2]]};
  int apex;  // the corner alone in its cell
  if (label[1] == label[2])
    apex = 0;
  else if (label[2] == label[0])
    apex = 1;
  else if (label[0] == label[1])
    apex = 2;
  else
    return false;
  const int a = apex, b = (apex + 1) % 3, c = (apex + 2) % 3;
  const std::uint32_t ab = solid_.edges[t][a], ca = solid_.edges[t][c];
  const auto& begin = cuts_.edge_cut_begin;
  if (begin[ab + 1] - begin[ab] != 1 || begin[ca + 1] - begin[ca] != 1) return false;

  const VertexId on_ab = cuts_.first_b() + begin[ab], on_ca = cuts_.first_b() + begin[ca];
  const auto side = [](int k) { return kMeshEdge + static_cast<PolygonSide>(k); };
  const auto emit = [&](SiteId cell, std::initializer_list<VertexId> vertices,
                        std::initializer_list<PolygonSide> sides) {
    out_.polygons.push_back({t, cell, static_cast<std::uint32_t>(out_.vertices.size()),
                             static_cast<std::uint32_t>(vertices.size())});
    out_.vertices.insert(out_.vertices.end(), vertices);
    out_.sides.insert(out_.sides.end(), sides);
  };
  const auto tip = [&] { emit(label[a], {on_ab, on_ca, v[a]}, {label[b], side(c), side(a)}); };
  const auto rest = [&] {
    emit(label[b], {on_ca, on_ab, v[b], v[c]}, {label[a], side(a), side(b), side(c)});
  };
  if (label[a] < label[b]) {
    tip();
    rest();
  } else {
    rest();
    tip();
  }
  return true;
}

void PolygonClipper::clip_to_cell(SiteId cell) {
  polygon_.assign({kMeshEdge, kMeshEdge + 1, kMeshEdge + 2});
  for (const Bisector& bisector : diagram_.bisectors(cell)) {
    // Most bisectors leave the whole triangle on the cell's side: three dot products tell.
    bool inside = true;
    for (const Vec3d& q : corner_)
      if (!(diagram_.value(cell, bisector, q) > bisector.error)) {
        inside = false;
        break;
      }
    if (inside) continue;

    // Corner m lies between side m-1 and side m.
    const std::size_t n = polygon_.size();
    sign_.resize(n);
    bool any_out = false, any_in = false;
    for (std::size_t m = 0; m < n; ++m) {
      sign_[m] = side_of_corner(cell, bisector, polygon_[(m + n - 1) % n], polygon_[m]);
      (sign_[m] > 0 ? any_in : any_out) = true;
    }
    if (!any_out) continue;
    if (!any_in)
      throw InternalError("triangle " + std::to_string(triangle_) + " misses cell " + std::to_string(cell));
    clipped_.clear();
    for (std::size_t m = 0; m < n; ++m) {
      const bool in = sign_[m] > 0, next_in = sign_[(m + 1) % n] > 0;
      if (in || next_in) clipped_.push_back(polygon_[m]);
      if (in && !next_in) clipped_.push_back(bisector.neighbor);
    }
    polygon_.swap(clipped_);
  }

  // Whatever cells share the rest of the triangle, and whichever bisector cut first.
  std::rotate(polygon_.begin(), std::min_element(polygon_.begin(), polygon_.end()), polygon_.end());
  const auto first = static_cast<std::uint32_t>(out_.vertices.size());
  const std::size_t n = polygon_.size();
  for (std::size_t m = 0; m < n; ++m) {
    out_.vertices.push_back(name_corner(cell, polygon_[(m + n - 1) % n], polygon_[m]));
    out_.sides.push_back(polygon_[m]);
    if (!is_mesh_edge(polygon_[m]) && std::find(cells_.begin(), cells_.end(), polygon_[m]) == cells_.end()) {
      if (diagram_.dual().is_corner(polygon_[m])) throw InternalError("a corner's cell meets the mesh");
      cells_.push_back(polygon_[m]);
    }
  }
  out_.polygons.push_back({triangle_, cell, first, static_cast<std::uint32_t>(n)});
}

int PolygonClipper::side_of_corner(SiteId cell, const Bisector& bisector, PolygonSide before,
                                   PolygonSide after) const {
  const auto site = [&](SiteId s) -> const Vec3d& { return diagram_.site(s); };
  if (is_mesh_edge(before) && is_mesh_edge(after))
    return diagram_.side(cell, bisector, corner_[after - kMeshEdge]);
  if (!is_mesh_edge(before) && !is_mesh_edge(after))
    return exact::side3(site(cell), site(bisector.neighbor), corner_[0], corner_[1], corner_[2], site(before),
                        site(after));
  const PolygonSide edge = is_mesh_edge(before) ? before : after;
  const SiteId other = is_mesh_edge(before) ? after : before;
  const auto k = edge - kMeshEdge;
  return exact::side2(site(cell), site(bisector.neighbor), corner_[k], corner_[(k + 1) % 3], site(other));
}

VertexId PolygonClipper::name_corner(SiteId cell, PolygonSide before, PolygonSide after) {
  if (is_mesh_edge(before) && is_mesh_edge(after)) return solid_.triangles[triangle_][after - kMeshEdge];
  if (is_mesh_edge(before)) return edge_cut(static_cast<int>(before - kMeshEdge), cell, after);
  if (is_mesh_edge(after)) return edge_cut(static_cast<int>(after - kMeshEdge), cell, before);
  std::array<SiteId, 3> sites{cell, before, after};
  std::sort(sites.begin(), sites.end());
  for (std::size_t c = first_c_; c < out_.triangle_cuts.size(); ++c)
    if (out_.triangle_cuts[c].sites == sites) return kBlockLocalC | static_cast<VertexId>(c);
  out_.triangle_cuts.push_back({triangle_, sites});
  return kBlockLocalC | static_cast<VertexId>(out_.triangle_cuts.size() - 1);
}

VertexId PolygonClipper::edge_cut(int k, SiteId i, SiteId j) const {
  const std::uint32_t e = solid_.edges[triangle_][k];
  for (std::uint32_t n = cuts_.edge_cut_begin[e]; n < cuts_.edge_cut_begin[e + 1]; ++n) {
    const EdgeCut& c = cuts_.edge_cuts[n];
    if ((c.from == i && c.to == j) || (c.from == j && c.to == i)) return cuts_.first_b() + n;
  }
  throw InternalError("edge " + std::to_string(e) + " has no cut between cells " + std::to_string(i) +
                      " and " + std::to_string(j));
}

}  // namespace fracture
