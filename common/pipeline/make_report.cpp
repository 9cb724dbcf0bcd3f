#include "common/pipeline/make_report.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/physics/hull_trim.hpp"
#include "common/physics/principal_axes.hpp"
#include "common/pipeline/fewer_fragments.hpp"
#include "common/pipeline/kept_instances.hpp"
#include "common/pipeline/unnamed_nodes.hpp"

namespace fracture {
namespace {

void report_sites(const Solid& solid, const SiteNotes& sites, const FragmentSet& set, Report& report) {
  report.solid = solid.report;
  report.choices = solid.report.choices;
  report.contacts = contact_report(solid);
  report.sites = sites.figures;
  report.remarks = solid.remarks();
  report.remarks.add(sites.remarks);
  if (solid.source) report.dropped = solid.source->dropped;
  if (set.lattice_ratio > 1e-5)
    report.remarks.warn(
        "The mesh is far from the origin relative to its size, so coordinates in the answer are rounded by up to "
        "1/100,000 of the size. Small details may be ragged. Move the mesh nearer to the origin.");
}

/// `volumes` must be ascending.
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
    pacer.step(8);  // one cache miss each
    sizes.volumes.push_back(body_volume(f));
    sizes.triangles += f.indices.size() / 3;
    sizes.nodes.push_back(f.node);
  }
  sort_with_polls(execution, sizes.volumes.begin(), sizes.volumes.end());
  return sizes;
}

std::string more_fragments(std::uint32_t asked, bool together, bool instances, const FragmentSet& set) {
  const std::uint32_t parts = set.size.parts;
  const std::string at_least = " Ask for at least " + grouped(parts > asked ? parts : set.fragments.size());
  if (parts > asked)
    return "the mesh has " + grouped(parts) + " separate parts" +
           (!together   ? ","
            : instances ? ", instances or groups of parts that touch each other,"
                        : ", or groups of parts that touch each other,") +
           " and each becomes at least one fragment." + at_least +
           (together ? ", or raise 'contact_gap' to the distance between parts."
                     : ", or use parts=together.");
  return "the remaining pieces have no neighbours to merge with." + at_least +
         ", or repair the mesh so that " + (parts > 1 ? "its parts are joined." : "they touch.");
}

/// Explains the number of fragments if it is off by more than a tenth. `instances`: whether some may stay whole. `kept_share`: the
/// kept region's share of the volume.
void report_fragments(std::uint32_t asked, const FractureParameters& p, bool instances, double kept_share,
                      const FragmentSet& set, Remarks& remarks) {
  const std::size_t made = set.fragments.size();
  if (asked == 0 || (10 * made <= 11 * std::uint64_t{asked} && 10 * made >= 9 * std::uint64_t{asked})) return;
  const std::string both = counted(asked, "fragment was", "fragments were") + " asked for, and " +
                           counted(made, "was", "were") + " made";
  if (made == p.size.max_fragments && made < asked)
    remarks.note(both + ", because 'max_fragments' allows no more.");
  else
    remarks.warn(both + ", because " +
                 (made < asked ? why_fewer(asked, p, kept_share, instances, set)
                               : more_fragments(asked, p.parts == Parts::kTogether, instances, set)));
}

/// Share of the largest fragment that is known to be the kept region.
constexpr double kMostOfIt = 0.999;

/// Explains a fragment above 'max_volume' and says what to do, after "because ". `is_kept`: whether it is the kept region.
std::string why_larger(const FractureParameters& p, const SplitFigures& split, bool is_kept) {
  if (p.keep && is_kept)
    return "the region of " + names_of(*p.keep) + " stays whole. Make the region smaller.";
  if (!p.hits.empty() && p.rest == LocalRest::kWhole)
    return "local_rest=whole keeps the rest of each part in one piece. Use local_rest=fractured.";
  if (split.too_large > 0)
    return "dividing it further would take too many passes or sites. Use a larger 'max_volume'.";
  if (is_barycentric(p))
    return "this limit divides Voronoi cells, but the hulls of dual=barycenter can be larger. Use a smaller "
           "'max_volume', or leave out large fragments with 'drop_above'.";
  if (p.size.any()) {
    const std::string names = names_of(p.size);
    return "pieces were merged to meet " + names + ". Change " +
           (names.find(',') != std::string::npos ? "these limits" : "this limit") +
           ", or use a larger 'max_volume'.";
  }
  return "its pieces were joined. Use a larger 'max_volume'.";
}

