#include "server/service/solid_figures.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/bulk.hpp"
#include "common/solid/contact_graph.hpp"

namespace fracture {
namespace {

/// A part is much smaller than a cell if it has at most this share of its volume.
constexpr double kLooseShare = 0.25;
/// A part is small if it has at most this share of the space that a hit breaks.
constexpr double kSmallPart = 0.25;
/// Bytes whose hashing takes about as long as a step, or less.
constexpr std::size_t kStepAsHashed = 8;

}  // namespace

void SolidFigures::step(std::size_t steps) const {
  count_bulk(kStepAsHashed * steps);
  pacer_.step(steps);
}

template <class Visit>
void SolidFigures::each_part(const Visit& visit) const {
  constexpr std::size_t kAtOnce = 256;
  const std::vector<Part>& parts = solid_.parts;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (p % kAtOnce == 0) step(std::min(kAtOnce, parts.size() - p));
    visit(parts[p], p);
  }
}

const SolidShape& SolidFigures::shape() const {
  if (!shape_) {
    step(1 + solid_.parts.size() / 4);
    shape_ = shape_of(solid_);
  }
  return *shape_;
}

const std::vector<double>& SolidFigures::fills() const {
  if (fills_.size() == solid_.parts.size()) return fills_;
  fills_.clear();
  fills_.reserve(solid_.parts.size());
  each_part([&](const Part& part, std::size_t) { fills_.push_back(fill_of(part)); });
  return fills_;
}

LooseParts SolidFigures::loose_parts(double cell, bool are_apart) const {
  LooseParts loose;
  if (!solid_.contacts && !are_apart) return loose;
  if (const auto known = loose_.find({cell, are_apart}); known != loose_.end()) return known->second;
  if (!are_apart && in_contact_.empty()) {
    step(1 + solid_.contacts->contacts.size() / 4);
    in_contact_.assign(solid_.parts.size(), 0);
    for (const Contact& contact : solid_.contacts->contacts)
      in_contact_[contact.a] = in_contact_[contact.b] = 1;
  }
  const std::vector<double>& fill = fills();
  const CellSize size(cell);
  each_part([&](const Part& part, std::size_t p) {
    if ((!are_apart && in_contact_[p]) || part.volume > kLooseShare * cell) return;
    ++loose.count;
    loose.pieces += cells_meeting(fill[p] * part.box.size(), part.volume, size);
  });
  loose_.emplace(std::pair{cell, are_apart}, loose);
  return loose;
}

SmallParts SolidFigures::small_parts(const LocalImpact& hit, double space) const {
  SmallParts small;
  if (solid_.parts.size() < 2) return small;
  const std::array<double, 6> key{hit.point.x, hit.point.y, hit.point.z, hit.radius, 1.0 * hit.sites, space};
  if (const auto known = small_.find(key); known != small_.end()) return known->second;
  const std::vector<double>& fill = fills();
  const CellSize cell(space / hit.sites);
  std::size_t larger = 0;
  each_part([&](const Part& part, std::size_t p) {
    Vec3d sides, beyond;  // of the box in the cube around the ball, and from the hit to the box
    for (int a = 0; a < 3; ++a) {
      sides[a] = std::fmin(part.box.max[a], hit.point[a] + hit.radius) -
                 std::fmax(part.box.min[a], hit.point[a] - hit.radius);
      beyond[a] = std::fmax(0, std::fmax(part.box.min[a] - hit.point[a], hit.point[a] - part.box.max[a]));
    }
    const Vec3d box = part.box.size();
    if (length(beyond) > hit.radius || !(box.x * box.y * box.z > 0)) return;
    const double inside = part.volume * (sides.x / box.x) * (sides.y / box.y) * (sides.z / box.z);
    if (inside > kSmallPart * space) {
      ++larger;
      return;
    }
    const double met = cells_meeting(fill[p] * sides, inside, cell);
    ++small.count;
    small.volume += inside;
    small.pieces += std::fmin(1.0 + hit.sites, 1 + kDenseInTheMiddle * (met - 1));
  });
  small.are_all = small.count > 0 && larger == 0;
  small_.emplace(key, small);
  return small;
}

}  // namespace fracture
