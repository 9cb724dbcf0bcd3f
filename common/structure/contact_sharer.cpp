#include "common/structure/contact_sharer.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace fracture {
namespace {

/// Each of the two surfaces is off by less than one step of the lattice.
constexpr double kRoundingInSteps = 2;
/// Number of successive pieces, near each other, that are first examined together.
constexpr std::size_t kBlock = 8;
/// A sum of normals that is a smaller share of the area is noise.
constexpr double kCancelled = 1e-9;
/// m²: the reciprocal of a smaller area may be infinite.
constexpr double kLeastArea = 1e-200;

Vec3d turned(const Vec3d& v) { return {v.x == 0 ? 0 : -v.x, v.y == 0 ? 0 : -v.y, v.z == 0 ? 0 : -v.z}; }

}  // namespace

ContactSharer::ContactSharer(const ContactBonds& with, const FragmentsOfCells& table,
                             const CellDivision& division, std::span<const Fragment* const> fragments,
                             std::span<const char> wanted, std::span<const char> wanted_parts,
                             const Execution& execution)
    : with_(with),
      table_(table),
      division_(division),
      wanted_(wanted),
      wanted_parts_(wanted_parts),
      rounding_(kRoundingInSteps * std::max({with.lattice_step.x, with.lattice_step.y, with.lattice_step.z})),
      pacer_(execution),
      islands_(fragments, rounding_, execution) {}

ContactSharer::Region ContactSharer::region_of(std::span<const Vec3d> corners) {
  Region region;
  Vec3d moment;
  double reach2 = 0;
  const Vec3d& o = corners[0];
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const Vec3d q = corners[k] - o;
    reach2 = std::max(reach2, dot(q, q));
    if (k + 1 == corners.size()) break;
    const Vec3d r = corners[k + 1] - o;
    const double twice = length(cross(q, r));
    region.area += 0.5 * twice;
    moment = moment + twice * (q + r);
  }
  region.reach = std::sqrt(reach2);
  region.middle = region.area > 0 ? o + (1 / (6 * region.area)) * moment
                                  : (1.0 / 3) * (corners[0] + corners[1] + corners[2]);
  return region;
}

bool ContactSharer::any_wanted(std::span<const std::uint32_t> cells) const {
  return std::any_of(cells.begin(), cells.end(), [&](std::uint32_t cell) {
    const auto all = table_.fragments(cell);
    return std::any_of(all.begin(), all.end(), [&](std::uint32_t f) { return is_wanted(f); });
  });
}

/// Whether a fragment at the block is wanted. If both parts have the same cells, the other part's cells are
/// those of the same sites.
bool ContactSharer::any_wanted_in_block() const {
  if (any_wanted(own_.block.cells)) return true;
  if (!is_one_place_) return any_wanted(other_.block.cells);
  return std::any_of(own_.block.cells.begin(), own_.block.cells.end(), [&](std::uint32_t cell) {
    const std::uint32_t same = table_.find(other_.part, table_.site(cell));
    return same != kNoIndex && any_wanted({&same, 1});
  });
}

/// Adds the bond of two parts that are one fragment each, if their contact is measured by facing.
void ContactSharer::add_whole(const Contact& contact, std::vector<Bond>& bonds) const {
  const std::uint32_t a = table_.only(contact.a), b = table_.only(contact.b);
  if (a == b || (!is_wanted(a) && !is_wanted(b))) return;
  bonds.push_back({std::min(a, b), std::max(a, b), contact.area, contact.place,
                   a < b ? contact.normal : turned(contact.normal), with_.strength});
}

CellBox ContactSharer::image(const Side& side, const Box& box) {
  const Vec3d half = 0.5 * (box.max - box.min);
  if (!side.frame) return {box.center(), half};
  CellBox made{side.frame->image(box.center()), {}};
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d& row = side.frame->matrix.rows[static_cast<std::size_t>(axis)];
    made.half[axis] = std::fabs(row.x) * half.x + std::fabs(row.y) * half.y + std::fabs(row.z) * half.z;
  }
  return made;
}

