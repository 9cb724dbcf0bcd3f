#include "common/physics/polyhedron.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/id.hpp"

namespace fracture {
double volume_of(const Polyhedron& solid, Pacer& pacer) {
  double sum = 0;
  std::size_t first = 0;
  for (const Polyhedron::Face& face : solid.faces) {
    pacer.step(1 + face.end - first);
    const Vec3d foot = solid.points[solid.edges[first].from] - solid.points[0];
    for (; first < face.end; ++first) {
      const auto [from, to] = solid.edges[first];
      sum += dot(foot, cross(solid.points[from] - solid.points[0], solid.points[to] - solid.points[0]));
    }
  }
  return sum / 6;
}

void PolyhedronCutter::Side::clear() {
  solid.clear();
  cap.clear();
}

void PolyhedronCutter::divide_points(const Polyhedron& whole, double rounding, Pacer& pacer) {
  height_.resize(whole.points.size());
  number_.resize(whole.points.size());
  crossed_.assign(whole.points.size(), kNoIndex);
  pacer.each(0, whole.points.size(), [&](std::size_t k) {
    height_[k] = dot(plane_.normal, whole.points[k]) - plane_.offset;
    std::vector<Vec3d>& to = sides_[height_[k] >= -rounding].solid.points;
    number_[k] = static_cast<std::uint32_t>(to.size());
    to.push_back(whole.points[k]);
  });
}

/// Above the plane, a corner on the plane is its own crossing. Below, each edge that ends there has its own crossing, so two
/// bodies that touch at a corner on the plane stay separate.
std::uint32_t PolyhedronCutter::crossing(const Polyhedron& whole, std::uint32_t a, std::uint32_t b,
                                         double rounding) {
  const std::uint32_t lo = std::min(a, b), hi = std::max(a, b);
  for (std::uint32_t c = crossed_[lo]; c != kNoIndex; c = crossings_[c].next)
    if (crossings_[c].hi == hi) return c;
  const std::uint32_t above = height_[lo] >= -rounding ? lo : hi;
  const bool is_on = height_[above] <= rounding;
  const double t = height_[lo] / (height_[lo] - height_[hi]);
  const Vec3d p = is_on ? whole.points[above] : whole.points[lo] + t * (whole.points[hi] - whole.points[lo]);
  Crossing made{hi, crossed_[lo], {}};
  made.corner[0] = static_cast<std::uint32_t>(sides_[0].solid.points.size());
  sides_[0].solid.points.push_back(p);
  made.corner[1] = number_[above];
  if (!is_on) {
    made.corner[1] = static_cast<std::uint32_t>(sides_[1].solid.points.size());
    sides_[1].solid.points.push_back(p);
  }
  crossed_[lo] = static_cast<std::uint32_t>(crossings_.size());
  crossings_.push_back(made);
  return crossed_[lo];
}

bool PolyhedronCutter::lies_on_plane(const Polyhedron& whole, std::size_t first, std::size_t end,
                                     double rounding) const {
  for (std::size_t e = first; e < end; ++e)
    if (std::fabs(height_[whole.edges[e].from]) > rounding) return false;
  return true;
}

/// A face on the plane is added to the cut above. If the solid is below the face, all its edges meet their reverse edges
/// there, so nothing of it is left above.
void PolyhedronCutter::cancel_cap() {
  std::vector<Edge>& cap = sides_[1].cap;
  const auto key = [](const Edge& e) { return std::pair(std::min(e.from, e.to), std::max(e.from, e.to)); };
  std::sort(cap.begin(), cap.end(), [&](const Edge& a, const Edge& b) {
    return key(a) != key(b) ? key(a) < key(b) : a.from < b.from;
  });
  std::size_t left = 0;
  for (std::size_t k = 0; k < cap.size();) {
    std::size_t end = k, rising = 0;
    for (; end < cap.size() && key(cap[end]) == key(cap[k]); ++end) rising += cap[end].from < cap[end].to;
    const std::size_t falling = end - k - rising;
    const Edge edge = cap[rising > falling ? k : end - 1];
    for (std::size_t n = std::min(rising, falling); n < std::max(rising, falling); ++n) cap[left++] = edge;
    k = end;
  }
  cap.resize(left);
}

void PolyhedronCutter::divide_face(const Polyhedron& whole, std::size_t face, double rounding) {
  const std::size_t first = face == 0 ? 0 : whole.faces[face - 1].end, end = whole.faces[face].end;
  if (lies_on_plane(whole, first, end, rounding)) {
    for (std::size_t e = first; e < end; ++e)
      sides_[1].cap.push_back({number_[whole.edges[e].from], number_[whole.edges[e].to]});
    has_faces_on_plane_ = true;
    return;
  }
  leaves_.clear();
  enters_.clear();
  for (std::size_t e = first; e < end; ++e) {
    const auto [from, to] = whole.edges[e];
    const bool is_from_above = height_[from] >= -rounding, is_to_above = height_[to] >= -rounding;
    if (is_from_above == is_to_above) {
      sides_[is_from_above].solid.edges.push_back({number_[from], number_[to]});
      continue;
    }
    const std::uint32_t c = crossing(whole, from, to, rounding);
    for (std::uint32_t side = 0; side < 2; ++side) {
      const std::uint32_t corner = crossings_[c].corner[side];
      const Edge part = side == is_from_above ? Edge{number_[from], corner} : Edge{corner, number_[to]};
      if (part.from != part.to) sides_[side].solid.edges.push_back(part);
    }
    (is_from_above ? leaves_ : enters_).push_back({0, c});
  }
  if (!leaves_.empty()) close_face(whole.faces[face].normal);
  end_face(whole.faces[face].normal);
}

//          leaves            enters         A face is closed along the line. Above the plane, the new edge runs from the
//     ->-----.------ line ------.----->-    leaving point to the entering point. Below, it runs the other way. The two
//   above     \                /            kinds of points alternate along the line. So the k-th leaving point and the
//              `-->-- below --'             k-th entering point belong together.
void PolyhedronCutter::close_face(const Vec3d& face_normal) {
  if (leaves_.size() > 1) {
    const Vec3d line = cross(face_normal, plane_.normal);
    for (std::vector<Passage>* const list : {&leaves_, &enters_}) {
      for (Passage& p : *list) p.along = dot(line, sides_[0].solid.points[crossings_[p.crossing].corner[0]]);
      std::sort(list->begin(), list->end(), [](const Passage& a, const Passage& b) {
        return a.along != b.along ? a.along < b.along : a.crossing < b.crossing;
      });
    }
  }
  // Equal numbers of both if the surface is closed.
  const std::size_t count = std::min(leaves_.size(), enters_.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Crossing &leave = crossings_[leaves_[k].crossing], &enter = crossings_[enters_[k].crossing];
    for (std::uint32_t side = 0; side < 2; ++side) {
      const Edge edge =
          side == 1 ? Edge{leave.corner[1], enter.corner[1]} : Edge{enter.corner[0], leave.corner[0]};
      if (edge.from == edge.to) continue;
      sides_[side].solid.edges.push_back(edge);
      sides_[side].cap.push_back({edge.to, edge.from});
    }
  }
}

void PolyhedronCutter::end_face(const Vec3d& normal) {
  for (Side& side : sides_) {
    const std::uint32_t first = side.solid.faces.empty() ? 0 : side.solid.faces.back().end;
    const auto end = static_cast<std::uint32_t>(side.solid.edges.size());
    if (end < first + 3)  // an edge and its reverse
      side.solid.edges.resize(first);
    else
      side.solid.faces.push_back({end, normal});
  }
}

/// If an outline of the cut is the edge of a hole, it belongs to the body around it: the solid is to the left of the
/// outline's leftmost corner, up to the next edge of the cut.
void PolyhedronCutter::join_across_holes(std::uint32_t side, Pacer& pacer) {
  Side& s = sides_[side];
  const std::vector<Vec3d>& points = s.solid.points;
  s.outlines.clear();
  for (std::size_t k = 0; k < points.size(); ++k) s.outlines.add();
  for (const Edge& e : s.cap) s.outlines.unite(e.from, e.to);
  amount_.assign(points.size(), 0);
  at_root_.assign(points.size(), kNoIndex);
  const Vec3d normal = side == 0 ? plane_.normal : -1.0 * plane_.normal;
  for (const Edge& e : s.cap) {
    const std::uint32_t root = s.outlines.find(e.from);
    amount_[root] += 0.5 * dot(normal, cross(points[e.from] - origin_, points[e.to] - origin_));
    if (at_root_[root] == kNoIndex || dot(u_, points[e.from]) < dot(u_, points[at_root_[root]]))
      at_root_[root] = e.from;
  }
  double area = 0;
  for (std::uint32_t root = 0; root < points.size(); ++root) {
    area += amount_[root];
    if (!(amount_[root] < 0)) continue;
    const Vec3d& p = points[at_root_[root]];
    const double x = dot(u_, p), y = dot(v_, p);
    double nearest = -HUGE_VAL;
    std::uint32_t beside = kNoIndex;
    pacer.step(s.cap.size());
    for (const Edge& e : s.cap) {
      const Vec3d &a = points[e.from], &b = points[e.to];
      const double ya = dot(v_, a), yb = dot(v_, b);
      if ((ya > y) == (yb > y) || s.outlines.find(e.from) == root) continue;
      const double xa = dot(u_, a), xb = dot(u_, b), at = xa + (y - ya) / (yb - ya) * (xb - xa);
      if (at > x || at <= nearest) continue;
      nearest = at;
      beside = e.from;
    }
    if (beside != kNoIndex) s.together.unite(root, beside);
  }
  if (side == 0) cut_area_ = area;
}

void PolyhedronCutter::list_bodies(std::uint32_t side, Pacer& pacer) {
  Side& s = sides_[side];
  const std::vector<Vec3d>& points = s.solid.points;
  const auto count = static_cast<std::uint32_t>(points.size());
  amount_.assign(count, 0);
  const auto is_root = [&](std::uint32_t k) { return s.body_of[k] == k; };  // before bodies get numbers
  std::size_t first = 0;
  for (const Polyhedron::Face& face : s.solid.faces) {
    pacer.step(1 + face.end - first);
    const Vec3d foot = points[s.solid.edges[first].from] - origin_;
    for (; first < face.end; ++first) {  // the outlines of a face may belong to several bodies
      const auto [from, to] = s.solid.edges[first];
      amount_[s.body_of[from]] += dot(foot, cross(points[from] - origin_, points[to] - origin_)) / 6;
    }
  }
  // A body without a volume is left over from a surface that crosses itself. It is added to the largest body.
  std::uint32_t largest = kNoIndex;
  for (std::uint32_t k = 0; k < count; ++k)
    if (is_root(k) && is_off_[k] && (largest == kNoIndex || amount_[k] > amount_[largest])) largest = k;
  if (largest == kNoIndex) {
    s.body_of.assign(count, kNoIndex);
    return;
  }
  const auto first_body = static_cast<std::uint32_t>(bodies_.size());
  at_root_.assign(count, kNoIndex);
  for (std::uint32_t k = 0; k < count; ++k)
    if (is_root(k) && is_off_[k] && (amount_[k] > 0 || k == largest)) {
      at_root_[k] = static_cast<std::uint32_t>(bodies_.size());
      bodies_.push_back({side, k, amount_[k], 0, 0});
    }
  for (std::uint32_t k = 0; k < count; ++k)
    if (is_root(k) && is_off_[k] && at_root_[k] == kNoIndex) {
      bodies_[at_root_[largest]].volume += amount_[k];
      at_root_[k] = at_root_[largest];
    }
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t body = at_root_[s.body_of[k]];
    s.body_of[k] = body;
    if (body != kNoIndex) ++bodies_[body].count;
  }
  auto begin = static_cast<std::uint32_t>(corners_.size());
  for (std::uint32_t b = first_body; b < bodies_.size(); ++b) {
    bodies_[b].first = begin;
    begin += bodies_[b].count;
    bodies_[b].count = 0;
  }
  corners_.resize(begin);
  for (std::uint32_t k = 0; k < count; ++k)
    if (s.body_of[k] != kNoIndex) {
      Body& b = bodies_[s.body_of[k]];
      corners_[b.first + b.count++] = points[k];
    }
}

