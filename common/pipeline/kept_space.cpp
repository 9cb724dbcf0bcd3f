#include "common/pipeline/kept_space.hpp"

#include <algorithm>
#include <cmath>

#include "common/sites/sites.hpp"

namespace fracture {
namespace {

/// Steps of the site lattice by which oblique facets are moved outwards.
constexpr double kStepsOut = 4;

/// The corners of an icosahedron, and the points that divide its edges into thirds and mark the middles of its
/// faces, on the unit sphere (a geodesic polyhedron of frequency 3).
std::vector<Vec3d> sphere_directions() {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3d> corners;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-golden, golden}) {
      corners.push_back({0, a, b});
      corners.push_back({a, b, 0});
      corners.push_back({b, 0, a});
    }
  const auto unit = [](const Vec3d& v) { return (1 / length(v)) * v; };
  const auto are_near = [&](std::size_t i, std::size_t j) { return length(corners[i] - corners[j]) < 2.1; };
  std::vector<Vec3d> directions;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    directions.push_back(unit(corners[i]));
    for (std::size_t j = 0; j < corners.size(); ++j)
      if (j != i && are_near(i, j)) directions.push_back(unit(2.0 * corners[i] + corners[j]));
    for (std::size_t j = i + 1; j < corners.size(); ++j)
      for (std::size_t k = j + 1; k < corners.size(); ++k)
        if (are_near(i, j) && are_near(j, k) && are_near(i, k))
          directions.push_back(unit(corners[i] + corners[j] + corners[k]));
  }
  return directions;
}

std::vector<KeptFacet> facets_of(const Region& region) {
  std::vector<KeptFacet> facets;
  if (region.shape == Region::Shape::kSphere) {
    for (const Vec3d& n : sphere_directions()) facets.push_back({n, dot(n, region.center) + region.radius});
    return facets;
  }
  for (int a = 0; a < 3; ++a) {
    Vec3d n;
    n[a] = 1;
    facets.push_back({n, region.box.max[a]});
    facets.push_back({-1.0 * n, -region.box.min[a]});
  }
  return facets;
}

KeptFacet image_of(const KeptFacet& facet, const CellMap::Frame& frame) {
  const Vec3d n = frame.inverse.transposed_times(facet.normal);
  const double scale = 1 / length(n);
  return {scale * n, scale * (facet.offset + dot(n, frame.shift))};
}

void move_out(KeptFacet& facet, double step) {
  const Vec3d& n = facet.normal;
  const bool along_axis = (n.x == 0) + (n.y == 0) + (n.z == 0) == 2;
  facet.offset = along_axis ? std::ceil(facet.offset / step) * step : facet.offset + kStepsOut * step;
}

Vec3d corner_of(const Box& box, int corner) {
  Vec3d p = box.min;
  for (int a = 0; a < 3; ++a)
    if (corner >> a & 1) p[a] = box.max[a];
  return p;
}

}  // namespace

KeptSpace::KeptSpace(const Region& region, const SeenSolid& seen) : map_(seen.map()) {
  const Solid& image = seen.seen();
  const double step = site_lattice(image.box).step;
  const std::vector<KeptFacet> facets = facets_of(region);
  frames_.resize(std::max<std::size_t>(1, map_.frames().size()));
  if (frames_.size() == 1)
    frames_[0].box = image.box;
  else
    for (std::uint32_t p = 0; p < image.parts.size(); ++p)
      frames_[static_cast<std::size_t>(&map_.of_part(p) - map_.frames().data())].box.add(image.parts[p].box);
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    Frame& frame = frames_[f];
    for (const KeptFacet& facet : facets) {
      KeptFacet seen_facet = map_ ? image_of(facet, map_.frames()[f]) : facet;
      move_out(seen_facet, step);
      double deepest = -HUGE_VAL, farthest = HUGE_VAL;
      for (int corner = 0; corner < 8; ++corner) {
        const double depth = seen_facet.depth(corner_of(frame.box, corner));
        deepest = std::fmax(deepest, depth);
        farthest = std::fmin(farthest, depth);
      }
      frame.meets = frame.meets && deepest > 0;
      frame.divides.push_back(deepest > 0 && farthest < -2 * step);
      frame.facets.push_back(seen_facet);
    }
  }
}

double KeptSpace::depth(const Vec3d& image) const {
  const Frame& frame = at(image);
  double least = frame.meets ? HUGE_VAL : -HUGE_VAL;
  for (const KeptFacet& facet : frame.facets) least = std::fmin(least, facet.depth(image));
  return least;
}

}  // namespace fracture