void ContactSharer::share(std::uint32_t number, std::vector<Bond>& bonds) {
  const ContactGraph& graph = *with_.solid.contacts;
  const Contact& contact = graph.contacts[number];
  pacer_.step();
  if (!(contact.area > 0)) return;
  if (contact.measure == ContactMeasure::kFacing && table_.only(contact.a) != kNoIndex &&
      table_.only(contact.b) != kNoIndex)
    return add_whole(contact, bonds);
  if (!wanted_.empty() && !wanted_parts_[contact.a] && !wanted_parts_[contact.b]) return;
  measure_ = contact.measure;
  own_.part = contact.of_b ? contact.b : contact.a;
  other_.part = contact.of_b ? contact.a : contact.b;
  for (Side* side : {&own_, &other_})
    side->frame = with_.cells.map ? &with_.cells.map.of_part(side->part) : nullptr;
  const std::span<const ContactPiece> pieces(graph.pieces.data() + graph.first_piece[number],
                                             graph.first_piece[number + 1] - graph.first_piece[number]);
  sums_.clear();
  sorted_.clear();
  is_one_place_ = own_.frame == other_.frame;
  boxes_.clear();
  block_boxes_.clear();
  Box all;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    Box box;
    for (const Vec3d& p : pieces[k].corners) box.add(p);
    const double h = std::fabs(static_cast<double>(pieces[k].height));
    if (h > rounding_) {
      is_one_place_ = false;
      box = {box.min - Vec3d{h, h, h}, box.max + Vec3d{h, h, h}};
    }
    if (k % kBlock == 0) block_boxes_.emplace_back();
    boxes_.push_back(box);
    block_boxes_.back().add(box);
    all.add(box);
  }
  Side* const sides[] = {&own_, &other_};
  const std::span<Side* const> looked_at(sides, is_one_place_ ? 1 : 2);
  pacer_.step(pieces.size() / 2);
  for (Side* side : looked_at) {
    pacer_.step(1 + table_.of(side->part).size() / 8);
    division_.near(side->part, image(*side, all), scratch_, side->near);
    if (side->near.size() == 0) return;
  }
  for (std::size_t k = 0; k < block_boxes_.size(); ++k) {
    for (Side* side : looked_at) {
      pacer_.step(1 + side->near.size() / 8);
      if (block_boxes_.size() == 1)
        side->block = side->near;
      else
        CellDivision::near_of(side->near, image(*side, block_boxes_[k]), scratch_, side->block);
    }
    if (!wanted_.empty() && !any_wanted_in_block()) continue;
    const std::size_t end = std::min(pieces.size(), (k + 1) * kBlock);
    for (std::size_t piece = k * kBlock; piece < end; ++piece) divide(pieces[piece], boxes_[piece]);
    pacer_.step(4 * kBlock);
  }
  for (const Sum& sum : sums_) {
    pacer_.step();
    if (sum.own == sum.other || !(sum.area > std::max(sum.noise, kLeastArea)))
      continue;  // one fragment, or only rims of cuts
    if (!is_wanted(sum.own) && !is_wanted(sum.other)) continue;
    const double l = length(sum.normal);
    Vec3d from_own = (1 / l) * sum.normal;
    if (!(l > kCancelled * sum.area)) from_own = contact.of_b ? turned(contact.normal) : contact.normal;
    bonds.push_back({std::min(sum.own, sum.other), std::max(sum.own, sum.other), sum.area,
                     (1 / sum.area) * sum.moment, sum.own < sum.other ? from_own : turned(from_own),
                     with_.strength});
  }
}

/// Calls visit(cell, region, is_cut) for the region of a polygon in each cell of a side.
template <class Visit>
void ContactSharer::each_region(const Side& side, const CellPolygon& polygon, const Visit& visit) {
  const std::vector<std::uint32_t>& places = side.here.places;
  const std::uint32_t nearest = side.here.nearest;
  const auto& cells = side.block.cells;
  if (places.size() == 1) return visit(cells[nearest], polygon, false);
  CellPolygon of_nearest, region;
  if (!division_.region(nearest, side.block, places, polygon, of_nearest))
    return visit(cells[nearest], polygon, false);
  for (const std::uint32_t place : places) {
    pacer_.step(places.size());
    if (place != nearest) division_.region(place, side.block, places, polygon, region);
    const CellPolygon& its = place == nearest ? of_nearest : region;
    if (its.size() > 0) visit(cells[place], its, true);
  }
}

void ContactSharer::divide(const ContactPiece& of, const Box& box) {
  CellDivision::near_of(own_.block, image(own_, box), own_.here);
  if (!is_one_place_) CellDivision::near_of(other_.block, image(other_, box), other_.here);
  const std::array<Vec3d, 4>& corners = of.corners;
  const std::size_t size = of.corners[2] == of.corners[3] ? 3 : 4;
  const Placed piece{of, static_cast<double>(of.height) * to_double(of.normal),
                     region_of({corners.data(), size})};
  CellPolygon whole;
  if (own_.here.places.size() == 1 && (is_one_place_ || other_.here.places.size() == 1))
    return divide_other(piece, own_.block.cells[own_.here.nearest], whole, false);
  for (std::size_t k = 0; k < size; ++k) whole.push(image(own_, corners[k]), kNoSite);
  each_region(own_, whole, [&](std::uint32_t cell, const CellPolygon& region, bool is_cut) {
    divide_other(piece, cell, region, is_cut);
  });
}

/// Divides a piece's region in one cell of the measured part. Without `is_cut`, the region is the whole piece.
void ContactSharer::divide_other(const Placed& piece, std::uint32_t own, const CellPolygon& polygon,
                                 bool is_cut) {
  if (is_one_place_) {
    const std::uint32_t same = table_.find(other_.part, table_.site(own));
    if (same == kNoIndex) return;  // possible only because of rounding
    return is_cut ? add_cut(piece, own, same, polygon, own_) : add_whole_piece(piece, own, same);
  }
  if (other_.here.places.size() == 1) {
    const std::uint32_t other = other_.block.cells[other_.here.nearest];
    return is_cut ? add_cut(piece, own, other, polygon, own_) : add_whole_piece(piece, own, other);
  }
  CellPolygon over;
  for (std::size_t k = 0; k < polygon.size(); ++k)
    over.push(image(other_, place(own_, polygon.corner(k)) + piece.across), kNoSite);
  each_region(other_, over, [&](std::uint32_t other, const CellPolygon& region, bool other_cut) {
    return is_cut || other_cut ? add_cut(piece, own, other, region, other_)
                               : add_whole_piece(piece, own, other);
  });
}