void PolyhedronCutter::cut(const Polyhedron& whole, const CutPlane& plane, double rounding, Pacer& pacer) {
  plane_ = plane;
  const Vec3d& n = plane.normal;
  const double least = std::min({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)});
  u_ = cross(n, std::fabs(n.x) == least   ? Vec3d{1, 0, 0}
                : std::fabs(n.y) == least ? Vec3d{0, 1, 0}
                                          : Vec3d{0, 0, 1});
  v_ = cross(n, u_);
  for (Side& side : sides_) side.clear();
  origin_ = whole.points[0] - (dot(n, whole.points[0]) - plane.offset) * n;
  crossings_.clear();
  bodies_.clear();
  corners_.clear();
  cut_area_ = 0;
  has_faces_on_plane_ = false;
  divide_points(whole, rounding, pacer);
  for (std::size_t f = 0; f < whole.faces.size(); ++f) {
    pacer.step(4);
    divide_face(whole, f, rounding);
  }
  if (has_faces_on_plane_) cancel_cap();
  for (std::uint32_t side = 0; side < 2; ++side) {
    Side& s = sides_[side];
    s.together.clear();
    pacer.each(0, s.solid.points.size(), [&](std::size_t) { s.together.add(); });
    pacer.each(0, s.solid.edges.size(),
               [&](std::size_t e) { s.together.unite(s.solid.edges[e].from, s.solid.edges[e].to); });
    join_across_holes(side, pacer);
    s.body_of.resize(s.solid.points.size());
    for (std::uint32_t k = 0; k < s.body_of.size(); ++k) s.body_of[k] = s.together.find(k);
    is_off_.assign(s.solid.points.size(), 0);
    pacer.each(0, whole.points.size(), [&](std::size_t k) {
      if ((height_[k] >= -rounding) == (side == 1) && std::fabs(height_[k]) > rounding)
        is_off_[s.body_of[number_[k]]] = 1;
    });
    list_bodies(side, pacer);
  }
}

