#include "common/fragment/bonds.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/fragment/cap_area.hpp"

namespace fracture {

std::vector<Bond> find_bonds(const RestrictedDiagram& d, const Pieces& pieces,
                             const std::vector<std::uint32_t>& group_of_piece, const Execution& execution) {
  Pacer pacer(execution);
  struct CapContact {
    std::uint32_t a, b, region;
    bool reversed;  // the cap's normal points from b to a
  };
  std::vector<CapContact> contacts;
  contacts.reserve(d.caps.regions.size());
  for (std::uint32_t r = 0; r < d.caps.regions.size(); ++r) {
    pacer.step();
    const std::uint32_t p = pieces.piece_of_cap[2 * r], q = pieces.piece_of_cap[2 * r + 1];
    if (p == kNoIndex || q == kNoIndex) continue;
    const std::uint32_t a = group_of_piece[p], b = group_of_piece[q];
    if (a == b || a == kNoIndex || b == kNoIndex) continue;
    contacts.push_back({std::min(a, b), std::max(a, b), r, a > b});
  }
  // Usually they are sorted already, because both regions and fragments are in the order of their cells.
  const auto before = [](const CapContact& x, const CapContact& y) {
    if (x.a != y.a) return x.a < y.a;
    if (x.b != y.b) return x.b < y.b;
    return x.region < y.region;
  };
  if (!std::is_sorted(contacts.begin(), contacts.end(), before))
    sort_with_polls(execution, contacts.begin(), contacts.end(), before);

  // Contacts between the same two groups are consecutive; each such run becomes a bond.
  std::vector<std::size_t> begin;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    pacer.step();
    if (k == 0 || contacts[k].a != contacts[k - 1].a || contacts[k].b != contacts[k - 1].b)
      begin.push_back(k);
  }
  std::vector<Bond> bonds(begin.size());
  begin.push_back(contacts.size());
  const auto measured = [&](std::size_t first, std::size_t last, Pacer& own_pacer) {
    Bond bond{contacts[first].a, contacts[first].b, 0, {}, {}};
    Vec3d normal, moment;
    for (std::size_t k = first; k < last; ++k) {
      const CapRegion& r = d.caps.regions[contacts[k].region];
      own_pacer.step(2 * r.triangle_count);
      const CapArea cap(d, r);
      for (std::uint32_t t = r.first_triangle; t < r.first_triangle + r.triangle_count; ++t) {
        const CapArea::Measured triangle = cap.of(t);
        bond.area += triangle.area;
        normal = contacts[k].reversed ? normal - triangle.normal : normal + triangle.normal;
        moment = moment + (triangle.area / 3) * triangle.corners_sum;
      }
    }
    if (!(bond.area > 0)) return bond;
    bond.centroid = (1 / bond.area) * moment;
    const double l = length(normal);
    bond.normal = l > 0 ? (1 / l) * normal : Vec3d{0, 0, 1};
    return bond;
  };
  parallel_for(execution, bonds.size(), 128, [&](std::size_t first, std::size_t last) {
    Pacer own_pacer(execution);
    for (std::size_t k = first; k < last; ++k) bonds[k] = measured(begin[k], begin[k + 1], own_pacer);
  });
  std::erase_if(bonds, [](const Bond& bond) { return !(bond.area > 0); });
  return bonds;
}

}  // namespace fracture
