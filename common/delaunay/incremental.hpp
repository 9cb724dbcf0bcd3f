// The mutable Delaunay tetrahedralization. Single sites are inserted, exactly and with the one tie rule. So
// the set of tetrahedra depends only on the set of sites, never on the history (exact/in_sphere.hpp).
//
// Sources for the cavity: Bowyer 1981 and Watson 1981. For the walk: Devillers, Pion & Teillaud 2001
// ("Walking in a triangulation"). For the compact storage: Marot, Pellerin & Remacle 2019.
// reference/reference_delaunay.hpp implements the source paper's insertion by flips, and removal, on the same
// storage. DECISION.md explains why the pipeline uses the cavity.
//
// Invariants after every public call (validate() checks them):
//  1. Every tetrahedron (a, b, c, d) is positive: orient3d(a, b, c, d) > 0. There is never a flat one.
//  2. Adjacency is symmetric: neighbour k of t is opposite vertex k, and its link leads back.
//  3. Every facet is locally Delaunay by exact in_sphere with the tie rule. With 1 and 2, it follows that no
//     sphere contains a site (Delaunay's lemma, valid for generic weights).
//
// Vertices 0..3 are the corners of the big tetrahedron. Sites follow in the order of insertion, and keep
// their ids. The ids of removed sites are used again. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pages.hpp"
#include "common/delaunay/big_tetrahedron.hpp"
#include "common/delaunay/circumsphere.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/exact/binary_scale.hpp"
#include "common/exact/orient3d.hpp"
#include "common/exact/predicate_counters.hpp"

namespace fracture {

using TetVertexId = Id<struct TetVertexTag>;

/// A neighbour and the shared facet, in one word; allows 2^30 tetrahedra.
class Link {
 public:
  Link() = default;
  /// facet < 4: the facet opposite that vertex of `tet`.
  constexpr Link(TetId tet, unsigned facet) : word_(4 * tet + facet) {}
  constexpr TetId tet() const { return TetId{word_ >> 2}; }
  constexpr unsigned facet() const { return word_ & 3; }
  friend constexpr bool operator==(Link, Link) = default;

 private:
  std::uint32_t word_;
};
static_assert(sizeof(Link) == sizeof(std::uint32_t) && std::is_trivial_v<Link>);
/// The neighbour outside the facets of the big tetrahedron.
inline constexpr Link kNoLink{TetId{0x3fffffff}, 3};

class IncrementalDelaunay {
 public:
  struct Options {
    /// Insertion is refused (kFull) if the structure has more tetrahedra than this.
    std::uint32_t max_tets = 0x3fffffff;
    /// Borrowed; polled in every long loop. If Interrupted is thrown, the structure can no longer be used.
    const Execution* execution = &kUninterrupted;
  };
  enum class Status : std::uint8_t {
    kInserted,
    kDuplicate,      ///< a site with these coordinates exists: `vertex` is its id; nothing changed
    kOutsideDomain,  ///< outside U: build a new structure with a larger domain; nothing changed
    kFull,           ///< exceeds Options::max_tets; nothing changed
  };
  struct Insertion {
    Status status;
    TetVertexId vertex;
  };

  IncrementalDelaunay(const BigTetrahedron& big, Options options);
  explicit IncrementalDelaunay(const BigTetrahedron& big) : IncrementalDelaunay(big, Options{}) {}
  /// Continues from a finished tetrahedralization of sites in `big`: site s is vertex 4 + s.
  IncrementalDelaunay(const BigTetrahedron& big, Options options, const Tetrahedralization& finished);

  /// Reserves all memory for this many sites. If it is much (reserves_much()), the system provides it now.
  /// Throws Interrupted.
  void reserve(std::size_t sites);
  static std::size_t reserved_tets(std::size_t sites) { return sites * 7 + 64; }  // random: 6.7 per site
  static constexpr std::size_t kTetBytes = 64;
  static bool reserves_much(std::size_t sites) { return reserved_tets(sites) * kTetBytes >= kAlwaysFresh; }
  /// Adds a finite point: removes the tetrahedra in conflict with it, and joins their boundary to it.
  /// Expected constant time if near the last insertion; otherwise, N^(1/3) steps of walk.
  Insertion insert(const Vec3d& p);
  /// The same in a part of a tetrahedralization, for a p that is not a vertex. The missing tetrahedra are
  /// beyond facets without a neighbour, and none of them may be in conflict with p. The walk to p begins at
  /// the vertex `near`. If it leaves the part, all tetrahedra are searched.
  Insertion insert_in_part(const Vec3d& p, TetVertexId near);

