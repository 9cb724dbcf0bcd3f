#include "common/fragment/surface_faces.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/base/work_blocks.hpp"
#include "common/fragment/outline.hpp"

namespace fracture {
namespace {

void halve(const CutVertexId* ring, std::uint32_t first, std::uint32_t last, std::uint32_t triangle,
           std::vector<Face>& out) {
  if (last - first < 2) return;
  const std::uint32_t middle = first + (last - first) / 2;
  out.push_back({{ring[first], ring[middle], ring[last]}, triangle});
  halve(ring, first, middle, triangle, out);
  halve(ring, middle, last, triangle, out);
}

/// The polygons of one input triangle.
struct CutTriangle {
  std::uint32_t triangle;
  std::size_t first, last;
};

/// Faces of a block of cut triangles that several owners share, in the order of the input triangles.
struct SharedFaces {
  std::vector<Face> faces;
  std::vector<std::uint32_t> owner;  // per face
};

class SurfaceDivider {
 public:
  SurfaceDivider(const RestrictedDiagram& diagram, const Ownership& ownership, const Execution& execution,
                 SharedFaces& out)
      : d_(diagram),
        ownership_(ownership),
        execution_(execution),
        pacer_(execution),
        mirrored_(diagram),
        outline_(diagram, execution),
        out_(out) {}

  /// Returns the owner of the whole triangle. Returns kNoIndex if that owner is not wanted. Also returns
  /// kNoIndex if several owners share the triangle; then the faces of each wanted owner are appended.
  std::uint32_t divide(const CutTriangle& cut) {
    const std::uint32_t owner = ownership_.grouped ? divide_among_groups(cut) : divide_among_cells(cut);
    if (out_.faces.size() - counted_ >= kCountedTogether) count_faces();
    return owner;
  }
  void count_faces() {
    execution_.made(Product::kFragmentTriangles, out_.faces.size() - counted_);
    counted_ = out_.faces.size();
  }

 private:
  static constexpr std::size_t kCountedTogether = 4096;

  std::uint32_t owner_of(SiteId s) const { return ownership_.owner_of_site[s]; }
  bool wanted(std::uint32_t o) const { return ownership_.wanted.empty() || ownership_.wanted[o]; }
  std::uint32_t only_owner(std::uint32_t o) const { return wanted(o) ? o : kNoIndex; }

  std::uint32_t divide_among_cells(const CutTriangle& cut) {
    const auto& polygons = d_.cuts.polygons;
    if (cut.last - cut.first == 1) return only_owner(owner_of(polygons[cut.first].cell));
    for (std::size_t k = cut.first; k < cut.last; ++k) add_polygon(polygons[k]);
    return kNoIndex;
  }

  std::uint32_t divide_among_groups(const CutTriangle& cut) {
    const auto& polygons = d_.cuts.polygons;
    const auto owner = [&](std::size_t k) { return owner_of(polygons[k].cell); };
    by_owner_.clear();
    bool same = true;
    for (std::size_t k = cut.first; k < cut.last; ++k) {
      by_owner_.push_back(k);
      same = same && owner(k) == owner(cut.first);
      pacer_.step();
    }
    if (same) return only_owner(owner(cut.first));
    sort_with_polls(execution_, by_owner_.begin(), by_owner_.end(), [&](std::size_t a, std::size_t b) {
      return owner(a) != owner(b) ? owner(a) < owner(b) : a < b;
    });
    for (std::size_t begin = 0, end = 0; begin < by_owner_.size(); begin = end) {
      const std::uint32_t o = owner(by_owner_[begin]);
      while (end < by_owner_.size() && owner(by_owner_[end]) == o) ++end;
      if (ownership_.sites_of_owner[o].size() == 1)
        add_polygon(polygons[by_owner_[begin]]);
      else if (wanted(o))
        fuse(o, begin, end);
    }
    return kNoIndex;
  }

  void add_polygon(const CutPolygon& p) {
    const std::uint32_t o = owner_of(p.cell);
    if (!wanted(o)) return;
    pacer_.step(p.count);
    if (mirrored_.is_mirrored(p.triangle))
      add_mirrored(p);
    else
      halve(d_.cuts.vertices.data() + p.first, 0, p.count - 1, p.triangle, out_.faces);
    out_.owner.resize(out_.faces.size(), o);
  }

  /// Gives the same triangles, mirrored, in the mirror image of the polygon.
  void add_mirrored(const CutPolygon& p) {
    const CutVertexId* const first = d_.cuts.vertices.data() + p.first;
    ring_.assign(first, first + p.count);
    const bool reversed = mirrored_.is_reversed(p.triangle);
    mirrored_.arrange(ring_, reversed);
    const std::size_t before = out_.faces.size();
    halve(ring_.data(), 0, p.count - 1, p.triangle, out_.faces);
    for (std::size_t k = before; reversed && k < out_.faces.size(); ++k)
      std::swap(out_.faces[k].v[1], out_.faces[k].v[2]);
  }

