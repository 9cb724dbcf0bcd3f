#include "common/fragment/make_fragments.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_set>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/fragment/assemble.hpp"
#include "common/fragment/bonds.hpp"
#include "common/fragment/file_volume.hpp"
#include "common/fragment/group_contacts.hpp"
#include "common/fragment/mirror_sum.hpp"
#include "common/fragment/volume_sign.hpp"

namespace fracture {
namespace {

/// Returns an id that depends only on the coordinates of the fragment's sites, its part and the number of
/// its island. So local refracture keeps the ids of untouched fragments. At most 2^53 - 1: exact in JSON.
std::uint64_t fragment_id(const VoronoiDiagram& diagram, const Fragment& f, std::uint32_t island,
                          const Execution& execution) {
  std::uint64_t h = 0x6672616374757265ull;
  const auto add = [&h](const Vec3d& s) {
    for (int a = 0; a < 3; ++a) h = mix64(h, std::bit_cast<std::uint64_t>(s[a] == 0 ? 0.0 : s[a]));
  };
  if (f.sites.size() == 1) {
    add(diagram.site(f.sites[0]));
  } else {
    std::vector<Vec3d> sites;
    for (const SiteId s : f.sites) sites.push_back(diagram.site(s));
    sort_with_polls(execution, sites.begin(), sites.end(), lexicographic_less);
    for (const Vec3d& s : sites) add(s);
  }
  return mix64(mix64(h, f.part), island) >> 11;
}

/// Fragments of groups of pieces, indexed by the group's name.
struct Assembly {
  void make(const std::vector<std::uint32_t>& names) {
    parallel_for(execution, names.size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::uint32_t g = names[k];
        if (groups.size(g) == 1)
          fragments[g] = assemble(d, ownership, pieces.pieces[g], pivot, execution);
        else
          fragments[g] = assemble_joined(g);
        volumes[g] = file_volume(fragments[g], execution);
      }
    });
  }

  Fragment assemble_joined(std::uint32_t group) const {
    const Piece joined = join_pieces(d, pieces, groups, group, execution);
    Fragment f = assemble(d, ownership, joined, pivot, execution);
    if (!joined.part_owners.empty())
      f.part_volumes = volumes_of_parts(d, pieces, groups.members(group, execution), execution);
    return f;
  }

  const RestrictedDiagram& d;
  const Ownership& ownership;
  const Pieces& pieces;
  PieceGroups& groups;
  Pivot pivot;
  const Execution& execution;
  std::vector<Fragment> fragments = {};  ///< [number of pieces]
  std::vector<FileVolume> volumes = {};  ///< [number of pieces]
};

