#include "common/pipeline/fracture.hpp"

#include <string>
#include <utility>

#include "common/fragment/make_fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/barycentric.hpp"
#include "common/pipeline/lloyd.hpp"
#include "common/pipeline/restrict.hpp"
#include "common/solid/image.hpp"

namespace fracture {
namespace {

/// Runs a stage: its time is kept, and an interruption becomes the error it stands for.
template <class Body>
auto stage(StageTimings& timings, const Execution& execution, const char* name, const Body& body)
    -> decltype(body()) {
  const StageTimings::Scope scope(timings, name);
  if (execution.progress) execution.progress(name, 0);
  try {
    auto result = body();
    if (execution.progress) execution.progress(name, 1);
    return result;
  } catch (const Interrupted& interrupted) {
    return fail(interrupted.code, interrupted.code == ErrorCode::kCancelled
                                      ? std::string("cancelled while in stage ") + name
                                      : std::string("the deadline passed in stage ") + name);
  }
}

nlohmann::json report_of(const Solid& solid, const Diagram& diagram, const FragmentSet& set) {
  nlohmann::json warnings = nlohmann::json::array();
  for (const std::string& w : solid.source->warnings) warnings.push_back(w);
  for (const std::string& note : solid.report.notes) warnings.push_back(note);
  for (const std::string& note : diagram.notes) warnings.push_back(note);
  if (set.lattice_ratio > 1e-5)
    warnings.push_back(
        "the mesh lies so far from the origin that float32 positions are coarse: one step is more than 1e-5 "
        "of its size");
  const Tetrahedralization& t = diagram.tetrahedralization;
  return {{"solid", solid.report.to_json()},
          {"sites",
           {{"given", diagram.sites.size()},
            {"used", t.site_count()},
            {"duplicates_merged", t.duplicates_merged},
            {"far_dropped", t.far_sites_dropped}}},
          {"warnings", std::move(warnings)}};
}

}  // namespace

Expected<Diagram> make_diagram(const Solid& solid, const FractureParameters& parameters,
                               const Execution& execution, StageTimings& timings) {
  return stage(timings, execution, "tetrahedralize", [&]() -> Expected<Diagram> {
    Expected<SitePlan> plan = plan_sites(solid, parameters, execution);
    if (!plan) return tl::unexpected(plan.error());
    std::optional<Solid> image;
    if (plan->map) image = image_of(solid, *plan->map);
    const Solid& seen = image ? *image : solid;
    if (parameters.lloyd > 0) {
      if (!plan->groups.empty())
        return fail(
            ErrorCode::kBadParameter,
            "'lloyd' moves sites to the middle of their piece, but a piece of this pattern has several.",
            "lloyd");
      if (auto relaxed = relax(solid, seen, *plan, parameters.lloyd, execution); !relaxed)
        return tl::unexpected(relaxed.error());
    }
    Expected<Tetrahedralization> t = tetrahedralize(plan->points, seen.box, execution);
    if (!t) return tl::unexpected(t.error());
    Diagram diagram;
    diagram.sites = std::move(plan->points);
    diagram.groups = std::move(plan->groups);
    diagram.map = plan->map;
    diagram.notes = std::move(plan->notes);
    diagram.tetrahedralization = std::move(*t);
    return diagram;
  });
}

Expected<FragmentSet> fracture(const Solid& solid, const Diagram& diagram,
                               const FractureParameters& parameters, const Execution& execution,
                               StageTimings& timings) {
  return stage(timings, execution, "clip", [&]() -> Expected<FragmentSet> {
    const Tetrahedralization& t = diagram.tetrahedralization;
    std::vector<std::uint32_t> groups;  // of sites, from those of the input points
    if (!diagram.groups.empty()) {
      groups.resize(t.site_count());
      for (std::size_t k = diagram.groups.size(); k-- > 0;)  // the first of merged points decides
        if (t.site_of_input[k] != kNoSite) groups[t.site_of_input[k]] = diagram.groups[k];
    }
    const Ownership ownership = Ownership::from_groups(t.site_count(), groups);

    std::optional<Solid> image;
    if (diagram.map) image = image_of(solid, *diagram.map);
    const Solid& seen = image ? *image : solid;
    const VoronoiDiagram voronoi(t, seen.box, diagram.map);
    FragmentSet set;
    std::uint32_t skipped_hulls = 0;
    if (parameters.dual == Dual::kBarycenter) {
      if (image)
        return fail(
            ErrorCode::kBadParameter,
            "dual=barycenter knows no stretched cells: leave out 'stretch', or slices of several families.",
            "dual");
      BarycentricResult result = fracture_barycentric(solid, voronoi, parameters.pivot, execution);
      set = std::move(result.set);
      skipped_hulls = result.skipped_hulls;
    } else {
      set = make_fragments(restrict_to_solid(solid, seen, voronoi, execution), ownership, parameters.pivot,
                           execution);
    }
    if (set.fragments.empty()) return fail(ErrorCode::kNoFragments, "none of the pieces has a volume");
    HullReport hulls;
    if (parameters.hulls == Hulls::kConvex) hulls = add_collision_hulls(set, execution);
    set.certificate.sites_asked = static_cast<std::uint32_t>(diagram.sites.size());
    set.report = report_of(solid, diagram, set);
    if (parameters.hulls == Hulls::kConvex)
      set.report["hulls"] = {{"count", hulls.hulls}, {"flat", hulls.flat}, {"simplified", hulls.simplified}};
    if (parameters.dual == Dual::kBarycenter) {
      set.report["barycenter"] = {{"partition", false}, {"skipped_hulls", skipped_hulls}};
      set.report["warnings"].push_back(
          "dual=barycenter: the hulls of barycentres overlap and leave gaps; volumes do not add up to the "
          "solid's, and there are no bonds");
      if (ownership.grouped)
        set.report["warnings"].push_back(
            "dual=barycenter: each cell is a fragment, those that the pattern keeps together too");
    }
    return set;
  });
}

}  // namespace fracture
