#include "common/solid/sheets.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/solid/faults.hpp"
#include "common/solid/mirrors.hpp"
#include "common/solid/open_pieces.hpp"
#include "common/solid/polled.hpp"
#include "common/solid/sheet_offsets.hpp"

namespace fracture::solid_detail {
namespace {

/// Share of the requested thickness below which a slab is reported as too thin, next to a fold.
constexpr double kThin = 0.9;
/// A corner of a fold moves farther than the thickness, so that the slab has the thickness on both sides (a mitre),
/// but at most by this factor, which suffices for turns of 151 degrees. Sharper folds would become long spikes.
constexpr double kLongestMitre = 4;
/// Cosine of the angle (2.6 degrees) between normals below which there is a fold. Elsewhere a mitre would change the
/// thickness by less than 0.1 %.
constexpr double kFlat = 0.999;
class Thickener {
 public:
  Thickener(Surface& surface, const Shells& shells, double thickness, const std::vector<TriangleId>& mirror,
            const Execution& execution)
      : surface_(surface),
        shells_(shells),
        thickness_(thickness),
        mirror_(mirror),
        execution_(execution),
        pacer_(execution),
        front_of_(filled(execution, surface.triangles.size(), kNoTriangle)),
        back_vertex_(filled(execution, surface.positions.size(), kNoVertex)),
        doomed_(filled<std::uint8_t>(execution, surface.triangles.size(), 0)),
        failed_(filled<std::uint8_t>(execution, surface.triangles.size(), 0)),
        lost_(shells.list.size(), 0) {}

  /// Grows a front from the seed and makes it a slab. Returns false if the seed is already in a front, is on
  /// the back of one, or is in a front that could not be moved.
  bool make_slab(TriangleId seed) {
    pacer_.step();
    if (front_of_[seed] != kNoTriangle || doomed_[seed] || surface_.source[seed] == kNoIndex) return false;
    const std::uint32_t shell = shells_.of_triangle[seed];
    if (failed_[seed] || lost_[shell] > kWorkLost * (shells_.list[shell].triangles + std::uint64_t{64}))
      return false;
    std::vector<TriangleId> front{seed};
    front_of_[seed] = seed;
    bool mirrored = false;
    for (std::size_t i = 0; i < front.size(); ++i) {
      pacer_.step(4);
      mirrored |= mirror_[front[i]] != kNoTriangle;
      for (HalfEdge h = 3 * front[i]; h < 3 * front[i] + 3; ++h) {
        const TriangleId n = triangle_of(surface_.twin[h]);
        if (n >= doomed_.size() || front_of_[n] != kNoTriangle || doomed_[n] ||
            surface_.source[n] == kNoIndex)
          continue;
        if (mirror_[n] != kNoTriangle && front_of_[mirror_[n]] == seed) continue;
        front_of_[n] = seed;
        front.push_back(n);
      }
    }
    sort_with_polls(execution_, front.begin(), front.end());
    // A mitre can move a corner exactly onto another one, next to a triangle that is as narrow as the thickness.
    if (!place_back_vertices(front, true) && !place_back_vertices(front, false)) {
      // Without mirrored triangles, every seed in it gives this front. With them, another choice of sides may
      // work.
      lost_[shell] += front.size();
      for (const TriangleId t : front) {
        pacer_.step();
        front_of_[t] = kNoTriangle;
        failed_[t] = !mirrored;
      }
      return false;
    }
    measure(front);
    build(front, seed);
    for (const TriangleId t : front) {
      pacer_.step();
      for (const VertexId v : surface_.triangles[t]) back_vertex_[v] = kNoVertex;
      if (mirror_[t] != kNoTriangle) doomed_[mirror_[t]] = 1;
    }
    return true;
  }
  /// A warning about slabs that are thinner than requested; empty if there are none.
  std::string warning() const {
    if (thin_ == 0) return {};
    return "'thickness' is not reached at sharp folds: " +
           counted(thin_, "triangle of an open sheet is", "triangles of open sheets are") +
           " thinner than 0.9 times " + short_number(thickness_) + " m. The thinnest, at " +
           place(thinnest_at_) + ", is only " + short_number(std::fmax(thinnest_, 0) * thickness_) +
           " m thick. Corners of such a fold would have to move by more than " + short_number(kLongestMitre) +
           " times the thickness. Round the fold off, or give the sheet a thickness in a modelling tool.";
  }
  bool in_front(TriangleId t) const { return t < front_of_.size() && front_of_[t] != kNoTriangle; }