/// Unites groups whose volume is not positive with the neighbour of largest shared cap area, all of them in
/// each round, until none is left. Groups without neighbours are dropped. If a surface crosses itself, a
/// group may have to grow by thousands of pieces, one per round. So its fragment is assembled only at the
/// end, or when its sign depends on rounding.
void unite_without_volume(Assembly& assembly, const std::vector<std::uint32_t>& all,
                          std::vector<bool>& dropped, Certificate& certificate) {
  PieceGroups& groups = assembly.groups;
  std::vector<std::uint32_t> bad;
  for (const std::uint32_t g : all)
    if (assembly.volumes[g].sign <= 0) bad.push_back(g);
  if (bad.empty()) return;

  GroupContacts contacts(assembly.d, assembly.pieces, groups, assembly.execution);
  VolumeSigns signs(assembly.d, assembly.pieces, assembly.execution);
  std::vector<char> stale(groups.pieces(), 0);  // per name: its fragment is out of date
  std::vector<std::uint32_t> grown;             // names that were stale once
  while (!bad.empty()) {
    // Each group chooses a neighbour before any of them is united.
    std::vector<std::vector<Neighbor>> neighbors;
    for (const std::uint32_t g : bad) neighbors.push_back(contacts.neighbors(g));
    std::vector<std::uint32_t> changed;
    for (std::size_t k = 0; k < bad.size(); ++k) {
      const std::uint32_t g = bad[k];
      if (!groups.is_group(g)) continue;  // already united with another group
      const auto best = std::find_if(neighbors[k].begin(), neighbors[k].end(),
                                     [&](const Neighbor& n) { return groups.of(n.group) != g; });
      if (best == neighbors[k].end()) {
        if (stale[g]) assembly.make({g});
        stale[g] = 0;
        dropped[g] = true;
        ++certificate.dropped;
        certificate.pocket_volume += assembly.fragments[g].mass.volume;
        certificate.pocket_area += assembly.fragments[g].surface_area;
        continue;
      }
      const std::uint32_t neighbor = groups.of(best->group), name = std::min(g, neighbor);
      signs.unite(groups, g, neighbor, name);
      contacts.unite(g, neighbor);
      ++certificate.united;
      changed.push_back(name);
    }
    sort_with_polls(assembly.execution, changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    std::erase_if(changed, [&](std::uint32_t g) { return !groups.is_group(g); });

    bad.clear();
    std::vector<std::uint32_t> unknown;
    for (const std::uint32_t g : changed) {
      stale[g] = 1;
      grown.push_back(g);
      if (const int sign = signs.of(g); sign < 0)
        bad.push_back(g);
      else if (sign == 0)
        unknown.push_back(g);
    }
    assembly.make(unknown);
    for (const std::uint32_t g : unknown) {
      stale[g] = 0;
      if (assembly.volumes[g].sign <= 0) bad.push_back(g);
    }
    sort_with_polls(assembly.execution, bad.begin(), bad.end());
  }
  contacts.release();
  sort_with_polls(assembly.execution, grown.begin(), grown.end());
  grown.erase(std::unique(grown.begin(), grown.end()), grown.end());
  std::erase_if(grown, [&](std::uint32_t g) { return !groups.is_group(g) || !stale[g]; });
  assembly.make(grown);
}

/// Whether two groups of pieces touch across parts.
bool touch_across(const PartContacts& across, const PieceGroups& groups) {
  return across.whole_touch ||
         std::any_of(across.pieces.begin(), across.pieces.end(),
                     [&](const PieceContact& c) { return groups.of(c.of) != groups.of(c.with); });
}

/// Repeats earlier unions, unites groups that are too small, assembles all groups, unites those without
/// volume, and assembles the changed groups again. Returns, per name, whether the group was dropped.
std::vector<bool> assemble_groups(Assembly& assembly, const SizeLimits& limits, const PartContacts* across,
                                  const std::vector<Union>& before, bool* touching, FragmentSet& out) {
  const std::size_t n = assembly.pieces.pieces.size();
  const std::vector<SiteId> lowest = lowest_cells(assembly.ownership);
  const std::uint32_t again =
      unite_again(before, assembly.d, assembly.pieces, lowest, assembly.groups, assembly.execution);
  out.size = unite_by_size(assembly.d, assembly.pieces, limits, across, assembly.groups, assembly.execution);
  out.size.united += again;
  if (touching) *touching = across == nullptr || touch_across(*across, assembly.groups);
  out.certificate.united = out.size.united;
  resize_with_polls(assembly.execution, assembly.fragments, n);
  resize_with_polls(assembly.execution, assembly.volumes, n);
  std::vector<std::uint32_t> all;
  for (std::uint32_t g = 0; g < n; ++g)
    if (assembly.groups.is_group(g)) all.push_back(g);
  assembly.make(all);
  std::uint32_t inside_out = 0;
  for (const std::uint32_t g : all)
    inside_out += assembly.fragments[g].mass.volume < -kInsideOut * assembly.d.solid.report.volume;
  out.size.inside_out = std::max(out.size.inside_out, inside_out);
  std::vector<bool> dropped(n, false);
  unite_without_volume(assembly, all, dropped, out.certificate);
  return dropped;
}

/// Moves the remaining fragments into the set, in the order of their pieces, and gives each its id.
/// Returns, per piece, the number of its fragment, or kNoIndex if it was dropped.
std::vector<std::uint32_t> take_fragments(Assembly& assembly, const std::vector<bool>& dropped,
                                          FragmentSet& out) {
  const std::size_t n = assembly.pieces.pieces.size();
  std::vector<Fragment>& fragments = assembly.fragments;
  std::uint32_t count = 0;
  std::vector<std::uint32_t> fragment_of_piece(n, kNoIndex);
  std::unordered_set<std::uint64_t> ids;  // used only for membership tests
  ids.reserve(n);                         // moving a million of them into a larger table takes a while
  Pacer pacer(assembly.execution);
  for (std::uint32_t g = 0; g < n; ++g) {
    pacer.step(16);
    const std::uint32_t name = assembly.groups.of(g);
    if (dropped[name]) continue;
    if (name != g) {  // its group's fragment was taken before
      fragment_of_piece[g] = fragment_of_piece[name];
      continue;
    }
    fragment_of_piece[g] = count;
    if (count != g) fragments[count] = std::move(fragments[g]);
    Fragment& f = fragments[count++];
    f.id = fragment_id(assembly.d.diagram, f, assembly.pieces.pieces[g].island, assembly.execution);
    while (!ids.insert(f.id).second) f.id = (f.id + 1) & ((1ull << 53) - 1);
    out.certificate.volume_out += f.mass.volume;
    out.certificate.volume_file += assembly.volumes[g].volume;
  }
  fragments.resize(count);
  fragments.shrink_to_fit();
  out.fragments = std::move(fragments);
  clear_nodes(pacer, ids);
  return fragment_of_piece;
}

/// Fills the counts of the certificate once the fragments exist.
void count(const Pieces& pieces, const RestrictedDiagram& d, FragmentSet& out) {
  Certificate& certificate = out.certificate;
  for (std::size_t k = 0; k < pieces.pieces.size(); ++k)  // pieces are in the order of their owners
    certificate.cells += k == 0 || pieces.pieces[k].owners[0] != pieces.pieces[k - 1].owners[0];
  certificate.islands = static_cast<std::uint32_t>(pieces.pieces.size()) - certificate.cells;
  certificate.fragments = static_cast<std::uint32_t>(out.fragments.size());
  certificate.crossing_caps = d.caps.crossing;
}

}  // namespace

