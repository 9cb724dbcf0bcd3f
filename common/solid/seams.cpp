#include "common/solid/seams.hpp"

#include <algorithm>
#include <span>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// Maximum number of open half-edges tested at a vertex; usually there are two.
constexpr std::size_t kMostAtVertex = 8;
/// Steps of the search per open half-edge. Beyond this, the search ends. Each seam takes as many steps as it
/// has half-edges; steps are wasted only if many lines overlap.
constexpr std::uint64_t kMostSteps = 64;

class SeamFinder {
 public:
  SeamFinder(const Surface& surface, double tolerance, const Execution& execution)
      : surface_(surface), tolerance2_(tolerance * tolerance), pacer_(execution) {
    for_each_polled(execution, surface.twin.size(), [&](std::size_t h) {
      if (surface.twin[h] != kNoIndex) return;
      make_room(execution, open_);
      open_.push_back(static_cast<HalfEdge>(h));
    });
    taken_ = filled<std::uint8_t>(execution, open_.size(), 0);
    leaving_.reserve(open_.size());
    arriving_.reserve(open_.size());
    for_each_polled(execution, open_.size(), [&](std::size_t k) {
      leaving_.push_back({surface.from(open_[k]), static_cast<std::uint32_t>(k)});
      arriving_.push_back({surface.to(open_[k]), static_cast<std::uint32_t>(k)});
    });
    sort_with_polls(execution, leaving_.begin(), leaving_.end());
    sort_with_polls(execution, arriving_.begin(), arriving_.end());
    steps_left_ = kMostSteps * open_.size();
  }

  std::vector<std::vector<HalfEdge>> run() {
    std::vector<std::vector<HalfEdge>> loops;
    for (std::size_t k = 0; k + 1 < leaving_.size(); ++k) {
      pacer_.step();
      const VertexId tip = leaving_[k].vertex;
      if (tip == leaving_[k + 1].vertex && (k == 0 || tip != leaving_[k - 1].vertex)) find_at(tip, loops);
    }
    return loops;
  }

 private:
  /// A member of open_ that leaves the vertex or arrives at it.
  struct AtVertex {
    VertexId vertex;
    std::uint32_t open;
    auto operator<=>(const AtVertex&) const = default;
  };
  /// One side of a seam, starting at its tip: members of open_, and the vertex reached so far.
  struct Side {
    std::vector<std::uint32_t> open;
    VertexId end;
    Vec3d place;  ///< position of the end relative to the tip
  };

  static std::span<const AtVertex> at(const std::vector<AtVertex>& list, VertexId v) {
    const auto first = std::lower_bound(list.begin(), list.end(), AtVertex{v, 0});
    auto last = first;
    while (last != list.end() && last->vertex == v && last - first < std::ptrdiff_t{kMostAtVertex}) ++last;
    return {first, last};
  }
  Vec3d from_tip(VertexId v) const {
    return to_double(surface_.positions[v]) - to_double(surface_.positions[tip_]);
  }
  /// Whether the nearer of the two points is within the tolerance of the segment from the tip to the farther
  /// one.
  bool on_one_line(const Vec3d& a, const Vec3d& b) const {
    const Vec3d n = cross(a, b);
    return dot(a, b) > 0 && dot(n, n) <= tolerance2_ * std::max(dot(a, a), dot(b, b));
  }

  void find_at(VertexId tip, std::vector<std::vector<HalfEdge>>& loops) {
    tip_ = tip;
    for (const AtVertex& arrives : at(arriving_, tip))
      for (const AtVertex& leaves : at(leaving_, tip)) {
        if (taken_[arrives.open] || taken_[leaves.open]) continue;
        back_.open.clear();
        front_.open.clear();
        add(back_, arrives.open, surface_.from(open_[arrives.open]));
        add(front_, leaves.open, surface_.to(open_[leaves.open]));
        if (!follow()) continue;
        // Go away from the tip against the half-edges that arrive at it, and back against the others.
        std::vector<HalfEdge>& loop = loops.emplace_back();
        for (const std::uint32_t k : back_.open) loop.push_back(open_[k]);
        for (auto k = front_.open.rbegin(); k != front_.open.rend(); ++k) loop.push_back(open_[*k]);
        for (const Side* side : {&back_, &front_})
          for (const std::uint32_t k : side->open) taken_[k] = 1;
      }
  }

  void add(Side& side, std::uint32_t open, VertexId end) {
    side.open.push_back(open);
    side.end = end;
    side.place = from_tip(end);
  }

  /// Extends the shorter side until both reach the same vertex. Returns false if a side cannot continue along
  /// the line.
  bool follow() {
    while (on_one_line(back_.place, front_.place)) {
      if (back_.end == front_.end) return true;
      const bool back = dot(back_.place, back_.place) <= dot(front_.place, front_.place);
      if (!lengthen(back ? back_ : front_, back ? front_ : back_, back)) return false;
    }
    return false;
  }

  bool lengthen(Side& side, const Side& other, bool back) {
    for (const AtVertex& next : at(back ? arriving_ : leaving_, side.end)) {
      if (steps_left_ == 0) return false;
      --steps_left_;
      pacer_.step(4);
      const VertexId end = back ? surface_.from(open_[next.open]) : surface_.to(open_[next.open]);
      const Vec3d place = from_tip(end);
      if (taken_[next.open] || !(dot(place, place) > dot(side.place, side.place)) ||
          !on_one_line(place, other.place))
        continue;
      add(side, next.open, end);
      return true;
    }
    return false;
  }

  const Surface& surface_;
  double tolerance2_;
  Pacer pacer_;
  std::vector<HalfEdge> open_;                // ascending
  std::vector<std::uint8_t> taken_;           // per member of open_
  std::vector<AtVertex> leaving_, arriving_;  // by vertex
  std::uint64_t steps_left_ = 0;
  VertexId tip_ = kNoVertex;
  Side back_, front_;
};

}  // namespace

std::vector<std::vector<HalfEdge>> find_seams(const Surface& surface, double tolerance,
                                              const Execution& execution) {
  return SeamFinder(surface, tolerance, execution).run();
}

}  // namespace fracture::solid_detail
