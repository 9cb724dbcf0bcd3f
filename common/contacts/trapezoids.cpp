#include "common/contacts/trapezoids.hpp"

#include <algorithm>
#include <cmath>

namespace fracture::contacts_detail {

void TrapezoidSweep::set_frame(const NearTriangle& t) {
  double longest = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d edge = t.corners[(k + 1) % 3] - t.corners[k];
    if (const double square = dot(edge, edge); square > longest) {
      longest = square;
      edge_ = k;
    }
  }
  origin_ = t.corners[edge_];
  const Vec3d edge = t.corners[(edge_ + 1) % 3] - origin_, apex = t.corners[(edge_ + 2) % 3] - origin_;
  length_ = length(edge);
  along_ = (1 / length_) * edge;
  up_ = cross(t.normal, along_);
  apex_u_ = std::clamp(dot(apex, along_), 0.0, length_);
  apex_v_ = dot(apex, up_);
}

void TrapezoidSweep::add_lines(std::span<const Segment> segments) {
  lines_.clear();
  for (const Segment& s : segments) {
    pacer_.step();
    const Vec3d tail = s.tail - origin_, head = s.head - origin_;
    const double u0 = std::clamp(dot(tail, along_), 0.0, length_),
                 u1 = std::clamp(dot(head, along_), 0.0, length_);
    const double v0 = dot(tail, up_), v1 = dot(head, up_);
    if (u0 < u1) lines_.push_back({u0, v0, u1, v1, 1});
    if (u1 < u0) lines_.push_back({u1, v1, u0, v0, -1});
  }
  std::sort(lines_.begin(), lines_.end(), [](const Line& a, const Line& b) {
    return a.u0 != b.u0 ? a.u0 < b.u0 : a.v0 != b.v0 ? a.v0 < b.v0 : a.v1 < b.v1;
  });
}

double TrapezoidSweep::height(std::uint32_t line, double u) const {
  if (line == kBottom) return 0;
  if (line == kLeftRoof) return apex_u_ > 0 ? u / apex_u_ * apex_v_ : apex_v_;
  if (line == kRightRoof) return apex_u_ < length_ ? (length_ - u) / (length_ - apex_u_) * apex_v_ : apex_v_;
  return lines_[line].at(u);
}

double TrapezoidSweep::slope(std::uint32_t line) const {
  if (line == kBottom) return 0;
  if (line == kLeftRoof) return apex_u_ > 0 ? apex_v_ / apex_u_ : 0;
  if (line == kRightRoof) return apex_u_ < length_ ? -apex_v_ / (length_ - apex_u_) : 0;
  return (lines_[line].v1 - lines_[line].v0) / (lines_[line].u1 - lines_[line].u0);
}

/// Continues the chain from its line to another line, which must begin at the first line's end. Returns
/// false if the region would not be convex. `outwards`: 1 if the region is below the chain, -1 if it is
/// above.
bool TrapezoidSweep::goes_on(Chain& chain, std::uint32_t line, double at, double outwards) const {
  if (chain.line == line) return true;
  const double v = height(chain.line, at);
  if (std::fabs(v - height(line, at)) > 1e-12 * length_) return false;
  const double turn = outwards * (slope(line) - slope(chain.line));
  if (turn > 0 || chain.size + 2 > chain.u.size()) return false;
  chain.u[chain.size] = at;
  chain.v[chain.size++] = v;
  chain.line = line;
  return true;
}

void TrapezoidSweep::close(Open& open, double until) {
  for (Chain* chain : {&open.below, &open.above}) {
    chain->u[chain->size] = until;
    chain->v[chain->size] = height(chain->line, until);
    ++chain->size;
  }
  ConvexRegion region;
  region.size = 0;
  region.winding = open.winding;
  double twice = 0, first_u = 0, first_v = 0, last_u = 0, last_v = 0;
  const auto push = [&](double u, double v) {
    if (region.size > 0 && std::fabs(u - last_u) + std::fabs(v - last_v) <= 1e-12 * length_) return;
    if (region.size == 0) {
      first_u = u;
      first_v = v;
    } else {
      twice += (last_u - first_u) * (v - first_v) - (last_v - first_v) * (u - first_u);
    }
    region.corners[region.size++] = origin_ + u * along_ + v * up_;
    last_u = u;
    last_v = v;
  };
  for (std::size_t k = 0; k < open.below.size; ++k) push(open.below.u[k], open.below.v[k]);
  for (std::size_t k = open.above.size; k-- > 0;) push(open.above.u[k], open.above.v[k]);
  region.area = 0.5 * twice;
  if (region.size > 2 && region.area > 0) made_.push_back(region);
}

