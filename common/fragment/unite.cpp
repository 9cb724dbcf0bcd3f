#include "common/fragment/unite.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>

#include "common/base/pacer.hpp"
#include "common/fragment/bonds.hpp"
#include "common/fragment/outline.hpp"

namespace fracture {

std::vector<Contact> find_contacts(const RestrictedDiagram& d, const Pieces& pieces,
                                   const std::vector<std::uint32_t>& group_of_piece,
                                   const Execution& execution) {
  // Every touching pair is a contact, those without area too: they bind where there is nothing better.
  std::vector<Contact> all;
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
  sort_with_polls(execution, all.begin(), all.end(), [](const Contact& x, const Contact& y) {
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
    VertexId lo, hi;
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
        const VertexId from = faces[k].face.v[c], to = faces[k].face.v[(c + 1) % 3];
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
  SmallestFirst(const RestrictedDiagram& d, const Pieces& pieces, const PieceGroups& groups,
                const Execution& execution)
      : pacer_(execution),
        volume_(pieces.pieces.size(), 0),
        touches_(pieces.pieces.size()),
        name_(pieces.pieces.size()),
        seat_(pieces.pieces.size()) {
    for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
      const std::vector<Face>& faces = pieces.pieces[p].faces;
      volume_[groups.of(p)] +=
          signed_volume(d, faces.data(), faces.size(), d.point(faces[0].v[0]), execution);
      name_[p] = seat_[p] = p;
      pacer_.step(4 + faces.size());
    }
    for (const Contact& c : find_contacts(d, pieces, groups.names(), execution)) {
      touches_[c.of][c.with] += c.area;
      pacer_.step(4);
    }
    for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
      if (groups.is_group(p)) order_.insert({volume_[p], p});
      pacer_.step(4);
    }
    count_ = static_cast<std::uint32_t>(order_.size());
  }

  std::uint32_t groups() const { return count_; }  ///< how many there are
  bool done() const { return order_.empty(); }
  double smallest_volume() const { return order_.begin()->first; }
  /// Unites the smallest group with its neighbour and says which those were; takes it out of the order when
  /// it has none (then both are the same).
  std::pair<std::uint32_t, std::uint32_t> unite_smallest() {
    const std::uint32_t g = order_.begin()->second;
    order_.erase(order_.begin());
    std::uint32_t with = kNoIndex;
    double area = -1;
    for (const auto& [other, shared] : touches_[seat_[g]]) {  // ties to the lowest
      if (shared > area || (shared == area && name_[other] < with)) {
        with = name_[other];
        area = shared;
      }
      pacer_.step();
    }
    if (with == kNoIndex) return {g, g};
    order_.erase({volume_[with], with});
    const std::uint32_t name = std::min(g, with);
    volume_[name] += volume_[std::max(g, with)];
    move_contacts(seat_[g], seat_[with], name);
    order_.insert({volume_[name], name});
    --count_;
    return {g, with};
  }

  /// Gives the memory back, which takes a while for a hundred thousand groups. Nothing may follow.
  void release(const Execution& execution) {
    clear_with_polls(execution, touches_);
    for (; !order_.empty(); order_.erase(order_.begin())) pacer_.step();
  }

 private:
  void move_contacts(std::uint32_t kept, std::uint32_t gone, std::uint32_t name) {
    if (touches_[kept].size() < touches_[gone].size()) std::swap(kept, gone);
    for (const auto& [other, shared] : touches_[gone]) {
      pacer_.step(16);
      touches_[other].erase(gone);
      if (other == kept) continue;
      touches_[kept][other] += shared;
      touches_[other][kept] += shared;
    }
    touches_[gone].clear();
    name_[kept] = name;
    seat_[name] = kept;
  }

  Pacer pacer_;
  std::vector<double> volume_;                            // per group
  std::vector<std::map<std::uint32_t, double>> touches_;  // per seat: seats, and the area shared with them
  std::vector<std::uint32_t> name_, seat_;                // per seat: its group; per group: its seat
  std::set<std::pair<double, std::uint32_t>> order_;
  std::uint32_t count_ = 0;
};

/// Triangles of all groups after some of the unions. A group of a given name and size is always the same
/// pieces, whichever number of unions is asked about, and its faces are joined once.
class TriangleCount {
 public:
  TriangleCount(const RestrictedDiagram& d, const Pieces& pieces, const PieceGroups& groups,
                const std::vector<std::pair<std::uint32_t, std::uint32_t>>& unions,
                const Execution& execution)
      : d_(d), pieces_(pieces), before_(groups), unions_(unions), execution_(execution) {}

