#include "common/fragment/unite.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/fragment/bonds.hpp"
#include "common/fragment/outline.hpp"

namespace fracture {

std::vector<PieceContact> find_piece_contacts(const RestrictedDiagram& d, const Pieces& pieces,
                                              const std::vector<std::uint32_t>& group_of_piece,
                                              const Execution& execution) {
  // Every touching pair is a contact, even without area: it is used if there is nothing better.
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

/// Appends the outer faces of a group, by input triangle. Faces of one piece are copied, and faces of
/// several pieces are fused. Nothing is fused if triangles are mirrored in another solid (Solid::mirrored), where
/// these pieces may not be united.
void join_surfaces(const RestrictedDiagram& d, const Pieces& pieces,
                   const std::vector<std::uint32_t>& members, std::vector<Face>& out,
                   const Execution& execution) {
  struct Owned {
    Face face;
    std::uint32_t piece;
    std::uint32_t number;  // in the order of the members and their faces; kept within a triangle
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
    if (!shared || !d.solid.mirrored.empty()) {
      for (std::size_t k = begin; k < end; ++k) out.push_back(faces[k].face);
      continue;
    }
    // The edges that are not used in both directions form the outline.
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

bool has_several_parts(const Pieces& pieces, const std::vector<std::uint32_t>& members) {
  return std::any_of(members.begin(), members.end(), [&](std::uint32_t m) {
    return pieces.pieces[m].part != pieces.pieces[members[0]].part;
  });
}

std::vector<PartOwner> part_owners_of(const Pieces& pieces, const std::vector<std::uint32_t>& members,
                                      const Execution& execution) {
  std::vector<PartOwner> all;
  all.reserve(members.size());
  for (const std::uint32_t m : members) all.push_back({pieces.pieces[m].part, pieces.pieces[m].owners[0]});
  sort_with_polls(execution, all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

std::vector<double> volumes_of_groups(const RestrictedDiagram& d, const Pieces& pieces,
                                      const PieceGroups& groups, const Execution& execution,
                                      const std::vector<double>& weights) {
  std::vector<double> volumes(pieces.pieces.size());
  Pacer pacer(execution);
  for (std::uint32_t p = 0; p < volumes.size(); ++p) {
    const std::vector<Face>& faces = pieces.pieces[p].faces;
    const double volume = signed_volume(d, faces.data(), faces.size(), d.point(faces[0].v[0]), execution);
    volumes[groups.of(p)] += weights.empty() ? volume : weights[pieces.pieces[p].part] * volume;
    pacer.step(4 + faces.size());
  }
  return volumes;
}

std::vector<PartVolume> volumes_of_parts(const RestrictedDiagram& d, const Pieces& pieces,
                                         const std::vector<std::uint32_t>& members,
                                         const Execution& execution) {
  std::vector<PartVolume> volumes;
  Pacer pacer(execution);
  for (const std::uint32_t m : members) {
    const Piece& piece = pieces.pieces[m];
    pacer.step(4 + piece.faces.size());
    volumes.push_back(
        {d.part_in_whole ? (*d.part_in_whole)[piece.part] : piece.part,
         signed_volume(d, piece.faces.data(), piece.faces.size(), d.point(piece.faces[0].v[0]), execution)});
  }
  std::stable_sort(volumes.begin(), volumes.end(),
                   [](const PartVolume& x, const PartVolume& y) { return x.part < y.part; });
  std::size_t kept = 0;
  for (std::size_t k = 1; k < volumes.size(); ++k) {
    if (volumes[k].part == volumes[kept].part)
      volumes[kept].volume += volumes[k].volume;
    else
      volumes[++kept] = volumes[k];
  }
  volumes.resize(std::min(volumes.size(), kept + 1));
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
  if (has_several_parts(pieces, members)) joined.part_owners = part_owners_of(pieces, members, execution);
  return joined;
}

}  // namespace fracture
