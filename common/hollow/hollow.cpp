#include "common/hollow/hollow.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/hollow/cavity.hpp"
#include "common/hollow/deep_points.hpp"
#include "common/hollow/inner_surface.hpp"
#include "common/hollow/rebuild.hpp"
#include "common/solid/corners.hpp"
#include "common/solid/part_selection.hpp"

namespace fracture {
namespace {

using hollow_detail::Cavity;
using hollow_detail::Run;

/// Returns "The closed part", "All 3 closed parts" or "2 of 3 closed parts".
std::string closed_parts(std::uint64_t count, std::uint64_t all) {
  if (all == 1) return "The closed part";
  return (count == all ? "All " + grouped(all) : grouped(count) + " of " + grouped(all)) + " closed parts";
}

/// Adds remarks. `asked`: number of parts that may have become walls; `hollow` of them did. `mean_thickness`: of their walls.
void add_remarks(SolidReport& report, const HollowOptions& options, std::uint64_t asked, std::uint64_t hollow,
                 double mean_thickness) {
  const std::uint64_t solid = asked - hollow;
  const bool by_material = options.least_ball > 0;
  if (by_material && hollow > 0)
    report.remarks.note(counted(hollow, "closed part", "closed parts") +
                        " became hollow, because a ball of the diameter 'shell_ball' fits inside " +
                        (hollow == 1 ? "it" : "each of them") + ". Use shell=0 to keep " +
                        (hollow == 1 ? "it" : "them") + " solid.");
  if (solid > 0) {
    const std::string what =
        closed_parts(solid, asked) + " stayed solid, because " + (solid == 1 ? "it is" : "they are") +
        " nowhere thick enough for walls, or because the inner sides of all parts together would have more than " +
        counted(options.max_all, "triangle", "triangles") + ", which is the limit.";
    if (by_material)
      report.remarks.note(what);
    else
      report.remarks.warn(what + " Ask for thinner walls, or send the parts as several meshes.");
  }
  if (options.thickness > 0 && mean_thickness > 2 * options.thickness)
    report.remarks.warn(
        "Walls are " + short_number(mean_thickness) + " m thick on average instead of the " +
        short_number(options.thickness) +
        " m that 'shell' asks for, because thinner walls need more triangles than a part may have. "
        "Ask for thicker walls, or model the inner side in a modelling tool.");
}

/// Says which parts stay solid, although the request (not a material) asks for walls.
void report_too_thick(const HollowOptions& options, std::uint64_t parts, std::uint64_t too_thin,
                      std::uint64_t with_walls, double thinnest, Remarks& remarks) {
  const std::string name = options.thickness > 0 ? "'shell'" : "'shell_fraction'";
  const bool none = too_thin + with_walls == parts;
  const auto tell = [&](std::string sentence) {
    none ? remarks.warn(std::move(sentence)) : remarks.note(std::move(sentence));
  };
  if (too_thin > 0)
    tell(closed_parts(too_thin, parts) + (too_thin == 1 ? " stays" : " stay") + " solid, because " + name +
         " asks for walls at least half as thick as " +
         (too_thin == 1 ? "the part itself. " : "the parts themselves. ") +
         (options.thickness > 0 ? "Give a value below " + short_number(thinnest / 2) + " m."
                                : "Give a smaller value."));
  if (with_walls > 0)
    tell(closed_parts(with_walls, parts) + (with_walls == 1 ? " has" : " have") + " a cavity already, so " +
         name + " does not apply to " + (with_walls == 1 ? "it." : "them."));
}

/// Lattice triangles per triangle that a part may have. If many parts share the triangles, more would be
/// wasted work.
constexpr std::uint32_t kMarched = 4;

std::uint32_t most_marched(std::size_t triangles) {
  return static_cast<std::uint32_t>(
      std::min<std::size_t>(kMarched * triangles, HollowOptions{}.max_triangles));
}

/// Limits for walls added by a material, because every fracture pays for their triangles: no finer than the
/// outside requires, and an eye no finer than its head. `share`: longest side of the part / longest side of
/// the largest part.
hollow_detail::InnerSurfaceLimits fine_enough(std::size_t outside, double share, std::uint32_t most) {
  constexpr std::size_t kForEach = 4, kLarge = 4000, kLeast = 1000;
  const auto of_size = static_cast<std::size_t>(kLarge * share * share);
  const std::size_t triangles = std::min<std::size_t>(most, std::max({kForEach * outside, of_size, kLeast}));
  return {static_cast<std::uint32_t>(triangles), most_marched(triangles)};
}

/// Makes the cavities of parts that share a limited number of triangles. The limit of each part depends on
/// the triangles left by the parts before it. It is never below the current share of each part, so several
/// cavities are made at once with that share. A cavity that would differ with its final limit is made again.
/// So the result is the same for any number of threads.
class Hollower {
 public:
  /// `is_of`: whether the options apply to a part.
  Hollower(Solid& solid, const HollowOptions& options, const std::function<bool(std::size_t)>& is_of,
           const Execution& execution)
      : solid_(solid),
        options_(options),
        is_of_(is_of),
        execution_(execution),
        least_ball_(options.least_ball > 0 ? std::fmax(options.least_ball, kSmallestBall) : 0),
        runs_(hollow_detail::runs_of_parts(solid)),
        left_(options.max_all - static_cast<std::uint32_t>(solid.report.hollow_triangles)) {}

