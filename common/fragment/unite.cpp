#include "common/fragment/unite.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/fragment/bonds.hpp"
#include "common/fragment/contact_table.hpp"
#include "common/fragment/outline.hpp"
#include "common/fragment/part_quotas.hpp"
#include "common/fragment/union_triangles.hpp"

namespace fracture {

std::vector<PieceContact> find_piece_contacts(const RestrictedDiagram& d, const Pieces& pieces,
                                              const std::vector<std::uint32_t>& group_of_piece,
                                              const Execution& execution) {
  // Every touching pair is a contact, those without area too: they bind where there is nothing better.
  std::vector<PieceContact> all;
  for (const Bond& b : find_bonds(d, pieces, group_of_piece, execution)) {
    all.push_back({b.a, b.b, b.area});
    all.push_back({b.b, b.a, b.area});
  }
  Pacer pacer(execution);
  for (std::uint32_t r = 0; r < d.caps.regions.size(); ++r) {
    pacer.step();
    const std::uint32_t p = pieces.piece_of_cap[2 * r], q = pieces.piece_of_cap[2 * r + 1];
    if (p == kNoIndex || q == kNoIndex || group_of_piece[p] == group_of_piece[q]) continue;
    all.push_back({group_of_piece[p], group_of_piece[q], 0});
    all.push_back({group_of_piece[q], group_of_piece[p], 0});
  }
  sort_with_polls(execution, all.begin(), all.end(), [](const PieceContact& x, const PieceContact& y) {
    if (x.of != y.of) return x.of < y.of;
    return x.area != y.area ? x.area > y.area : x.with < y.with;
  });
  return all;
}

namespace {

/// The outer faces of a group, by input triangle: those of one piece as they are, those of several fused.
void join_surfaces(const RestrictedDiagram& d, const Pieces& pieces,
                   const std::vector<std::uint32_t>& members, std::vector<Face>& out,
                   const Execution& execution) {
  struct Owned {
    Face face;
    std::uint32_t piece;
    std::uint32_t number;  // in the order of the members and their faces, which triangles keep
  };
  Pacer pacer(execution);
  std::vector<Owned> faces;
  for (const std::uint32_t m : members)
    for (const Face& face : pieces.pieces[m].faces) {
      pacer.step();
      if (!is_cap(face.source)) faces.push_back({face, m, static_cast<std::uint32_t>(faces.size())});
    }
  sort_with_polls(execution, faces.begin(), faces.end(), [](const Owned& a, const Owned& b) {
    return a.face.source != b.face.source ? a.face.source < b.face.source : a.number < b.number;
  });

  struct Edge {
    CutVertexId lo, hi;
    bool forward;  // from lo to hi
  };
  std::vector<Edge> edges;
  Outline outline(d, execution);
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    const std::uint32_t t = faces[begin].face.source;
    bool shared = false;
    for (end = begin; end < faces.size() && faces[end].face.source == t; ++end)
      shared = shared || faces[end].piece != faces[begin].piece;
    pacer.step(8 * (end - begin));
    if (!shared) {
      for (std::size_t k = begin; k < end; ++k) out.push_back(faces[k].face);
      continue;
    }
    // What is left of the edges when those used both ways are taken out is the outline.
    edges.clear();
    for (std::size_t k = begin; k < end; ++k)
      for (int c = 0; c < 3; ++c) {
        const CutVertexId from = faces[k].face.v[c], to = faces[k].face.v[(c + 1) % 3];
        edges.push_back({std::min(from, to), std::max(from, to), from < to});
      }
    sort_with_polls(execution, edges.begin(), edges.end(),
                    [](const Edge& a, const Edge& b) { return a.lo != b.lo ? a.lo < b.lo : a.hi < b.hi; });
    outline.clear();
    for (std::size_t k = 0; k < edges.size();) {
      const Edge e = edges[k];
      int balance = 0;
      for (; k < edges.size() && edges[k].lo == e.lo && edges[k].hi == e.hi; ++k)
        balance += edges[k].forward ? 1 : -1;
      for (; balance > 0; --balance) outline.add(e.lo, e.hi);
      for (; balance < 0; ++balance) outline.add(e.hi, e.lo);
    }
    outline.triangulate_into(t, out);
  }
}

/// Contacts of the groups while they grow, and the groups by volume. Of two groups that unite the one of
/// fewer contacts moves these to the other: each contact moves at most log2 of their number times. So a group
/// has a seat besides its name, which is always that of its smallest piece.
class SmallestFirst {
 public:
  /// `volumes`: of the groups.
  SmallestFirst(const RestrictedDiagram& d, const Pieces& pieces, const PieceGroups& groups,
                const std::vector<double>& volumes, const Execution& execution)
      : SmallestFirst(pieces, groups, volumes, find_piece_contacts(d, pieces, groups.names(), execution),
                      execution) {}
  SmallestFirst(const SmallestFirst&) = delete;  // its table of contacts refers to its pacer
  SmallestFirst& operator=(const SmallestFirst&) = delete;