void report_size(const FractureParameters& p, bool instances, const SplitFigures& split,
                 const CutCells::Whole& sizes, double kept_share, const FragmentSet& set, Report& report) {
  const std::vector<double>& volumes = sizes.volumes;
  const std::uint64_t triangles = sizes.triangles;
  const double largest = volumes.empty() ? 0 : volumes.back();
  report.size = {volume_distribution(volumes), triangles, p.size, set.size, p.max_volume, split};
  Remarks& remarks = report.remarks;
  if (const std::uint32_t alone = set.size.alone; alone > 0)
    remarks.note(counted(alone, "piece is", "pieces are") + " smaller than " +
                 short_number(set.size.min_volume) + " m³ and " + (alone == 1 ? "touches" : "touch") +
                 " no other piece, so " + (alone == 1 ? "it stays as it is." : "they stay as they are."));
  const bool united = p.hits.empty() && !is_barycentric(p);  // otherwise, nothing is merged
  report_fragments(united ? p.size.fragments : 0, p, instances, kept_share, set, remarks);
  if (united && p.size.max_fragments > 0 && set.fragments.size() > p.size.max_fragments)
    remarks.warn(
        "The answer has " + counted(set.fragments.size(), "fragment", "fragments") +
        ", although 'max_fragments' is " + grouped(p.size.max_fragments) +
        ": the remaining fragments have no neighbours to merge with. Allow more, or join the parts of "
        "the mesh in a modelling tool.");
  if (united && p.size.max_triangles > 0 && triangles > p.size.max_triangles)
    remarks.warn("The fragments have " + counted(triangles, "triangle", "triangles") +
                 ", although 'max_triangles' is " + grouped(p.size.max_triangles) +
                 ". Nothing was merged to meet this limit, because " + grouped(set.size.fewest_triangles) +
                 " would be left even if everything were merged. Set 'max_triangles' to at least " +
                 grouped(set.size.fewest_triangles) + ", or simplify the mesh.");
  if (p.max_volume > 0 && largest > p.max_volume)
    remarks.warn("The largest fragment has a volume of " + short_number(largest) +
                 " m³, although 'max_volume' is " + short_number(p.max_volume) + " m³, because " +
                 why_larger(p, split, kept_share * report.solid.volume >= kMostOfIt * largest));
}

void report_inside_out(const FragmentSet& set, Remarks& remarks) {
  if (!are_many_inside_out(set)) return;
  const std::uint32_t count = set.size.inside_out;
  remarks.warn(
      counted(count, "piece", "pieces") + " of " +
      grouped(std::uint64_t{set.certificate.cells} + set.certificate.islands) +
      (count == 1 ? " has" : " have") +
      " a negative volume, because the surface crosses itself with opposite winding. Such pieces are merged "
      "with their neighbours, so the answer has fewer and larger fragments. Repair the mesh in a modelling "
      "tool, so that all its parts face outwards.");
}

void report_kept(const FractureParameters& p, const CutCells& cut, Report& report) {
  if (!p.keep) return;
  const std::string name = names_of(*p.keep);
  if (is_barycentric(p)) {
    report.remarks.warn("dual=barycenter keeps no region whole, so " + name +
                        " had no effect. Leave out either the region or 'dual'.");
    return;
  }
  report.kept = {cut.kept, cut.kept_share};
  if (!(cut.kept_share > 0))
    report.remarks.warn("The region of " + name +
                        " contains no part of the mesh, so nothing is kept whole. Move it onto the mesh; its "
                        "coordinates are in metres, with y up.");
  else if (cut.kept_share > kAllKept && (p.hits.empty() || p.rest == LocalRest::kFractured))
    report.remarks.warn("The region of " + name +
                        " contains the whole mesh, so nothing is cut. Make the region smaller.");
}

void report_structure(std::optional<std::uint32_t> anchored, Report& report) {
  report.anchored = anchored;
  if (anchored == 0u) report.remarks.warn(kNothingAnchored);
}