const std::vector<ConvexRegion>& TrapezoidSweep::of(const NearTriangle& t, std::span<const Segment> segments,
                                                    std::span<const EdgeJump> jumps,
                                                    const std::array<int, 3>& windings) {
  made_.clear();
  set_frame(t);
  add_lines(segments);
  stops_.assign({0, apex_u_, length_});
  std::vector<std::pair<double, int>> bottom;  // jumps along the longest edge
  for (const EdgeJump& jump : jumps)
    if (jump.edge == edge_) bottom.emplace_back(jump.x * length_, jump.jump);
  std::sort(bottom.begin(), bottom.end());
  for (const auto& [u, jump] : bottom) stops_.push_back(u);
  for (const Line& line : lines_) {
    stops_.push_back(line.u0);
    stops_.push_back(line.u1);
  }
  std::sort(stops_.begin(), stops_.end());

  const double least = 1e-12 * length_;
  active_.clear();
  open_.clear();
  std::uint32_t next_line = 0;
  auto next_jump = bottom.begin();
  int at_bottom = windings[edge_];
  double from = 0;
  for (const double to : stops_) {
    if (!(to - from > least)) continue;
    const double middle = 0.5 * (from + to);
    for (; next_line < lines_.size() && lines_[next_line].u0 < middle; ++next_line)
      active_.push_back(next_line);
    std::erase_if(active_, [&](std::uint32_t line) { return lines_[line].u1 < middle; });
    for (; next_jump != bottom.end() && next_jump->first < middle; ++next_jump)
      at_bottom += next_jump->second;
    pacer_.step(1 + active_.size() / 8);
    // The order hardly changes from stop to stop.
    for (std::size_t k = 1; k < active_.size(); ++k)
      for (std::size_t m = k; m > 0 && height(active_[m], middle) < height(active_[m - 1], middle); --m)
        std::swap(active_[m], active_[m - 1]);

    next_.clear();
    new_.clear();
    std::size_t searched = 0;
    const auto add = [&](std::uint32_t below, std::uint32_t above, int winding) {
      if (winding == 0) return;
      for (std::size_t k = searched; k < open_.size(); ++k)
        if (open_[k].below.line == below && open_[k].above.line == above && open_[k].winding == winding) {
          next_.push_back(open_[k]);
          open_[k].winding = 0;  // continues
          searched = k + 1;
          return;
        }
      new_.push_back(static_cast<std::uint32_t>(next_.size()));
      Open& begun = next_.emplace_back();
      begun.winding = winding;
      begun.below.line = below;
      begun.above.line = above;
      for (Chain* chain : {&begun.below, &begun.above}) {
        chain->size = 1;
        chain->u[0] = from;
        chain->v[0] = height(chain->line, from);
      }
    };
    std::uint32_t below = kBottom;
    int winding = at_bottom;
    for (const std::uint32_t line : active_) {
      add(below, line, winding);
      winding += lines_[line].step;
      below = line;
    }
    add(below, middle < apex_u_ ? kLeftRoof : kRightRoof, winding);
    for (const std::uint32_t begun : new_)
      for (Open& open : open_) {
        if (open.winding == 0 || open.winding != next_[begun].winding) continue;
        Open longer = open;
        if (!goes_on(longer.below, next_[begun].below.line, from, -1) ||
            !goes_on(longer.above, next_[begun].above.line, from, 1))
          continue;
        next_[begun] = longer;
        open.winding = 0;
        break;
      }
    for (Open& open : open_)
      if (open.winding != 0) close(open, from);
    open_.swap(next_);
    from = to;
  }
  for (Open& open : open_) close(open, from);
  return made_;
}

}  // namespace fracture::contacts_detail
