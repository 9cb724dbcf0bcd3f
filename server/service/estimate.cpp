#include "server/service/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "common/base/product.hpp"
#include "common/base/words.hpp"
#include "common/gltf/cut_detail.hpp"
#include "common/mesh/material_library.hpp"
#include "common/pipeline/broken_solid.hpp"
#include "common/rough/roughen.hpp"
#include "server/service/admission.hpp"
#include "server/service/cell_means.hpp"
#include "server/service/estimate_of_hits.hpp"

namespace fracture {
namespace {

// Bytes in a GLB, fitted to the answers of estimate_test.cpp.
constexpr double kBytesPerFile = 3000, kBytesPerFragment = 2650, kBytesPerHull = 1370, kBytesOfIndices = 9,
                 kBytesOfPosition = 12, kBytesOfNormal = 12, kBytesOfUv = 8, kBytesOfTangent = 16,
                 kBytesOfColor = 16, kBytesOfMaps = 200e3;
// Vertices per triangle. Smooth surfaces share theirs; each flat cut has its own.
constexpr double kVerticesOfSurface = 0.5, kVerticesOfFlatCuts = 1.8, kVerticesOfRoughCuts = 0.8;
// Hulls of a fragment of several cells or parts, and of a pattern that merges some cells.
constexpr double kHullsOfAggregate = 3, kHullsOfMerged = 2;

// Time for the numbers without hits, in steps (SolidFigures::step), and more for each entry of `assign`.
constexpr std::size_t kStepsOfNumbers = 50, kStepsOfEntry = 10;

bool divides_the_box(const SitePattern& pattern) {
  return std::holds_alternative<GridPattern>(pattern) || std::holds_alternative<BrickPattern>(pattern) ||
         std::holds_alternative<SlicePattern>(pattern);
}

struct Numbers {
  double sites = 0, cells = 0, fragments = 0;
  double tetrahedra = 0, polygons = 0, segments = 0, flat_caps = 0, rough_caps = 0;
  double surface = 0;          ///< triangles of the outside, after the cuts
  double cut_triangles = 0;    ///< of both sides of the cuts between fragments, flat
  double rough_triangles = 0;  ///< the same, rough
  double counted = 0;          ///< triangles of fragments, before some of these are merged
  double hulls = 0;
  double hit_bytes = 0;  ///< of memory for all pieces of hits and the largest hit
};

/// The cells that meet the solid.
double cells_in(const SolidShape& shape, double sites, const FractureParameters& p) {
  if (!divides_the_box(p.pattern) || !(shape.box > 0)) return sites;
  const double side = std::cbrt(shape.box / sites);
  const double met = shape.volume / (side * side * side) + 0.5 * shape.area / (side * side);
  return std::fmin(sites, std::fmax(met, p.size.fragments));
}

/// The lines in which the faces of cells meet the surface.
struct Section {
  double width = 0;      ///< m, of a cell
  double widths = 0;     ///< the area of the surface in units of width²
  double crossings = 0;  ///< of the lines with edges of the mesh
};

/// In a wall that is thinner than a cell, the cells lie next to each other in its plane.
Section section_of(const SolidShape& shape, double cells, double longer) {
  Section section;
  section.width = std::fmax(std::cbrt(shape.volume / cells), std::sqrt(shape.area / (2 * cells)));
  const double cut = (cells - 1) / cells;  // a single cell has no cuts
  section.widths = cut * shape.area / (section.width * section.width);
  const double length = kEdgesOnSection * longer * cut * shape.area / section.width;
  section.crossings = kCrossings * length * shape.edges / shape.area;
  return section;
}

/// The numbers without hits.
Numbers numbers_of(const FractureParameters& p, const SolidFigures& solid, const Selection& selection) {
  Numbers n;
  solid.step(kStepsOfNumbers + kStepsOfEntry * p.assigned.size());
  const SolidShape& shape = solid.shape();
  if (!(shape.volume > 0) || !(shape.area > 0)) return n;
  n.sites = std::fmax(1, expected_sites(p, &solid.solid(), selection));
  n.cells = std::fmax(1, cells_in(shape, n.sites, p));
  double group = cells_per_fragment(p);
  n.fragments = p.size.fragments > 0 ? p.size.fragments : n.cells / group;
  if (p.size.max_fragments > 0) n.fragments = std::fmin(n.fragments, p.size.max_fragments);
  if (shape.parts > 1 && n.cells > 1) {
    const LooseParts loose = solid.loose_parts(shape.volume / n.cells, p.parts == Parts::kApart);
    if (p.size.fragments > 0 || p.size.max_fragments > 0)
      n.fragments = std::fmax(n.fragments, 1 + loose.count);
    else
      n.fragments += p.size.any_least() ? loose.count : loose.pieces;
  }
  if (p.parts == Parts::kApart) n.fragments = std::fmax(n.fragments, shape.parts);
  if (std::holds_alternative<BrickPattern>(p.pattern))
    group = std::fmax(1, n.cells / n.fragments);  // lumps of bricks

  const double thickness = shape.thickness(), longer = surface_of_stretched(p.anisotropy.stretch);
  const Section section = section_of(shape, n.cells, longer);
  n.tetrahedra = kTetrahedraPerSite * n.sites;
  // Each crossing cuts a triangle and adds a piece. Triangles inside one cell are not cut.
  n.polygons = 2 * section.crossings + kCellsOnSection * section.widths;

  const double flatness = std::fmin(1, section.width / thickness);  // 1: the cells are prisms in a wall
  const auto between = [&](double solid_value, double prism) {
    return solid_value + flatness * (prism - solid_value);
  };
  const double faces = (n.cells - 1) * between(kFacesPerCell, kFacesPerPrism);
  n.flat_caps = faces * between(kTrianglesPerFace, kTrianglesPerPrismFace) + section.crossings;
  n.segments = 2 * (section.crossings + 1.5 * kVerticesOnSection * section.widths) + 5.2 * faces;

  // The cuts inside aggregates are not in the answer, neither on the surface nor inside.
  const Section outside = group > 1 ? section_of(shape, std::fmax(1, n.fragments), longer) : section;
  n.surface = shape.triangles + 2 * outside.crossings + 2 * kVerticesOnSection * outside.widths;
  const double kept = group > 1 ? std::fmin(1, kRaggedness / std::pow(group, between(1.0 / 3, 1.0 / 2))) : 1;
  n.cut_triangles = 2 * kept * n.flat_caps;
  if (p.roughness.amplitude > 0 && !is_barycentric(p)) {
    const double area =
        kept * (n.cells - 1) / n.cells * shape.volume / section.width * (kFaceArea * longer - flatness);
    const double edge = shape.size / (kEdgesPerWave * p.roughness.frequency *
                                      std::ldexp(1, static_cast<int>(p.roughness.octaves) - 1));
    // A face that is smaller than such an edge stays as it is.
    n.rough_caps =
        std::fmax(std::fmin(kMostRoughTriangles, area / (0.433 * edge * edge)), kept * n.flat_caps);
    n.rough_triangles = 2 * n.rough_caps;
    n.cut_triangles = 0;
  }
  const bool merged = n.cells > 1.5 * n.fragments;
  const bool several = group > 1 || shape.parts > 1;
  n.hulls = n.fragments * (several ? kHullsOfAggregate : merged ? kHullsOfMerged : 1);
  n.counted = (n.surface + n.cut_triangles + n.rough_triangles) * (several || merged ? kCountedOfMerged : 1);
  return n;
}

/// The parameters of the answer before the hits. It has one cell if the hits leave the rest whole.
FractureParameters before_hits_of(const FractureParameters& p, const SolidFigures& solid) {
  FractureParameters before = before_first_hit(solid.solid(), p);
  if (!p.hits.empty() && p.rest == LocalRest::kWhole) before.sites = 1;
  return before;
}

Numbers numbers_with_hits(const FractureParameters& p, const SolidFigures& solid,
                          const Selection& selection) {
  if (p.hits.empty()) return numbers_of(p, solid, selection);
  Numbers n = numbers_of(before_hits_of(p, solid), solid, selection);
  const HitNumbers hits =
      expected_of_hits(p, solid, n.fragments, n.surface + n.cut_triangles + n.rough_triangles);
  n.sites += hits.sites;
  n.fragments += hits.fragments;
  n.surface += hits.surface;
  n.cut_triangles += hits.cut_triangles;
  n.rough_triangles += hits.rough_triangles;
  n.hulls += hits.hulls;
  n.hit_bytes = hits.kept_bytes + hits.step_bytes;
  return n;
}

double working_bytes_of(const Numbers& n) {
  const auto bytes = [](Product product, double count) {
    return static_cast<double>(bytes_of(product)) * count;
  };
  return bytes(Product::kTetrahedra, n.tetrahedra) + bytes(Product::kPolygons, n.polygons) +
         bytes(Product::kSegments, n.segments) + bytes(Product::kCapTriangles, n.flat_caps + n.rough_caps) +
         bytes(Product::kFragmentTriangles, n.counted) + n.hit_bytes;
}

double file_bytes_of(const Numbers& n, const RequestParameters& asked, const SolidFigures& solid) {
  double vertex = kBytesOfPosition + kBytesOfNormal, images = 0;
  if (const auto& source = solid.solid().source) {
    const Attributes& attributes = source->attributes;
    vertex += kBytesOfUv * static_cast<double>(attributes.uvs.size()) +
              kBytesOfColor * static_cast<double>(attributes.colors.size()) +
              (attributes.tangents.empty() ? 0 : kBytesOfTangent);
    for (const Image& image : source->library->images) images += static_cast<double>(image.bytes.size());
  }
  if (asked.interior.detail != CutDetail::kNone && asked.delta != DeltaAnswer::kOnly) images += kBytesOfMaps;
  const bool hulls = asked.physics != Physics::kNone || asked.ue_collision != UeCollision::kNone;
  const double vertices = kVerticesOfSurface * n.surface + kVerticesOfFlatCuts * n.cut_triangles +
                          kVerticesOfRoughCuts * n.rough_triangles;
  const double triangles = n.surface + n.cut_triangles + n.rough_triangles;
  const double intact =
      asked.fracture.intact ? 2.0 : 1.0;  // the unbroken mesh counts like all fragments together
  return kBytesPerFile + images + kBytesPerFragment * n.fragments + (hulls ? kBytesPerHull * n.hulls : 0) +
         vertex * (vertices + (intact - 1) * static_cast<double>(solid.solid().triangles.size())) +
         kBytesOfIndices * triangles;
}

/// The parameter that sets the number of cells.
std::string counting_parameter(const RequestParameters& asked, const SolidFigures& solid) {
  const FractureParameters& p = asked.fracture;
  if (p.max_volume > 0 && 2 * solid.solid().report.volume / p.max_volume >= expected_sites(p, &solid.solid()))
    return "max_volume";
  FractureParameters fewer = p;
  fewer.sites = 1;
  if (p.sites > 1 && !(expected_sites(fewer, &solid.solid()) < expected_sites(p, &solid.solid())))
    return std::holds_alternative<SlicePattern>(p.pattern) ? "spacing" : "cell";
  return p.size.fragments > 0 ? "fragments" : "sites";
}

void set_count(FractureParameters& parameters, std::uint32_t count) {
  parameters.sites = count;
  if (parameters.size.fragments > 0) parameters.size.fragments = count;
}

void limit_sites_of_hits(FractureParameters& parameters, std::uint32_t most) {
  for (LocalImpact& hit : parameters.hits) hit.sites = std::min(hit.sites, most);
}

/// The largest number from 1 to `high` whose request is estimated at `limit` bytes at most, rounded down to two digits; at
/// least 1. Also the bytes of the request with that number. `set`: sets it in the parameters.
template <class Set>
std::pair<std::uint32_t, double> largest_count(const FractureParameters& parameters, const Set& set,
                                               std::uint32_t high, const SolidFigures& solid, double limit) {
  const auto bytes_with = [&](std::uint32_t count) {
    FractureParameters fewer = parameters;
    set(fewer, count);
    return expected_working_bytes(fewer, solid);
  };
  std::uint32_t low = 1;
  while (low < high) {
    const std::uint32_t middle = low + (high - low + 1) / 2;
    if (bytes_with(middle) <= limit)
      low = middle;
    else
      high = middle - 1;
  }
  std::uint32_t unit = 1;
  while (low / unit >= 100) unit *= 10;
  const std::uint32_t count = low / unit * unit;
  return {count, bytes_with(count)};
}

/// The advice to give each hit fewer cells.
CostliestParameter fewer_sites_of_hits(const FractureParameters& p, const SolidFigures& solid, double limit) {
  std::uint32_t most = 1;
  for (const LocalImpact& hit : p.hits) most = std::max(most, hit.sites);
  const auto [count, bytes] = largest_count(p, limit_sites_of_hits, most, solid, limit);
  return {"local_sites", count, bytes};
}

std::string size_in_words(double bytes) { return data_size(static_cast<std::uint64_t>(bytes)); }

/// Returns the memory that a request needs and the limit, without advice.
std::string need_in_words(const ExpectedAnswer& expected, double limit, const std::string& setting) {
  return "This request needs about " + size_in_words(expected.working_bytes) + " of memory, for about " +
         counted(static_cast<std::uint64_t>(expected.triangles), "triangle", "triangles") + " in " +
         counted(static_cast<std::uint64_t>(expected.fragments), "fragment", "fragments") +
         "; the limit for one computation is " + size_in_words(limit) + " (" + setting + ").";
}

}  // namespace

double expected_working_bytes(const FractureParameters& parameters, const SolidFigures& solid,
                              const Selection& selection) {
  return working_bytes_of(numbers_with_hits(parameters, solid, selection));
}

ExpectedAnswer expected_answer(const RequestParameters& asked, const SolidFigures& solid) {
  const Numbers n = numbers_with_hits(asked.fracture, solid, asked.selection);
  return {.sites = n.sites,
          .fragments = n.fragments,
          .triangles = n.surface + n.cut_triangles + n.rough_triangles,
          .file_bytes = n.sites > 0 ? file_bytes_of(n, asked, solid) : 0,
          .working_bytes = working_bytes_of(n)};
}

CostliestParameter costliest_parameter(const RequestParameters& asked, const SolidFigures& solid,
                                       double limit) {
  const FractureParameters& p = asked.fracture;
  const double whole = expected_working_bytes(p, solid);
  FractureParameters smooth = p;
  smooth.roughness.amplitude = 0;
  FractureParameters whole_mesh;  // a single cell
  whole_mesh.sites = 1;
  const double flat = expected_working_bytes(smooth, solid), mesh = expected_working_bytes(whole_mesh, solid);
  if (!(whole > 0)) return {"", nullptr, 0};
  if (whole - flat >= flat - mesh && whole - flat >= mesh) return {"rough_amplitude", 0, flat};
  if (flat - mesh < mesh) return {"", nullptr, mesh};
  if (!p.hits.empty()) {
    FractureParameters small_hits = smooth;
    limit_sites_of_hits(small_hits, 1);
    const double fewest = expected_working_bytes(small_hits, solid);
    if (flat - fewest >= fewest - mesh && flat - fewest >= mesh) return fewer_sites_of_hits(p, solid, limit);
    if (p.rest == LocalRest::kWhole) return {"", nullptr, mesh};
  }
  const std::string name = counting_parameter(asked, solid);
  if (name != "fragments" && name != "sites") return {name, nullptr, mesh};
  const auto [count, bytes] = largest_count(p, set_count, std::max(1u, p.sites), solid, limit);
  return {name, count, bytes};
}

namespace {

std::string advice_about(const CostliestParameter& costliest, const RequestParameters& asked,
                         const SolidFigures& solid, double limit, const std::string& setting) {
  const std::string or_raise = ", or raise " + setting + ".";
  if (costliest.name.empty())
    return "Most of the memory is for the mesh itself, which has " + grouped(solid.solid().triangles.size()) +
           " triangles: send a mesh with fewer" + or_raise;
  const std::string most = "Most of the memory is for '" + costliest.name + "': ";
  if (costliest.value.is_null()) return most + "use a larger value, which gives fewer cells" + or_raise;
  std::string text =
      most + "use " + costliest.name + "=" + costliest.value.dump() +
      (costliest.value.is_number_integer() && costliest.value.get<std::uint64_t>() > 0 ? " or fewer" : "") +
      " (about " + size_in_words(costliest.working_bytes) + ")";
  if (costliest.name != "rough_amplitude" || costliest.working_bytes <= limit) return text + or_raise;
  RequestParameters smooth = asked;
  smooth.fracture.roughness.amplitude = 0;
  const CostliestParameter next = costliest_parameter(smooth, solid, limit);
  if (next.value.is_number_integer())
    text += ", and with it " + next.name + "=" + next.value.dump() + " or fewer (about " +
            size_in_words(next.working_bytes) + ")";
  return text + or_raise;
}

/// The refusal of a request that cannot fit.
Error cannot_fit(const ExpectedAnswer& expected, const CostliestParameter& costliest,
                 const RequestParameters& asked, const SolidFigures& solid, std::uint64_t limit,
                 const std::string& setting) {
  const auto most = static_cast<double>(limit);
  Error error{ErrorCode::kTooComplex, need_in_words(expected, most, setting) + " " +
                                          advice_about(costliest, asked, solid, most, setting)};
  error.pointer = costliest.name;
  error.extra = Figures(nlohmann::json{{"bytes", static_cast<std::uint64_t>(expected.working_bytes)},
                                       {"limit", limit},
                                       {"estimated", true},
                                       {"fragments", static_cast<std::uint64_t>(expected.fragments)},
                                       {"triangles", static_cast<std::uint64_t>(expected.triangles)}});
  return error;
}

bool fits(double working_bytes, const RequestParameters& asked, std::uint64_t limit) {
  return asked.selection.new_hits || asked.selection.refracture ||
         !(working_bytes > kEstimateFactor * static_cast<double>(limit));
}

}  // namespace

std::string advice_for_less_memory(const RequestParameters& asked, const SolidFigures& solid, double limit,
                                   const std::string& setting) {
  return advice_about(costliest_parameter(asked, solid, limit), asked, solid, limit, setting);
}

bool fits(const RequestParameters& asked, const SolidFigures& solid, std::uint64_t limit) {
  if (asked.selection.new_hits || asked.selection.refracture) return true;
  return fits(expected_working_bytes(asked.fracture, solid, asked.selection), asked, limit);
}

std::optional<Error> cannot_fit(const RequestParameters& asked, const SolidFigures& solid,
                                std::uint64_t limit, const std::string& setting) {
  if (fits(asked, solid, limit)) return std::nullopt;
  return cannot_fit(expected_answer(asked, solid),
                    costliest_parameter(asked, solid, static_cast<double>(limit)), asked, solid, limit,
                    setting);
}

nlohmann::json estimate_document(const RequestParameters& asked, const SolidFigures& solid,
                                 std::uint64_t limit, const std::string& setting) {
  const auto whole = [](double number) { return static_cast<std::uint64_t>(std::llround(number)); };
  const ExpectedAnswer expected = expected_answer(asked, solid);
  const auto most = limit > 0 ? static_cast<double>(limit) : expected.working_bytes;
  const CostliestParameter costliest = costliest_parameter(asked, solid, most);
  const std::string& name = costliest.name;
  const bool is_possible = limit == 0 || fits(expected.working_bytes, asked, limit);
  std::optional<std::string> advice;
  if (!is_possible)
    advice = cannot_fit(expected, costliest, asked, solid, limit, setting).detail;
  else if (expected.working_bytes > most)
    advice = need_in_words(expected, most, setting) +
             " The estimate may be twice the real number, so the request is computed, but refused if it "
             "reaches the limit. " +
             advice_about(costliest, asked, solid, most, setting);
  return {{"sites", whole(expected.sites)},
          {"fragments", whole(expected.fragments)},
          {"triangles", whole(expected.triangles)},
          {"bytes", whole(expected.file_bytes)},
          {"working_bytes", whole(expected.working_bytes)},
          {"limit_bytes", limit > 0 ? nlohmann::json(limit) : nlohmann::json()},
          {"fits", is_possible},
          {"costliest", name.empty() ? nlohmann::json() : nlohmann::json(name)},
          {"advice", advice ? nlohmann::json(*advice) : nlohmann::json()}};
}

Error with_advice(Error error, const RequestParameters& asked, const SolidFigures& solid,
                  const std::string& setting) {
  if (error.code != ErrorCode::kTooComplex || !error.extra->contains("limit") ||
      !error.extra->contains("grew"))
    return error;
  const std::string general = " " + std::string(kAdviceForFewerProducts);
  if (const std::size_t at = error.detail.find(general); at != std::string::npos) error.detail.erase(at);
  error.detail += " " + advice_for_less_memory(asked, solid, error.extra->at("limit").get<double>(), setting);
  return error;
}

}  // namespace fracture
