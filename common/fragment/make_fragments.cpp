#include "common/fragment/make_fragments.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <unordered_set>

#include "common/base/pacer.hpp"
#include "common/fragment/assemble.hpp"
#include "common/fragment/bonds.hpp"
#include "common/fragment/mirror_sum.hpp"
#include "common/fragment/unite.hpp"

namespace fracture {
namespace {

/// Whom a group shares its largest cap with, at the start of a round of uniting.
class Contacts {
 public:
  Contacts(const RestrictedDiagram& d, const Pieces& pieces, const std::vector<std::uint32_t>& group_of_piece)
      : begin_(group_of_piece.size() + 1, 0), contacts_(find_contacts(d, pieces, group_of_piece)) {
    for (const Contact& c : contacts_) ++begin_[c.of + 1];
    for (std::size_t g = 0; g + 1 < begin_.size(); ++g) begin_[g + 1] += begin_[g];
  }

  /// The group that shares the largest cap with g, ties to the lowest; kNoIndex when g touches nobody.
  std::uint32_t best_neighbor(std::uint32_t g, const PieceGroups& groups) const {
    for (std::uint32_t k = begin_[g]; k < begin_[g + 1]; ++k)
      if (groups.of_piece()[contacts_[k].with] != g) return groups.of_piece()[contacts_[k].with];
    return kNoIndex;
  }

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<Contact> contacts_;
};

std::uint64_t mix(std::uint64_t h, std::uint64_t v) {
  h ^= v;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
  return (h ^ (h >> 31)) + 0x9e3779b97f4a7c15ull;
}

/// A function of the coordinates of the fragment's sites, the part and which island of them it is: local
/// refracture keeps the ids of what it does not touch. At most 2^53 - 1: exact in JSON.
std::uint64_t fragment_id(const VoronoiDiagram& diagram, const Fragment& f, std::uint32_t island) {
  std::vector<Vec3d> sites;
  for (const SiteId s : f.sites) sites.push_back(diagram.site(s));
  std::sort(sites.begin(), sites.end(), lexicographic_less);
  std::uint64_t h = 0x6672616374757265ull;
  for (const Vec3d& s : sites)
    for (int a = 0; a < 3; ++a) h = mix(h, std::bit_cast<std::uint64_t>(s[a] == 0 ? 0.0 : s[a]));
  return mix(mix(h, f.part), island) >> 11;
}

}  // namespace

FragmentSet make_fragments(const RestrictedDiagram& d, const Ownership& ownership, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution) {
  const Pieces pieces = gather_pieces(d, ownership, execution);
  const std::size_t n = pieces.pieces.size();
  FragmentSet out;
  out.source = d.solid.source;
  Certificate& certificate = out.certificate;

  // Unite what is too small; assemble; unite what has no volume; assemble again what changed.
  PieceGroups groups(n);
  out.size = unite_by_size(d, pieces, limits, groups, execution);
  certificate.united = out.size.united;
  std::vector<Fragment> fragments;
  resize_with_polls(execution, fragments, n);
  std::vector<FileVolume> volumes(n);
  std::vector<bool> dropped(n, false);
  std::vector<std::uint32_t> todo(n);
  std::iota(todo.begin(), todo.end(), 0u);
  std::erase_if(todo, [&](std::uint32_t g) { return !groups.is_group(g); });
  while (!todo.empty()) {
    parallel_for(execution, todo.size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::uint32_t g = todo[k];
        const auto& members = groups.members(g);
        if (members.size() == 1)
          fragments[g] = assemble(d, ownership, pieces.pieces[g], pivot, execution);
        else
          fragments[g] =
              assemble(d, ownership, join_pieces(d, pieces, members, groups.of_piece()), pivot, execution);
        volumes[g] = file_volume(fragments[g], execution);
      }
    });
    std::vector<std::uint32_t> bad;
    for (const std::uint32_t g : todo)
      if (volumes[g].sign <= 0 && !dropped[g]) bad.push_back(g);
    todo.clear();
    if (bad.empty()) break;

