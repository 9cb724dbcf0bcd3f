#include "common/pipeline/part_contacts.hpp"

#include <algorithm>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/bvh/ray_crossing.hpp"
#include "common/pipeline/kept_instances.hpp"
#include "common/structure/contact_bonds.hpp"

namespace fracture {
namespace {

/// Fills the fields of a fragment that find_contact_bonds() reads. It reads surfaces only if a cell has
/// several pieces of the part.
Fragment outline_of(const RestrictedDiagram& d, const Ownership& ownership, const Piece& piece,
                    bool with_surface, const Execution& execution) {
  Fragment f;
  f.part = piece.part;
  f.sites = ownership.sites_of_owner[piece.owners[0]];
  if (!with_surface) return f;
  std::vector<CutVertexId> ids;
  ids.reserve(3 * piece.faces.size());
  for (const Face& face : piece.faces) ids.insert(ids.end(), face.v.begin(), face.v.end());
  std::vector<CutVertexId> sorted = ids;
  sort_with_polls(execution, sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  Pacer pacer(execution);
  for (const CutVertexId v : sorted) {
    pacer.step(4);
    const Vec3d p = d.point(v);
    f.topology.push_back(static_cast<std::uint32_t>(f.positions.size()));
    f.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  for (const CutVertexId v : ids) {
    pacer.step(16);
    f.indices.push_back(
        static_cast<std::uint32_t>(std::lower_bound(sorted.begin(), sorted.end(), v) - sorted.begin()));
  }
  return f;
}

std::vector<Fragment> outlines(const RestrictedDiagram& d, const Ownership& ownership, const Pieces& pieces,
                               const Execution& execution) {
  const std::vector<Piece>& all = pieces.pieces;
  const auto same_cell = [&](std::size_t j, std::size_t k) {
    return all[j].owners[0] == all[k].owners[0] && all[j].part == all[k].part;
  };
  std::vector<Fragment> made(all.size());
  parallel_for(execution, all.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const bool several = (k > 0 && same_cell(k - 1, k)) || (k + 1 < all.size() && same_cell(k, k + 1));
      made[k] = outline_of(d, ownership, all[k], several, execution);
    }
  });
  return made;
}

/// Whether pieces of the two parts join if they overlap. The parts are then in one group.
bool joins_if_overlapping(const Contact& c) { return c.kind == ContactKind::kOverlapping && c.area > 0; }

/// Finds pieces in one cell that overlap but share no contact surface.
class OverlapsInCells {
 public:
  OverlapsInCells(const RestrictedDiagram& d, const Pieces& pieces, const Execution& execution)
      : d_(d), pieces_(pieces.pieces), execution_(execution), pacer_(execution) {
    std::vector<std::uint32_t> count(d.solid.parts.size() + 1, 0);
    for (const Contact& c : d.solid.contacts->contacts)
      if (joins_if_overlapping(c)) ++count[c.a + 1];
    for (std::size_t p = 1; p < count.size(); ++p) count[p] += count[p - 1];
    first_ = count;
    others_.resize(first_.back());
    for (const Contact& c : d.solid.contacts->contacts)
      if (joins_if_overlapping(c)) others_[count[c.a]++] = c.b;
  }

