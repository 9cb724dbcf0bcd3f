#include "common/gltf/mesh_figures.hpp"

#include <algorithm>
#include <string>

#include "common/base/error.hpp"
#include "common/base/work_blocks.hpp"
#include "common/gltf/mesh_manifold.hpp"

namespace fracture {
namespace {

void check(const Fragment& f, Pacer& pacer) {
  const std::size_t count = f.positions.size();
  const auto sized = [count](const auto& values) { return values.empty() || values.size() == count; };
  bool good = count > 0 && !f.indices.empty() && sized(f.attributes.normals) && sized(f.attributes.tangents);
  for (const auto& set : f.attributes.uvs) good = good && set.size() == count;
  for (const auto& set : f.attributes.colors) good = good && set.size() == count;
  std::uint32_t highest = 0;
  pacer.each(0, f.indices.size(), [&](std::size_t k) { highest = std::max(highest, f.indices[k]); });
  std::size_t covered = 0;
  for (const FragmentPrimitive& p : f.primitives) {
    good = good && p.first_index == covered && p.index_count > 0 && p.index_count % 3 == 0;
    covered += p.index_count;
  }
  if (!good || highest >= count || covered != f.indices.size())
    throw InternalError("fragment " + std::to_string(f.id) + " contradicts its own description: " +
                        std::to_string(count) + " vertices, " + std::to_string(f.indices.size()) +
                        " indices, primitives cover " + std::to_string(covered));
}

}  // namespace

MeshFigures measure(const Fragment& f, bool mesh_manifold, Pacer& pacer) {
  check(f, pacer);
  const bool merges = mesh_manifold && !f.topology.empty();
  return {bounds_of(f.positions, pacer), merges ? merged_corners(f, pacer) : 0};
}

std::vector<MeshFigures> measure(const std::vector<Fragment>& fragments, bool mesh_manifold,
                                 const Execution& execution) {
  std::vector<MeshFigures> figures;
  resize_with_polls(execution, figures, fragments.size());
  constexpr std::uint64_t kBlock = 1u << 17;  // corners per block: enough to be worth a thread
  const WorkBlocks blocks(execution, fragments.size(), kBlock,
                          [&](std::size_t k) { return fragments[k].indices.size() + 32; });
  parallel_for_blocks(execution, blocks, [&](std::size_t, std::size_t begin, std::size_t end) {
    Pacer pacer(execution);
    for (std::size_t k = begin; k < end; ++k) figures[k] = measure(fragments[k], mesh_manifold, pacer);
  });
  return figures;
}

}  // namespace fracture
