// Converts caps to stored cuts, and adds stored cuts to other caps.
#include <algorithm>

#include "common/base/stamped_map.hpp"
#include "common/rough/edge_splits.hpp"
#include "common/rough/moving_caps.hpp"

namespace fracture {

std::vector<KeptCut> MovingCaps::cuts() const {
  std::vector<KeptCut> all(made_regions_);
  parallel_for(execution_, made_regions_, 16, [&](std::size_t begin, std::size_t end) {
    Pacer pacer(execution_);
    StampedMap& local = worker_map();
    std::vector<std::size_t> vertices;
    for (std::size_t r = begin; r < end; ++r) {
      const std::uint32_t first = region_begin_[r], last = region_begin_[r + 1];
      KeptCut& cut = all[r];
      cut.lo = facets_[r].lo;
      cut.hi = facets_[r].hi;
      if (first == last || !seen_[first]) continue;
      pacer.step(8 + 4 * (last - first));
      local.next_epoch(flat_.size());
      vertices.clear();
      for (std::uint32_t t = first; t < last; ++t)
        for (const CutVertexId id : caps_.triangles[t]) {
          std::uint32_t& slot = local.slot(number(id));
          if (slot != StampedMap::kEmpty) continue;
          slot = 0;
          vertices.push_back(number(id));
        }
      const auto moving =
          std::stable_partition(vertices.begin(), vertices.end(), [&](std::size_t v) { return v < fixed_; });
      for (std::size_t k = 0; k < vertices.size(); ++k) {
        const std::size_t v = vertices[k];
        local.slot(v) = static_cast<std::uint32_t>(k);
        cut.box.add(flat_[v]);
        cut.box.add(flat_[v] + moves_[v]);
      }
      cut.fixed.reserve(static_cast<std::size_t>(moving - vertices.begin()));
      for (auto v = vertices.begin(); v != moving; ++v) cut.fixed.push_back(flat_[*v]);
      for (auto v = moving; v != vertices.end(); ++v) {
        cut.flat.push_back(nearest_steps(positions_.lattice, flat_[*v]));
        cut.moves.push_back(moves_[*v]);
      }
      cut.triangles.reserve(last - first);
      for (std::uint32_t t = first; t < last; ++t) {
        const auto& ids = caps_.triangles[t];
        cut.triangles.push_back(
            {local.slot(number(ids[0])), local.slot(number(ids[1])), local.slot(number(ids[2]))});
      }
    }
  });
  std::erase_if(all, [](const KeptCut& cut) { return cut.triangles.empty(); });
  return all;
}

void MovingCaps::give(std::span<const KeptCut* const> cuts, std::span<const Calming> before,
                      std::span<const SiteId> made) {
  before_ = before;
  made_ = made;
  for (const KeptCut* const cut : cuts) {
    pacer_.step(8 + cut->triangles.size());
    const std::size_t first = positions_.first_constructed + positions_.points.size();
    const auto add = [&](const Vec3d& flat, const Vec3d& move, bool fixed) {
      append_vertex(positions_, flat);
      given_fixed_.push_back(fixed);
      flat_.push_back(flat);
      moves_.push_back(move);
      surface_.push_back(0);
      share_.push_back(1);
      moved_.push_back(0);
      place(flat_.size() - 1);
    };
    for (const Vec3d& p : cut->fixed) add(p, {}, true);
    for (std::size_t k = 0; k < cut->flat.size(); ++k)
      add(positions_.lattice.to_world(cut->flat[k]), cut->moves[k], false);
    facets_.push_back({cut->lo, cut->hi, 0, {}});
    for (const auto& t : cut->triangles)
      caps_.triangles.push_back(
          {CutVertexId{first + t[0]}, CutVertexId{first + t[1]}, CutVertexId{first + t[2]}});
    region_begin_.push_back(static_cast<std::uint32_t>(caps_.triangles.size()));
  }
  seen_.resize(caps_.triangles.size(), 1);
}

void MovingCaps::take_away_given() {
  positions_.points.resize(made_vertices_);
  positions_.steps.resize(made_vertices_);
  caps_.triangles.resize(region_begin_[made_regions_]);
}

}  // namespace fracture
