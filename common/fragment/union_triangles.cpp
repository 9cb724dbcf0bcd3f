#include "common/fragment/union_triangles.hpp"

#include "common/fragment/unite.hpp"

namespace fracture {

std::uint64_t UnionTriangles::after(std::size_t count) {
  PieceGroups groups = before_;
  Pacer pacer(execution_);
  std::vector<std::uint32_t> made_by(groups.pieces(), kNoIndex);  // per group: its last union
  for (std::uint32_t k = 0; k < count; ++k) {
    const auto [a, b] = unions_[k];
    groups.unite(a, b, pacer);
    pacer.step(8);
    made_by[groups.of(a)] = k;
  }
  const auto triangles = [&](std::uint32_t g) -> std::uint64_t& {
    return made_by[g] != kNoIndex ? of_union_[made_by[g]] : of_group_before_[g];
  };
  std::vector<std::uint32_t> unknown;
  for (std::uint32_t g = 0; g < groups.pieces(); ++g) {
    pacer.step(4);
    if (!groups.is_group(g) || triangles(g) != kUnknown) continue;
    if (groups.size(g) == 1)
      triangles(g) = pieces_.pieces[g].faces.size();
    else
      unknown.push_back(g);
  }
  parallel_for(execution_, unknown.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      triangles(unknown[k]) = join_pieces(d_, pieces_, groups, unknown[k], execution_).faces.size();
  });
  std::uint64_t sum = 0;
  for (std::uint32_t g = 0; g < groups.pieces(); ++g) {
    pacer.step(4);
    if (groups.is_group(g)) sum += triangles(g);
  }
  return sum;
}

}  // namespace fracture