  std::uint32_t groups() const { return count_; }  ///< how many there are
  /// Is there none left in the order? Else the volume of the smallest may be asked for.
  bool done() {
    while (!order_.empty() && order_.front().change != changes_[order_.front().group]) pop();
    return order_.empty();
  }
  double smallest_volume() const { return order_.front().volume; }
  std::uint32_t smallest() const { return order_.front().group; }
  /// Takes the smallest out of the order as it is, until take_back() or somebody unites with it.
  void leave_smallest() {
    left_.push_back(order_.front());
    pop();
  }
  /// Those that were left.
  void take_back() {
    for (const Entry& entry : left_) {
      if (entry.change != changes_[entry.group]) continue;
      pacer_.step(8);
      order_.push_back(entry);
      std::push_heap(order_.begin(), order_.end(), later);
    }
    left_.clear();
  }
  /// Unites the smallest group with its neighbour and says which those were; takes it out of the order when
  /// it has none (then both are the same).
  std::pair<std::uint32_t, std::uint32_t> unite_smallest() {
    const std::uint32_t g = order_.front().group;
    pop();
    std::uint32_t with = kNoIndex;
    double area = -1;
    touches_.visit(seat_[g], [&](std::uint32_t other, double shared) {  // ties to the lowest
      if (shared > area || (shared == area && name_[other] < with)) {
        with = name_[other];
        area = shared;
      }
    });
    if (with == kNoIndex) return {g, g};
    const std::uint32_t name = std::min(g, with);
    volume_[name] += volume_[std::max(g, with)];
    std::uint32_t kept = seat_[g], gone = seat_[with];
    if (touches_.degree(kept) < touches_.degree(gone)) std::swap(kept, gone);
    touches_.merge(kept, gone);
    name_[kept] = name;
    seat_[name] = kept;
    ++changes_[g];
    ++changes_[with];
    push(name);
    --count_;
    return {g, with};
  }

 private:
  struct Entry {
    double volume;
    std::uint32_t group, change;  ///< out of date when the group has changed since
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.volume != b.volume ? a.volume > b.volume : a.group > b.group;
  }

  SmallestFirst(const Pieces& pieces, const PieceGroups& groups, const std::vector<double>& volumes,
                const std::vector<PieceContact>& contacts, const Execution& execution)
      : pacer_(execution),
        volume_(volumes),
        name_(pieces.pieces.size()),
        seat_(pieces.pieces.size()),
        changes_(pieces.pieces.size(), 0),
        touches_(static_cast<std::uint32_t>(pieces.pieces.size()), contacts.size() / 2, pacer_) {
    for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
      pacer_.step(4);
      name_[p] = seat_[p] = p;
    }
    for (const PieceContact& c : contacts)  // each pair is listed twice
      if (c.of < c.with) touches_.add(c.of, c.with, c.area);
    for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
      if (!groups.is_group(p)) continue;
      push(p);
      ++count_;
    }
  }

  void push(std::uint32_t group) {
    pacer_.step(8);
    order_.push_back({volume_[group], group, changes_[group]});
    std::push_heap(order_.begin(), order_.end(), later);
  }
  void pop() {
    pacer_.step(16);
    std::pop_heap(order_.begin(), order_.end(), later);
    order_.pop_back();
  }

  Pacer pacer_;
  std::vector<double> volume_;              // per group
  std::vector<std::uint32_t> name_, seat_;  // per seat: its group; per group: its seat
  std::vector<std::uint32_t> changes_;      // per group
  ContactTable touches_;                    // of seats
  std::vector<Entry> order_;                // a heap
  std::vector<Entry> left_;                 // out of it
  std::uint32_t count_ = 0;
};

}  // namespace

std::vector<double> volumes_of_groups(const RestrictedDiagram& d, const Pieces& pieces,
                                      const PieceGroups& groups, const Execution& execution) {
  std::vector<double> volumes(pieces.pieces.size());
  Pacer pacer(execution);
  for (std::uint32_t p = 0; p < volumes.size(); ++p) {
    const std::vector<Face>& faces = pieces.pieces[p].faces;
    volumes[groups.of(p)] += signed_volume(d, faces.data(), faces.size(), d.point(faces[0].v[0]), execution);
    pacer.step(4 + faces.size());
  }
  return volumes;
}

Piece join_pieces(const RestrictedDiagram& d, const Pieces& pieces, const PieceGroups& groups,
                  std::uint32_t group, const Execution& execution) {
  Pacer pacer(execution);
  const std::vector<std::uint32_t> members = groups.members(group, execution);
  const Piece& first = pieces.pieces[group];
  Piece joined{{}, first.part, first.island, {}, {}};
  join_surfaces(d, pieces, members, joined.faces, execution);
  for (const std::uint32_t m : members) {
    const Piece& piece = pieces.pieces[m];
    joined.owners.insert(joined.owners.end(), piece.owners.begin(), piece.owners.end());
    joined.bodies.insert(joined.bodies.end(), piece.bodies.begin(), piece.bodies.end());
    if (piece.bodies.empty()) {
      std::vector<CutVertexId>& body = joined.bodies.emplace_back();
      for (const Face& face : piece.faces) body.insert(body.end(), face.v.begin(), face.v.end());
      sort_with_polls(execution, body.begin(), body.end());
      body.erase(std::unique(body.begin(), body.end()), body.end());
    }
    for (const Face& face : piece.faces) {
      pacer.step();
      if (!is_cap(face.source)) continue;
      const std::uint32_t other = pieces.piece_of_cap[(face.source ^ 1) & ~kCapFace];
      if (other != kNoIndex && groups.of(other) == group) continue;
      joined.faces.push_back(face);
    }
  }
  sort_with_polls(execution, joined.owners.begin(), joined.owners.end());
  joined.owners.erase(std::unique(joined.owners.begin(), joined.owners.end()), joined.owners.end());
  return joined;
}