 private:
  /// Limits the work on fronts that cannot be moved: no more fronts of a shell are tried if those had this
  /// many times the shell's triangles in total.
  static constexpr std::uint64_t kWorkLost = 64;

  bool is_in_front(TriangleId t, TriangleId seed) const {
    return t < front_of_.size() && front_of_[t] == seed;
  }

  /// Measures the thickness of the slab above each triangle of its front, after its back is placed.
  void measure(const std::vector<TriangleId>& front) {
    for (const TriangleId t : front) {
      pacer_.step(4);
      const Triangle& c = surface_.triangles[t];
      const Vec3d a = at(c[0]), n = cross(at(c[1]) - a, at(c[2]) - a);
      const double area = length(n);
      if (!(area > 0)) continue;
      double least = 1;
      for (const VertexId v : c)
        least = std::fmin(least, dot(at(v) - at(back_vertex_[v]), n) / (area * thickness_));
      thin_ += least < kThin;
      if (least < std::fmin(thinnest_, kThin)) {
        thinnest_ = least;
        thinnest_at_ = surface_.positions[c[0]];
      }
    }
  }

  Vec3d at(VertexId v) const { return to_double(surface_.positions[v]); }

  /// Returns false if the corners of a triangle or of a wall would coincide, so that the front cannot be moved.
  bool place_back_vertices(const std::vector<TriangleId>& front, bool mitred) {
    std::vector<VertexId> vertices;
    for (const TriangleId t : front) {
      pacer_.step();
      vertices.insert(vertices.end(), surface_.triangles[t].begin(), surface_.triangles[t].end());
    }
    sort_with_polls(execution_, vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const auto index = [&](VertexId v) { return index_of(v, vertices); };
    const std::vector<SheetOffset> offsets = sheet_offsets(surface_, front, vertices, mitred, pacer_);
    std::vector<Vec3f> back(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      pacer_.step();
      const auto& [normal, least] = offsets[i];
      const Vec3f& p = surface_.positions[vertices[i]];
      if (!(dot(normal, normal) > 0)) return false;
      const double mitre = least < kFlat ? std::fmin(1 / least, kLongestMitre) : 1;
      const Vec3d q = to_double(p) - (mitre * thickness_) * normal;
      back[i] = {static_cast<float>(q.x) + 0.0f, static_cast<float>(q.y) + 0.0f,
                 static_cast<float>(q.z) + 0.0f};
      if (back[i] == p) return false;
    }
    // Rounding must not merge corners of a back triangle, nor the ends of both diagonals of a wall.
    for (const TriangleId t : front) {
      pacer_.step(4);
      for (int k = 0; k < 3; ++k) {
        const VertexId from = surface_.triangles[t][k], to = surface_.triangles[t][(k + 1) % 3];
        const bool is_rim = !is_in_front(triangle_of(surface_.twin[3 * t + k]), front_of_[t]);
        if (back[index(from)] == back[index(to)] || (is_rim && back[index(from)] == surface_.positions[to] &&
                                                     back[index(to)] == surface_.positions[from]))
          return false;
      }
    }
    make_room(execution_, surface_.positions, vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      pacer_.step();
      back_vertex_[vertices[i]] = VertexId{surface_.positions.size()};
      surface_.positions.push_back(back[i]);
    }
    return true;
  }

  TriangleId append(const Triangle& triangle, std::uint32_t source, bool flipped) {
    surface_.triangles.push_back(triangle);
    surface_.source.push_back(source);
    if (!surface_.flipped.empty()) surface_.flipped.push_back(flipped);
    surface_.twin.of_triangle.push_back(kThreeOpen);
    return TriangleId{surface_.triangles.size() - 1};
  }
  void glue(HalfEdge a, HalfEdge b) {
    surface_.twin[a] = b;
    surface_.twin[b] = a;
  }

  void build(const std::vector<TriangleId>& front, TriangleId seed) {
    const auto position_in = [&](TriangleId t) {
      return static_cast<std::size_t>(std::lower_bound(front.begin(), front.end(), t) - front.begin());
    };
    const auto inside = [&](HalfEdge h) { return is_in_front(triangle_of(h), seed); };
    std::size_t rim = 0;
    const std::vector<HalfEdge> old_twin = [&] {
      std::vector<HalfEdge> twins;
      twins.reserve(3 * front.size());
      for (const TriangleId t : front) {
        pacer_.step();
        for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h) {
          twins.push_back(surface_.twin[h]);
          rim += !inside(surface_.twin[h]);
        }
      }
      return twins;
    }();
    const auto twin_of = [&](HalfEdge h) {
      const HalfEdge twin = old_twin[3 * position_in(triangle_of(h)) + h % 3];
      return inside(twin) ? twin : kNoIndex;
    };
    const std::size_t more = front.size() + 2 * rim;
    execution_.made(Product::kSurfaceTriangles, more);
    make_room(execution_, surface_.triangles, more);
    make_room(execution_, surface_.source, more);
    if (!surface_.flipped.empty()) make_room(execution_, surface_.flipped, more);
    make_room(execution_, surface_.twin.of_triangle, more);

    std::vector<TriangleId> back(front.size());
    for (std::size_t i = 0; i < front.size(); ++i) {
      pacer_.step(2);
      const Triangle c = surface_.triangles[front[i]];
      const TriangleId m = mirror_[front[i]];
      Triangle b{back_vertex_[c[0]], back_vertex_[c[2]], back_vertex_[c[1]]};
      if (m != kNoTriangle) {  // begin at the same corner as the other side's triangle, so its wedges stay at
                               // their corners
        const Vec3f& first = surface_.positions[surface_.triangles[m][0]];
        const int k = surface_.positions[c[0]] == first ? 0 : surface_.positions[c[1]] == first ? 1 : 2;
        b = {back_vertex_[c[k]], back_vertex_[c[(k + 2) % 3]], back_vertex_[c[(k + 1) % 3]]};
      }
      back[i] = append(b, m == kNoTriangle ? kNoIndex : surface_.source[m],
                       m != kNoTriangle && !surface_.flipped.empty() && surface_.flipped[m]);
    }
    const auto back_of = [&](HalfEdge h) {  // goes from the back of h's end to the back of h's beginning
      const TriangleId t = back[position_in(triangle_of(h))];
      for (HalfEdge g = 3 * t; g < 3 * t + 3; ++g)
        if (surface_.from(g) == back_vertex_[surface_.to(h)] &&
            surface_.to(g) == back_vertex_[surface_.from(h)])
          return g;
      throw InternalError("sheets: a back triangle does not face its front");
    };

    // Add a wall of two triangles to each rim half-edge u -> v.
    struct Wall {
      HalfEdge rim;
      HalfEdge at_begin, at_end;  ///< u -> its back, and back of v -> v: glued to the walls of the neighbours
    };
    std::vector<Wall> walls;  // by rim, ascending
    for (const TriangleId t : front) {
      pacer_.step(8);
      for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h) {
        if (const HalfEdge twin = twin_of(h); twin != kNoIndex) {
          glue(back_of(h), back_of(twin));
          continue;
        }
        const VertexId u = surface_.from(h), v = surface_.to(h);
        const VertexId bu = back_vertex_[u], bv = back_vertex_[v];
        if (surface_.positions[bu] != surface_.positions[v]) {
          const TriangleId first = append({v, u, bu}, kNoIndex, false);
          const TriangleId second = append({v, bu, bv}, kNoIndex, false);
          glue(3 * first, h);
          glue(3 * first + 2, 3 * second);
          glue(3 * second + 1, back_of(h));
          walls.push_back({h, 3 * first + 1, 3 * second + 2});
        } else {  // the ends of that diagonal have the same position
          const TriangleId first = append({v, u, bv}, kNoIndex, false);
          const TriangleId second = append({u, bu, bv}, kNoIndex, false);
          glue(3 * first, h);
          glue(3 * first + 1, 3 * second + 2);
          glue(3 * second + 1, back_of(h));
          walls.push_back({h, 3 * second, 3 * first + 2});
        }
      }
    }
    for (const Wall& wall : walls) {
      HalfEdge p = previous(wall.rim);  // becomes the rim half-edge that ends at the beginning of wall.rim
      for (HalfEdge twin = twin_of(p); twin != kNoIndex; twin = twin_of(p)) {
        pacer_.step(2);
        p = previous(twin);
      }
      pacer_.step(2);
      const auto neighbour = std::lower_bound(walls.begin(), walls.end(), p,
                                              [](const Wall& w, HalfEdge h) { return w.rim < h; });
      glue(wall.at_begin, neighbour->at_end);
    }
  }