  std::uint32_t site_count() const {
    return static_cast<std::uint32_t>(vertices_.size() - 4 - free_vertices_.size());
  }
  std::uint32_t tet_count() const { return static_cast<std::uint32_t>(tets_.size() - free_tets_.size()); }
  /// 1 + the largest vertex id in use.
  TetVertexId vertex_end() const { return TetVertexId{vertices_.size()}; }
  bool is_live(TetVertexId v) const { return v < vertices_.size() && vertices_[v].tet != kNoTet; }
  Vec3d position(TetVertexId v) const { return {vertices_[v].x, vertices_[v].y, vertices_[v].z}; }
  const BigTetrahedron& big() const { return big_; }

  /// Returns the first violated invariant with its ids, or nothing if all hold. Exact; linear in the
  /// tetrahedra.
  std::optional<std::string> validate() const;

  /// Returns the compact, immutable copy. site_of_vertex[v] is the id that vertex v gets; live sites must map
  /// one-to-one to 0..n-1. Tetrahedra keep the order of the storage, which depends on the history;
  /// canonicalize() removes this dependence.
  Tetrahedralization snapshot(std::span<const SiteId> site_of_vertex) const;
  /// The same, with sites numbered by increasing vertex id.
  Tetrahedralization snapshot() const;
  /// The same, in little more memory than the structure has. The structure cannot be used afterwards: if it
  /// has at least kManyTets tetrahedra, memory is released as it is read.
  static constexpr std::size_t kManyTets = std::size_t{1} << 20;
  Tetrahedralization take_snapshot(std::span<const SiteId> site_of_vertex);

  /// Calls visit(std::array<TetVertexId, 4>) for every tetrahedron, in storage order.
  template <class Visit>
  void for_each_tet(Visit visit) const {
    for (const Tet& t : tets_)
      if (t.v[0] != kNoVertex) visit(std::array<TetVertexId, 4>{t.v[0], t.v[1], t.v[2], t.v[3]});
  }

  /// How decisions were made. Costs nothing: insertion counts the calls of the filter, and the slow path the
  /// rest.
  struct Counters {
    std::uint64_t sphere_tests = 0;  ///< in_sphere decisions of insertions
    std::uint64_t walk_steps = 0;
    std::uint64_t tets_created = 0;
    exact::PredicateCounters in_sphere;
    exact::PredicateCounters orient3d;
  };
  const Counters& counters() const { return counters_; }

 protected:
  // Storage, location and predicates, also used by the other algorithms (reference/).
  static constexpr TetVertexId kNoVertex{0xffffffffu};

  /// One cache line. It stores the circumsphere, in units of K about the centre of the big tetrahedron
  /// (normalized()), so in_sphere needs only a squared distance. If this is less than the squared radius, the
  /// point is inside. If the two differ by less than kMargin times the squared radius, the exact path
  /// decides.
  struct alignas(64) Tet {
    TetVertexId v[4];
    Link n[4];
    double center[3];
    float radius2;       ///< NaN: always use the exact path
    std::uint32_t mark;  ///< state in the current insertion, see visit_
  };
  struct alignas(32) Vertex {
    double x, y, z;
    TetId tet;            ///< some tetrahedron at this vertex; kNoTet: removed
    std::uint32_t local;  ///< number in the cavity of the current insertion, otherwise kNoLocal
  };
  static constexpr std::uint32_t kNoLocal = 0xffffffffu;
  static_assert(sizeof(Tet) == kTetBytes);

  struct Located {
    TetId tet;
    unsigned zeros;  ///< bit k: the point is on the plane of facet k
  };

