#include "common/pipeline/local_impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/base/words.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/pipeline/aggregate.hpp"
#include "common/pipeline/hit_region.hpp"
#include "common/sites/request_places.hpp"

namespace fracture {
namespace {

/// Sites are rounded, so they may be farther from the centre by this share of the radius.
constexpr double kRounding = 0.01;
/// Guards are rounded to this share of the radius, because short coordinates make exact tests cheap.
constexpr double kGuardStep = 0x1p-12;

Vec3d unit(const Vec3d& v) { return (1 / length(v)) * v; }

std::vector<Vec3d> divided_icosahedron() {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3d> corners;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-golden, golden})
      for (const Vec3d& v : {Vec3d{0, x, y}, Vec3d{x, y, 0}, Vec3d{y, 0, x}}) corners.push_back(v);
  std::vector<Vec3d> all;
  for (const Vec3d& v : corners) all.push_back(unit(v));
  for (std::size_t a = 0; a < corners.size(); ++a)
    for (std::size_t b = a + 1; b < corners.size(); ++b)
      if (const Vec3d edge = corners[b] - corners[a]; dot(edge, edge) < 5)  // an edge has the length 2
        all.push_back(unit(corners[a] + corners[b]));
  return all;
}

/// The part whose surface is nearest to the point; ties: the lowest. Linear in the triangles.
std::uint32_t nearest_part(const Solid& solid, const Vec3d& point, const Execution& execution) {
  Pacer pacer(execution);
  std::uint32_t nearest = 0;
  double least = HUGE_VAL;
  const auto at = [&](VertexId v) { return to_double(solid.positions[v]); };
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(4);
    const auto& v = solid.triangles[t];
    const double distance = distance_to_triangle(point, at(v[0]), at(v[1]), at(v[2]));
    if (distance >= least) continue;
    least = distance;
    nearest = solid.part[t];
  }
  return nearest;
}

/// An upper bound, exact to 0.1 %, of the factor by which the matrix lengthens a vector. This is the square root of the
/// largest eigenvalue of M = A Aᵀ. M is squared repeatedly, because trace(M^n)^(1/n) is at least this eigenvalue and at
/// most 3^(1/n) times as much.
double most_stretch(const Matrix3& a) {
  Matrix3 m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m.rows[r][c] = dot(a.rows[r], a.rows[c]);
  constexpr int kSquarings = 10;
  double bound = 1;
  for (int k = 0; k <= kSquarings; ++k) {
    const double trace = m.rows[0].x + m.rows[1].y + m.rows[2].z;
    double root = trace;  // its 2^(k + 1)-th root, because lengths are square roots of eigenvalues
    for (int n = 0; n <= k; ++n) root = std::sqrt(root);
    bound *= root;
    for (Vec3d& row : m.rows) row = (1 / trace) * row;
    Matrix3 square;
    for (int r = 0; r < 3; ++r) square.rows[r] = m.transposed_times(m.rows[r]);  // M is symmetric
    m = square;
  }
  return bound;
}

/// Groups a hit's sites into fragments of about `cells` sites each: each site joins the nearest seed.
/// Distances in the direction away from the hit count less than across it. The hit's sites are in the order
/// of a curve through the solid: sites that are near in space are near in it. So every `cells`-th site
/// serves as a seed in the middle of some others. Groups are numbered from 1.
std::vector<std::uint32_t> group_sites(const std::vector<Vec3d>& points, const Vec3d& center,
                                       std::uint32_t cells, const Execution& execution) {
  const auto seeds = static_cast<std::int64_t>((points.size() + cells - 1) / cells);
  constexpr std::int64_t kNear = 16;  // number of seeds before and after a site's own that are tested
  Pacer pacer(execution);
  std::vector<std::uint32_t> groups;
  for (std::size_t k = 0; k < points.size(); ++k) {
    pacer.step(2 * kNear);
    const Vec3d& p = points[k];
    const Vec3d from = p - center;
    const double far = length(from);
    const Vec3d out = far > 0 ? (1 / far) * from : Vec3d{};
    const auto own = static_cast<std::int64_t>(k / cells);
    std::int64_t best = own;
    double least = HUGE_VAL;
    for (std::int64_t seed = std::max<std::int64_t>(0, own - kNear); seed < std::min(seeds, own + kNear + 1);
         ++seed) {
      const std::size_t middle =
          std::min(static_cast<std::size_t>(seed) * cells + cells / 2, points.size() - 1);
      const Vec3d to = points[middle] - p;
      const double along = dot(to, out),
                   square = dot(to, to) - (1 - 1 / (kOutwards * kOutwards)) * along * along;
      if (square < least) {
        least = square;
        best = seed;
      }
    }
    groups.push_back(1 + static_cast<std::uint32_t>(best));
  }
  return groups;
}