void PolyhedronCutter::write(const Body& body, Polyhedron& out, Pacer& pacer) {
  const Side& s = sides_[body.side];
  const auto index = static_cast<std::uint32_t>(&body - bodies_.data());
  out.clear();
  number_.resize(s.solid.points.size());
  pacer.each(0, s.solid.points.size(), [&](std::size_t k) {
    if (s.body_of[k] != index) return;
    number_[k] = static_cast<std::uint32_t>(out.points.size());
    out.points.push_back(s.solid.points[k]);
  });
  std::size_t first = 0;
  for (const Polyhedron::Face& face : s.solid.faces) {
    pacer.step(1 + face.end - first);
    const std::size_t begin = first;
    first = face.end;
    const std::size_t before = out.edges.size();
    for (std::size_t e = begin; e < face.end; ++e) {  // the outlines of a face may belong to several bodies
      const Edge& edge = s.solid.edges[e];
      if (s.body_of[edge.from] == index) out.edges.push_back({number_[edge.from], number_[edge.to]});
    }
    if (out.edges.size() > before)
      out.faces.push_back({static_cast<std::uint32_t>(out.edges.size()), face.normal});
  }
  const std::size_t before_cap = out.edges.size();
  for (const Edge& e : s.cap)
    if (s.body_of[e.from] == index) out.edges.push_back({number_[e.from], number_[e.to]});
  if (out.edges.size() > before_cap)
    out.faces.push_back({static_cast<std::uint32_t>(out.edges.size()),
                         body.side == 0 ? plane_.normal : -1.0 * plane_.normal});
}

std::size_t PolyhedronCutter::bytes() const {
  std::size_t bytes = bytes_of_vectors(height_, number_, crossed_, crossings_, leaves_, enters_, is_off_,
                                       amount_, at_root_, bodies_, corners_);
  for (const Side& s : sides_)
    bytes += s.solid.bytes() + bytes_of_vectors(s.cap, s.body_of) + s.together.bytes() + s.outlines.bytes();
  return bytes;
}

void PolyhedronCutter::release() {
  release_vectors(height_, number_, crossed_, crossings_, leaves_, enters_, is_off_, amount_, at_root_,
                  bodies_, corners_);
  for (Side& s : sides_) {
    s.solid.release();
    release_vectors(s.cap, s.body_of);
    s.together = DisjointSets();
    s.outlines = DisjointSets();
  }
}

}  // namespace fracture