    const Contacts contacts(d, pieces, groups.of_piece());
    for (const std::uint32_t g : bad) {
      if (groups.of_piece()[g] != g) continue;  // swallowed meanwhile
      const std::uint32_t neighbor = contacts.best_neighbor(g, groups);
      if (neighbor == kNoIndex) {
        dropped[g] = true;
        ++certificate.dropped;
        certificate.pocket_volume += fragments[g].mass.volume;
        certificate.pocket_area += fragments[g].surface_area;
        continue;
      }
      groups.unite(g, neighbor);
      ++certificate.united;
      todo.push_back(std::min(g, neighbor));
    }
    std::sort(todo.begin(), todo.end());
    todo.erase(std::unique(todo.begin(), todo.end()), todo.end());
    std::erase_if(todo, [&](std::uint32_t g) { return groups.of_piece()[g] != g; });
  }

  // What is left, in order of the pieces.
  std::vector<std::uint32_t> fragment_of_piece(n, kNoIndex);
  std::unordered_set<std::uint64_t> ids;  // only asked for membership
  std::unordered_set<std::uint32_t> owners_seen;
  Pacer pacer(execution);
  out.fragments.reserve(n);
  for (std::uint32_t g = 0; g < n; ++g) {
    pacer.step(64);
    owners_seen.insert(pieces.pieces[g].owners[0]);
    if (groups.of_piece()[g] != g || dropped[g]) continue;
    for (const std::uint32_t p : groups.members(g))
      fragment_of_piece[p] = static_cast<std::uint32_t>(out.fragments.size());
    Fragment& f = fragments[g];
    f.id = fragment_id(d.diagram, f, pieces.pieces[g].island);
    while (!ids.insert(f.id).second) f.id = (f.id + 1) & ((1ull << 53) - 1);
    certificate.volume_out += f.mass.volume;
    certificate.volume_file += volumes[g].volume;
    out.fragments.push_back(std::move(f));
  }
  out.bonds = find_bonds(d, pieces, fragment_of_piece, execution);

  certificate.volume_out += certificate.pocket_volume;
  sum_up(d.solid, out.fragments, certificate);
  certificate.cells = static_cast<std::uint32_t>(owners_seen.size());
  certificate.islands = static_cast<std::uint32_t>(n) - certificate.cells;
  certificate.fragments = static_cast<std::uint32_t>(out.fragments.size());
  certificate.crossing_caps = d.caps.crossing;

  state_lattice(d, out);
  return out;
}

std::optional<WantedFragments> make_wanted_fragments(const RestrictedDiagram& d, const Ownership& ownership,
                                                     const std::vector<std::uint32_t>& others, Pivot pivot,
                                                     const Execution& execution) {
  Pieces pieces = gather_pieces(d, ownership, execution);
  const std::size_t n = pieces.pieces.size();
  WantedFragments out;
  out.crossing_caps = d.caps.crossing;
  out.fragments.resize(n);
  out.volumes_file.resize(n);
  std::vector<char> bad(n, 0);
  parallel_for(execution, n, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      Fragment& f = out.fragments[k];
      f = assemble(d, ownership, pieces.pieces[k], pivot, execution);
      const FileVolume volume = file_volume(f, execution);
      out.volumes_file[k] = volume.volume;
      bad[k] = volume.sign <= 0;
      if (bad[k]) continue;
      f.id = fragment_id(d.diagram, f, pieces.pieces[k].island);
    }
  });
  if (std::find(bad.begin(), bad.end(), 1) != bad.end()) return std::nullopt;

  // Pieces stand in the order of their owners.
  const std::size_t owners = ownership.sites_of_owner.size();
  out.first_of.assign(owners + 1, 0);
  for (std::size_t o = 0; o < owners; ++o)
    if (!ownership.wanted[o]) out.first_of[o + 1] = others[o];
  for (const Piece& piece : pieces.pieces) ++out.first_of[piece.owners[0] + 1];
  for (std::size_t o = 0; o < owners; ++o) out.first_of[o + 1] += out.first_of[o];
  std::vector<std::uint32_t> fragment_of_piece(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t o = pieces.pieces[k].owners[0];
    fragment_of_piece[k] =
        k > 0 && pieces.pieces[k - 1].owners[0] == o ? fragment_of_piece[k - 1] + 1 : out.first_of[o];
  }

  // The other sides of caps, whose pieces were not made, as further pieces.
  std::vector<std::uint32_t> piece_of_owner(owners, kNoIndex);
  for (std::uint32_t r = 0; r < d.caps.regions.size(); ++r)
    for (int side = 0; side < 2; ++side) {
      const CapRegion& region = d.caps.regions[r];
      const std::uint32_t o = ownership.owner_of_site[side == 0 ? region.lo : region.hi];
      if (ownership.wanted[o] || others[o] == 0) continue;
      if (piece_of_owner[o] == kNoIndex) {
        piece_of_owner[o] = static_cast<std::uint32_t>(fragment_of_piece.size());
        fragment_of_piece.push_back(out.first_of[o]);
      }
      pieces.piece_of_cap[2 * r + static_cast<std::uint32_t>(side)] = piece_of_owner[o];
    }
  out.bonds = find_bonds(d, pieces, fragment_of_piece, execution);
  return out;
}

void sum_up(const Solid& solid, const std::vector<Fragment>& fragments, Certificate& certificate) {
  certificate.open_edges = 0;
  certificate.area_out = certificate.pocket_area;
  std::uint64_t caps = 0;
  for (const Fragment& f : fragments) {
    certificate.open_edges += f.open_edges;
    certificate.area_out += f.surface_area;
    caps += f.cap_sum;
  }
  certificate.unmirrored_caps = caps != 0;
  certificate.area_in = solid.report.area;
  certificate.volume_in = solid.report.volume;
  certificate.relative_error =
      std::fabs(certificate.volume_out - certificate.volume_in) / certificate.volume_in;
}

void state_lattice(const RestrictedDiagram& d, FragmentSet& out) {
  out.lattice_step = d.positions.lattice.step();
  const Vec3d size = d.solid.box.size();
  for (int a = 0; a < 3; ++a)
    if (size[a] > 0) out.lattice_ratio = std::max(out.lattice_ratio, out.lattice_step[a] / size[a]);
}

}  // namespace fracture