  Surface& surface_;
  const Shells& shells_;
  double thickness_;
  const std::vector<TriangleId>& mirror_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<TriangleId> front_of_;  ///< per triangle: the seed of its front
  std::vector<VertexId> back_vertex_;
  std::vector<std::uint8_t> doomed_;
  std::vector<std::uint8_t> failed_;  ///< per triangle: its front cannot be moved, for any seed
  std::vector<std::uint64_t> lost_;   ///< per shell: total number of triangles in such fronts
  std::uint64_t thin_ = 0;            ///< triangles above which a slab is thinner than kThin · thickness
  double thinnest_ = 1;               ///< as a share of the requested thickness
  Vec3f thinnest_at_{};
};

}  // namespace

std::size_t thicken_sheets(Surface& surface, const Shells& shells, double thickness, const Walled& walled,
                           std::vector<TriangleId>& fills, SolidReport& report, const Execution& execution) {
  const std::vector<std::uint8_t> is_sheet =
      find_open_sheets(surface, shells, thickness, walled, report, execution);
  std::vector<TriangleId> candidates;
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    if (surface.source[t] != kNoIndex && is_sheet[shells.of_triangle[t]]) candidates.push_back(TriangleId{t});
  });
  if (candidates.empty()) return 0;

  const std::vector<TriangleId> mirror = find_mirrors(surface, candidates, execution);
  Thickener thickener(surface, shells, thickness, mirror, execution);
  const std::size_t old_count = surface.triangles.size();
  std::size_t slabs = 0;
  std::vector<std::uint8_t> shell_done(shells.list.size(), 0);
  for (const TriangleId t : candidates) {
    if (!thickener.make_slab(t)) continue;
    ++slabs;
    const std::uint32_t shell = shells.of_triangle[t];
    shell_done[shell] = 1;
    report.rooms_walled += !walled.rooms.empty() && walled.rooms[shell];
  }
  if (std::string warning = thickener.warning(); !warning.empty()) report.remarks.warn(std::move(warning));
  // Remove the rest of each replaced shell: its fill, its other sides, and parts too small to be moved.
  std::vector<TriangleId> place_of = filled(execution, surface.triangles.size(), kNoTriangle);
  TriangleId kept{0};
  for_each_polled(execution, place_of.size(), [&](std::size_t t) {
    if (t >= old_count || !shell_done[shells.of_triangle[t]] || thickener.in_front(TriangleId{t}))
      place_of[t] = kept++;
  });
  for_each_polled(execution, place_of.size(), [&](std::size_t t) {
    const TriangleId to = place_of[t];
    if (to == kNoTriangle) return;
    surface.triangles[to] = surface.triangles[t];
    surface.source[to] = surface.source[t];
    if (!surface.flipped.empty()) surface.flipped[to] = surface.flipped[t];
    for (HalfEdge k = 0; k < 3; ++k) {
      const HalfEdge twin = surface.twin[3 * t + k];
      surface.twin[3 * std::size_t{to} + k] = 3 * place_of[twin / 3] + twin % 3;
    }
  });
  surface.triangles.resize(kept);
  surface.source.resize(kept);
  if (!surface.flipped.empty()) surface.flipped.resize(kept);
  surface.twin.of_triangle.resize(kept);
  std::size_t fills_kept = 0;
  for (const TriangleId fill : fills)
    if (place_of[fill] != kNoTriangle) fills[fills_kept++] = place_of[fill];
  fills.resize(fills_kept);
  return slabs;
}

}  // namespace fracture::solid_detail