  /// A facet of the boundary of a cavity or star, and the link beyond it.
  struct Facet {
    TetVertexId v[3];
    Link outer;
  };

  /// Performs an insertion: finds the place of p, and calls fill(vertex, place) to insert it there.
  template <class Fill>
  Insertion insert_with(const Vec3d& p, const Fill& fill);
  Located locate(const Vec3d& p, TetId start);
  /// Returns nothing if the walk leaves through a facet without a neighbour.
  std::optional<Located> walk(const Vec3d& p, TetId start);
  int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) const {
    return exact::orient3d(a, b, c, d, scale_, &counters_.orient3d);
  }
  Vec3d normalized(const Vec3d& p) const { return inverse_half_ * (p - big_.center); }
  /// A point, in the units of the sites and of the spheres.
  struct Query {
    Vec3d p, normalized;
  };
  Query query(const Vec3d& p) const { return {p, normalized(p)}; }
  struct Filtered {
    bool inside, certain;
  };
  static Filtered filter(const Tet& t, const Query& q);
  bool in_conflict(const Tet& t, const Query& q) const;
  bool in_conflict_exact(const Tet& t, const Vec3d& p) const;
  void set_sphere(Tet& t) const;
  TetVertexId new_vertex(const Vec3d& p);
  TetId new_tet();
  TetId make_tet(TetVertexId a, TetVertexId b, TetVertexId c, TetVertexId d);
  void free_tet(TetId t);
  void next_visit();
  /// The link of the tetrahedron that `to` leads to, back through the same facet.
  Link& link_back(Link to) { return tets_[to.tet()].n[to.facet()]; }

  BigTetrahedron big_;
  Options options_;
  exact::BinaryScale scale_;  ///< scale of all points so far
  double orient_bound_;       ///< filter bound of orient3d for any four points in the big tetrahedron
  double inverse_half_;       ///< 1 / K, a power of two

  template <class AfterReading>
  Tetrahedralization snapshot(std::span<const SiteId> site_of_vertex,
                              const AfterReading& after_reading) const;

  std::vector<Tet> tets_;
  std::vector<Vertex> vertices_;
  std::vector<TetId> free_tets_;
  std::vector<TetVertexId> free_vertices_;
  TetId last_{0};  ///< start of the next walk
  std::uint64_t walk_state_ = 0x853c49e6748fea9bull;
  std::uint32_t visit_ = 0;  ///< marks equal to visit_: in conflict; visit_ + 1: known not to be
  mutable Counters counters_;

 private:
  // cavity.cpp
  void grow_cavity(const Query& q, TetId start);
  void fill_cavity(TetVertexId v);
  void take_slots();
  TetId slot(std::size_t boundary_facet) const { return cavity_[boundary_facet].tet(); }
  std::uint32_t make_tets(TetVertexId v);
  void measure_edges(TetVertexId v, std::uint32_t locals);
  template <bool kJoin>
  void finish_tets(TetVertexId v);
  using Edge = delaunay_detail::Edge<double>;
  void join_by_hash();
  /// For loops over one cavity; few cavities have thousands of facets.
  void poll_in_large_cavity(std::size_t step) const {
    if ((step & 0xfff) == 0xfff) [[unlikely]]
      options_.execution->poll();
  }

  // Scratch of one insertion, kept to avoid allocation.
  /// Each tetrahedron with the facet through which it was reached; later the slots of the new tetrahedra.
  std::vector<Link> cavity_;
  std::vector<Facet> boundary_;
  std::size_t cavity_count_ = 0, boundary_count_ = 0;  ///< number in use; the arrays never shrink
  std::vector<TetVertexId> local_;                     ///< the vertices of the cavity
  std::vector<Edge> edges_;                            ///< from the new vertex to each vertex of the cavity
  std::vector<std::uint32_t> fresh_;                   ///< three local numbers per boundary facet
  std::vector<Link> edge_table_;                       ///< by directed edge, if there are few vertices
  std::vector<std::uint32_t> edge_hash_;               ///< the same for join_by_hash()
};

}  // namespace fracture
