#include "common/rough/cap_normals.hpp"

#include <algorithm>
#include <array>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// Regions of one cut that may meet at one place and smooth each other; where more do (all facets of a
/// lattice through one point), each has its own normal there: every pair would have to be looked at.
constexpr std::size_t kMostAtOnePlace = 64;
/// Cosine of the angle between two facets up to which they are one cut.
constexpr double kOneCut = 0.94;

struct Corner {
  std::array<std::int32_t, 3> place;  // on the seam lattice: coinciding vertices are one
  std::uint32_t region, corner;
};

}  // namespace

std::vector<Vec3f> cap_normals(const VoronoiDiagram& diagram, const std::vector<std::uint32_t>& owner_of_site,
                               const Caps& caps, const VertexPositions& positions,
                               const Execution& execution) {
  // Regions by the pair of owners they part.
  struct Cut {
    std::uint32_t low, high, region;
    auto operator<=>(const Cut&) const = default;
  };
  std::vector<Cut> cuts;
  for (std::uint32_t r = 0; r < caps.regions.size(); ++r) {
    const std::uint32_t a = owner_of_site[caps.regions[r].lo], b = owner_of_site[caps.regions[r].hi];
    if (a != b) cuts.push_back({std::min(a, b), std::max(a, b), r});
  }
  sort_with_polls(execution, cuts.begin(), cuts.end());
  std::vector<std::size_t> begin;
  for (std::size_t k = 0; k < cuts.size(); ++k)
    if (k == 0 || cuts[k].low != cuts[k - 1].low || cuts[k].high != cuts[k - 1].high) begin.push_back(k);
  const std::size_t count = begin.size();
  begin.push_back(cuts.size());

  const auto at = [&](CutVertexId v) { return positions.points[v - positions.first_constructed]; };
  // From the owner with the lower number to the other.
  const auto sign_of = [&](std::uint32_t r) {
    return owner_of_site[caps.regions[r].lo] < owner_of_site[caps.regions[r].hi] ? 1.0 : -1.0;
  };
  std::vector<Vec3f> normals(3 * caps.triangles.size());
  parallel_for(execution, count, 16, [&](std::size_t first, std::size_t last) {
    std::vector<Corner> corners;
    Pacer pacer(execution);
    for (std::size_t c = first; c < last; ++c) {
      corners.clear();
      for (std::size_t k = begin[c]; k < begin[c + 1]; ++k) {
        const CapRegion& region = caps.regions[cuts[k].region];
        pacer.step(4 * region.triangle_count);
        for (std::uint32_t t = region.first_triangle; t < region.first_triangle + region.triangle_count; ++t)
          for (std::uint32_t i = 0; i < 3; ++i)
            corners.push_back({positions.steps[caps.triangles[t][i] - positions.first_constructed],
                               cuts[k].region, 3 * t + i});
      }
      sort_with_polls(execution, corners.begin(), corners.end(), [](const Corner& x, const Corner& y) {
        for (std::size_t a = 0; a < 3; ++a)
          if (x.place[a] != y.place[a]) return x.place[a] < y.place[a];
        return x.region != y.region ? x.region < y.region : x.corner < y.corner;
      });
      struct Sum {
        std::uint32_t region;
        std::size_t first, last;
        Vec3d facet, normal;
      };
      std::vector<Sum> sums;  // at one place, by region
      for (std::size_t k = 0; k < corners.size();) {
        sums.clear();
        std::size_t end = k;
        for (; end < corners.size() && corners[end].place == corners[k].place; ++end) {
          const std::uint32_t r = corners[end].region;
          if (sums.empty() || sums.back().region != r) {
            const Vec3d u = diagram.facet_normal(caps.regions[r].lo, caps.regions[r].hi);
            sums.push_back({r, end, end, (sign_of(r) / length(u)) * u, {}});
          }
          const auto& t = caps.triangles[corners[end].corner / 3];
          sums.back().normal =
              sums.back().normal + sign_of(r) * cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
          sums.back().last = end + 1;
        }
        const bool crowded = sums.size() > kMostAtOnePlace;
        for (const Sum& own : sums) {
          Vec3d n = crowded ? own.normal : Vec3d{};
          pacer.step(crowded ? 1 : sums.size());
          for (std::size_t s = 0; !crowded && s < sums.size(); ++s)
            if (dot(own.facet, sums[s].facet) > kOneCut) n = n + sums[s].normal;
          const double l = length(n);
          n = l > 0 ? (sign_of(own.region) / l) * n : sign_of(own.region) * own.facet;
          for (std::size_t m = own.first; m < own.last; ++m)
            normals[corners[m].corner] = {static_cast<float>(n.x), static_cast<float>(n.y),
                                          static_cast<float>(n.z)};
        }
        k = end;
      }
    }
  });
  return normals;
}

}  // namespace fracture
