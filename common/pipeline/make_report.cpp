#include "common/pipeline/make_report.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/physics/principal_axes.hpp"
#include "common/pipeline/number_text.hpp"

namespace fracture {
namespace {

void report_sites(const Solid& solid, const SiteNotes& sites, const FragmentSet& set, Report& report) {
  report.solid = solid.report;
  report.sites = sites.figures;
  std::vector<std::string>& warnings = report.warnings;
  for (const auto* notes : {&solid.source->warnings, &solid.report.notes, &sites.notes})
    warnings.insert(warnings.end(), notes->begin(), notes->end());
  if (set.lattice_ratio > 1e-5)
    warnings.emplace_back(
        "the mesh lies so far from the origin that float32 positions are coarse: one step is more than 1e-5 "
        "of its size");
}

/// Of volumes in ascending order.
VolumeDistribution volume_distribution(const std::vector<double>& volumes) {
  const std::size_t n = volumes.size();
  if (n == 0) return {};
  const auto quantile = [&](std::size_t tenths) { return volumes[(n - 1) * tenths / 10]; };
  double sum = 0, squares = 0, in_largest_tenth = 0;
  for (const double v : volumes) sum += v;
  const double mean = sum / static_cast<double>(n);
  for (const double v : volumes) squares += (v - mean) * (v - mean);
  const std::size_t tenth = (n + 9) / 10;
  for (std::size_t k = n - tenth; k < n; ++k) in_largest_tenth += volumes[k];
  return {.smallest = volumes.front(),
          .lowest_tenth = quantile(1),
          .median = quantile(5),
          .highest_tenth = quantile(9),
          .largest = volumes.back(),
          .mean = mean,
          .coefficient_of_variation = mean > 0 ? std::sqrt(squares / static_cast<double>(n)) / mean : 0,
          .share_of_largest_tenth = sum > 0 ? in_largest_tenth / sum : 0};
}

CutCells::Whole sizes_of(const FragmentSet& set, const Execution& execution) {
  CutCells::Whole sizes;
  Pacer pacer(execution);
  for (const Fragment& f : set.fragments) {
    pacer.step(8);  // a miss of the cache each
    sizes.volumes.push_back(body_volume(f));
    sizes.triangles += f.indices.size() / 3;
  }
  sort_with_polls(execution, sizes.volumes.begin(), sizes.volumes.end());
  return sizes;
}

/// Where the number of fragments is off by more than a tenth: why.
void report_fragments(std::uint32_t asked, const FragmentSet& set, std::vector<std::string>& warnings) {
  const std::size_t made = set.fragments.size();
  if (asked == 0 || (10 * made <= 11 * std::uint64_t{asked} && 10 * made >= 9 * std::uint64_t{asked})) return;
  const std::string both =
      "fragments: " + std::to_string(asked) + " asked, " + std::to_string(made) + " made; ";
  if (made < asked && set.certificate.united > set.size.united)
    warnings.push_back(both + std::to_string(set.certificate.united - set.size.united) +
                       " pieces have no volume of their own, because the surface crosses itself");
  else if (made < asked)
    warnings.push_back(both + "the pattern's cells and limits of size give no more");
  else if (set.size.parts > 1)
    warnings.push_back(both + "the mesh has " + std::to_string(set.size.parts) +
                       " separate parts, each of which is at least one");
  else
    warnings.push_back(both + "what is left touches nothing it could be united with");
}

void report_size(const FractureParameters& p, const SplitFigures& split, const CutCells::Whole& sizes,
                 const FragmentSet& set, Report& report) {
  const std::vector<double>& volumes = sizes.volumes;
  const std::uint64_t triangles = sizes.triangles;
  const double largest = volumes.empty() ? 0 : volumes.back();
  report.size = {volume_distribution(volumes), triangles, p.size, set.size, p.max_volume, split};
  std::vector<std::string>& warnings = report.warnings;
  if (set.size.alone > 0)
    warnings.push_back(std::to_string(set.size.alone) + " pieces below " + text_of(set.size.min_volume) +
                       " m3 touch no other piece; they stay as they are");
  report_fragments(p.hits.empty() ? p.size.fragments : 0, set, warnings);
  if (p.size.max_fragments > 0 && set.fragments.size() > p.size.max_fragments)
    warnings.push_back("max_fragments: " + std::to_string(p.size.max_fragments) + " asked, " +
                       std::to_string(set.fragments.size()) +
                       " made; what is left touches nothing it could be united with");
  if (p.size.max_triangles > 0 && triangles > p.size.max_triangles)
    warnings.push_back("max_triangles: " + std::to_string(p.size.max_triangles) + " asked, " +
                       std::to_string(triangles) + " made; uniting everything would leave " +
                       std::to_string(set.size.fewest_triangles) + ", so nothing was united for it");
  if (p.max_volume > 0 && largest > p.max_volume)
    warnings.push_back("max_volume: " + text_of(p.max_volume) + " m3 asked, the largest fragment has " +
                       text_of(largest) + " m3 (united, kept, or the passes or sites ran out)");
}

void report_structure(const FractureParameters& p, std::size_t kept_cells,
                      std::optional<std::uint32_t> anchored, Report& report) {
  if (p.keep) {
    report.kept_cells = kept_cells;
    if (kept_cells == 0) report.warnings.emplace_back("keep: the region lies outside of the mesh's box");
  }
  report.anchored = anchored;
  if (anchored == 0u) report.warnings.emplace_back(kNothingAnchored);
}

/// What was asked of the cuts, and what was made.
void report_roughness(const FractureParameters& p, const CutCells& cut, Report& report) {
  const RoughReport& rough = cut.rough;
  std::vector<std::string>& warnings = report.warnings;
  if (p.dual == Dual::kBarycenter) {
    warnings.emplace_back("rough cuts: hulls of barycentres share no cuts; theirs are flat");
    return;
  }
  RoughCuts& cuts = report.rough_cuts.emplace();
  cuts = {.amplitude = rough.amplitude,
          .amplitude_asked = rough.asked,
          .edge_length = rough.length,
          .triangles = rough.triangles,
          .calmed_vertices = rough.calmed,
          .crossing_triangles = rough.crossing};
  if (cut.all_flat) {
    cuts.amplitude_asked = p.roughness.amplitude;
    warnings.emplace_back("rough cuts: the cuts are flat, because rough ones did not prove themselves");
    return;
  }
  if (cut.restrained_cells > 0) {
    cuts.restrained_cells = cut.restrained_cells;
    warnings.push_back("rough cuts: those of " + std::to_string(cut.restrained_cells) +
                       " cells are less rough, or flat, because rougher ones did not prove themselves");
  }
  if (rough.given_up) {
    cuts.amplitude = 0;
    warnings.emplace_back(
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

/// The limits of size that are in force, by name.
std::string names_of(const FractureParameters& p) {
  std::string names;
  const auto add = [&](bool given, const char* name) {
    if (given) names += std::string(names.empty() ? "'" : ", '") + name + "'";
  };
  add(p.size.min_volume > 0, "min_volume");
  add(p.size.min_fraction > 0, "min_fraction");
  add(p.size.min_of_mean > 0, "min_of_mean");
  add(p.size.fragments > 0, "fragments");
  add(p.size.max_fragments > 0, "max_fragments");
  add(p.size.max_triangles > 0, "max_triangles");
  return names;
}

void report_barycenter(const FractureParameters& p, const CutCells& cut, Report& report) {
  const BarycentricResult& result = cut.barycentric;
  report.barycenter = {.skipped_hulls = result.skipped_hulls};
  if (p.drop_above > 0) report.barycenter->dropped = {result.dropped, result.dropped_volume};
  report.warnings.emplace_back(
      "dual=barycenter: the hulls of barycentres overlap and leave gaps; volumes do not add up to the "
      "solid's, and there are no bonds");
  if (p.size.any())
    report.warnings.push_back(
        "dual=barycenter: no fragments are united for their size, because they share no cuts, so " +
        names_of(p) + " changed nothing; leave the parameter out, or 'dual'");
  if (cut.grouped)
    report.warnings.emplace_back(
        "dual=barycenter: each cell is a fragment, those that the pattern keeps together too");
}

}  // namespace

Report make_report(const Solid& solid, const SiteNotes& sites, const FractureParameters& parameters,
                   const CutCells& cut, std::optional<std::uint32_t> anchored, const HullReport& hulls,
                   const FragmentSet& set, const Execution& execution) {
  Report report;
  report_sites(solid, sites, set, report);
  report_size(parameters, sites.split, cut.whole ? *cut.whole : sizes_of(set, execution), set, report);
  report_structure(parameters, cut.kept, anchored, report);
  if (parameters.roughness.amplitude > 0) report_roughness(parameters, cut, report);
  if (parameters.hulls == Hulls::kConvex) report.hulls = cut.whole ? cut.whole->hulls : hulls;
  if (parameters.dual == Dual::kBarycenter) report_barycenter(parameters, cut, report);
  return report;
}

}  // namespace fracture
