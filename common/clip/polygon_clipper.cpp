#include "common/clip/polygon_clipper.hpp"

#include <algorithm>
#include <string>

#include "common/exact/side.hpp"

namespace fracture {
namespace {

using clip_detail::Corner;
using clip_detail::Line;

/// Up to this many items, a linear search is faster than a lookup.
constexpr std::size_t kFew = 16;

/// Number of polygons reported at a time.
constexpr std::size_t kCountedTogether = 1024;

/// Marks keys of TripleTable for cells, as opposed to C vertices and cuts of an edge.
constexpr std::uint32_t kCellKey = kNoSite;

}  // namespace

void PolygonClipper::count_polygons() {
  execution_.made(Product::kPolygons, out_.polygons.size() - counted_);
  counted_ = out_.polygons.size();
}

void PolygonClipper::divide(std::uint32_t t) {
  pacer_.step(8);
  triangle_ = t;
  if (divide_between_two(t)) return;

  for (int k = 0; k < 3; ++k) corner_[k] = to_double(solid_.positions[solid_.triangles[t][k]]);
  first_c_ = out_.triangle_cuts.size();
  names_.clear();
  for (unsigned k = 0; k < 3; ++k) {
    const std::uint32_t e = solid_.edges[t][k], end = cuts_.edge_cut_begin[e + 1];
    std::uint32_t n = cuts_.edge_cut_begin[e];
    if (end - n <= kFew) continue;
    for (; n < end; ++n) {
      const EdgeCut& c = cuts_.edge_cuts[n];
      names_.insert(std::min(c.from, c.to), std::max(c.from, c.to), kMeshEdge + k, n);
      pacer_.step();
    }
  }
  cells_.clear();
  for (const VertexId v : solid_.triangles[t]) meet_cell(cuts_.label[v]);
  // The regions of the cells tile the triangle. Because the diagram is generic, regions that meet share a
  // whole segment, so every cell is found across a bisector side of another cell.
  const std::size_t first_polygon = out_.polygons.size(), first_vertex = out_.vertices.size();
  for (std::size_t n = 0; n < cells_.size(); ++n) {
    clip_to_cell(cells_[n]);
    if (out_.polygons.size() - counted_ >= kCountedTogether) count_polygons();
  }
  sort_with_polls(execution_, out_.polygons.begin() + static_cast<std::ptrdiff_t>(first_polygon),
                  out_.polygons.end(),
                  [](const CutPolygon& a, const CutPolygon& b) { return a.cell < b.cell; });
  number_cuts_by_sites(first_vertex);
}

void PolygonClipper::meet_cell(SiteId cell) {
  if (cells_.size() <= kFew) {
    if (std::find(cells_.begin(), cells_.end(), cell) != cells_.end()) return;
    cells_.push_back(cell);
    if (cells_.size() > kFew)
      for (const SiteId c : cells_) names_.insert(c, kCellKey, kCellKey, 0);
    return;
  }
  if (names_.find(cell, kCellKey, kCellKey) != TripleTable::kNone) return;
  names_.insert(cell, kCellKey, kCellKey, 0);
  cells_.push_back(cell);
}

// The common case on fine meshes: the same bisector cuts two edges of the triangle once each, and the third
// edge is not cut. The corners of both regions are in their (closed, convex) cells, so the regions are too,
// and no other cell is involved.
bool PolygonClipper::divide_between_two(std::uint32_t t) {
  const auto& v = solid_.triangles[t];
  const std::array<SiteId, 3> label{cuts_.label[v[0]], cuts_.label[v[1]], cuts_.label[v[2]]};
  int apex;  // the corner that is alone in its cell
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

  const CutVertexId on_ab{cuts_.first_b() + begin[ab]}, on_ca{cuts_.first_b() + begin[ca]};
  const auto side = [](int k) { return kMeshEdge + static_cast<PolygonSide>(k); };
  const auto emit = [&](SiteId cell, std::initializer_list<CutVertexId> vertices,
                        std::initializer_list<PolygonSide> sides) {
    out_.polygons.push_back({t, cell, static_cast<std::uint32_t>(out_.vertices.size()),
                             static_cast<std::uint32_t>(vertices.size())});
    out_.vertices.insert(out_.vertices.end(), vertices);
    out_.sides.insert(out_.sides.end(), sides);
  };
  const auto tip = [&] { emit(label[a], {on_ab, on_ca, cut_vertex(v[a])}, {label[b], side(c), side(a)}); };
  const auto rest = [&] {
    emit(label[b], {on_ca, on_ab, cut_vertex(v[b]), cut_vertex(v[c])}, {label[a], side(a), side(b), side(c)});
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

void PolygonClipper::start_polygon() {
  polygon_.clear();
  for (unsigned k = 0; k < 3; ++k)
    polygon_.push_back(
        {kMeshEdge + k, Line::of_edge(k), Corner::of_triangle(k), true, (k + 2) % 3, (k + 1) % 3, kNoIndex});
}

void PolygonClipper::clip_to_cell(SiteId cell) {
  start_polygon();
  if (diagram_.has_many_neighbors(cell))
    clip_by_search(cell);
  else
    clip_by_all(cell);
  name_polygon(cell);
}

Line PolygonClipper::line_of(SiteId cell, const Bisector& bisector) const {
  return Line::of_values(
      {diagram_.value(cell, bisector, corner_[0]), diagram_.value(cell, bisector, corner_[1]),
       diagram_.value(cell, bisector, corner_[2])},
      bisector.error);
}

/// Whether all corners are certainly on the cell's side. This is the result for most bisectors that cut the
/// triangle, once the nearest ones have been applied.
bool PolygonClipper::leaves_all(const Line& line) {
  const Line::Bounds bounds = line.bounds();
  const Side* before = &polygon_.back();
  for (Side& at : polygon_) {
    if (!at.corner_is_known) {
      at.corner = Corner::meet(before->line, at.line);
      at.corner_is_known = true;
    }
    if (!at.corner.is_inside(line, bounds)) return false;
    before = &at;
  }
  return true;
}

void PolygonClipper::clip_by_all(SiteId cell) {
  const auto bisectors = diagram_.bisectors(cell);
  pacer_.step(4 * bisectors.size());
  for (const Bisector& bisector : bisectors) {
    // Most bisectors leave the whole triangle on the cell's side, which three dot products show.
    const Line line = line_of(cell, bisector);
    if (line.value[0] > line.error && line.value[1] > line.error && line.value[2] > line.error) continue;

    const std::size_t n = polygon_.size();
    if (leaves_all(line)) continue;
    sign_.resize(n);
    bool any_out = false, any_in = false;
    for (std::size_t m = 0; m < n; ++m) {
      sign_[m] = side_of_corner(cell, bisector, line, polygon_[m == 0 ? n - 1 : m - 1], polygon_[m]);
      (sign_[m] > 0 ? any_in : any_out) = true;
    }
    if (!any_out) continue;
    if (!any_in)
      throw InternalError("triangle " + std::to_string(triangle_) + " misses cell " + std::to_string(cell));
    clipped_.clear();
    for (std::size_t m = 0; m < n; ++m) {
      const bool in = sign_[m] > 0, next_in = sign_[m + 1 < n ? m + 1 : 0] > 0;
      if (in || next_in) {
        clipped_.push_back(polygon_[m]);
        clipped_.back().corner_is_known &= in;
      }
      if (in && !next_in) clipped_.push_back({bisector.neighbor, line, {}, false, 0, 0, 0});
    }
    polygon_.swap(clipped_);
  }
}

// For a cell with many neighbours. Cuts off a corner that is beyond some bisector, with all neighbours that
// are beyond it, until no such corner is left. Each time, uses the bisector through which the ray from the
// site leaves the cell, so that few cuts are cut off again.
void PolygonClipper::clip_by_search(SiteId cell) {
  if (ray_cell_ != cell) ray_ = 0;
  ray_cell_ = cell;
  unproven_ = {0, 1, 2};
  while (!unproven_.empty()) {
    const std::uint32_t m = unproven_.back();
    const Bisector* bisector = polygon_[m].after == kNoIndex ? nullptr : find_violated(cell, m);
    if (!bisector)  // proven, or cut off in the meantime
      unproven_.pop_back();
    else if (!cut_around(cell, *bisector, m))
      throw InternalError("triangle " + std::to_string(triangle_) + " misses cell " + std::to_string(cell));
  }
  // The remaining sides, in order.
  clipped_.clear();
  std::uint32_t first = 0;
  while (polygon_[first].after == kNoIndex) ++first;
  std::uint32_t m = first;
  do {
    clipped_.push_back(polygon_[m]);
    m = polygon_[m].after;
  } while (m != first);
  polygon_.swap(clipped_);
}

/// A bisector that corner m is beyond; null if there is none.
const Bisector* PolygonClipper::find_violated(SiteId cell, std::uint32_t m) {
  Side& at = polygon_[m];
  const Side& before = polygon_[at.before];
  if (!at.corner_is_known) {
    at.corner = Corner::meet(before.line, at.line);
    at.corner_is_known = true;
  }
  if (is_mesh_edge(before.side) && is_mesh_edge(at.side) &&
      cuts_.label[solid_.triangles[triangle_][at.side - kMeshEdge]] == cell)
    return nullptr;
  if (at.corner.sum > 0) {
    std::uint32_t on[2];
    std::size_t n = 0;
    if (!is_mesh_edge(before.side)) on[n++] = before.facet;
    if (!is_mesh_edge(at.side)) on[n++] = at.facet;
    std::uint64_t looked_at = 0;
    const auto bisectors = diagram_.bisectors(cell);
    const auto answer = diagram_.neighborhood(cell).shoot_ray(
        bisectors, [&](const Bisector& b) { return at.corner.value(line_of(cell, b)); },
        std::span<const std::uint32_t>(on, n), ray_, looked_at);
    pacer_.step(looked_at);
    if (answer == Neighborhood::RayAnswer::kInside) return nullptr;
    if (answer == Neighborhood::RayAnswer::kOutside) return &bisectors[ray_];
  }
  return find_violated_by_tree(cell, before, at);
}

const Bisector* PolygonClipper::find_violated_by_tree(SiteId cell, const Side& before, const Side& at) {
  const Corner::Place place = at.corner.place(corner_);
  const Bisector* found = nullptr;
  doubts_.clear();
  double radius2 = diagram_.reach2(cell, place.at, place.off);
  diagram_.visit_near(cell, place.at, radius2, [&](const Bisector& b, double distance2) {
    pacer_.step();
    if (b.neighbor == at.side || b.neighbor == before.side) return radius2;
    const int side = at.corner.side(line_of(cell, b));
    if (side == 0) doubts_.push_back(&b);
    if (side < 0) {
      found = &b;
      radius2 = std::min(radius2, distance2);
    }
    return radius2;
  });
  if (found) return found;
  for (const Bisector* b : doubts_) {
    pacer_.step(16);
    if (side_exactly(cell, *b, before.side, at.side) < 0) return b;
  }
  return nullptr;
}

/// Cuts off the corners beyond the bisector: corner m and its neighbours, which are consecutive because the
/// polygon is convex. Returns false if no corner would be left.
bool PolygonClipper::cut_around(SiteId cell, const Bisector& bisector, std::uint32_t m) {
  const Line line = line_of(cell, bisector);
  const auto is_out = [&](std::uint32_t k) {
    pacer_.step();
    return side_of_corner(cell, bisector, line, polygon_[polygon_[k].before], polygon_[k]) < 0;
  };
  std::uint32_t first = m, last = m;
  for (;;) {
    const std::uint32_t k = polygon_[first].before;
    if (k == last) return false;
    if (!is_out(k)) break;
    first = k;
  }
  for (;;) {
    const std::uint32_t k = polygon_[last].after;
    if (k == polygon_[first].before || !is_out(k)) break;
    last = k;
  }
  // The side before the first of these corners and the side after the last one are shortened.
  const std::uint32_t from = polygon_[first].before, added = static_cast<std::uint32_t>(polygon_.size());
  for (std::uint32_t k = first; k != last;) {
    const std::uint32_t next = polygon_[k].after;
    polygon_[k].after = kNoIndex;
    k = next;
  }
  const auto facet = static_cast<std::uint32_t>(&bisector - diagram_.bisectors(cell).data());
  polygon_.push_back({bisector.neighbor, line, {}, false, from, last, facet});
  polygon_[from].after = added;
  polygon_[last].before = added;
  polygon_[last].corner_is_known = false;
  unproven_.push_back(added);
  if (last != m) unproven_.push_back(last);
  return true;
}

int PolygonClipper::side_of_corner(SiteId cell, const Bisector& bisector, const Line& line,
                                   const Side& before, Side& after) const {
  if (!after.corner_is_known) {
    after.corner = Corner::meet(before.line, after.line);
    after.corner_is_known = true;
  }
  if (const int side = after.corner.side(line)) return side;
  return side_exactly(cell, bisector, before.side, after.side);
}

int PolygonClipper::side_exactly(SiteId cell, const Bisector& bisector, PolygonSide before,
                                 PolygonSide after) const {
  const auto site = [&](SiteId s) -> const Vec3d& { return diagram_.site(s); };
  if (is_mesh_edge(before) && is_mesh_edge(after))
    return exact::side1(site(cell), site(bisector.neighbor), corner_[after - kMeshEdge]);
  if (!is_mesh_edge(before) && !is_mesh_edge(after))
    return exact::side3(site(cell), site(bisector.neighbor), corner_[0], corner_[1], corner_[2],
                        site(SiteId{before}), site(SiteId{after}));
  const PolygonSide edge = is_mesh_edge(before) ? before : after;
  const SiteId other{is_mesh_edge(before) ? after : before};
  const auto k = edge - kMeshEdge;
  return exact::side2(site(cell), site(bisector.neighbor), corner_[k], corner_[(k + 1) % 3], site(other));
}

void PolygonClipper::name_polygon(SiteId cell) {
  // The name must not depend on which cells share the rest of the triangle, or which bisector cut first.
  const std::size_t n = polygon_.size();
  std::size_t lowest = 0;
  for (std::size_t m = 1; m < n; ++m)
    if (polygon_[m].side < polygon_[lowest].side) lowest = m;
  const auto first = static_cast<std::uint32_t>(out_.vertices.size());
  PolygonSide before = polygon_[lowest == 0 ? n - 1 : lowest - 1].side;
  for (std::size_t m = 0; m < n; ++m) {
    pacer_.step();
    const PolygonSide side = polygon_[lowest + m < n ? lowest + m : lowest + m - n].side;
    out_.vertices.push_back(name_corner(cell, before, side));
    out_.sides.push_back(side);
    before = side;
    if (is_mesh_edge(side)) continue;
    const SiteId neighbor{side};
    if (diagram_.dual().is_corner(neighbor)) throw InternalError("a corner's cell meets the mesh");
    meet_cell(neighbor);
  }
  out_.polygons.push_back({triangle_, cell, first, static_cast<std::uint32_t>(n)});
}

CutVertexId PolygonClipper::name_corner(SiteId cell, PolygonSide before, PolygonSide after) {
  if (is_mesh_edge(before) && is_mesh_edge(after))
    return cut_vertex(solid_.triangles[triangle_][after - kMeshEdge]);
  if (is_mesh_edge(before)) return edge_cut(static_cast<int>(before - kMeshEdge), cell, SiteId{after});
  if (is_mesh_edge(after)) return edge_cut(static_cast<int>(after - kMeshEdge), cell, SiteId{before});
  std::array<SiteId, 3> sites{cell, SiteId{before}, SiteId{after}};
  std::sort(sites.begin(), sites.end());
  const std::size_t count = out_.triangle_cuts.size() - first_c_;
  if (count <= kFew) {
    for (std::size_t c = first_c_; c < out_.triangle_cuts.size(); ++c)
      if (out_.triangle_cuts[c].sites == sites) return CutVertexId{kBlockLocalC | c};
    if (count == kFew)
      for (std::size_t c = first_c_; c < out_.triangle_cuts.size(); ++c) {
        const auto& s = out_.triangle_cuts[c].sites;
        names_.insert(s[0], s[1], s[2], static_cast<std::uint32_t>(c));
      }
  } else if (const std::uint32_t c = names_.find(sites[0], sites[1], sites[2]); c != TripleTable::kNone) {
    return CutVertexId{kBlockLocalC | c};
  }
  const auto fresh = static_cast<std::uint32_t>(out_.triangle_cuts.size());
  if (count >= kFew) names_.insert(sites[0], sites[1], sites[2], fresh);
  out_.triangle_cuts.push_back({triangle_, sites});
  return CutVertexId{kBlockLocalC | fresh};
}

CutVertexId PolygonClipper::edge_cut(int k, SiteId i, SiteId j) const {
  const std::uint32_t e = solid_.edges[triangle_][k];
  const std::uint32_t begin = cuts_.edge_cut_begin[e], end = cuts_.edge_cut_begin[e + 1];
  if (end - begin > kFew) {
    const std::uint32_t n =
        names_.find(std::min(i, j), std::max(i, j), kMeshEdge + static_cast<PolygonSide>(k));
    if (n != TripleTable::kNone) return CutVertexId{cuts_.first_b() + n};
  } else {
    for (std::uint32_t n = begin; n < end; ++n) {
      const EdgeCut& c = cuts_.edge_cuts[n];
      if ((c.from == i && c.to == j) || (c.from == j && c.to == i)) return CutVertexId{cuts_.first_b() + n};
    }
  }
  throw InternalError("edge " + std::to_string(e) + " has no cut between cells " + std::to_string(i) +
                      " and " + std::to_string(j));
}

}  // namespace fracture