/// Reports the requested and the actual roughness of the cuts.
void report_roughness(const FractureParameters& p, const CutCells& cut, Report& report) {
  const RoughReport& rough = cut.rough;
  Remarks& remarks = report.remarks;
  if (is_barycentric(p)) {
    remarks.warn(std::string(p.hits.empty() ? "The cuts are flat" : "Only the cuts of hits are rough") +
                 ", because fragments of dual=barycenter share no cuts. Leave out 'dual' if you want "
                 "rough cuts.");
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
    remarks.warn(
        "The cuts are flat, because fragments with rough cuts did not pass the answer's check. Try a smaller "
        "'rough_amplitude' or fewer sites.");
    return;
  }
  if (cut.restrained_cells > 0) {
    cuts.restrained_cells = cut.restrained_cells;
    remarks.note(
        "The cuts of " + counted(cut.restrained_cells, "cell", "cells") +
        " are less rough than requested, or flat, because fragments with rougher cuts did not pass the "
        "answer's check.");
  }
  if (rough.given_up) {
    cuts.amplitude = 0;
    remarks.warn(
        "The cuts are flat, because too many triangles of rough cuts would cross each other: pieces are much "
        "longer than they are wide, or smaller than the amplitude. Ask for fewer sites, or for a smaller "
        "'rough_amplitude' or 'rough_frequency'.");
    return;
  }
  if (rough.amplitude < rough.asked)
    remarks.note("The amplitude of the rough cuts is " + short_number(rough.amplitude) + " m instead of " +
                 short_number(rough.asked) +
                 " m, so that they do not cross each other. A lower 'rough_frequency' allows more.");
  if (rough.crossing > 0)
    remarks.note(counted(rough.crossing, "pair", "pairs") + " of triangles in the rough cuts " +
                 (rough.crossing == 1 ? "crosses" : "cross") + ", because the surface crosses itself there.");
}

void report_barycenter(const FractureParameters& p, const CutCells& cut, Report& report) {
  const BarycentricResult& result = cut.barycentric;
  report.barycenter = {.skipped_hulls = result.skipped_hulls};
  if (p.drop_above > 0) report.barycenter->dropped = {result.dropped, result.dropped_volume};
  report.remarks.note(
      "dual=barycenter: the fragments overlap and leave gaps, their volumes do not add up to the solid's, "
      "and there are no bonds.");
  SizeLimits idle = p.size;
  idle.min_of_mean = 0;  // may be of the material (parameters/effects.cpp)
  if (!p.hits.empty()) idle.min_volume = idle.min_fraction = 0;  // they merge the pieces of hits
  if (idle.any())
    report.remarks.warn("dual=barycenter: fragments are not merged by size, because they share no cuts, so " +
                        names_of(idle) + " had no effect. Leave out either the size limits or 'dual'.");
  if (cut.grouped && p.hits.empty())  // hits always make groups
    report.remarks.note(
        "dual=barycenter: each cell is a separate fragment, even if the pattern keeps it together with other cells.");
}

/// `physics=none` with hulls for Unreal is like `physics=omi`: neither has filters.
void report_rest(const RestFigures& rest, Remarks& remarks) {
  if (rest.left > 0)
    remarks.warn(
        "The hulls of " + counted(rest.left, "pair", "pairs") + " of fragments overlap, the deepest by " +
        short_number(rest.deepest) +
        " m, so engines push these fragments apart when the simulation starts. " +
        (rest.filtered > 0
             ? "The 32 collision systems of a file are too few to exclude so many pairs. Ask for fewer fragments, or join overlapping "
               "parts in a modelling tool."
             : "The file's format has no collision filters. Use physics=khr, or turn off collisions "
               "between them in the engine."));
  if (rest.least_share < kLeastShareAtContacts)
    remarks.note("Some collision hulls were trimmed to as little as " + short_number(100 * rest.least_share) +
                 " % of their volume, because more pairs of fragments overlap than 32 collision systems can "
                 "exclude. Ask for fewer fragments, or join overlapping parts in a modelling tool.");
}

}  // namespace

Report make_report(const Solid& solid, const SiteNotes& sites, const FractureParameters& parameters,
                   const CutCells& cut, std::optional<std::uint32_t> anchored, const HullReport& hulls,
                   const std::optional<Rest>& rest, const FragmentSet& set, const Execution& execution) {
  Report report;
  report_sites(solid, sites, set, report);
  const CutCells::Whole whole = cut.whole ? *cut.whole : sizes_of(set, execution);
  report_size(parameters, may_keep_instances(solid, parameters), sites.split, whole, cut.kept_share, set,
              report);
  if (solid.source) {
    add_unnamed_nodes(*solid.source, whole.nodes, set, report.dropped, execution);
    if (!parameters.levels.empty()) add_nodes_without_group(*solid.source, report.dropped, execution);
  }
  report_inside_out(set, report.remarks);
  report_kept(parameters, cut, report);
  report_structure(anchored, report);
  if (parameters.roughness.amplitude > 0) report_roughness(parameters, cut, report);
  if (rest) report_rest(rest->figures, report.remarks);
  if (parameters.hulls == Hulls::kConvex) report.hulls = cut.whole ? cut.whole->hulls : hulls;
  if (is_barycentric(parameters)) report_barycenter(parameters, cut, report);
  return report;
}

}  // namespace fracture
