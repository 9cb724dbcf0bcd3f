#include "common/pipeline/soundness.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/fragment/mirror_sum.hpp"
#include "common/pipeline/number_text.hpp"

namespace fracture {
namespace {

/// Relative tolerance of volumes and areas before rounding (invariant I2).
constexpr double kTolerance = 1e-9;
/// The same for sheets. Fused pieces of a triangle are triangulated on rounded positions, so a strip as high as the
/// rounding may be counted three times.
constexpr double kSheetTolerance = 1e-5;

/// The largest absolute coordinate of a box, m.
double reach_of(const Box& box) {
  double reach = 0;
  for (int a = 0; a < 3; ++a)
    reach = std::fmax(reach, std::fmax(std::fabs(box.min[a]), std::fabs(box.max[a])));
  return reach;
}

void compare(const char* what, double is, double should_be, double bound, const char* unit,
             Verdict& verdict) {
  if (std::fabs(is - should_be) <= bound) return;  // NaN is beyond every bound
  verdict.violations.push_back(std::string(what) + " " + text_of(is) + " " + unit + " instead of " +
                               text_of(should_be) + ", off by more than " + text_of(bound));
}

/// Total length (m) of the edges of all triangles that are not caps. If the set is only a delta, each missing fragment
/// is estimated as 12 times the longest side of the solid's box.
double surface_edges(const FragmentSet& set, double size) {
  const std::size_t all = std::max<std::size_t>(set.certificate.fragments, set.fragments.size());
  double sum = 12 * size * static_cast<double>(all - set.fragments.size());
  for (const Fragment& f : set.fragments) {
    auto cap = f.caps.begin();
    for (std::uint32_t k = 0; k < f.indices.size(); k += 3) {
      if (cap != f.caps.end() && k == cap->first) {
        k += cap->count - 3;
        ++cap;
        continue;
      }
      for (std::uint32_t e = 0; e < 3; ++e)
        sum += length(to_double(f.positions[f.indices[k + (e + 1) % 3]]) -
                      to_double(f.positions[f.indices[k + e]]));
    }
  }
  return sum;
}

}  // namespace

Verdict judge(const FragmentSet& set, const Solid& solid, Promise promise) {
  Verdict verdict;
  const Certificate& c = set.certificate;
  if (c.open_edges > 0) {
    verdict.violations.push_back(std::to_string(c.open_edges) + " edges of fragments are open");
    for (std::uint32_t k = 0; k < set.fragments.size(); ++k)
      if (set.fragments[k].open_edges > 0) verdict.fragments.push_back(k);
  }
  if (solid.sheets) {
    const double far = reach_of(solid.sheets->surface->box);
    compare("the sheets in the answer cover", c.sheet_area_out, c.sheet_area_in,
            kSheetTolerance * c.sheet_area_in + 0x1.0p-40 * far * far, "m²", verdict);
  }
  if (promise == Promise::kClosed) return verdict;

  if (c.unmirrored_caps > 0) {
    std::uint64_t count = 0;
    const std::vector<std::uint32_t> concerned = unmirrored(set.fragments, count);
    verdict.fragments.insert(verdict.fragments.end(), concerned.begin(), concerned.end());
    verdict.violations.push_back((count > 0 ? std::to_string(count) : std::string("some")) +
                                 " triangles of cuts have no mirror image in another fragment");
  }
  // Positions before rounding are off by at most 2^-52 of the largest coordinate.
  const double reach = reach_of(solid.box);
  const double size = solid.box.longest_side(), rounding = 0x1.0p-48 * reach;
  compare("the fragments' volumes before rounding add up to", c.volume_out, c.volume_in,
          kTolerance * solid.report.absolute_volume + rounding * solid.report.area, "m³", verdict);
  const double h = std::fmax(set.lattice_step.x, std::fmax(set.lattice_step.y, set.lattice_step.z));
  const double height = h + std::ldexp(size, -24);
  // Pieces of a triangle are triangulated on rounded positions (invariant I5). So a strip next to an edge, as high
  // as the rounding, may be covered three times.
  double bound = kTolerance * c.area_in;
  if (!(std::fabs(c.area_out - c.area_in) <= bound)) bound += 2 * height * surface_edges(set, size);
  compare("the fragments cover", c.area_out, c.area_in, bound, "m² of the surface", verdict);
  compare("the fragments' volumes in the file add up to", c.volume_file, c.volume_in - c.pocket_volume,
          height * (c.area_out - c.pocket_area) + kTolerance * solid.report.absolute_volume, "m³", verdict);
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k) {
    const MassProperties& mass = set.fragments[k].mass;
    if (mass.volume >= -height * mass.area) continue;
    verdict.violations.push_back("fragment " + std::to_string(set.fragments[k].id) + " has the volume " +
                                 text_of(mass.volume) + " m³");
    verdict.fragments.push_back(k);
  }
  std::sort(verdict.fragments.begin(), verdict.fragments.end());
  verdict.fragments.erase(std::unique(verdict.fragments.begin(), verdict.fragments.end()),
                          verdict.fragments.end());
  return verdict;
}

Verdict judge_rest(const Rest& rest, HullFilters filters) {
  Verdict verdict;
  const RestFigures& f = rest.figures;
  // Pairs that neither filters nor trimming keep apart are counted, and a warning says so (make_report.cpp).
  if (filters == HullFilters::kNone || f.left > 0 || f.deepest <= f.tolerance) return verdict;
  verdict.violations.push_back("bodies that may collide overlap by " + text_of(f.deepest) + " m, more than " +
                               text_of(f.tolerance) + ", but the report counts no such pair");
  return verdict;
}

Error unsound(const Verdict& verdict, const Certificate& certificate) {
  std::string detail = "The answer failed its check and is not returned: ";
  constexpr std::size_t kMost = 5;
  for (std::size_t k = 0; k < std::min(verdict.violations.size(), kMost); ++k)
    detail += (k > 0 ? "; " : "") + verdict.violations[k];
  if (verdict.violations.size() > kMost)
    detail += "; and " + std::to_string(verdict.violations.size() - kMost) + " more";
  detail += ". This is a bug in the program. Please report the mesh and the parameters.";
  return {ErrorCode::kUnsound,
          std::move(detail),
          {},
          Figures(nlohmann::json{{"open_edges", certificate.open_edges},
                                 {"unmirrored_caps", certificate.unmirrored_caps},
                                 {"volume_in", certificate.volume_in},
                                 {"volume_out", certificate.volume_out},
                                 {"volume_file", certificate.volume_file},
                                 {"area_in", certificate.area_in},
                                 {"area_out", certificate.area_out}})};
}

}  // namespace fracture