/// Adds a remark about sites of a hit that did not fit near it.
void add_remark(const Solid& solid, const LocalImpact& impact, std::size_t hit, std::size_t missing,
                std::size_t asked, Remarks& remarks, const Execution& execution) {
  const std::string where = " in the solid within " + short_number(impact.radius) + " m of the hit";
  if (missing == asked) {
    if (const auto far = far_place(solid, impact.point, impact.radius, "local_point", execution))
      remarks.warn("Hit " + grouped(hit) + " breaks nothing off, because " + far->place + " is " +
                   short_number(far->distance) + " m from the mesh, but 'local_radius' is only " +
                   short_number(impact.radius) + " m. " + far->correction);
    else
      remarks.warn("Hit " + grouped(hit) + " breaks nothing off, because its sites do not fit" + where +
                   ". Give a larger 'local_radius'.");
  } else {
    remarks.note("Hit " + grouped(hit) + ": " + grouped(missing) + " of " + counted(asked, "site", "sites") +
                 (missing == 1 ? " was" : " were") + " left out, because there is no more room" + where +
                 ".");
  }
}

/// The cells of a hit end at this distance from a region to keep, in radii. It differs from hit to hit, so that cuts of two hits do not
/// lie in one plane.
double margin_of(std::size_t hit) { return 0.02 + 0.0025 * static_cast<double>(hit % 8); }

/// If the region takes sites from a hit, at most this many times as many are drawn.
constexpr std::size_t kMostDrawn = 8;

std::size_t share_up(std::uint32_t count, std::size_t whole, std::size_t part) {
  return (count * whole + part - 1) / part;
}

/// Keeps at most `most` points. They are in the order of a curve through the solid, so evenly spaced ones fill the same space.
void thin_out(std::vector<Vec3d>& points, std::size_t most) {
  const std::size_t count = points.size();
  if (count <= most) return;
  for (std::size_t k = 0; k < most; ++k) points[k] = points[k * count / most];
  points.resize(most);
}

/// The sites of one hit.
class SitesOfHit {
 public:
  /// `radius`: in the image. Borrows `seen`.
  SitesOfHit(const SeenSolid& seen, const SiteParameters& near, const Vec3d& center, double radius,
             const HitRegion* region, const Execution& execution)
      : seen_(seen), near_(near), center_(center), radius_(radius), region_(region), execution_(execution) {}

  /// Sites that did not fit near the point were placed elsewhere and are not part of the hit.
  Expected<void> plan() {
    Expected<std::vector<Vec3d>> drawn = draw();
    if (!drawn) return tl::unexpected(std::move(drawn.error()));
    points = std::move(*drawn);
    near_the_point = points.size();
    if (!region_) return {};
    region_->leave_out_inside(points);
    if (points.size() == near_the_point || points.empty()) return {};
    // As many sites as were asked for, around the region.
    const auto most = static_cast<std::size_t>(near_.most_sites / std::max(1u, cells_per_fragment(near_)));
    const std::size_t more =
        std::min({share_up(near_.sites, near_the_point, points.size()), kMostDrawn * near_.sites, most});
    if (more <= near_.sites) return {};
    asked_before_ = asked;
    near_.sites = static_cast<std::uint32_t>(more);
    drawn = draw();
    asked = asked_before_;
    if (!drawn) return tl::unexpected(std::move(drawn.error()));
    region_->leave_out_inside(*drawn);
    thin_out(*drawn, near_the_point);
    if (drawn->size() > points.size()) points = std::move(*drawn);
    return {};
  }

