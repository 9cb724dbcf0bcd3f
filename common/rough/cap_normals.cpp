#include "common/rough/cap_normals.hpp"

#include <algorithm>
#include <numeric>
#include <span>

#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"

namespace fracture {
namespace {

/// Maximum number of regions of one cut that smooth each other at one place. If more meet (all facets of a
/// lattice through one point), each keeps its own normal there, because every pair would have to be compared.
constexpr std::size_t kMostAtOnePlace = 64;
/// Cosine of the largest angle between two facets that count as one cut.
constexpr double kOneCut = 0.94;
/// Minimum cosine of the angle between the normal of a corner and the normal of its triangle in the file.
/// More than 0, so that the normal still points to the front after rounding to floats.
constexpr double kLeastCosine = 0.01;

struct Corner {
  std::uint32_t region, corner;
};

/// The corners of a cut, grouped by place. Within each place, they are in the order of their regions.
class CornersByPlace {
 public:
  void begin(std::size_t vertices) {
    number_.next_epoch(vertices);
    places_.clear();
    corners_.clear();
    begin_.assign(1, 0);
  }
  void add(std::size_t place, const Corner& corner) {
    std::uint32_t& number = number_.slot(place);
    if (number == StampedMap::kEmpty) {
      number = static_cast<std::uint32_t>(begin_.size() - 1);
      begin_.push_back(0);
    }
    ++begin_[number + 1];
    places_.push_back(number);
    corners_.push_back(corner);
  }
  /// Groups the corners by a counting sort.
  void group() {
    for (std::size_t p = 0; p + 1 < begin_.size(); ++p) begin_[p + 1] += begin_[p];
    next_.assign(begin_.begin(), begin_.end() - 1);
    sorted_.resize(corners_.size());
    for (std::size_t k = 0; k < corners_.size(); ++k) sorted_[next_[places_[k]]++] = corners_[k];
  }
  std::size_t places() const { return begin_.size() - 1; }
  std::span<const Corner> at(std::size_t place) const {
    return {sorted_.data() + begin_[place], begin_[place + 1] - begin_[place]};
  }

 private:
  StampedMap& number_ = worker_map();
  std::vector<std::uint32_t> places_, begin_, next_;
  std::vector<Corner> corners_, sorted_;
};

Vec3f to_float(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Returns the corner's normal, or the triangle's normal if the mean of its neighbours points behind the
/// triangle. So a triangle that is steep relative to its cut looks flat, and is not lit from behind.
/// Returns the mean if the triangle has no area.
Vec3d on_front(const Vec3d& normal, const Vec3d& of_triangle) {
  const double l = length(of_triangle);
  return l > 0 && dot(normal, of_triangle) < kLeastCosine * l ? (1 / l) * of_triangle : normal;
}

/// Returns, per constructed vertex, a number shared by all vertices at the same place of the seam lattice.
std::vector<std::uint32_t> places_of(const VertexPositions& positions, const Execution& execution) {
  const auto& steps = positions.steps;
  std::vector<std::uint32_t> order(steps.size()), place(steps.size());
  std::iota(order.begin(), order.end(), 0u);
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return steps[a] != steps[b] ? steps[a] < steps[b] : a < b;
  });
  Pacer pacer(execution);
  pacer.each(0, order.size(), [&](std::size_t k) {
    place[order[k]] = k > 0 && steps[order[k]] == steps[order[k - 1]] ? place[order[k - 1]] : order[k];
  });
  return place;
}

}  // namespace

std::vector<Vec3f> cap_normals(const VoronoiDiagram& diagram, const std::vector<std::uint32_t>& owner_of_site,
                               const Caps& caps, const VertexPositions& positions,
                               const Execution& execution) {
  // Regions, grouped by the pair of owners that they separate.
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
  const auto normal_of = [&](std::uint32_t triangle, const auto& place) {
    const auto& t = caps.triangles[triangle];
    return cross(place(t[1]) - place(t[0]), place(t[2]) - place(t[0]));
  };
  const Vec3d step = positions.lattice.step();
  const auto in_file = [&](CutVertexId v) -> Vec3d {
    const auto& s = positions.steps[v - positions.first_constructed];
    return {s[0] * step.x, s[1] * step.y, s[2] * step.z};
  };
  // Normals point from the owner with the lower number to the other.
  const auto sign_of = [&](std::uint32_t r) {
    return owner_of_site[caps.regions[r].lo] < owner_of_site[caps.regions[r].hi] ? 1.0 : -1.0;
  };
  const std::vector<std::uint32_t> place = places_of(positions, execution);
  std::vector<Vec3f> normals(3 * caps.triangles.size());
  parallel_for(execution, count, 16, [&](std::size_t first, std::size_t last) {
    CornersByPlace corners;
    Pacer pacer(execution);
    struct Sum {
      std::uint32_t region;
      std::size_t first, last;
      Vec3d facet, normal;
    };
    std::vector<Sum> sums;  // the sums at one place, by region
    for (std::size_t c = first; c < last; ++c) {
      corners.begin(place.size());
      for (std::size_t k = begin[c]; k < begin[c + 1]; ++k) {
        const CapRegion& region = caps.regions[cuts[k].region];
        pacer.step(8 * region.triangle_count);
        for (std::uint32_t t = region.first_triangle; t < region.first_triangle + region.triangle_count; ++t)
          for (std::uint32_t i = 0; i < 3; ++i)
            corners.add(place[caps.triangles[t][i] - positions.first_constructed],
                        {cuts[k].region, 3 * t + i});
      }
      corners.group();
      for (std::size_t p = 0; p < corners.places(); ++p) {
        const std::span<const Corner> here = corners.at(p);
        sums.clear();
        for (std::size_t k = 0; k < here.size(); ++k) {
          const std::uint32_t r = here[k].region;
          if (sums.empty() || sums.back().region != r) {
            const Vec3d u = diagram.facet_normal(caps.regions[r].lo, caps.regions[r].hi);
            sums.push_back({r, k, k, (sign_of(r) / length(u)) * u, {}});
          }
          sums.back().normal = sums.back().normal + sign_of(r) * normal_of(here[k].corner / 3, at);
          sums.back().last = k + 1;
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
            normals[here[m].corner] = to_float(on_front(n, normal_of(here[m].corner / 3, in_file)));
        }
      }
    }
  });
  return normals;
}

}  // namespace fracture
