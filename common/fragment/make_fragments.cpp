#include "common/fragment/make_fragments.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <unordered_set>

#include "common/fragment/assemble.hpp"
#include "common/fragment/bonds.hpp"
#include "common/fragment/closedness.hpp"

namespace fracture {
namespace {

/// Pieces joined so far: a group is named by its smallest piece.
class PieceGroups {
 public:
  explicit PieceGroups(std::size_t pieces) : group_(pieces), members_(pieces) {
    for (std::uint32_t p = 0; p < pieces; ++p) {
      group_[p] = p;
      members_[p] = {p};
    }
  }
  const std::vector<std::uint32_t>& of_piece() const { return group_; }
  const std::vector<std::uint32_t>& members(std::uint32_t group) const { return members_[group]; }
  void unite(std::uint32_t a, std::uint32_t b) {
    a = group_[a];
    b = group_[b];
    if (a == b) return;
    if (b < a) std::swap(a, b);
    for (const std::uint32_t p : members_[b]) group_[p] = a;
    members_[a].insert(members_[a].end(), members_[b].begin(), members_[b].end());
    std::sort(members_[a].begin(), members_[a].end());
    members_[b].clear();
  }

 private:
  std::vector<std::uint32_t> group_;
  std::vector<std::vector<std::uint32_t>> members_;
};

/// Who touches whom, and how much: the shared cap areas at the start of a round of uniting.
class Contacts {
 public:
  Contacts(const RestrictedDiagram& d, const Pieces& pieces, const std::vector<std::uint32_t>& group_of_piece)
      : begin_(group_of_piece.size() + 1, 0) {
    // Every touching pair is a contact, those without area too: they bind where there is nothing better.
    std::vector<Contact> all;
    for (const Bond& b : find_bonds(d, pieces, group_of_piece)) {
      all.push_back({b.a, b.b, b.area});
      all.push_back({b.b, b.a, b.area});
    }
    for (std::uint32_t r = 0; r < d.caps.regions.size(); ++r) {
      const std::uint32_t p = pieces.piece_of_cap[2 * r], q = pieces.piece_of_cap[2 * r + 1];
      if (p == kNoIndex || q == kNoIndex || group_of_piece[p] == group_of_piece[q]) continue;
      all.push_back({group_of_piece[p], group_of_piece[q], 0});
      all.push_back({group_of_piece[q], group_of_piece[p], 0});
    }
    std::sort(all.begin(), all.end(), [](const Contact& x, const Contact& y) {
      if (x.of != y.of) return x.of < y.of;
      return x.area != y.area ? x.area > y.area : x.with < y.with;
    });
    contacts_ = std::move(all);
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
  struct Contact {
    std::uint32_t of, with;
    double area;
  };
  std::vector<std::uint32_t> begin_;
  std::vector<Contact> contacts_;
};

/// The faces of a group of pieces: all of theirs, but the caps between them, which cancel.
Piece join_pieces(const Pieces& pieces, const std::vector<std::uint32_t>& members,
                  const std::vector<std::uint32_t>& group_of_piece) {
  Piece joined = pieces.pieces[members[0]];
  joined.faces.clear();
  joined.owners.clear();
  joined.bodies.clear();
  for (const std::uint32_t m : members) {
    const Piece& piece = pieces.pieces[m];
    joined.owners.insert(joined.owners.end(), piece.owners.begin(), piece.owners.end());
    joined.bodies.insert(joined.bodies.end(), piece.bodies.begin(), piece.bodies.end());
    if (piece.bodies.empty()) {
      std::vector<VertexId>& body = joined.bodies.emplace_back();
      for (const Face& face : piece.faces) body.insert(body.end(), face.v.begin(), face.v.end());
      std::sort(body.begin(), body.end());
      body.erase(std::unique(body.begin(), body.end()), body.end());
    }
    for (const Face& face : piece.faces) {
      if (is_cap(face.source)) {
        const std::uint32_t other = pieces.piece_of_cap[(face.source ^ 1) & ~kCapFace];
        if (other != kNoIndex && group_of_piece[other] == group_of_piece[m]) continue;
      }
      joined.faces.push_back(face);
    }
  }
  std::sort(joined.owners.begin(), joined.owners.end());
  joined.owners.erase(std::unique(joined.owners.begin(), joined.owners.end()), joined.owners.end());
  return joined;
}

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
                           const Execution& execution) {
  const Pieces pieces = gather_pieces(d, ownership, execution);
  const std::size_t n = pieces.pieces.size();
  FragmentSet out;
  out.source = d.solid.source;
  Certificate& certificate = out.certificate;

  // Assemble; unite what has no volume; assemble again what changed.
  PieceGroups groups(n);
  std::vector<Fragment> fragments(n);
  std::vector<FileVolume> volumes(n);
  std::vector<bool> dropped(n, false);
  std::vector<std::uint32_t> todo(n);
  std::iota(todo.begin(), todo.end(), 0u);
  while (!todo.empty()) {
    parallel_for(execution, todo.size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::uint32_t g = todo[k];
        const auto& members = groups.members(g);
        if (members.size() == 1)
          fragments[g] = assemble(d, ownership, pieces.pieces[g], pivot);
        else
          fragments[g] = assemble(d, ownership, join_pieces(pieces, members, groups.of_piece()), pivot);
        volumes[g] = file_volume(fragments[g]);
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
        certificate.pocket_area += fragments[g].exterior_area;
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
  for (std::uint32_t g = 0; g < n; ++g) {
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
  out.bonds = find_bonds(d, pieces, fragment_of_piece);

  std::vector<std::uint64_t> open(out.fragments.size());
  parallel_for(execution, open.size(), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) open[k] = open_edges(out.fragments[k]);
  });
  for (const std::uint64_t edges : open) certificate.open_edges += edges;
  certificate.volume_in = d.solid.report.volume;
  certificate.volume_out += certificate.pocket_volume;
  certificate.relative_error =
      std::fabs(certificate.volume_out - certificate.volume_in) / certificate.volume_in;
  certificate.cells = static_cast<std::uint32_t>(owners_seen.size());
  certificate.islands = static_cast<std::uint32_t>(n) - certificate.cells;
  certificate.fragments = static_cast<std::uint32_t>(out.fragments.size());
  certificate.crossing_caps = d.caps.crossing;

  out.lattice_step = d.positions.lattice.step();
  const Vec3d size = d.solid.box.size();
  for (int a = 0; a < 3; ++a)
    if (size[a] > 0) out.lattice_ratio = std::max(out.lattice_ratio, out.lattice_step[a] / size[a]);
  return out;
}

}  // namespace fracture