void ContactSharer::add_cut(const Placed& piece, std::uint32_t own, std::uint32_t other,
                            const CellPolygon& polygon, const Side& in) {
  std::array<Vec3d, CellPolygon::kMost> corners;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    corners[k] = place(in, polygon.corner(k));
    if (&in == &other_) corners[k] = corners[k] - piece.across;
  }
  const Region region = region_of({corners.data(), polygon.size()});
  if (region.area > 0) add(piece, own, other, {corners.data(), polygon.size()}, region, true);
}

void ContactSharer::add_whole_piece(const Placed& piece, std::uint32_t own, std::uint32_t other) {
  const std::array<Vec3d, 4>& corners = piece.piece.corners;
  add(piece, own, other, {corners.data(), corners[2] == corners[3] ? 3u : 4u}, piece.whole, false);
}

void ContactSharer::add(const Placed& piece, std::uint32_t own, std::uint32_t other,
                        std::span<const Vec3d> corners, const Region& region, bool is_cut) {
  if (!may_be_divided(piece, own, other, corners))
    return add_to(pick(piece, own, other, region.middle), piece, region, is_cut);
  for (std::size_t k = 2; k < corners.size(); ++k)
    divide_among_islands(piece, own, other, {corners[0], corners[k - 1], corners[k]}, 0);
}

ContactSharer::Pair ContactSharer::pick(const Placed& piece, std::uint32_t own, std::uint32_t other,
                                        const Vec3d& at) {
  return {
      islands_.pick(own, table_.fragments(own), at, true),
      islands_.pick(other, table_.fragments(other), at + piece.across, measure_ != ContactMeasure::kInside)};
}

/// Whether several islands of one of the two cells may be at the region.
bool ContactSharer::may_be_divided(const Placed& piece, std::uint32_t own, std::uint32_t other,
                                   std::span<const Vec3d> corners) {
  if (table_.fragments(own).size() == 1 && table_.fragments(other).size() == 1) return false;
  Box here, there;
  for (const Vec3d& corner : corners) {
    here.add(corner);
    there.add(corner + piece.across);
  }
  return islands_.count_near(own, table_.fragments(own), here) > 1 ||
         islands_.count_near(other, table_.fragments(other), there) > 1;
}

/// Divides a triangle among islands by points in it. It is divided into four as long as they are in different islands.
void ContactSharer::divide_among_islands(const Placed& piece, std::uint32_t own, std::uint32_t other,
                                         const std::array<Vec3d, 3>& corners, int depth) {
  constexpr int kLeastDepth = 1, kMostDepth = 4;
  constexpr double kTowardsCorner = 0.9;  // points of two triangles are not at the same place
  const auto& [a, b, c] = corners;
  const Region region = region_of(corners);
  if (!(region.area > 0)) return;
  const Pair pair = pick(piece, own, other, region.middle);
  bool same = depth >= kLeastDepth;
  for (std::size_t k = 0; same && depth < kMostDepth && k < 3; ++k)
    same = pick(piece, own, other, region.middle + kTowardsCorner * (corners[k] - region.middle)) == pair;
  if (same) return add_to(pair, piece, region, true);
  const Vec3d ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
  for (const std::array<Vec3d, 3>& part :
       {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}})
    divide_among_islands(piece, own, other, part, depth + 1);
}

void ContactSharer::add_to(const Pair& pair, const Placed& piece, const Region& region, bool is_cut) {
  Sum& sum = sum_of(pair.own, pair.other);
  // The corners of a sliver may be on a line after rounding. It then has no area here, but the regions of it may.
  const bool is_part = is_cut && region.area < piece.whole.area;
  const double area = is_part ? region.area / piece.whole.area * piece.piece.area : piece.piece.area;
  sum.area += area;
  sum.moment = sum.moment + area * (region.middle + 0.5 * piece.across);
  sum.normal = sum.normal + area * to_double(piece.piece.normal);
  if (is_cut) sum.noise += rounding_ * region.reach;
}

ContactSharer::Sum& ContactSharer::sum_of(std::uint32_t own, std::uint32_t other) {
  if (!sums_.empty() && sums_[last_].own == own && sums_[last_].other == other) return sums_[last_];
  const auto at = std::lower_bound(
      sorted_.begin(), sorted_.end(), std::tie(own, other),
      [&](std::uint32_t k, const auto& pair) { return std::tie(sums_[k].own, sums_[k].other) < pair; });
  if (at != sorted_.end() && sums_[*at].own == own && sums_[*at].other == other) {
    last_ = *at;
    return sums_[last_];
  }
  last_ = sums_.size();
  sorted_.insert(at, static_cast<std::uint32_t>(last_));
  return sums_.emplace_back(Sum{own, other});
}

}  // namespace fracture
