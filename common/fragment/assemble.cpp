#include "common/fragment/assemble.hpp"

#include <algorithm>
#include <cmath>

#include "common/exact/number_types.hpp"
#include "common/fragment/mass_properties.hpp"
#include "common/fragment/stamped_map.hpp"
#include "common/fragment/vertex_attributes.hpp"

namespace fracture {
namespace {

/// Which vertex of the file: a position (VertexId) and the attributes it has there. Faces that agree share
/// the vertex.
struct Flavor {
  std::uint32_t kind, a, b;
  friend bool operator==(const Flavor&, const Flavor&) = default;
};
enum FlavorKind : std::uint32_t {
  kPlain,     // the source has no attributes: a position is all
  kWedge,     // input vertex: the wedge (a)
  kOnEdge,    // cut of an edge: the wedges at its ends (a lower vertex, b higher)
  kInside,    // in the interior of triangle a
  kInterior,  // on the flat face a: a cap's facet and side, or a filled triangle
};

class Assembler {
 public:
  Assembler(const RestrictedDiagram& diagram, Fragment& out)
      : d_(diagram), mesh_(*diagram.solid.source), out_(out), writer_(mesh_.attributes, out.attributes) {
    const Attributes& a = mesh_.attributes;
    plain_ = a.normals.empty() && a.tangents.empty() && a.uvs.empty() && a.colors.empty();
  }

  void run(const Piece& piece, const Face* faces) {
    order_by_material(piece, faces);
    first_variant_.next_epoch(d_.vertex_count());
    out_.indices.reserve(3 * order_.size());
    const std::size_t vertices =
        order_.size() / 2 + order_.size() / 4 + 8;  // a guess: half the faces, and seams
    out_.topology.reserve(vertices);
    ids_.reserve(vertices);
    flavors_.reserve(vertices);
    next_variant_.reserve(vertices);
    points_.reserve(vertices);
    FlatFrame frame({0, 0, 1});
    FaceSource frame_source = kNoIndex;
    for (const auto& [material, f] : order_) {
      if (out_.primitives.empty() || out_.primitives.back().material != material)
        out_.primitives.push_back({material, static_cast<std::uint32_t>(out_.indices.size()), 0});
      const Face& face = faces[f];
      // The plane of a flat face is the same for all its triangles, which follow one another.
      const bool flat = material == kInteriorMaterial;
      if (flat && face.source != frame_source) {
        frame = FlatFrame(flat_normal(face));
        frame_source = face.source;
      }
      for (const VertexId v : face.v) out_.indices.push_back(vertex(face, v, flat, frame));
      out_.primitives.back().index_count += 3;
    }
    measure();
    place(piece);
  }

 private:
  // Faces by material, in their order within each; interior last, "no material" just before it. A piece has
  // few materials.
  void order_by_material(const Piece& piece, const Face* faces) {
    const auto rank = [](std::uint32_t m) {
      return m == kInteriorMaterial ? 0xffffffffu : m == kNoIndex ? 0xfffffffeu : m;
    };
    std::vector<std::uint32_t> material(piece.face_count);
    std::vector<std::uint32_t> kinds;
    for (std::uint32_t f = 0; f < piece.face_count; ++f) {
      material[f] = is_cap(faces[f].source) ? kInteriorMaterial : d_.solid.material[faces[f].source];
      if (f > 0 && material[f] == material[f - 1]) continue;
      kinds.push_back(material[f]);
    }
    std::sort(kinds.begin(), kinds.end(),
              [&](std::uint32_t x, std::uint32_t y) { return rank(x) < rank(y); });
    kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
    order_.reserve(piece.face_count);
    if (kinds.size() <= 4) {
      for (const std::uint32_t m : kinds)
        for (std::uint32_t f = 0; f < piece.face_count; ++f)
          if (material[f] == m) order_.push_back({m, f});
      return;
    }
    for (std::uint32_t f = 0; f < piece.face_count; ++f) order_.push_back({material[f], f});
    std::stable_sort(order_.begin(), order_.end(),
                     [&](const auto& x, const auto& y) { return rank(x.first) < rank(y.first); });
  }