SizeFigures unite_by_size(const RestrictedDiagram& d, const Pieces& pieces, const SizeLimits& limits,
                          PieceGroups& groups, const Execution& execution) {
  execution.poll();
  SizeFigures figures;
  if (!limits.any() || pieces.pieces.empty()) return figures;
  const std::vector<double> volumes = volumes_of_groups(d, pieces, groups, execution);
  std::uint32_t count = 0;
  double smallest = HUGE_VAL;
  for (std::uint32_t g = 0; g < volumes.size(); ++g) {
    if (!groups.is_group(g)) continue;
    ++count;
    smallest = std::fmin(smallest, volumes[g]);
  }
  const double all = d.solid.report.volume;
  const auto least = [&](std::uint32_t fragments) { return limits.least(all, fragments); };
  // Mostly nothing is too small, and then nobody asks who touches whom.
  if (limits.fragments == 0 && limits.max_fragments == 0 && limits.max_triangles == 0 &&
      smallest >= least(count)) {
    figures.min_volume = least(count);
    return figures;
  }

  // One sequence of unions, always the smallest group with its neighbour: first what is too small, then what is
  // beyond the share of its part, then what is beyond the number for all or too small beside the mean of what is
  // left. A budget of triangles takes as many of the unions that would go on from there as it needs.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> unions;
  SmallestFirst order(d, pieces, groups, volumes, execution);
  std::vector<std::uint32_t> of_part;
  for (std::uint32_t g = 0; g < volumes.size(); ++g) {
    const std::uint32_t part = pieces.pieces[g].part;
    if (of_part.size() <= part) of_part.resize(part + 1, 0);
    of_part[part] += groups.is_group(g);
  }
  /// The part of the two that are one now; kNoIndex if there was nothing to unite the smallest with.
  const auto unite_smallest = [&] {
    const auto [group, with] = order.unite_smallest();
    if (group == with) return kNoIndex;
    unions.emplace_back(group, with);
    return pieces.pieces[group].part;
  };
  const auto is_too_small = [&] { return !order.done() && order.smallest_volume() < least(order.groups()); };
  while (is_too_small())
    if (const std::uint32_t part = unite_smallest(); part != kNoIndex) --of_part[part];
  if (limits.fragments > 0) {
    PartQuotas quotas(pieces, volumes, std::move(of_part), limits.fragments, execution);
    figures.parts = quotas.parts();
    while (quotas.any_over() && !order.done()) {
      if (!quotas.over(pieces.pieces[order.smallest()].part))
        order.leave_smallest();
      else if (const std::uint32_t part = unite_smallest(); part != kNoIndex)
        quotas.unite(part);
    }
    order.take_back();
  }
  const auto are_too_many = [&] {
    return limits.max_fragments > 0 && order.groups() > limits.max_fragments && !order.done();
  };
  while (is_too_small() || are_too_many()) unite_smallest();
  std::size_t needed = unions.size();

  if (limits.max_triangles > 0) {
    // Numbers of unions after which nothing is too small, ascending.
    std::vector<std::size_t> ends;
    while (!order.done()) {
      if (!is_too_small() && (ends.empty() || ends.back() < unions.size())) ends.push_back(unions.size());
      unite_smallest();
    }
    if (ends.empty() || ends.back() < unions.size()) ends.push_back(unions.size());
    UnionTriangles triangles(d, pieces, groups, unions, execution);
    figures.fewest_triangles = triangles.after(unions.size());
    if (figures.fewest_triangles <= limits.max_triangles)
      // The fewest unions that are enough; each one takes triangles away.
      needed = *std::partition_point(ends.begin(), ends.end() - 1, [&](std::size_t so_many) {
        return triangles.after(so_many) > limits.max_triangles;
      });
  }
  Pacer pacer(execution);
  std::vector<double> left = volumes;
  for (std::size_t k = 0; k < needed; ++k) {
    const auto [a, b] = std::minmax(unions[k].first, unions[k].second);
    groups.unite(a, b, pacer);
    left[a] += left[b];
  }
  figures.united = static_cast<std::uint32_t>(needed);
  figures.min_volume = least(count - figures.united);
  // Whatever touches something has been united; what has no volume does not stay.
  for (std::uint32_t g = 0; g < left.size(); ++g)
    figures.alone += groups.is_group(g) && left[g] > 0 && left[g] < figures.min_volume;
  return figures;
}

}  // namespace fracture