  /// Fuses the polygons of one owner. The remaining sides are those that do not face a cell of the same
  /// owner.
  void fuse(std::uint32_t owner, std::size_t begin, std::size_t end) {
    const auto& cuts = d_.cuts;
    outline_.clear();
    for (std::size_t n = begin; n < end; ++n) {
      const CutPolygon& p = cuts.polygons[by_owner_[n]];
      pacer_.step(p.count);
      for (std::uint32_t k = 0; k < p.count; ++k) {
        const PolygonSide side = cuts.sides[p.first + k];
        if (!is_mesh_edge(side) && owner_of(SiteId{side}) == owner) continue;
        outline_.add(cuts.vertices[p.first + k], cuts.vertices[p.first + (k + 1) % p.count]);
      }
    }
    outline_.triangulate_into(cuts.polygons[by_owner_[begin]].triangle, out_.faces);
    out_.owner.resize(out_.faces.size(), owner);
  }

  const RestrictedDiagram& d_;
  const Ownership& ownership_;
  const Execution& execution_;
  Pacer pacer_;
  const MirroredRings mirrored_;
  MirroredRings::Ring ring_;
  Outline outline_;
  SharedFaces& out_;
  std::size_t counted_ = 0;            // number of faces already counted
  std::vector<std::size_t> by_owner_;  // polygons
};

}  // namespace

OwnedFaces divide_surface(const RestrictedDiagram& d, const Ownership& ownership,
                          const Execution& execution) {
  const auto& polygons = d.cuts.polygons;
  const auto count = static_cast<std::uint32_t>(d.solid.triangles.size());
  const auto owners = static_cast<std::uint32_t>(ownership.sites_of_owner.size());

  // The faces of triangles that several owners share, by input triangle; all other triangles stay whole.
  std::vector<std::uint32_t> whole(count);  // per triangle: its only owner, or kNoIndex
  parallel_for(execution, count, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t o = ownership.owner_of_site[d.cuts.label[d.solid.triangles[t][0]]];
      whole[t] = ownership.wanted.empty() || ownership.wanted[o] ? o : kNoIndex;
    }
  });
  Pacer pacer(execution);
  std::vector<CutTriangle> cut;
  for (std::size_t p = 0; p < polygons.size();) {
    const std::size_t first = p;
    while (p < polygons.size() && polygons[p].triangle == polygons[first].triangle) ++p;
    pacer.step(p - first);
    cut.push_back({polygons[first].triangle, first, p});
  }
  const WorkBlocks blocks(execution, cut.size(), 400'000,
                          [&](std::size_t k) { return 100 * (cut[k].last - cut[k].first); });
  std::vector<SharedFaces> shared(blocks.count());
  parallel_for_blocks(execution, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
    SurfaceDivider divider(d, ownership, execution, shared[block]);
    for (std::size_t k = begin; k < end; ++k) whole[cut[k].triangle] = divider.divide(cut[k]);
    divider.count_faces();
  });

  // Counting sort by owner, in order of the input triangles.
  OwnedFaces out;
  out.begin.assign(owners + 1, 0);
  std::size_t faces = 0;
  for (const std::uint32_t o : whole) {
    pacer.step();
    if (o == kNoIndex) continue;
    ++out.begin[o + 1];
    ++faces;
  }
  execution.made(Product::kFragmentTriangles, faces);
  for (const SharedFaces& block : shared) {
    for (const std::uint32_t o : block.owner) ++out.begin[o + 1];
    faces += block.faces.size();
    pacer.step(block.faces.size());
  }
  if (faces >= kCapFace)
    throw Interrupted(Error{ErrorCode::kTooComplex,
                            "The surface is divided into more than 2^31 triangles. Ask for fewer sites."});
  for (std::uint32_t o = 0; o < owners; ++o) out.begin[o + 1] += out.begin[o];
  resize_with_polls(execution, out.faces, out.begin[owners]);
  std::vector<std::uint32_t> next(out.begin.begin(), out.begin.end() - 1);
  std::size_t block = 0, s = 0;
  for (std::uint32_t t = 0; t < count; ++t) {
    pacer.step();
    if (whole[t] != kNoIndex) {
      out.faces[next[whole[t]]++] = {d.corners(t), t};
      continue;
    }
    for (;; ++s) {
      while (block < shared.size() && s == shared[block].faces.size()) {
        ++block;
        s = 0;
      }
      if (block == shared.size() || shared[block].faces[s].source != t) break;
      out.faces[next[shared[block].owner[s]]++] = shared[block].faces[s];
      pacer.step();
    }
  }
  return out;
}

}  // namespace fracture