  Vec3d flat_normal(const Face& face) const {
    if (is_cap(face.source)) {
      const CapRegion& r = d_.caps.regions[cap_region(face.source)];
      const Vec3d n = d_.diagram.site(r.hi) - d_.diagram.site(r.lo);
      return ((cap_side(face.source) == 0 ? 1.0 : -1.0) / length(n)) * n;
    }
    const auto& v = d_.solid.triangles[face.source];
    const Vec3d n = cross(d_.point(v[1]) - d_.point(v[0]), d_.point(v[2]) - d_.point(v[0]));
    const double l = length(n);
    return l > 0 ? (1 / l) * n : Vec3d{0, 0, 1};
  }

  Flavor flavor(const Face& face, VertexId v, bool flat) const {
    if (flat) {
      // Regions of one facet share their plane, but not their vertices: the region will do.
      return {kInterior, face.source, 0};
    }
    if (plain_) return {kPlain, 0, 0};
    const auto& corners = d_.solid.triangles[face.source];
    const auto& wedges = d_.solid.wedges[face.source];
    if (v < d_.cuts.first_b()) {
      for (int k = 0; k < 3; ++k)
        if (corners[k] == v) return {kWedge, wedges[k], 0};
    } else if (v < d_.cuts.first_c()) {
      const auto [lo, hi] = edge_of(v);
      Flavor f{kOnEdge, 0, 0};
      for (int k = 0; k < 3; ++k) {
        if (corners[k] == lo) f.a = wedges[k];
        if (corners[k] == hi) f.b = wedges[k];
      }
      return f;
    }
    return {kInside, face.source, 0};
  }

  std::array<std::uint32_t, 2> edge_of(VertexId b) const {
    return d_.solid.edge_vertices[d_.cuts.edge_cuts[b - d_.cuts.first_b()].edge];
  }

  std::uint32_t vertex(const Face& face, VertexId v, bool flat, const FlatFrame& frame) {
    const Flavor f = flavor(face, v, flat);
    std::uint32_t& first = first_variant_.slot(v);
    for (std::uint32_t k = first; k != kNoIndex; k = next_variant_[k])
      if (flavors_[k] == f) return k;

    const auto fresh = static_cast<std::uint32_t>(ids_.size());
    ids_.push_back(v);
    flavors_.push_back(f);
    points_.push_back(d_.point(v));
    if (first == kNoIndex) {
      first = fresh;
      next_variant_.push_back(kNoIndex);
    } else {  // behind the first, which stands for the position's topology
      next_variant_.push_back(next_variant_[first]);
      next_variant_[first] = fresh;
    }
    out_.topology.push_back(first);
    write_attributes(f, face, v, frame);
    return fresh;
  }

  void write_attributes(const Flavor& f, const Face& face, VertexId v, const FlatFrame& frame) {
    switch (f.kind) {
      case kPlain:
        return writer_.blank();
      case kWedge:
        return writer_.copy(f.a);
      case kOnEdge: {
        const auto [lo, hi] = edge_of(v);
        const double t = along(d_.point(lo), d_.point(hi), d_.point(v));
        return writer_.blend({f.a, f.b, f.a}, {1 - t, t, 0});
      }
      case kInside:
        return writer_.blend(d_.solid.wedges[face.source], barycentric(face.source, d_.point(v)));
      default:
        return writer_.interior(frame, d_.point(v));
    }
  }

  /// Parameter of x on the segment (a, b), from its longest axis.
  static double along(const Vec3d& a, const Vec3d& b, const Vec3d& x) {
    const Vec3d e = b - a;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::fabs(e[k]) > std::fabs(e[axis])) axis = k;
    if (e[axis] == 0) return 0;
    return std::clamp((x[axis] - a[axis]) / e[axis], 0.0, 1.0);
  }

  std::array<double, 3> barycentric(std::uint32_t t, const Vec3d& x) const {
    const auto& v = d_.solid.triangles[t];
    const Vec3d a = d_.point(v[0]) - x, b = d_.point(v[1]) - x, c = d_.point(v[2]) - x;
    const Vec3d n = cross(b - a, c - a);
    std::array<double, 3> w{std::fmax(0, dot(n, cross(b, c))), std::fmax(0, dot(n, cross(c, a))),
                            std::fmax(0, dot(n, cross(a, b)))};
    const double sum = w[0] + w[1] + w[2];
    if (!(sum > 0)) return {1, 0, 0};
    for (double& k : w) k /= sum;
    return w;
  }