  std::vector<Vec3d> points;
  std::size_t asked = 0;           ///< sites of the plan, near the point or not
  std::size_t near_the_point = 0;  ///< those near it, in the region or not

 private:
  Expected<std::vector<Vec3d>> draw() {
    Expected<SitePlan> plan = plan_sites(seen_, near_, execution_);
    if (!plan) return tl::unexpected(std::move(plan.error()));
    asked = plan->points.size();
    std::erase_if(plan->points, [&](const Vec3d& p) {
      return !(length(p - center_) <= (kSitesWithin + kRounding) * radius_);
    });
    return std::move(plan->points);
  }

  const SeenSolid& seen_;
  SiteParameters near_;
  const Vec3d center_;
  const double radius_;
  const HitRegion* const region_;
  const Execution& execution_;
  std::size_t asked_before_ = 0;
};

/// Says that a hit meets the region to keep. `is_all`: the region contains everything that it reaches.
void add_remark_on_region(std::size_t hit, bool is_all, Remarks& remarks) {
  if (is_all)
    remarks.warn("Hit " + grouped(hit) +
                 " breaks nothing off, because everything it reaches is in the region to keep. Move "
                 "'local_point' out of the region, or make the region smaller.");
  else
    remarks.note(
        "Hit " + grouped(hit) +
        " reaches into the region to keep, which stays whole. The pieces of the hit lie outside the region.");
}

/// The box of the images of a box's corners.
template <class Map>
Box box_of_images(const Box& box, const Map& map) {
  Box images;
  for (int corner = 0; corner < 8; ++corner)
    images.add(map(Vec3d{(corner & 1 ? box.max : box.min).x, (corner & 2 ? box.max : box.min).y,
                         (corner & 4 ? box.max : box.min).z}));
  return images;
}

}  // namespace

std::span<const Vec3d> guard_directions() {
  static const std::vector<Vec3d> directions = divided_icosahedron();
  return directions;
}

