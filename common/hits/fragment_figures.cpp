#include "common/hits/fragment_figures.hpp"

#include <algorithm>
#include <iterator>

#include "common/base/heap_bytes.hpp"
#include "common/base/pacer.hpp"
#include "common/physics/principal_axes.hpp"

namespace fracture {
namespace {

template <class T>
void replace_sorted(std::vector<T>& gone, std::vector<T>& fresh, std::vector<T>& all,
                    const Execution& execution) {
  sort_with_polls(execution, gone.begin(), gone.end());
  sort_with_polls(execution, fresh.begin(), fresh.end());
  std::vector<T> stay, result;
  stay.reserve(all.size());
  result.reserve(all.size() + fresh.size());
  std::set_difference(all.begin(), all.end(), gone.begin(), gone.end(), std::back_inserter(stay));
  std::merge(stay.begin(), stay.end(), fresh.begin(), fresh.end(), std::back_inserter(result));
  all = std::move(result);
}

}  // namespace

FragmentFigures figures_of(const std::vector<KeptFragment>& fragments,
                           const std::vector<std::uint32_t>& pieces, const Execution& execution) {
  FragmentFigures f;
  f.first_of.assign(pieces.size() + 1, 0);
  Pacer pacer(execution);
  for (const KeptFragment& kept : fragments) {
    pacer.step(8);
    ++f.first_of[kept.fragment.sites[0] + 1];
    f.append(kept);
    f.sorted_volumes.push_back(body_volume(kept.fragment));
    f.sorted_ids.push_back(kept.fragment.id);
    f.sorted_excesses.push_back(kept.hulls.excess);
    f.count(kept, 1);
  }
  for (std::size_t s = 0; s < pieces.size(); ++s) {
    f.cells += pieces[s] > 0;
    f.pieces += pieces[s];
    f.first_of[s + 1] += f.first_of[s];
  }
  sort_with_polls(execution, f.sorted_volumes.begin(), f.sorted_volumes.end());
  sort_with_polls(execution, f.sorted_ids.begin(), f.sorted_ids.end());
  sort_with_polls(execution, f.sorted_excesses.begin(), f.sorted_excesses.end());
  f.hulls.excess = f.sorted_excesses.empty() ? 0 : f.sorted_excesses.back();
  return f;
}

void FragmentFigures::append(const KeptFragment& kept) {
  volumes.push_back(kept.fragment.mass.volume);
  volumes_file.push_back(kept.volume_file);
  surface_areas.push_back(kept.fragment.surface_area);
}

void FragmentFigures::count(const KeptFragment& kept, int times) {
  const auto n = static_cast<std::uint64_t>(static_cast<std::int64_t>(times));  // modulo 2^64
  open_edges += n * kept.fragment.open_edges;
  caps += n * kept.fragment.cap_sum;
  triangles += n * (kept.fragment.indices.size() / 3);
  const auto few = static_cast<std::uint32_t>(n);
  hulls.hulls += few * static_cast<std::uint32_t>(kept.hulls.hulls.size());
  hulls.flat += few * kept.hulls.flat;
  hulls.simplified += few * kept.hulls.simplified;
}

std::size_t memory_size(const KeptFragment& kept) {
  const Fragment& f = kept.fragment;
  std::size_t bytes = sizeof kept + heap(f.sites) + heap(f.positions) + heap(f.attributes.normals) +
                      heap(f.attributes.tangents) + nested_heap(f.attributes.uvs) +
                      nested_heap(f.attributes.colors) + heap(f.indices) + heap(f.primitives) +
                      heap(f.part_cells) + heap(f.part_volumes) + heap(f.topology) + heap(f.caps) +
                      nested_heap(f.bodies) + heap(kept.hulls.hulls);
  if (f.sheet) bytes += memory_size(KeptFragment{*f.sheet, {}, 0});
  for (const CollisionHull& hull : kept.hulls.hulls) bytes += heap(hull.points) + heap(hull.triangles);
  return bytes;
}

std::optional<FragmentFigures> figures_after(const FragmentFigures& before, std::span<const SiteId> changed,
                                             SiteId first_new, const CellOf& was, const CellOf& is,
                                             const Execution& execution) {
  FragmentFigures after = before;
  after.first_of.assign(1, 0);
  after.first_of.reserve(before.first_of.size() + changed.size());
  after.volumes.clear();
  after.volumes_file.clear();
  after.surface_areas.clear();
  std::vector<double> volumes_gone, volumes_new, excesses_gone, excesses_new;
  std::vector<std::uint64_t> ids_gone, ids_new;
  Pacer pacer(execution);
  SiteId done{0};
  const auto take_until = [&](SiteId s) {  // copies the cells before s, which did not change
    pacer.step((s - done) / 16 + 1);
    const std::uint32_t first = before.first_of[done], last = before.first_of[s];
    const auto shift = static_cast<std::uint32_t>(after.volumes.size()) - first;  // modulo 2^32
    for (std::uint32_t k = done; k < s; ++k) after.first_of.push_back(before.first_of[k + 1] + shift);
    const auto append = [&](const std::vector<double>& from, std::vector<double>& to) {
      to.insert(to.end(), from.begin() + first, from.begin() + last);
    };
    append(before.volumes, after.volumes);
    append(before.volumes_file, after.volumes_file);
    append(before.surface_areas, after.surface_areas);
  };
  for (const SiteId s : changed) {
    if (s < first_new) {
      take_until(s);
      for (const KeptFragment& kept : was(s).fragments) {
        after.count(kept, -1);
        volumes_gone.push_back(body_volume(kept.fragment));
        ids_gone.push_back(kept.fragment.id);
        excesses_gone.push_back(kept.hulls.excess);
      }
      after.cells -= was(s).pieces > 0;
      after.pieces -= was(s).pieces;
      done = SiteId{s + 1};
    } else if (done < first_new) {
      take_until(first_new);
      done = first_new;
    }
    for (const KeptFragment& kept : is(s).fragments) {
      after.append(kept);
      after.count(kept, 1);
      volumes_new.push_back(body_volume(kept.fragment));
      ids_new.push_back(kept.fragment.id);
      excesses_new.push_back(kept.hulls.excess);
    }
    after.cells += is(s).pieces > 0;
    after.pieces += is(s).pieces;
    after.first_of.push_back(static_cast<std::uint32_t>(after.volumes.size()));
  }
  if (done < first_new) take_until(first_new);
  replace_sorted(volumes_gone, volumes_new, after.sorted_volumes, execution);
  execution.poll();
  replace_sorted(ids_gone, ids_new, after.sorted_ids, execution);
  execution.poll();
  replace_sorted(excesses_gone, excesses_new, after.sorted_excesses, execution);
  after.hulls.excess = after.sorted_excesses.empty() ? 0 : after.sorted_excesses.back();
  if (std::adjacent_find(after.sorted_ids.begin(), after.sorted_ids.end()) != after.sorted_ids.end())
    return std::nullopt;
  return after;
}

std::optional<SizeFigures> size_after(const SizeLimits& limits, double volume, const SizeFigures& before,
                                      const FragmentFigures& after, double smallest) {
  if (!limits.any_least()) return SizeFigures{};
  // Pieces are measured before they are assembled, with different rounding errors.
  constexpr double kRounding = 1e-6;
  const std::vector<double>& volumes = after.sorted_volumes;
  const double least = limits.least(volume, static_cast<std::uint32_t>(volumes.size()));
  // Fragments below the old limit touched no other. Fragments now below the limit that were not made again
  // were also below it then.
  if (least > before.min_volume || smallest < (1 + kRounding) * least) return std::nullopt;
  const auto below = [&](double limit) {
    return static_cast<std::uint32_t>(std::lower_bound(volumes.begin(), volumes.end(), limit) -
                                      volumes.begin());
  };
  if (below((1 - kRounding) * least) != below((1 + kRounding) * least)) return std::nullopt;
  return SizeFigures{.alone = below(least), .min_volume = least};
}

}  // namespace fracture
