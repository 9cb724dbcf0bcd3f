#include "common/pipeline/fewer_fragments.hpp"

#include <algorithm>
#include <variant>

#include "common/base/words.hpp"

namespace fracture {
namespace {

/// The parameters that set the number of cells instead of 'sites', and how to get more cells; empty if 'sites' sets it.
struct CellSize {
  std::string names, change;
};

CellSize cell_size_of(const SitePattern& pattern) {
  const auto* radial = std::get_if<RadialPattern>(&pattern);
  const auto* grid = std::get_if<GridPattern>(&pattern);
  const auto* brick = std::get_if<BrickPattern>(&pattern);
  const auto* slices = std::get_if<SlicePattern>(&pattern);
  if ((grid && grid->cell) || (brick && brick->cell))
    return {"this 'cell'", "Use a smaller 'cell', or leave it out."};
  if (slices && slices->spacing) return {"this 'spacing'", "Use a smaller 'spacing', or leave it out."};
  if (radial && radial->rings && radial->spokes)
    return {"these 'rings' and 'spokes'", "Raise 'rings' or 'spokes', or leave one of them out."};
  return {};
}

/// The pattern has too few cells, of which `pieces` came.
std::string few_cells(std::uint32_t asked, std::uint64_t pieces, const FractureParameters& p,
                      bool instances) {
  if (const auto* points = std::get_if<PointsPattern>(&p.pattern); points && points->points.size() < asked)
    return "'points' has " + counted(points->points.size(), "point", "points") + ". Give at least " +
           grouped(asked) + ".";
  const std::string came = counted(pieces, "piece", "pieces");
  if (std::holds_alternative<PointsPattern>(p.pattern))
    return "the cells of 'points' cut the mesh into " + came + ". Give more points inside the mesh.";
  if (const CellSize size = cell_size_of(p.pattern); !size.names.empty())
    return "the pattern with " + size.names + " cuts the mesh into " + came + ". " + size.change;
  if (p.sites < asked)
    return "'sites' is " + grouped(p.sites) + ". Raise 'sites' to at least " + grouped(asked) +
           ", or leave it out.";
  return "the pattern cuts the mesh into " + came + ". Set 'sites' to more than " + grouped(p.sites) +
         (instances ? ", or use instances=separate." : ".");
}

}  // namespace

std::string names_of(const Region& region) {
  return region.shape == Region::Shape::kBox ? "'keep_box'" : "'keep_center' and 'keep_radius'";
}

std::string names_of(const SizeLimits& size) {
  std::string names;
  const auto add = [&](bool given, const char* name) {
    if (given) names += std::string(names.empty() ? "'" : ", '") + name + "'";
  };
  add(size.min_volume > 0, "min_volume");
  add(size.min_fraction > 0, "min_fraction");
  add(size.min_of_mean > 0, "min_of_mean");
  add(size.fragments > 0, "fragments");
  add(size.max_fragments > 0, "max_fragments");
  add(size.max_triangles > 0, "max_triangles");
  return names;
}

bool are_many_inside_out(const FragmentSet& set) {
  const std::uint64_t pieces = std::uint64_t{set.certificate.cells} + set.certificate.islands;
  return set.size.inside_out > 0 && 10 * std::uint64_t{set.size.inside_out} >= pieces;
}

std::string why_fewer(std::uint32_t asked, const FractureParameters& parameters, double kept_share,
                      bool instances, const FragmentSet& set) {
  if (parameters.keep && kept_share > kAllKept)
    return "the region of " + names_of(*parameters.keep) +
           " contains the whole mesh. Make the region smaller.";
  const Certificate& counts = set.certificate;
  const std::uint64_t united = counts.united - std::min(counts.united, set.size.united),
                      crossing = std::max<std::uint64_t>(united, set.size.inside_out);
  if (united > 0 || are_many_inside_out(set))
    return counted(crossing, "piece has no separate volume", "pieces have no separate volume") +
           ", because the surface crosses itself. Ask for more fragments, or repair the surface in a modelling tool.";
  SizeLimits others = parameters.size;
  others.fragments = 0;
  const std::uint64_t made = set.fragments.size(), pieces = made + set.size.united;
  const std::uint64_t never_made = asked - std::min<std::uint64_t>(asked, pieces),
                      merged = std::min<std::uint64_t>(asked, pieces) - std::min<std::uint64_t>(asked, made);
  if (others.any() && merged > 0 && (merged >= never_made || 2 * made <= pieces)) {
    const std::string names = names_of(others);
    const bool several = names.find(',') != std::string::npos;
    return names + (several ? " merge" : " merges") + " small pieces. " +
           (several ? "Change these limits, or set them to 0." : "Change this limit, or set it to 0.");
  }
  return few_cells(asked, pieces, parameters, instances);
}

}  // namespace fracture
