#include "common/fragment/carried_sheets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/error.hpp"
#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/sheet_mesh.hpp"
#include "common/fragment/surface_faces.hpp"
#include "common/solid/corners.hpp"
#include "common/solid/image.hpp"

namespace fracture {
namespace {

/// Finds the nearest of some fragments. The trees of their triangles are built when they are needed.
class NearestFragment {
 public:
  NearestFragment(const std::vector<Fragment>& fragments, const Execution& execution)
      : fragments_(fragments), execution_(execution), pacer_(execution), trees_(fragments.size()) {}

  std::uint32_t of(const Vec3d& p, std::span<const std::uint32_t> candidates) {
    std::uint32_t best = candidates[0];
    double least = HUGE_VAL;
    for (const std::uint32_t f : candidates) {
      const double d = tree(f).distance(p, least, pacer_);
      if (!(d < least)) continue;
      least = d;
      best = f;
    }
    return best;
  }
  std::uint32_t of_all(const Vec3d& p) {
    if (!boxes_) make_boxes();
    std::uint32_t best = 0;
    double least = HUGE_VAL;
    boxes_->nearest(p, HUGE_VAL, slack_, [&](std::uint32_t f) {
      const double d = tree(f).distance(p, HUGE_VAL, pacer_);
      if (d < least || (d == least && f < best)) {
        least = d;
        best = f;
      }
      return d;
    });
    return best;
  }

 private:
  /// Bounds the rounding errors of distances, relative to the coordinates.
  static constexpr double kSlack = 0x1p-40;

  std::vector<std::array<Vec3d, 3>> corners(std::uint32_t f) {
    const Fragment& fragment = fragments_[f];
    std::vector<std::array<Vec3d, 3>> triangles(fragment.indices.size() / 3);
    for (std::size_t k = 0; k < fragment.indices.size(); ++k) {
      pacer_.step();
      triangles[k / 3][k % 3] = to_double(fragment.positions[fragment.indices[k]]) + fragment.pivot;
    }
    return triangles;
  }
  const SurfaceTree& tree(std::uint32_t f) {
    if (!trees_[f]) trees_[f].emplace(corners(f), execution_);
    return *trees_[f];
  }
  void make_boxes() {
    std::vector<Box> boxes(fragments_.size());
    Box all;
    for (std::size_t f = 0; f < boxes.size(); ++f) {
      pacer_.step(fragments_[f].positions.size());
      for (const Vec3f& p : fragments_[f].positions) boxes[f].add(to_double(p) + fragments_[f].pivot);
      all.add(boxes[f]);
    }
    for (int axis = 0; axis < 3; ++axis)
      slack_ = std::fmax(slack_, kSlack * std::fmax(std::fabs(all.min[axis]), std::fabs(all.max[axis])));
    boxes_.emplace(boxes, execution_);
  }

  const std::vector<Fragment>& fragments_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<std::optional<SurfaceTree>> trees_;
  std::optional<BoxTree> boxes_;
  double slack_ = 0;
};

/// The fragments that have each cell, and the cells that the same fragments have.
class CellCarriers {
 public:
  CellCarriers(const std::vector<Fragment>& fragments, std::uint32_t site_count, const Execution& execution)
      : of_site_(site_count) {
    Pacer pacer(execution);
    for (std::uint32_t f = 0; f < fragments.size(); ++f)
      for (const SiteId s : fragments[f].sites) {
        pacer.step();
        of_site_[s].push_back(f);
      }
    // Cells of the same single fragment or fragments are one, so no cut divides what moves together.
    std::map<std::vector<std::uint32_t>, std::uint32_t> number;
    std::vector<std::uint32_t> groups(site_count);
    for (std::uint32_t s = 0; s < site_count; ++s) {
      pacer.step(8);
      groups[s] = of_site_[s].empty() ? s : number.try_emplace(of_site_[s], site_count + s).first->second;
    }
    ownership = Ownership::from_groups(site_count, groups, execution);
  }
  /// Ascending; empty if the cells have nothing of the solid.
  const std::vector<std::uint32_t>& of_owner(std::size_t owner) const {
    return of_site_[ownership.sites_of_owner[owner][0]];
  }

