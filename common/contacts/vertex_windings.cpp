#include "common/contacts/vertex_windings.hpp"

#include <optional>

#include "common/base/stamped_map.hpp"

namespace fracture::contacts_detail {
namespace {

/// A float beyond the box along +x. It is a power of two, so that exact sums with it stay short.
double beyond(const Box& box) {
  double x = 1;
  while (!(x > box.max.x)) x *= 2;
  return x;
}

/// Sets of vertices whose numbers differ by known amounts (union-find with path halving).
class Differences {
 public:
  std::uint32_t add(const Vec3d& place) {
    members_.push_back({static_cast<std::uint32_t>(members_.size()), 0, place});
    return static_cast<std::uint32_t>(members_.size() - 1);
  }
  std::size_t size() const { return members_.size(); }
  const Vec3d& place(std::uint32_t m) const { return members_[m].place; }
  std::uint32_t find(std::uint32_t m) {
    while (members_[m].up != m) {
      Member& here = members_[m];
      const Member& above = members_[here.up];
      if (above.up != here.up) {
        here.more += above.more;
        here.up = above.up;
      }
      m = here.up;
    }
    return m;
  }
  /// Returns the number of m minus that of find(m).
  int over_root(std::uint32_t m) const {
    int more = 0;
    for (; members_[m].up != m; m = members_[m].up) more += members_[m].more;
    return more;
  }
  /// Records that the number of q is that of p plus `jump`.
  void relate(std::uint32_t p, std::uint32_t q, int jump) {
    const std::uint32_t root_p = find(p), root_q = find(q);
    if (root_p == root_q) return;
    const int more = over_root(p) + jump - over_root(q);  // number of root_q minus that of root_p
    if (root_p < root_q) {
      members_[root_q].up = root_p;
      members_[root_q].more = more;
    } else {
      members_[root_p].up = root_q;
      members_[root_p].more = -more;
    }
  }

 private:
  struct Member {
    std::uint32_t up;
    int more;  ///< number minus that of `up`
    Vec3d place;
  };
  std::vector<Member> members_;
};

bool outside(const Vec3d& p, const Box& box) {
  return p.x < box.min.x || p.x > box.max.x || p.y < box.min.y || p.y > box.max.y || p.z < box.min.z ||
         p.z > box.max.z;
}

}  // namespace

int winding_around(const PartSurfaces& surfaces, std::uint32_t part, const Vec3d& point, Owner owner,
                   Pacer& pacer) {
  const Box& box = surfaces.solid().parts[part].box;
  if (outside(point, box)) return 0;
  const Vec3d end{beyond(box), point.y, point.z};
  const MovedSigns signs;
  int winding = 0;
  surfaces.each_near(part, {point, end}, pacer, [&](std::uint32_t t) {
    pacer.step(4);
    winding += signs.crossing(point, end, surfaces.corners(t), owner);
  });
  return winding;
}

std::vector<std::array<int, 3>> corner_windings(const PartSurfaces& surfaces,
                                                const std::vector<NearTriangle>& triangles,
                                                const std::vector<EdgeJumps>& jumps, std::uint32_t around,
                                                Owner owner, Pacer& pacer) {
  const Solid& solid = surfaces.solid();
  const Box& box = solid.parts[around].box;
  StampedMap& number_of = worker_map();
  number_of.next_epoch(solid.positions.size());
  Differences sets;
  std::vector<std::array<std::uint32_t, 3>> members(triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    pacer.step(4);
    for (std::size_t c = 0; c < 3; ++c) {
      const VertexId v = solid.triangles[triangles[k].triangle][c];
      std::uint32_t& number = number_of.slot(v);
      if (number == StampedMap::kEmpty) number = sets.add(to_double(solid.positions[v]));
      members[k][c] = number;
    }
  }
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    pacer.step();
    for (std::size_t c = 0; c < 3; ++c) sets.relate(members[k][c], members[k][(c + 1) % 3], jumps[k][c]);
  }
  std::vector<std::optional<int>> of_root(sets.size());
  for (std::uint32_t m = 0; m < sets.size(); ++m) {
    pacer.step();
    if (outside(sets.place(m), box)) {
      const std::uint32_t root = sets.find(m);
      of_root[root] = -sets.over_root(m);
    }
  }
  std::vector<std::array<int, 3>> windings(triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    pacer.step();
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t root = sets.find(members[k][c]);
      if (!of_root[root]) of_root[root] = winding_around(surfaces, around, sets.place(root), owner, pacer);
      windings[k][c] = *of_root[root] + sets.over_root(members[k][c]);
    }
  }
  return windings;
}

}  // namespace fracture::contacts_detail
