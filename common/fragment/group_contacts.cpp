#include "common/fragment/group_contacts.hpp"

#include <algorithm>
#include <iterator>

#include "common/fragment/cap_area.hpp"

namespace fracture {

GroupContacts::GroupContacts(const RestrictedDiagram& diagram, const Pieces& pieces, PieceGroups& groups,
                             const Execution& execution)
    : d_(diagram), pieces_(pieces), groups_(groups), execution_(execution), pacer_(execution) {}

// Sums in the same order as find_bonds(), because choices made by area must not depend on the last bit.
double GroupContacts::area_of(const std::vector<std::uint32_t>& regions) {
  double area = 0;
  for (const std::uint32_t region : regions) {
    const CapRegion& r = d_.caps.regions[region];
    const CapArea cap(d_, r);
    pacer_.step(r.triangle_count);
    for (std::uint32_t t = r.first_triangle; t < r.first_triangle + r.triangle_count; ++t)
      area += cap.of(t).area;
  }
  return area;
}

GroupContacts::Neighbors& GroupContacts::known(std::uint32_t set) {
  const auto [at, fresh] = known_.try_emplace(set);
  Neighbors& neighbors = at->second;
  if (!fresh) return neighbors;
  for (const std::uint32_t member : groups_.members(groups_.name_of_set(set), execution_)) {
    FaceSource last = kNoIndex;
    for (const Face& face : pieces_.pieces[member].faces) {
      pacer_.step();
      if (!is_cap(face.source) || face.source == last) continue;  // the faces of a region are consecutive
      last = face.source;
      const std::uint32_t other = pieces_.piece_of_cap[(face.source ^ 1) & ~kCapFace];
      if (other == kNoIndex || groups_.set_of(other) == set) continue;
      neighbors[groups_.set_of(other)].regions.push_back(cap_region(face.source));
    }
  }
  for (auto& [other, shared] : neighbors) {
    sort_with_polls(execution_, shared.regions.begin(), shared.regions.end());
    shared.regions.erase(std::unique(shared.regions.begin(), shared.regions.end()), shared.regions.end());
    measure(shared);
  }
  return neighbors;
}

std::vector<Neighbor> GroupContacts::neighbors(std::uint32_t group) {
  std::vector<Neighbor> all;
  for (const auto& [set, shared] : known(groups_.set_of(group))) {
    all.push_back({groups_.name_of_set(set), shared.area});
    pacer_.step();
  }
  sort_with_polls(execution_, all.begin(), all.end(), [](const Neighbor& x, const Neighbor& y) {
    return x.area != y.area ? x.area > y.area : x.group < y.group;
  });
  return all;
}

void GroupContacts::unite(std::uint32_t a, std::uint32_t b) {
  // Both groups must be known before they are united.
  if (groups_.of(a) == groups_.of(b)) return;
  known(groups_.set_of(a));
  known(groups_.set_of(b));
  const auto [kept, gone] = groups_.unite(a, b, pacer_);
  auto moved = known_.extract(gone);
  Neighbors& to = known_.at(kept);
  to.erase(gone);
  for (auto& [other, shared] : moved.mapped()) {
    if (other == kept) continue;
    pacer_.step(16);
    Shared& sum = to[other];
    std::vector<std::uint32_t> regions;
    std::merge(sum.regions.begin(), sum.regions.end(), shared.regions.begin(), shared.regions.end(),
               std::back_inserter(regions));
    sum.regions = std::move(regions);
    measure(sum);
    const auto mutual = known_.find(other);
    if (mutual == known_.end()) continue;
    mutual->second.erase(gone);
    mutual->second[kept] = sum;
  }
  clear_nodes(pacer_, moved.mapped());
}

void GroupContacts::release() {
  for (auto& [set, neighbors] : known_) clear_nodes(pacer_, neighbors);
  clear_nodes(pacer_, known_);
}

}  // namespace fracture