  std::uint64_t after(std::size_t count) {
    PieceGroups groups = before_;
    Pacer pacer(execution_);
    for (std::size_t k = 0; k < count; ++k) {
      groups.unite(unions_[k].first, unions_[k].second, pacer);
    }
    std::uint64_t sum = 0;
    std::vector<std::uint32_t> unknown;
    for (std::uint32_t g = 0; g < groups.pieces(); ++g) {
      pacer.step();
      if (!groups.is_group(g)) continue;
      const auto known = triangles_.find(key(g, groups));
      if (groups.size(g) == 1)
        sum += pieces_.pieces[g].faces.size();
      else if (known != triangles_.end())
        sum += known->second;
      else
        unknown.push_back(g);
    }
    std::vector<std::uint64_t> joined(unknown.size());
    parallel_for(execution_, unknown.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        joined[k] = join_pieces(d_, pieces_, groups, unknown[k], execution_).faces.size();
    });
    for (std::size_t k = 0; k < unknown.size(); ++k) {
      triangles_.emplace(key(unknown[k], groups), joined[k]);
      sum += joined[k];
    }
    return sum;
  }

 private:
  static std::uint64_t key(std::uint32_t group, const PieceGroups& groups) {
    return std::uint64_t{group} << 32 | groups.size(group);
  }

  const RestrictedDiagram& d_;
  const Pieces& pieces_;
  const PieceGroups& before_;
  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& unions_;
  const Execution& execution_;
  std::unordered_map<std::uint64_t, std::uint64_t> triangles_;  // only looked up
};

}  // namespace

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
      std::vector<VertexId>& body = joined.bodies.emplace_back();
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
  SizeFigures figures;
  figures.min_volume = std::max(limits.min_volume, limits.min_fraction * d.solid.report.volume);
  if (!limits.any() || pieces.pieces.empty()) return figures;

  // One sequence of unions, of which the limits take as many as they need: the smallest group goes first
  // whatever is asked, so that each limit needs a prefix.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> unions;
  std::size_t needed = 0;
  SmallestFirst order(d, pieces, groups, execution);
  while (!order.done()) {
    const bool small = order.smallest_volume() < figures.min_volume;
    const bool many = limits.max_fragments > 0 && order.groups() > limits.max_fragments;
    if (!small && !many && limits.max_triangles == 0) break;
    const auto [group, with] = order.unite_smallest();
    if (group == with) {
      if (small) ++figures.alone;
      continue;
    }
    unions.emplace_back(group, with);
    if (small || many) needed = unions.size();
  }
  order.release(execution);

  if (limits.max_triangles > 0) {
    TriangleCount triangles(d, pieces, groups, unions, execution);
    figures.fewest_triangles = triangles.after(unions.size());
    if (figures.fewest_triangles <= limits.max_triangles) {
      // The fewest unions that are enough; each one takes triangles away.
      std::size_t enough = unions.size();
      for (std::size_t low = needed; low < enough;) {
        const std::size_t middle = low + (enough - low) / 2;
        if (triangles.after(middle) <= limits.max_triangles)
          enough = middle;
        else
          low = middle + 1;
      }
      needed = std::max(needed, enough);
    }
  }
  Pacer pacer(execution);
  for (std::size_t k = 0; k < needed; ++k) {
    groups.unite(unions[k].first, unions[k].second, pacer);
  }
  figures.united = static_cast<std::uint32_t>(needed);
  return figures;
}

}  // namespace fracture