  std::vector<Cavity> run() {
    choose();
    const std::size_t at_once = execution_.threads > 1 ? std::size_t{kForAThread} * execution_.threads : 1;
    for (std::size_t done = 0; done < chosen_.size(); done += at_once) {
      const std::size_t end = std::min(done + at_once, chosen_.size());
      execution_.reaches(0.2 + 0.6 * static_cast<double>(end) / static_cast<double>(chosen_.size()));
      make(done, end);
    }
    add_remarks(solid_.report, options_, chosen_.size(), cavities_.size(),
                area_ > 0 ? thickness_times_area_ / area_ : 0);
    return std::move(cavities_);
  }
  /// Area of the inner sides, m², and the sum of their thicknesses times their areas, m³.
  double area() const { return area_; }
  double thickness_times_area() const { return thickness_times_area_; }

 private:
  /// With more at once, more cavities have to be made again.
  static constexpr int kForAThread = 4;

  std::uint32_t asked() const { return static_cast<std::uint32_t>(chosen_.size()); }
  double thickness_of(const Part& part) const {
    return options_.thickness > 0 ? options_.thickness : options_.fraction * part.box.longest_side();
  }
  SurfaceTree surface_of(std::size_t p) const {
    return SurfaceTree(corners_of(solid_, runs_[p].begin, runs_[p].end, execution_), execution_);
  }

  bool may(std::size_t p) const {
    const Part& part = solid_.parts[p];
    const Vec3d size = part.box.size();
    const double longest = part.box.longest_side(), shortest = std::fmin(size.x, std::fmin(size.y, size.z));
    if (!is_of_(p) || part.shells.size() > 1 ||
        !(shortest > std::fmax(2 * thickness_of(part), least_ball_ * longest)))
      return false;
    return least_ball_ == 0 ||
           hollow_detail::holds_ball(surface_of(p), part.box, least_ball_ / 2 * longest, execution_);
  }

  void choose() {
    execution_.reaches(0.2);
    std::vector<std::uint8_t> may_be(solid_.parts.size());
    parallel_for(execution_, may_be.size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) may_be[p] = may(p);
    });
    if (least_ball_ == 0) report_unsuitable();
    for (std::size_t p = 0; p < may_be.size(); ++p) {
      if (!may_be[p]) continue;
      chosen_.push_back(p);
      longest_ = std::fmax(longest_, solid_.parts[p].box.longest_side());
    }
    waiting_ = asked();
  }

  void report_unsuitable() {
    std::uint64_t too_thin = 0, with_walls = 0;
    double thinnest = HUGE_VAL;
    for (const Part& part : solid_.parts) {
      const Vec3d size = part.box.size();
      const double shortest = std::fmin(size.x, std::fmin(size.y, size.z));
      if (part.shells.size() > 1) {
        ++with_walls;
      } else if (!(shortest > 2 * thickness_of(part))) {
        ++too_thin;
        thinnest = std::fmin(thinnest, shortest);
      }
    }
    report_too_thick(options_, solid_.parts.size(), too_thin, with_walls, thinnest, solid_.report.remarks);
  }

  /// Maximum number of triangles of the next waiting part, and a lower bound of this limit for the others.
  std::uint32_t most() const { return std::min(options_.max_triangles, left_ / waiting_); }

  hollow_detail::InnerSurfaceLimits limits_of(std::size_t p, std::uint32_t most) const {
    if (least_ball_ > 0)
      return fine_enough(runs_[p].end - runs_[p].begin, solid_.parts[p].box.longest_side() / longest_, most);
    return {.triangles = most, .marched = most_marched(most)};
  }

  Cavity cavity(std::size_t p, std::uint32_t most) const {
    const Part& part = solid_.parts[p];
    return cavity_of(p, surface_of(p), part.box, thickness_of(part), limits_of(p, most), execution_);
  }

