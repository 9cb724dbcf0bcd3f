#include "server/service/estimate_of_hits.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/product.hpp"
#include "common/pipeline/local_impact.hpp"
#include "common/rough/roughen.hpp"
#include "server/service/admission.hpp"
#include "server/service/cell_means.hpp"

namespace fracture {
namespace {

constexpr double kPi = 3.14159265358979;
/// Sets of m and n random cells in the same volume overlap in m + n + this times (m^(2/3) n^(1/3) + m^(1/3) n^(2/3)) pieces.
/// It is the mean surface times the mean integral of curvature by 4π: 5.82 * 2π * 1.458 / 4π.
constexpr double kOverlay = 4.24;
/// The same for cells in a plane, m + n + this times sqrt(m n): the square of a mean perimeter of 4, by 2π.
constexpr double kPlaneOverlay = 2.55;

/// Triangles that a piece more in an overlay has on one side of its cuts. An overlay of two equal sets has 4.7 faces of 4.7 corners for
/// each piece. The triangles of earlier cuts are cut as they are, which adds a third.
constexpr double kTrianglesInOverlay = 13, kTrianglesInPlaneOverlay = 6;
/// Edges in an earlier cut or in its triangles on the surface, relative to its outline.
constexpr double kWithDiagonals = 1.5;

/// How many pieces more than m + n there are if n cells cut m pieces. `flatness`: 1: all are prisms in a wall.
double pieces_of_overlay(double m, double n, double flatness) {
  const double a = std::cbrt(m), b = std::cbrt(n);
  const double solid = kOverlay * (a * a * b + a * b * b), prisms = kPlaneOverlay * std::sqrt(m * n);
  return kDenseInTheMiddle * (solid + flatness * (prisms - solid));
}

/// How much of the ball of `a` is in the ball of `b`, as a share.
double common_share(const LocalImpact& a, const LocalImpact& b) {
  const double d = length(a.point - b.point), r = a.radius, s = b.radius;
  if (d >= r + s) return 0;
  if (d <= std::fabs(r - s)) return r <= s ? 1 : (s * s * s) / (r * r * r);
  const double lens =
      kPi * (r + s - d) * (r + s - d) * (d * d + 2 * d * (r + s) - 3 * (r - s) * (r - s)) / (12 * d);
  return lens / (4 * kPi / 3 * r * r * r);
}

/// Time for a hit, in steps (SolidFigures::step). Each earlier hit takes one more.
constexpr std::size_t kStepsOfHit = 30;

/// The part of the solid that a hit breaks.
struct Place {
  double volume = 0, area = 0;
  double space = 0;  ///< m³, if the solid filled all of it
};

/// A hit is usually at the surface, so half of its ball is inside, or the part of a wall that it contains. With stretched cells it is
/// an ellipsoid, whose longest half-axis is the radius.
Place place_of(const LocalImpact& hit, const SolidShape& shape, double stretch) {
  const double r = hit.radius, narrow = stretch > 1 ? 1 / (stretch * stretch) : stretch;
  const double half_ball = 2 * kPi / 3 * r * r * r * narrow, disc = kPi * r * r * std::sqrt(narrow);
  Place place{.space = half_ball};
  place.volume = std::min({half_ball, disc * shape.thickness(), shape.volume});
  place.area = std::min(disc * std::min(2.0, half_ball / place.volume), shape.area);
  return place;
}

}  // namespace

HitNumbers expected_of_hits(const FractureParameters& parameters, const SolidFigures& solid, double fragments,
                            double triangles, std::size_t first) {
  HitNumbers all;
  const SolidShape& shape = solid.shape();
  if (!(shape.volume > 0) || !(shape.area > 0)) return all;
  const double stretch = parameters.anisotropy.stretch, longer = surface_of_stretched(stretch);
  const double cells = cells_per_fragment(parameters);
  const double least_volume =
      std::max(parameters.size.min_volume, parameters.size.min_fraction * shape.volume);
  const Roughness& rough = parameters.roughness;
  const auto bytes = [](Product product, double count) {
    return static_cast<double>(bytes_of(product)) * count;
  };
  std::vector<double> added;
  for (std::size_t k = 0; k < parameters.hits.size(); ++k) {
    solid.step(kStepsOfHit + k);
    const LocalImpact& hit = parameters.hits[k];
    const Place place = place_of(hit, shape, stretch);
    double there = std::fmax(0, fragments - 1) * place.volume / shape.volume;  // pieces in the ball
    double of_hits = 0;  // pieces of earlier hits in the ball
    for (std::size_t j = 0; j < k; ++j) of_hits += added[j] * common_share(parameters.hits[j], hit);
    there += of_hits;
    const SmallParts small = solid.small_parts(hit, place.space);
    // The sites in larger parts. (At least a little, because it divides.)
    const double own =
        small.are_all ? 1e-6 * hit.sites : hit.sites * place.volume / (place.volume + small.volume);
    const double cutting = of_hits > 0 ? hit.sites : own;  // small parts have pieces of earlier hits
    const double flatness = std::fmin(1, std::cbrt(place.volume / own) / shape.thickness());
    const auto between = [&](double solid_value, double prism) {
      return solid_value + flatness * (prism - solid_value);
    };
    double mixed = pieces_of_overlay(there, cutting, flatness) + small.pieces - small.count;
    if (least_volume > 0)
      mixed = std::fmin(mixed, std::fmax(0, (place.volume + small.volume) / least_volume - own));
    const double more = own + mixed;
    added.push_back(more);
    if (k < first) continue;

    const double width = std::fmax(std::cbrt(place.volume / own), std::sqrt(place.area / (2 * own)));
    const double widths = place.area / (width * width);
    const double edges = shape.edges / shape.area +  // per area, with those of earlier cuts
                         kWithDiagonals * kEdgesOnSection * std::cbrt(there / place.volume);
    const double crossings = kCrossings * kEdgesOnSection * longer * place.area / width * edges;
    const double surface = 2 * crossings + 2 * kVerticesOnSection * widths;
    const double faces = own * between(kFacesPerCell, kFacesPerPrism);
    const double ragged = cells > 1 ? kRaggedness : 1;
    // The faces that earlier hits made are cut on both sides.
    const double cut_twice = there > 0 ? 1 + of_hits / there : 1;
    const double flat_caps =
        ragged * (faces * between(kTrianglesPerFace, kTrianglesPerPrismFace) +
                  mixed * cut_twice * between(kTrianglesInOverlay, kTrianglesInPlaneOverlay)) +
        crossings;
    double rough_caps = 0;
    if (rough.amplitude > 0) {  // only the hit's own cuts; the earlier ones are cut with their triangles
      const double area = ragged * longer * kFaceArea * std::cbrt(place.volume * place.volume * (1 + own));
      const double edge =
          shape.size / (kEdgesPerWave * rough.frequency * std::ldexp(1, static_cast<int>(rough.octaves) - 1));
      rough_caps = std::fmax(std::fmin(kMostRoughTriangles, area / (0.433 * edge * edge)), flat_caps);
    }
    const double cuts = 2 * std::fmax(flat_caps, rough_caps);
    // All triangles of a fragment that is cut are made again. The fragments that meet the ball:
    const double root = std::cbrt(there);
    const double met =
        std::fmin(1, (1 + there + small.count + kOverlay * (root + root * root)) / std::fmax(1, fragments));
    const double made = (met * triangles + surface + cuts) * (cells > 1 ? kCountedOfMerged : 1);
    all.sites += cells * hit.sites;
    all.fragments += more;
    all.surface += surface;
    (rough_caps > 0 ? all.rough_triangles : all.cut_triangles) += cuts;
    all.hulls += more * (cells > 1 ? 2 : 1) + met * fragments;
    all.kept_bytes += bytes(Product::kFragmentTriangles, surface + cuts);
    const double with_companion = parameters.keep ? 2 : 1;  // next to a region to keep, each site has one
    const double site_cells =
        with_companion * cells * hit.sites + static_cast<double>(guard_directions().size());
    const double step =
        bytes(Product::kTetrahedra, kTetrahedraPerSite * site_cells) +
        bytes(Product::kPolygons, 2 * crossings + kCellsOnSection * widths) +
        bytes(Product::kSegments, 2 * (crossings + 1.5 * kVerticesOnSection * widths) + 5.2 * cells * faces) +
        bytes(Product::kCapTriangles, cells * flat_caps + rough_caps) +
        bytes(Product::kFragmentTriangles, made);
    all.step_bytes = std::fmax(all.step_bytes, step);
  }
  return all;
}

}  // namespace fracture