  Ownership ownership;

 private:
  std::vector<std::vector<std::uint32_t>> of_site_;
};

/// Divides the faces of one owner into connected pieces, in the order of their first faces.
class PieceFinder {
 public:
  explicit PieceFinder(std::uint32_t vertices) : vertices_(vertices) {}

  std::vector<std::vector<Face>> pieces(std::span<const Face> faces, Pacer& pacer) {
    local_.next_epoch(vertices_);
    DisjointSets sets;
    const auto number = [&](CutVertexId v) {
      std::uint32_t& slot = local_.slot(v);
      if (slot == StampedMap::kEmpty) slot = sets.add();
      return slot;
    };
    for (const Face& face : faces) {
      pacer.step(4);
      const std::uint32_t a = number(face.v[0]), b = number(face.v[1]), c = number(face.v[2]);
      sets.unite(a, b);
      sets.unite(b, c);
    }
    std::vector<std::vector<Face>> pieces;
    std::map<std::uint32_t, std::size_t> piece_of;
    for (const Face& face : faces) {
      pacer.step(4);
      const std::uint32_t set = sets.find(number(face.v[0]));
      const std::size_t piece = piece_of.try_emplace(set, pieces.size()).first->second;
      if (piece == pieces.size()) pieces.emplace_back();
      pieces[piece].push_back(face);
    }
    return pieces;
  }