  void make(std::size_t begin, std::size_t end) {
    const std::uint32_t foreseen = most();
    std::vector<Cavity> made(end - begin);
    if (foreseen >= kLeastTriangles && made.size() > 1)
      parallel_for(execution_, made.size(), 1,
                   [&](std::size_t k, std::size_t) { made[k] = cavity(chosen_[begin + k], foreseen); });
    else
      for (Cavity& none : made) none.other = {0, 0, 0};
    for (std::size_t k = begin; k < end; ++k) {
      execution_.poll();
      const std::uint32_t may_have = most();
      --waiting_;
      if (may_have < kLeastTriangles) continue;
      const hollow_detail::InnerSurfaceLimits limits = limits_of(chosen_[k], may_have);
      const hollow_detail::InnerSurfaceLimits& other = made[k - begin].other;
      if (limits.triangles >= other.triangles || limits.marched >= other.marched)
        made[k - begin] = cavity(chosen_[k], may_have);
      keep(std::move(made[k - begin]));
    }
  }

  void keep(Cavity cavity) {
    Part& part = solid_.parts[cavity.part];
    SolidReport& report = solid_.report;
    // If a surface crosses itself, it may enclose less volume than its deep points do.
    if (cavity.surface.triangles.empty() || cavity.volume >= part.volume) return;
    left_ -= static_cast<std::uint32_t>(cavity.surface.triangles.size());
    execution_.made(Product::kSurfaceTriangles, cavity.surface.triangles.size());
    report.least_thickness = report.parts_hollowed == 0
                                 ? cavity.least_thickness
                                 : std::fmin(report.least_thickness, cavity.least_thickness);
    for (const Cavity::Wall& wall : cavity.walls) {
      thickness_times_area_ += wall.thickness * wall.area;
      area_ += wall.area;
    }
    cavity.walls = {};
    part.volume -= cavity.volume;
    report.absolute_volume += cavity.volume;
    ++report.parts_hollowed;
    report.hollow_triangles += cavity.surface.triangles.size();
    report.hollow_volume += cavity.volume;
    cavities_.push_back(std::move(cavity));
  }

  Solid& solid_;
  const HollowOptions& options_;
  const std::function<bool(std::size_t)>& is_of_;
  const Execution& execution_;
  const double least_ball_;
  const std::vector<Run> runs_;
  std::vector<std::size_t> chosen_;  // parts that may become walls
  std::uint32_t waiting_ = 0;        // number of chosen parts not processed yet
  std::uint32_t left_;               // number of triangles left
  double longest_ = 0, area_ = 0, thickness_times_area_ = 0;
  std::vector<Cavity> cavities_;
};

}  // namespace

Solid hollowed(Solid solid, const HollowOptions& options, const Execution& execution) {
  if (!options.any()) return solid;
  std::vector<PartSelector> selectors;
  std::vector<HollowOptions> walls{options};  // of parts that no entry matches, then of each entry
  for (const PartWalls& entry : options.by_part) {
    selectors.push_back(entry.selector);
    walls.push_back(options);
    walls.back().thickness = entry.thickness;
    walls.back().fraction = entry.fraction;
    walls.back().least_ball = entry.least_ball;
  }
  for (HollowOptions& own : walls) own.by_part.clear();
  const PartChoice choice = choose_parts(solid, selectors, execution);

  SolidReport& report = solid.report;
  std::vector<Cavity> cavities;
  double area = 0, thickness_times_area = 0;
  for (std::size_t k = 0; k < walls.size(); ++k) {
    if (!walls[k].any()) continue;
    const std::uint32_t entry = k == 0 ? kNoIndex : static_cast<std::uint32_t>(k - 1);
    const std::function<bool(std::size_t)> is_of = [&](std::size_t p) { return choice.of_part[p] == entry; };
    const StageProgress::Part part(walls.size() > 1 ? execution.within : nullptr,
                                   static_cast<double>(k + 1) / static_cast<double>(walls.size() + 1));
    Hollower hollower(solid, walls[k], is_of, execution);
    for (Cavity& cavity : hollower.run()) cavities.push_back(std::move(cavity));
    area += hollower.area();
    thickness_times_area += hollower.thickness_times_area();
  }
  if (cavities.empty()) return solid;
  std::stable_sort(cavities.begin(), cavities.end(),
                   [](const Cavity& a, const Cavity& b) { return a.part < b.part; });
  if (area > 0) report.mean_thickness = thickness_times_area / area;
  report.area += area;
  report.volume = 0;
  for (const Part& part : solid.parts) report.volume += part.volume;
  execution.reaches(1);
  hollow_detail::rebuild(solid, cavities, execution);
  return solid;
}

}  // namespace fracture