Expected<HitCells> cells_of_hit(const Solid& solid, const SiteParameters& parameters,
                                std::span<const LocalImpact> hits, std::size_t number,
                                const std::optional<Region>& keep, Remarks& remarks,
                                const Execution& execution) {
  const LocalImpact& hit = hits[number];
  SiteParameters near = parameters;
  near.sites = hit.sites;
  // Uses a sequence that differs from the pattern's and from that of every other hit.
  near.seed = (parameters.seed ^ 0x696d70616374ull) + number * kGoldenGamma;
  near.lloyd = 0;
  near.aggregation.cells = cells_per_fragment(parameters);  // from the original pattern
  near.density_from.clear();
  near.pattern = ImpactPattern{.impacts = {hit.point}, .exponent = 1, .share = 1, .by_parts = false};
  Expected<CellMap> map = map_of_cells(solid, near, execution);
  if (!map) return tl::unexpected(map.error());
  if (map->frames().size() > 1) map = CellMap(map->of_part(nearest_part(solid, hit.point, execution)).matrix);
  near.anisotropy = {};  // the map has it already

  HitCells cells;
  cells.map = *map;
  const auto image = [&](const Vec3d& p) { return cells.map ? cells.map.of_part(0).image(p) : p; };
  const auto place = [&](const Vec3d& p) { return cells.map ? cells.map.of_part(0).place(p) : p; };
  const double radius =
      cells.map ? hit.radius / most_stretch(cells.map.of_part(0).inverse) : hit.radius;  // in the image
  const Vec3d center = image(hit.point);
  std::get<ImpactPattern>(near.pattern).radius = kSitesWithin * radius;
  const SeenSolid seen(solid, cells.map, execution);
  std::optional<HitRegion> region;
  if (keep) {
    region.emplace(*keep, margin_of(number) * hit.radius, seen);
    if (!region->reaches(center, kReach * radius)) region.reset();
  }
  SitesOfHit planned(seen, near, center, radius, region ? &*region : nullptr, execution);
  if (auto done = planned.plan(); !done) return tl::unexpected(std::move(done.error()));
  std::vector<Vec3d>& points = planned.points;
  cells.asked = static_cast<std::uint32_t>(planned.asked);
  if (const std::size_t missing = planned.asked - planned.near_the_point; missing > 0)
    add_remark(solid, hit, number + 1, missing, planned.asked, remarks, execution);
  if (region && region->reaches(center, radius) && planned.near_the_point > 0)
    add_remark_on_region(number + 1, points.empty(), remarks);
  if (points.empty()) return cells;
  std::vector<std::uint32_t> groups =
      group_sites(points, center, std::max(1u, cells_per_fragment(near)), execution);

  // Sites come first, so a guard that is equal to a site is the one that is left out.
  int exponent = 0;
  std::frexp(kGuardStep * radius, &exponent);
  const double step = std::ldexp(1, exponent - 1);
  const std::size_t of_hit = points.size();
  for (const Vec3d& direction : guard_directions()) {
    Vec3d guard = center + (kGuardsAt * radius) * direction;
    for (int axis = 0; axis < 3; ++axis) guard[axis] = step * std::nearbyint(guard[axis] / step);
    points.push_back(guard);
    groups.push_back(0);
  }
  if (region)
    for (std::size_t k = 0; k < of_hit; ++k) points.push_back(region->companion(points[k]));
  cells.image = box_of_images(solid.box, image);
  if (cells.map) {  // vertices of the image are rounded to float
    Box& box = cells.image;
    const Vec3d size = box.size();
    for (int axis = 0; axis < 3; ++axis) {
      const double margin =
          0x1p-20 * std::fmax(size[axis], std::fmax(std::fabs(box.min[axis]), std::fabs(box.max[axis])));
      box.min[axis] -= margin;
      box.max[axis] += margin;
    }
  }
  Expected<Tetrahedralization> dual = tetrahedralize(points, cells.image, execution);
  if (!dual) return tl::unexpected(dual.error());
  cells.dual = std::move(*dual);
  canonicalize(cells.dual, execution);
  cells.groups.resize(cells.dual.site_count(), 0);
  for (std::size_t k = 0; k < of_hit; ++k) {
    const SiteId s = cells.dual.site_of_input[k];
    if (s == kNoSite) continue;
    std::uint32_t& group = cells.groups[s];
    cells.sites += group == 0;
    cells.duplicates += group != 0;
    group = groups[k];
  }
  const Vec3d reach{kReach * radius, kReach * radius, kReach * radius};
  cells.reach = box_of_images(Box{center - reach, center + reach}, place);
  return cells;
}

std::vector<char> parts_in_ball(const Solid& solid, const LocalImpact& hit, const Box& reach,
                                const Execution& execution) {
  Pacer pacer(execution);
  std::vector<char> is_in(solid.parts.size(), 0), open(solid.parts.size(), 0);
  std::size_t left = 0;  // number of parts that are open: neither in nor known to be out
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step();
    const Box& box = solid.parts[p].box;
    if (!box.intersects(reach)) continue;
    is_in[p] = box.intersects(Box{hit.point, hit.point});
    open[p] = !is_in[p];
    left += open[p] != 0;
  }
  const auto at = [&](VertexId v) { return to_double(solid.positions[v]); };
  for (std::size_t t = 0; t < solid.triangles.size() && left > 0; ++t) {
    pacer.step();
    const std::uint32_t p = solid.part[t];
    if (!open[p]) continue;
    const auto& v = solid.triangles[t];
    if (distance_to_triangle(hit.point, at(v[0]), at(v[1]), at(v[2])) > hit.radius) continue;
    is_in[p] = 1;
    open[p] = 0;
    --left;
  }
  return is_in;
}

Expected<void> check_sites_of_hits(const SiteParameters& parameters, std::span<const LocalImpact> hits,
                                   std::uint64_t of_pattern) {
  std::uint64_t all = of_pattern;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    all += std::uint64_t{cells_per_fragment(parameters)} * hits[k].sites;
    if (all > parameters.most_sites)
      return fail(ErrorCode::kTooComplex,
                  "With hit " + grouped(k + 1) + ", there would be " + grouped(all) +
                      " sites. For the pattern and all hits together, " + site_limit(parameters.most_sites) +
                      ". Lower 'local_sites', or give fewer hits.",
                  "local_sites");
  }
  return {};
}

}  // namespace fracture