  void measure() {
    MassIntegral all(points_[out_.indices[0]]);
    for (const FragmentPrimitive& p : out_.primitives) {
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3)
        all.add(points_[out_.indices[k]], points_[out_.indices[k + 1]], points_[out_.indices[k + 2]]);
      if (p.material != kInteriorMaterial) out_.exterior_area = all.area();  // the interior comes last
    }
    out_.mass = all.result();
  }

  void place(const Piece& piece) {
    const SeamLattice& lattice = d_.positions.lattice;
    const Vec3d step = lattice.step();
    // Inside the box even when rounding error throws the centre of a sliver out of it.
    Box box;
    for (const Vec3d& p : points_) box.add(p);
    std::array<std::int32_t, 3> pivot;
    for (int a = 0; a < 3; ++a)
      pivot[a] = static_cast<std::int32_t>(
          std::nearbyint(std::clamp(out_.mass.center_of_mass[a], box.min[a], box.max[a]) / step[a]));
    out_.pivot = lattice.to_world(pivot);
    const auto local = [&](VertexId v) -> Vec3f {
      if (v < d_.positions.first_constructed) {
        const Vec3d p = d_.point(v) - out_.pivot;
        return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
      }
      const auto& s = d_.positions.steps[v - d_.positions.first_constructed];
      return {static_cast<float>((s[0] - pivot[0]) * step.x), static_cast<float>((s[1] - pivot[1]) * step.y),
              static_cast<float>((s[2] - pivot[2]) * step.z)};
    };
    out_.positions.reserve(ids_.size());
    for (const VertexId v : ids_) out_.positions.push_back(local(v));
    for (const std::vector<VertexId>& body : piece.bodies) {
      out_.bodies.emplace_back();
      for (const VertexId v : body) out_.bodies.back().push_back(local(v));
    }
  }

  const RestrictedDiagram& d_;
  const Mesh& mesh_;
  Fragment& out_;
  AttributeWriter writer_;
  bool plain_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order_;  // (material, face)
  StampedMap& first_variant_ = worker_map();
  // Per vertex of the fragment.
  std::vector<VertexId> ids_;
  std::vector<Flavor> flavors_;
  std::vector<std::uint32_t> next_variant_;
  std::vector<Vec3d> points_;
};

}  // namespace

Fragment assemble(const RestrictedDiagram& diagram, const Ownership& ownership, const Piece& piece,
                  const Face* faces) {
  Fragment out;
  for (const std::uint32_t o : piece.owners)
    out.sites.insert(out.sites.end(), ownership.sites_of_owner[o].begin(), ownership.sites_of_owner[o].end());
  std::sort(out.sites.begin(), out.sites.end());
  out.part = piece.part;
  out.node = diagram.solid.parts[piece.part].node;
  Assembler(diagram, out).run(piece, faces);
  return out;
}

FileVolume file_volume(const Fragment& f) {
  double six = 0, reach = 0;
  for (const Vec3f& p : f.positions)
    for (const float c : {p.x, p.y, p.z}) reach = std::max(reach, std::fabs(static_cast<double>(c)));
  for (std::size_t k = 0; k < f.indices.size(); k += 3)
    six += dot(to_double(f.positions[f.indices[k]]),
               cross(to_double(f.positions[f.indices[k + 1]]), to_double(f.positions[f.indices[k + 2]])));
  // Floats are exact in double. A term is at most 6 reach³ and off by fewer than 8 roundings; the k-th
  // partial sum is at most k times that and rounded once: together less than n (n + 16) 2^-53 6 reach³.
  const auto n = static_cast<double>(f.indices.size() / 3);
  const double error = n * (n + 16) * 0x1.0p-52 * 6 * reach * reach * reach;
  if (std::fabs(six) > error) return {six / 6, six > 0 ? 1 : -1};

  exact::BinaryScale scale;
  for (const Vec3f& p : f.positions) scale.include(to_double(p));
  exact::BigInt sum = 0;
  for (std::size_t k = 0; k < f.indices.size(); k += 3) {
    const auto at = [&](std::size_t m) {
      return scale.scaled<exact::BigInt>(to_double(f.positions[f.indices[m]]));
    };
    sum += dot(at(k), cross(at(k + 1), at(k + 2)));
  }
  return {six / 6, exact::sign_of(sum)};
}

}  // namespace fracture