FragmentSet make_fragments(const RestrictedDiagram& d, const Ownership& ownership, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution) {
  return make_fragments(d, ownership, gather_pieces(d, ownership, execution), pivot, limits, execution);
}

FragmentSet make_fragments(const RestrictedDiagram& d, const Ownership& ownership, Pieces pieces, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution,
                           const std::vector<Union>& before, const PartContacts* across, bool* touching) {
  PieceGroups groups(pieces.pieces.size());
  FragmentSet out;
  out.source = d.solid.source;
  Assembly assembly{d, ownership, pieces, groups, pivot, execution};
  const std::vector<bool> dropped = assemble_groups(assembly, limits, across, before, touching, out);
  const std::vector<std::uint32_t> fragment_of_piece = take_fragments(assembly, dropped, out);
  out.bonds = find_bonds(d, pieces, fragment_of_piece, execution);
  out.certificate.volume_out += out.certificate.pocket_volume;
  sum_up(d.solid, out.fragments, out.certificate);
  count(pieces, d, out);
  state_lattice(d.solid, out);
  clear_with_polls(execution, pieces.pieces);
  return out;
}

void sum_up(const Solid& solid, const ProofSums& sums, Certificate& certificate) {
  certificate.open_edges = sums.open_edges;
  certificate.area_out = sums.surface_area;
  certificate.unmirrored_caps = sums.caps != 0;
  certificate.area_in = solid.report.area;
  certificate.volume_in = solid.report.volume;
  certificate.relative_error =
      std::fabs(certificate.volume_out - certificate.volume_in) / certificate.volume_in;
}

void sum_up(const Solid& solid, const std::vector<Fragment>& fragments, Certificate& certificate) {
  ProofSums sums{.surface_area = certificate.pocket_area};
  for (const Fragment& f : fragments) {
    sums.open_edges += f.open_edges;
    sums.caps += f.cap_sum;
    sums.surface_area += f.surface_area;
  }
  sum_up(solid, sums, certificate);
}

void state_lattice(const Solid& solid, FragmentSet& out) {
  out.lattice_step = SeamLattice(solid.box).step();
  const Vec3d size = solid.box.size();
  for (int a = 0; a < 3; ++a)
    if (size[a] > 0) out.lattice_ratio = std::max(out.lattice_ratio, out.lattice_step[a] / size[a]);
}

}  // namespace fracture