  /// Adds each pair that is not in `contacts`, which must be ascending.
  void add_to(std::vector<PieceContact>& contacts) {
    std::vector<PieceContact> more;
    for (std::uint32_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {
      pacer_.step();
      while (end < pieces_.size() && pieces_[end].owners[0] == pieces_[begin].owners[0]) ++end;
      if (pieces_[begin].part == pieces_[end - 1].part) continue;
      for (std::uint32_t p = begin; p < end; ++p) examine(p, end, contacts, more);
    }
    contacts.insert(contacts.end(), more.begin(), more.end());
  }

 private:
  /// Compares a piece with those of higher parts in its cell.
  void examine(std::uint32_t p, std::uint32_t end, const std::vector<PieceContact>& contacts,
               std::vector<PieceContact>& more) {
    const std::uint32_t part = pieces_[p].part;
    for (std::uint32_t k = first_[part]; k < first_[part + 1]; ++k) {
      pacer_.step(16);
      auto q = static_cast<std::uint32_t>(
          std::partition_point(pieces_.begin() + p, pieces_.begin() + end,
                               [&](const Piece& piece) { return piece.part < others_[k]; }) -
          pieces_.begin());
      for (; q < end && pieces_[q].part == others_[k]; ++q)
        if (!is_known(p, q, contacts) && overlap(pieces_[p], pieces_[q])) more.push_back({p, q, 0});
    }
  }
  static bool is_known(std::uint32_t p, std::uint32_t q, const std::vector<PieceContact>& contacts) {
    const auto before = [](const PieceContact& c, const std::pair<std::uint32_t, std::uint32_t>& pair) {
      return std::pair(c.of, c.with) < pair;
    };
    const auto at = std::lower_bound(contacts.begin(), contacts.end(), std::pair(p, q), before);
    return at != contacts.end() && at->of == p && at->with == q;
  }
  bool overlap(const Piece& p, const Piece& q) {
    const std::vector<TetId> of_p = voronoi_vertices(p), of_q = voronoi_vertices(q);
    for (auto a = of_p.begin(), b = of_q.begin(); a != of_p.end() && b != of_q.end();) {
      if (*a == *b) return true;
      *a < *b ? ++a : ++b;
    }
    return is_inside(p, q) || is_inside(q, p);
  }
  /// Returns the Voronoi vertices of a piece, ascending.
  std::vector<TetId> voronoi_vertices(const Piece& piece) {
    const CutVertexId first = d_.cuts.first_d();
    std::vector<TetId> tets;
    for (const Face& face : piece.faces)
      for (const CutVertexId v : face.v)
        if (v >= first && v - first < d_.winding.inner_vertices.size())
          tets.push_back(d_.winding.inner_vertices[v - first].tet);
    pacer_.step(piece.faces.size());
    sort_with_polls(execution_, tets.begin(), tets.end());
    tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
    return tets;
  }
  /// Whether the middle of an outer face of `inner`, which is within the cell, is inside `outer`.
  bool is_inside(const Piece& inner, const Piece& outer) {
    const auto face =
        std::find_if(inner.faces.begin(), inner.faces.end(), [](const Face& f) { return !is_cap(f.source); });
    if (face == inner.faces.end()) return false;
    const Vec3d middle = (1.0 / 3) * (d_.point(face->v[0]) + d_.point(face->v[1]) + d_.point(face->v[2]));
    int winding = 0;
    for (const Face& f : outer.faces) {
      pacer_.step(4);
      winding +=
          ray_crossing(d_.point(f.v[0]) - middle, d_.point(f.v[1]) - middle, d_.point(f.v[2]) - middle);
    }
    return winding != 0;
  }

  const RestrictedDiagram& d_;
  const std::vector<Piece>& pieces_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<std::uint32_t> first_, others_;  // per part: parts with a higher index that overlap it
};

}  // namespace

bool joins_parts(const Solid& solid, const FractureParameters& parameters) {
  return (parameters.parts == Parts::kTogether && parts_hold_together(solid)) ||
         may_keep_instances(solid, parameters);
}

namespace {

/// The contacts between pieces of different parts.
std::vector<PieceContact> contacts_of_pieces(const RestrictedDiagram& flat, const Ownership& ownership,
                                             const Pieces& pieces, const Execution& execution) {
  std::vector<PieceContact> contacts;
  if (!parts_hold_together(flat.solid)) return contacts;
  const std::vector<Fragment> fragments = outlines(flat, ownership, pieces, execution);
  std::vector<const Fragment*> pointers;
  pointers.reserve(fragments.size());
  for (const Fragment& f : fragments) pointers.push_back(&f);
  const CellSites cells{flat.diagram.dual().points, flat.diagram.map()};
  const ContactBonds with{flat.solid, cells, flat.positions.lattice.step()};
  for (const Bond& bond : find_contact_bonds(with, pointers, {}, execution))
    contacts.push_back({bond.a, bond.b, bond.area});
  OverlapsInCells(flat, pieces, execution).add_to(contacts);
  return contacts;
}

}  // namespace

std::optional<PartContacts> find_part_contacts(const RestrictedDiagram& flat, const Ownership& ownership,
                                               const Pieces& pieces, const FractureParameters& parameters,
                                               const Execution& execution) {
  if (!joins_parts(flat.solid, parameters)) return std::nullopt;
  PartGroups groups = group_parts(flat.solid, parameters, wanted_fragments(parameters), execution);
  if (parameters.parts == Parts::kInstances) {  // nothing else joins, whatever it touches
    if (groups.whole.empty()) return std::nullopt;
    return PartContacts{{}, std::move(groups.of_part), std::move(groups.whole), true};
  }
  PartContacts contacts{contacts_of_pieces(flat, ownership, pieces, execution), std::move(groups.of_part),
                        std::move(groups.whole)};
  if (contacts.whole.empty()) return contacts;
  const auto instance_of = [&](std::uint32_t piece) { return contacts.whole[pieces.pieces[piece].part]; };
  std::erase_if(contacts.pieces, [&](const PieceContact& c) {
    const std::uint32_t a = instance_of(c.of), b = instance_of(c.with);
    if (a != b) contacts.whole_touch = true;
    return a != kNoIndex || b != kNoIndex;
  });
  return contacts;
}

}  // namespace fracture
