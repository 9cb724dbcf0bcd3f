#include "common/pipeline/report.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace fracture {
namespace {

nlohmann::json report_of_sites(const Solid& solid, const Diagram& diagram, const FragmentSet& set) {
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

std::string text_of(double value) { return nlohmann::json(value).dump(); }

/// How the volumes of the fragments are distributed, m³. The coefficient of variation is the standard
/// deviation over the mean: 0 is all alike.
nlohmann::json volume_distribution(const std::vector<Fragment>& fragments) {
  std::vector<double> volumes;
  for (const Fragment& f : fragments) volumes.push_back(f.mass.volume);
  std::sort(volumes.begin(), volumes.end());
  const std::size_t n = volumes.size();
  if (n == 0) return nlohmann::json::object();
  const auto quantile = [&](std::size_t tenths) { return volumes[(n - 1) * tenths / 10]; };
  double sum = 0, squares = 0, in_largest_tenth = 0;
  for (const double v : volumes) sum += v;
  const double mean = sum / static_cast<double>(n);
  for (const double v : volumes) squares += (v - mean) * (v - mean);
  const std::size_t tenth = (n + 9) / 10;
  for (std::size_t k = n - tenth; k < n; ++k) in_largest_tenth += volumes[k];
  return {{"smallest", volumes.front()},
          {"lowest_tenth", quantile(1)},
          {"median", quantile(5)},
          {"highest_tenth", quantile(9)},
          {"largest", volumes.back()},
          {"mean", mean},
          {"coefficient_of_variation", mean > 0 ? std::sqrt(squares / static_cast<double>(n)) / mean : 0},
          {"share_of_largest_tenth", sum > 0 ? in_largest_tenth / sum : 0}};
}

/// What was asked of the sizes and the structure, and what was made.
void report_structure(const FractureParameters& p, const Diagram& diagram, std::size_t kept_cells,
                      std::uint64_t triangles, std::uint32_t anchored, const FracturedSolid& made,
                      nlohmann::json& report) {
  const FragmentSet& set = made.set;
  double largest = 0;
  for (const Fragment& f : set.fragments) {
    largest = std::max(largest, f.mass.volume);
    triangles += f.indices.size() / 3;
  }
  nlohmann::json& warnings = report["warnings"];
  nlohmann::json size = volume_distribution(set.fragments);
  size["triangles"] = triangles;
  if (p.size.any()) {
    size["united"] = set.size.united;
    size["alone"] = set.size.alone;
    if (set.size.min_volume > 0) size["min_volume"] = set.size.min_volume;
    if (set.size.alone > 0)
      warnings.push_back(std::to_string(set.size.alone) + " pieces below " + text_of(set.size.min_volume) +
                         " m3 touch no other piece; they stay as they are");
  }
  if (p.size.max_fragments > 0) {
    size["max_fragments"] = p.size.max_fragments;
    if (set.fragments.size() > p.size.max_fragments)
      warnings.push_back("max_fragments: " + std::to_string(p.size.max_fragments) + " asked, " +
                         std::to_string(set.fragments.size()) +
                         " made; what is left touches nothing it could be united with");
  }
  if (p.size.max_triangles > 0) {
    size["max_triangles"] = p.size.max_triangles;
    size["fewest_triangles"] = set.size.fewest_triangles;
    if (triangles > p.size.max_triangles)
      warnings.push_back("max_triangles: " + std::to_string(p.size.max_triangles) + " asked, " +
                         std::to_string(triangles) + " made; uniting everything would leave " +
                         std::to_string(set.size.fewest_triangles) + ", so nothing was united for it");
  }
  if (p.max_volume > 0) {
    size["max_volume"] = p.max_volume;
    size["sites_added"] = diagram.split.sites_added;
    size["passes"] = diagram.split.passes;
    size["too_large"] = diagram.split.too_large;
    if (largest > p.max_volume)
      warnings.push_back("max_volume: " + text_of(p.max_volume) + " m3 asked, the largest fragment has " +
                         text_of(largest) + " m3 (united, kept, or the passes or sites ran out)");
  }
  report["size"] = std::move(size);
  if (p.keep) {
    report["keep"] = {{"cells", kept_cells}};
    if (kept_cells == 0) warnings.push_back("keep: the region lies outside of the mesh's box");
  }
  if (p.anchors.any()) {
    report["anchors"] = {{"fragments", anchored}};
    if (anchored == 0) warnings.push_back("anchors: no fragment touches one");
  }
  if (!p.levels.empty()) {
    nlohmann::json counts = nlohmann::json::array();
    for (const ClusterLevel& level : made.hierarchy.levels) counts.push_back(level.clusters.size());
    counts.push_back(set.fragments.size());
    report["levels"] = std::move(counts);
  }
}

/// What was asked of the cuts, and what was made.
void report_roughness(const FractureParameters& p, const CutCells& cut, nlohmann::json& report) {
  const RoughReport& rough = cut.rough;
  nlohmann::json& warnings = report["warnings"];
  if (p.dual == Dual::kBarycenter) {
    warnings.push_back("rough cuts: hulls of barycentres share no cuts; theirs are flat");
    return;
  }
  report["rough_cuts"] = {{"amplitude", rough.amplitude},    {"amplitude_asked", rough.asked},
                          {"edge_length", rough.length},     {"triangles", rough.triangles},
                          {"calmed_vertices", rough.calmed}, {"crossing_triangles", rough.crossing}};
  if (cut.all_flat) {
    report["rough_cuts"]["amplitude_asked"] = p.roughness.amplitude;
    warnings.push_back("rough cuts: the cuts are flat, because rough ones did not prove themselves");
    return;
  }
  if (cut.restrained_cells > 0) {
    report["rough_cuts"]["restrained_cells"] = cut.restrained_cells;
    warnings.push_back("rough cuts: those of " + std::to_string(cut.restrained_cells) +
                       " cells are less rough, or flat, because rougher ones did not prove themselves");
  }
  if (rough.given_up) {
    report["rough_cuts"]["amplitude"] = 0;
    warnings.push_back(
        "rough cuts: the cuts are flat, because too many of their triangles lie in each other's way (pieces "
        "much longer than wide, or smaller than the amplitude); fewer sites, a smaller amplitude or a lower "
        "frequency help");
    return;
  }
  if (rough.amplitude < rough.asked)
    warnings.push_back("rough cuts: amplitude lowered from " + text_of(rough.asked) + " m to " +
                       text_of(rough.amplitude) +
                       " m, so that the cuts do not cross each other; a lower frequency allows a larger one");
  if (rough.crossing > 0)
    warnings.push_back("rough cuts: " + std::to_string(rough.crossing) +
                       " pairs of their triangles cross, as the surface itself does there");
}

void report_barycenter(const FractureParameters& p, const CutCells& cut, nlohmann::json& report) {
  nlohmann::json& mode = report["barycenter"];
  mode = {{"partition", false}, {"skipped_hulls", cut.barycentric.skipped_hulls}};
  if (p.drop_above > 0) {
    mode["dropped"] = cut.barycentric.dropped;
    mode["dropped_volume"] = cut.barycentric.dropped_volume;
  }
  report["warnings"].push_back(
      "dual=barycenter: the hulls of barycentres overlap and leave gaps; volumes do not add up to the "
      "solid's, and there are no bonds");
  if (cut.grouped)
    report["warnings"].push_back(
        "dual=barycenter: each cell is a fragment, those that the pattern keeps together too");
}

}  // namespace

nlohmann::json make_report(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                           const CutCells& cut, std::uint32_t anchored, const HullReport& hulls,
                           const FracturedSolid& made) {
  nlohmann::json report = report_of_sites(solid, diagram, made.set);
  report_structure(parameters, diagram, cut.kept, cut.further_triangles, anchored, made, report);
  if (parameters.roughness.amplitude > 0) report_roughness(parameters, cut, report);
  if (parameters.hulls == Hulls::kConvex)
    report["hulls"] = {{"count", hulls.hulls + cut.further_hulls.hulls},
                       {"flat", hulls.flat + cut.further_hulls.flat},
                       {"simplified", hulls.simplified + cut.further_hulls.simplified}};
  if (parameters.dual == Dual::kBarycenter) report_barycenter(parameters, cut, report);
  return report;
}

}  // namespace fracture