 private:
  std::uint32_t vertices_;
  StampedMap local_;
};

double area_of(const RestrictedDiagram& d, const Face& face) {
  const Vec3d a = d.point(face.v[0]);
  return 0.5 * length(cross(d.point(face.v[1]) - a, d.point(face.v[2]) - a));
}

/// The middle of a piece, weighted by area; the mean of its corners if it has no area.
Vec3d middle_of(const RestrictedDiagram& d, std::span<const Face> faces) {
  Vec3d sum, corners;
  double area = 0;
  for (const Face& face : faces) {
    const Vec3d middle = (1.0 / 3) * (d.point(face.v[0]) + d.point(face.v[1]) + d.point(face.v[2]));
    const double share = area_of(d, face);
    area += share;
    sum = sum + share * middle;
    corners = corners + middle;
  }
  return area > 0 ? (1 / area) * sum : (1.0 / static_cast<double>(faces.size())) * corners;
}

/// Gives the faces of each owner to fragments.
std::vector<std::vector<Face>> share_out(const RestrictedDiagram& d, const CellCarriers& carriers,
                                         const std::vector<Fragment>& fragments, const Execution& execution) {
  const OwnedFaces owned = divide_surface(d, carriers.ownership, execution);
  std::vector<std::vector<Face>> of_fragment(fragments.size());
  NearestFragment nearest(fragments, execution);
  PieceFinder finder(d.vertex_count());
  Pacer pacer(execution);
  const auto give = [&](std::uint32_t fragment, std::span<const Face> faces) {
    pacer.step(faces.size());
    of_fragment[fragment].insert(of_fragment[fragment].end(), faces.begin(), faces.end());
  };
  for (std::size_t o = 0; o + 1 < owned.begin.size(); ++o) {
    pacer.step();
    const std::span<const Face> faces(owned.faces.data() + owned.begin[o],
                                      owned.begin[o + 1] - owned.begin[o]);
    if (faces.empty()) continue;
    const std::vector<std::uint32_t>& candidates = carriers.of_owner(o);
    if (candidates.size() == 1) {
      give(candidates[0], faces);
      continue;
    }
    for (const std::vector<Face>& piece : finder.pieces(faces, pacer)) {
      const Vec3d middle = middle_of(d, piece);
      give(candidates.empty() ? nearest.of_all(middle) : nearest.of(middle, candidates), piece);
    }
  }
  return of_fragment;
}

void cut_and_carry(const SeenSolid& seen, const VoronoiDiagram& diagram, FragmentSet& set,
                   const Execution& execution) {
  RestrictedDiagram d{seen.original(), seen.seen(), diagram, cut_surface(seen.seen(), diagram, execution)};
  d.positions = place_vertices(d.solid, d.seen, diagram, d.cuts, d.winding, execution);
  const CellCarriers carriers(set.fragments, diagram.dual().site_count(), execution);
  const std::vector<std::vector<Face>> of_fragment = share_out(d, carriers, set.fragments, execution);
  Pacer pacer(execution);
  for (std::size_t f = 0; f < of_fragment.size(); ++f) {
    for (const Face& face : of_fragment[f]) {
      pacer.step();
      set.certificate.sheet_area_out += area_of(d, face);
    }
    if (of_fragment[f].empty()) continue;
    set.fragments[f].sheet =
        std::make_shared<const Fragment>(sheet_mesh(d, of_fragment[f], set.fragments[f].pivot, execution));
  }
}

bool contains(const Box& box, const Box& inner) {
  for (int axis = 0; axis < 3; ++axis)
    if (inner.min[axis] < box.min[axis] || inner.max[axis] > box.max[axis]) return false;
  return true;
}

}  // namespace

std::vector<std::uint32_t> parts_near_sheets(const Solid& solid, const Solid& surface,
                                             const Execution& execution) {
  const std::vector<std::array<Vec3d, 3>> corners = corners_of(solid, execution);
  std::vector<Box> boxes;
  boxes.reserve(corners.size());
  double reach = 0;
  for (const auto& triangle : corners) {
    boxes.push_back(box_of(triangle));
    for (const Vec3d& p : triangle) reach = std::fmax(reach, length(p));
  }
  const BoxTree tree(boxes, execution);
  DisjointSets sets;
  Pacer pacer(execution);
  for (std::size_t v = 0; v < surface.positions.size(); ++v) sets.add();
  for (const auto& triangle : surface.triangles) {
    pacer.step();
    sets.unite(triangle[0], triangle[1]);
    sets.unite(triangle[1], triangle[2]);
  }
  std::vector<std::uint32_t> part_of_set(surface.positions.size(), kNoIndex);
  std::vector<std::uint32_t> parts(surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    std::uint32_t& part = part_of_set[sets.find(surface.triangles[t][0])];
    if (part == kNoIndex) {
      Vec3d middle;
      for (const VertexId v : surface.triangles[t]) middle = middle + to_double(surface.positions[v]);
      middle = (1.0 / 3) * middle;
      std::uint32_t nearest = 0;
      double least = HUGE_VAL;
      tree.nearest(middle, HUGE_VAL, 0x1p-40 * (reach + length(middle)), [&](std::uint32_t k) {
        pacer.step(8);
        const auto& [a, b, c] = corners[k];
        const double d = distance_to_triangle(middle, a, b, c);
        if (d < least || (d == least && k < nearest)) {
          least = d;
          nearest = k;
        }
        return d;
      });
      part = solid.part[nearest];
    }
    parts[t] = part;
  }
  return parts;
}

void carry_sheets(const Solid& solid, const VoronoiDiagram& diagram, const Box& box, FragmentSet& set,
                  const Execution& execution) {
  if (!solid.sheets || solid.sheets->whole) return;
  set.certificate.sheet_area_in = solid.sheets->area;
  std::optional<Solid> with_parts;
  if (diagram.map().frames().size() > 1) {  // the frame of the nearest part cuts a sheet
    with_parts = *solid.sheets->surface;
    with_parts->part = parts_near_sheets(solid, *solid.sheets->surface, execution);
    with_parts->parts = solid.parts;
  }
  const SeenSolid seen(with_parts ? *with_parts : *solid.sheets->surface, diagram.map(), execution);
  Box all = box;
  for (const Vec3f& p : seen.seen().positions) all.add(to_double(p));
  if (contains(box, all)) return cut_and_carry(seen, diagram, set, execution);
  // The sites are distinct and own points of the smaller box, so all of them stay, with their numbers.
  const std::vector<Vec3d>& points = diagram.dual().points;
  const std::uint32_t count = diagram.dual().site_count();
  const Expected<Tetrahedralization> larger = tetrahedralize(std::span(points).first(count), all, execution);
  if (!larger) throw Interrupted(larger.error());
  if (larger->site_count() != count) throw InternalError("sheets: a larger box lost a site");
  cut_and_carry(seen, VoronoiDiagram(*larger, all, diagram.map(), execution), set, execution);
}

}  // namespace fracture
