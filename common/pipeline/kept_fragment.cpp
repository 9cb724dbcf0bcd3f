#include "common/pipeline/kept_fragment.hpp"

#include <utility>

#include "common/base/heap_bytes.hpp"
#include "common/base/pacer.hpp"
#include "common/fragment/file_volume.hpp"

namespace fracture {

KeptFragment kept_with_pivot(Fragment made, Pivot pivot, const Execution& execution) {
  Pacer pacer(execution);
  KeptFragment kept{.fragment = std::move(made)};
  Fragment& f = kept.fragment;
  for (const Vec3f& p : f.positions) {
    pacer.step();
    kept.box.add(to_double(p));
  }
  kept.is_in_convex = f.bodies.empty();
  if (pivot == Pivot::kCenterOfMass) {
    const auto moved = [&](const Vec3f& world) -> Vec3f {
      const Vec3d p = to_double(world) - f.center;
      return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    };
    kept.far = std::move(f.positions);
    f.positions.clear();
    f.positions.reserve(kept.far.size());
    for (const Vec3f& p : kept.far) {
      pacer.step();
      f.positions.push_back(moved(p));
    }
    for (std::vector<Vec3f>& body : f.bodies) {
      pacer.step(body.size());
      for (Vec3f& p : body) p = moved(p);
    }
    f.pivot = f.center;
  }
  kept.volume_file = file_volume(f, execution).volume;
  return kept;
}

std::size_t memory_size(const Fragment& f) {
  std::size_t bytes = sizeof f + heap(f.sites) + heap(f.positions) + heap(f.attributes.normals) +
                      heap(f.attributes.tangents) + nested_heap(f.attributes.uvs) +
                      nested_heap(f.attributes.colors) + heap(f.indices) + heap(f.primitives) +
                      heap(f.part_cells) + heap(f.part_volumes) + heap(f.triangle_parts) + heap(f.topology) +
                      heap(f.caps) + nested_heap(f.bodies);
  if (f.sheet) bytes += memory_size(*f.sheet);
  return bytes;
}

std::size_t memory_size(const FragmentHulls& hulls) {
  std::size_t bytes = sizeof hulls + heap(hulls.hulls);
  for (const CollisionHull& hull : hulls.hulls) bytes += heap(hull.points) + heap(hull.triangles);
  return bytes;
}

std::size_t memory_size(const KeptFragment& kept) {
  return sizeof kept - sizeof kept.fragment - sizeof kept.hulls + memory_size(kept.fragment) +
         memory_size(kept.hulls) + heap(kept.far);
}

}  // namespace fracture
