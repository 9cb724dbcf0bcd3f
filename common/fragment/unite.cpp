#include "common/fragment/unite.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "common/fragment/bonds.hpp"
#include "common/fragment/outline.hpp"

namespace fracture {

PieceGroups::PieceGroups(std::size_t pieces) : group_(pieces), members_(pieces) {
  for (std::uint32_t p = 0; p < pieces; ++p) {
    group_[p] = p;
    members_[p] = {p};
  }
}

void PieceGroups::unite(std::uint32_t a, std::uint32_t b) {
  a = group_[a];
  b = group_[b];
  if (a == b) return;
  if (b < a) std::swap(a, b);
  for (const std::uint32_t p : members_[b]) group_[p] = a;
  const auto middle = static_cast<std::ptrdiff_t>(members_[a].size());
  members_[a].insert(members_[a].end(), members_[b].begin(), members_[b].end());
  std::inplace_merge(members_[a].begin(), members_[a].begin() + middle, members_[a].end());
  members_[b].clear();
}

std::vector<Contact> find_contacts(const RestrictedDiagram& d, const Pieces& pieces,
                                   const std::vector<std::uint32_t>& group_of_piece) {
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
  return all;
}

namespace {

/// The outer faces of a group, by input triangle: those of one piece as they are, those of several fused.
void join_surfaces(const RestrictedDiagram& d, const Pieces& pieces,
                   const std::vector<std::uint32_t>& members, std::vector<Face>& out) {
  struct Owned {
    Face face;
    std::uint32_t piece;
  };
  std::vector<Owned> faces;
  for (const std::uint32_t m : members)
    for (const Face& face : pieces.pieces[m].faces)
      if (!is_cap(face.source)) faces.push_back({face, m});
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Owned& a, const Owned& b) { return a.face.source < b.face.source; });

  struct Edge {
    VertexId lo, hi;
    bool forward;  // from lo to hi
  };
  std::vector<Edge> edges;
  Outline outline(d);
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    const std::uint32_t t = faces[begin].face.source;
    bool shared = false;
    for (end = begin; end < faces.size() && faces[end].face.source == t; ++end)
      shared = shared || faces[end].piece != faces[begin].piece;
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
    std::sort(edges.begin(), edges.end(),
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

/// Contacts of the groups while they grow, and the groups by volume.
class SmallestFirst {
 public:
  SmallestFirst(const RestrictedDiagram& d, const Pieces& pieces, const PieceGroups& groups)
      : volume_(pieces.pieces.size(), 0), touches_(pieces.pieces.size()) {
    for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
      const std::vector<Face>& faces = pieces.pieces[p].faces;
      volume_[groups.of_piece()[p]] += signed_volume(d, faces.data(), faces.size(), d.point(faces[0].v[0]));
    }
    for (const Contact& c : find_contacts(d, pieces, groups.of_piece())) touches_[c.of][c.with] += c.area;
    for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p)
      if (groups.is_group(p)) order_.insert({volume_[p], p});
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
    for (const auto& [other, shared] : touches_[g])  // ascending: ties to the lowest
      if (shared > area) {
        with = other;
        area = shared;
      }
    if (with == kNoIndex) return {g, g};
    order_.erase({volume_[with], with});
    const std::uint32_t kept = std::min(g, with), gone = std::max(g, with);
    volume_[kept] += volume_[gone];
    for (const auto& [other, shared] : touches_[gone]) {
      touches_[other].erase(gone);
      if (other == kept) continue;
      touches_[kept][other] += shared;
      touches_[other][kept] += shared;
    }
    touches_[gone].clear();
    order_.insert({volume_[kept], kept});
    --count_;
    return {g, with};
  }

 private:
  std::vector<double> volume_;
  std::vector<std::map<std::uint32_t, double>> touches_;
  std::set<std::pair<double, std::uint32_t>> order_;
  std::uint32_t count_ = 0;
};

/// Triangles of all groups after the first `count` unions.
std::uint64_t count_triangles(const RestrictedDiagram& d, const Pieces& pieces, PieceGroups groups,
                              const std::vector<std::pair<std::uint32_t, std::uint32_t>>& unions,
                              std::size_t count, const Execution& execution) {
  for (std::size_t k = 0; k < count; ++k) groups.unite(unions[k].first, unions[k].second);
  const std::size_t n = pieces.pieces.size();
  std::vector<std::uint64_t> triangles(n, 0);
  parallel_for(execution, n, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g) {
      const auto& members = groups.members(static_cast<std::uint32_t>(g));
      if (members.empty()) continue;
      triangles[g] = members.size() == 1 ? pieces.pieces[g].faces.size()
                                         : join_pieces(d, pieces, members, groups.of_piece()).faces.size();
    }
  });
  std::uint64_t sum = 0;
  for (const std::uint64_t t : triangles) sum += t;
  return sum;
}

}  // namespace

Piece join_pieces(const RestrictedDiagram& d, const Pieces& pieces, const std::vector<std::uint32_t>& members,
                  const std::vector<std::uint32_t>& group_of_piece) {
  Piece joined = pieces.pieces[members[0]];
  joined.faces.clear();
  joined.owners.clear();
  joined.bodies.clear();
  join_surfaces(d, pieces, members, joined.faces);
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
      if (!is_cap(face.source)) continue;
      const std::uint32_t other = pieces.piece_of_cap[(face.source ^ 1) & ~kCapFace];
      if (other != kNoIndex && group_of_piece[other] == group_of_piece[m]) continue;
      joined.faces.push_back(face);
    }
  }
  std::sort(joined.owners.begin(), joined.owners.end());
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
  SmallestFirst order(d, pieces, groups);
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

  if (limits.max_triangles > 0) {
    const auto triangles = [&](std::size_t count) {
      execution.poll();
      return count_triangles(d, pieces, groups, unions, count, execution);
    };
    figures.fewest_triangles = triangles(unions.size());
    if (figures.fewest_triangles <= limits.max_triangles) {
      // The fewest unions that are enough; each one takes triangles away.
      std::size_t enough = unions.size();
      for (std::size_t low = needed; low < enough;) {
        const std::size_t middle = low + (enough - low) / 2;
        if (triangles(middle) <= limits.max_triangles)
          enough = middle;
        else
          low = middle + 1;
      }
      needed = std::max(needed, enough);
    }
  }
  for (std::size_t k = 0; k < needed; ++k) groups.unite(unions[k].first, unions[k].second);
  figures.united = static_cast<std::uint32_t>(needed);
  return figures;
}

}  // namespace fracture
