#include "common/contacts/part_pair.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "common/base/hilbert_curve.hpp"
#include "common/bvh/triangle_distance.hpp"
#include "common/contacts/facing.hpp"
#include "common/contacts/overlap.hpp"

namespace fracture::contacts_detail {
namespace {

Vec3d normal_of(const Vec3d& sum, double area, const Box& a, const Box& b) {
  if (const double l = length(sum); l > kCancelled * area) return (1 / l) * sum;
  const Vec3d between = b.center() - a.center();
  const double l = length(between);
  return l > 0 ? (1 / l) * between : Vec3d{1, 0, 0};
}

}  // namespace

double rounding_of(const Box& box) {
  Vec3d steps;
  for (int axis = 0; axis < 3; ++axis) {
    int exponent = 0;
    const double largest = std::max(std::fabs(box.min[axis]), std::fabs(box.max[axis]));
    std::frexp(largest, &exponent);
    steps[axis] = largest > 0 ? std::ldexp(1, exponent - std::numeric_limits<float>::digits) : 0;
  }
  return length(steps);
}

/// Whether the boxes have more in common than rounding can cause for boxes that only touch.
bool PairMeasurer::overlap_shows(const Box& common) const {
  for (int axis = 0; axis < 3; ++axis)
    if (!(common.max[axis] - common.min[axis] > pair_.rounding)) return false;
  return true;
}

/// Whether a plane separates the parts, apart from rounding, so that nothing overlaps. Only tried for small
/// parts, with the plane of the triangle in each part that faces the other part most.
bool PairMeasurer::parted_by_plane() const {
  constexpr std::uint32_t kSmall = 64;
  if (surfaces_.triangles_of(pair_.part_a) > kSmall || surfaces_.triangles_of(pair_.part_b) > kSmall)
    return false;
  const auto parts = [&](const std::vector<NearTriangle>& own, std::uint32_t own_part,
                         std::uint32_t other_part) {
    const NearTriangle* plane = nullptr;
    for (const NearTriangle& t : own)
      if (t.faced.area > (plane ? plane->faced.area : 0)) plane = &t;
    if (!plane) return false;
    const double height = dot(plane->normal, plane->corners[0] + pair_.origin);
    const auto all = [&](std::uint32_t part, double sign) {
      for (std::uint32_t k = 0; k < surfaces_.triangles_of(part); ++k)
        for (const Vec3d& p : surfaces_.corners(surfaces_.first_of(part) + k))
          if (sign * (dot(plane->normal, p) - height) > pair_.rounding) return false;
      return true;
    };
    return all(own_part, 1) && all(other_part, -1);
  };
  return parts(pair_.a, pair_.part_a, pair_.part_b) || parts(pair_.b, pair_.part_b, pair_.part_a);
}

void PairMeasurer::measure_facing(double low) {
  for (NearTriangle& t : pair_.a) t.faced = {};
  for (NearTriangle& t : pair_.b) t.faced = {};
  facing_a_.clear();
  facing_b_.clear();
  for (const auto& [i, k] : pair_.pairs)
    add_facing(pair_.a[i], i, facing_a_, pair_.b[k], k, facing_b_, {low, reach_});
  pacer_.step(2 * pair_.pairs.size());
}

bool PairMeasurer::within_reach() {
  for (const auto& [i, k] : pair_.pairs) {
    pacer_.step(4);
    if (are_within(pair_.a[i].corners, pair_.b[k].corners, reach_)) return true;
  }
  return false;
}

/// Whether `inner` lies in an empty ball: a ball around the middle of `outer` that neither meets the
/// surface of `outer` nor lies inside it.
bool PairMeasurer::is_in_hollow(std::uint32_t inner, std::uint32_t outer) {
  const auto& parts = surfaces_.solid().parts;
  if (!contains(parts[outer].box, parts[inner].box)) return false;
  const auto &of_inner = surfaces_.core(inner, pacer_), &of_outer = surfaces_.core(outer, pacer_);
  return length(of_inner.center - of_outer.center) + of_inner.farthest + 2 * reach_ < of_outer.nearest &&
         of_outer.winding == 0;
}

/// Sorts the pieces so that successive ones are near each other.
void PairMeasurer::sort_pieces(std::size_t first, std::vector<ContactPiece>& pieces) {
  constexpr std::size_t kFew = 8;
  constexpr int kBits = 10;
  if (pieces.size() - first <= kFew) return;
  Box box;
  const auto middle = [](const ContactPiece& piece) { return 0.5 * (piece.corners[0] + piece.corners[2]); };
  for (std::size_t k = first; k < pieces.size(); ++k) box.add(middle(pieces[k]));
  const HilbertCurve curve(box, kBits);
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  order.reserve(pieces.size() - first);
  for (std::size_t k = first; k < pieces.size(); ++k) order.emplace_back(curve.at(middle(pieces[k])), k);
  sort_with_polls(execution_, order.begin(), order.end());
  std::vector<ContactPiece> sorted;
  sorted.reserve(order.size());
  for (const auto& [at, k] : order) sorted.push_back(pieces[k]);
  std::copy(sorted.begin(), sorted.end(), pieces.begin() + static_cast<std::ptrdiff_t>(first));
}

std::optional<Contact> PairMeasurer::measure(std::uint32_t a, std::uint32_t b,
                                             std::vector<ContactPiece>& pieces) {
  const Box &box_a = surfaces_.solid().parts[a].box, &box_b = surfaces_.solid().parts[b].box;
  pair_.part_a = a;
  pair_.part_b = b;
  pair_.rounding = std::max(rounding_of(box_a), rounding_of(box_b));
  reach_ = gap_ + pair_.rounding;
  pair_.reach = reach_ + 2 * pair_.rounding;  // triangles that are moved off a surface are still near it
  const Box common = common_of(widened(box_a, reach_), widened(box_b, reach_));
  const bool may_overlap = overlap_shows(common_of(box_a, box_b));
  pair_.origin = common.center();
  pacer_.step();
  if (is_in_hollow(a, b) || is_in_hollow(b, a)) return std::nullopt;
  pair_.gather(surfaces_, execution_, pacer_);

  Contact contact{.a = a, .b = b, .place = common.center(), .normal = normal_of({}, 0, box_a, box_b)};
  measure_facing(-pair_.rounding);
  Faced faced_a = faced_by(pair_.a), faced_b = faced_by(pair_.b);
  const std::optional<Overlap> overlap =
      may_overlap && !parted_by_plane() ? find_overlap(surfaces_, pair_, execution_, pacer_) : std::nullopt;
  struct Side {
    const Patch& patch;
    const Vec3d& outward;
  };
  const auto describe = [&](ContactMeasure measure, bool of_b, double area, const Side& side_a,
                            const Side& side_b) {
    contact.measure = measure;
    contact.of_b = of_b;
    contact.area = area;
    const double both = side_a.patch.area + side_b.patch.area;
    contact.place = pair_.origin + (1 / both) * (side_a.patch.moment + side_b.patch.moment);
    contact.normal = normal_of(side_a.outward - side_b.outward, both, box_a, box_b);
  };
  if (overlap) {
    const double inside_a = overlap->a.patch.area, inside_b = overlap->b.patch.area,
                 flush = overlap->flush.area;
    const double most = std::max(inside_a, inside_b), least = std::min(inside_a, inside_b);
    if (overlap->depth > pair_.rounding) {
      contact.kind = ContactKind::kOverlapping;
      contact.volume = overlap->volume;
      const bool around = !(least > kCancelled * most);  // one part is entirely inside the other
      if (most > kCancelled * flush)
        describe(ContactMeasure::kInside, around ? inside_b > inside_a : inside_b < inside_a,
                 around ? most : least, {overlap->a.patch, overlap->a.outward},
                 {overlap->b.patch, overlap->b.outward});
      else
        describe(ContactMeasure::kCommon, false, flush, {overlap->flush, {}}, {overlap->flush, {}});
    }
    measure_facing(contact.kind == ContactKind::kOverlapping ? -reach_ : -pair_.rounding);
    faced_a = faced_by(pair_.a);
    faced_b = faced_by(pair_.b);
  }
  const double least = std::min(faced_a.patch.area, faced_b.patch.area);
  if (faced_a.patch.area + faced_b.patch.area > 0 && least >= contact.area)
    describe(ContactMeasure::kFacing, faced_b.patch.area < faced_a.patch.area, least,
             {faced_a.patch, faced_a.outward}, {faced_b.patch, faced_b.outward});
  else if (contact.kind == ContactKind::kTouching && !overlap && !within_reach())
    return std::nullopt;
  if (!(contact.area > 0)) return contact;
  const std::size_t first_piece = pieces.size();
  if (contact.measure == ContactMeasure::kFacing)
    piece_maker_.add_facing(contact, pair_, contact.of_b ? facing_b_ : facing_a_, pieces);
  else if (contact.measure == ContactMeasure::kInside)
    piece_maker_.add_inside(contact, pair_, *overlap, pieces);
  else
    piece_maker_.add_common(pair_, *overlap, pieces);
  sort_pieces(first_piece, pieces);
  return contact;
}

}  // namespace fracture::contacts_detail
