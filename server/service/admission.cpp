#include "server/service/admission.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/gltf/cut_detail.hpp"
#include "common/pipeline/enough_sites.hpp"
#include "common/pipeline/part_sets.hpp"
#include "common/rough/roughen.hpp"
#include "server/service/estimate.hpp"
#include "server/service/estimate_of_hits.hpp"
#include "server/service/solid_figures.hpp"

namespace fracture {
namespace {

constexpr double kSecondsPerMeshByte = 60e-9;  // import and repair of a 1 MB OBJ: 60 ms
constexpr double kSecondsPerSite = 0.15e-3;    // 50 sites in a mesh of 1k triangles: 8 ms
constexpr double kSecondsPerRequest = 1e-3;
// Every triangle of the solid is clipped and written. A stored mesh of 60,000 triangles takes 30 ms longer than a cube
// (docker/README.md). common/base/product.cpp says how many bytes a fragment's triangle counts as.
constexpr double kSecondsPerTriangle = 0.5e-6, kBytesPerTriangle = 220;
// Share of kSecondsPerSite that each relaxation pass repeats: it builds the diagram, but no fragments.
constexpr double kPassShare = 0.4;

// Walls are computed on a lattice, so even a simple mesh takes long: a cube of 12 triangles takes 1.0 to 1.9 s, and a sphere
// of 250,000 triangles (8.5 MB of OBJ) takes 5 to 11 s.
constexpr double kSecondsForWalls = 1.2, kSecondsOfWallsPerMeshByte = 0.6e-6;
constexpr double kSecondsForDetailMaps = 2;  // 1.6 to 5 s, depending on the kind; once per process and kind

// An import reserves these (import_worker/import_pool.cpp). A small mesh asks for its 16 MiB only when it is read, so that it
// counts as small until then.
constexpr double kBytesPerImport = 16u << 20, kBytesPerMeshByte = 20;
constexpr std::uint64_t kLargeMesh = 1u << 20;
constexpr double kBytesPerSite = 16u << 10, kBytesPerRequest = 4u << 20;

// Estimates for a hit on a kept answer. kPiecesPerSite: pieces for each site if the solid is not known. For 30 sites in 300 cells,
// estimate_of_hits.hpp gives 3. kShareToCopy: time for copying all fragments, as a share of the whole work. If the answer contains
// only the changes, nothing is copied. kShareToPass and kBytesToPass then count the passes over a few numbers for each fragment.
constexpr double kPiecesPerSite = 3, kShareToCopy = 0.06, kShareToPass = 0.003, kBytesToPass = 128;

constexpr double kSecondsPerRoughTriangle = 4e-6, kBytesPerRoughTriangle = 600;

// Decoding inflates twice at 300 MB/s (content_coding.hpp). Bytes that are read are hashed or checked, and copied.
constexpr double kSecondsPerDecodedByte = 7e-9, kSecondsPerByteRead = 2e-9,
                 kSecondsPerCodedByte = 1.5e-8;  // gzip; zstd takes half of it

// Seconds for one evaluation of an estimate: in any case, for each entry of `assign`, part, hit, pair of hits, and part and hit.
constexpr double kSecondsForNumbers = 1e-6, kSecondsPerEntry = 0.2e-6, kSecondsPerPart = 10e-9,
                 kSecondsPerHit = 0.4e-6, kSecondsPerPairOfHits = 10e-9, kSecondsPerPartOfHit = 20e-9;

ExpectedWork work(std::uint64_t mesh_bytes, std::uint64_t triangles, double sites, double passes,
                  double rough_triangles) {
  const auto read = static_cast<double>(mesh_bytes), clipped = static_cast<double>(triangles);
  return {kSecondsPerRequest + kSecondsPerMeshByte * read + kSecondsPerTriangle * clipped +
              kSecondsPerSite * sites * (1 + kPassShare * passes) +
              kSecondsPerRoughTriangle * rough_triangles,
          static_cast<std::uint64_t>(kBytesPerRequest + (mesh_bytes >= kLargeMesh ? kBytesPerImport : 0) +
                                     kBytesPerMeshByte * read + kBytesPerTriangle * clipped +
                                     kBytesPerSite * sites + kBytesPerRoughTriangle * rough_triangles)};
}

bool leaves_whole(const FractureParameters& parameters) {
  return !parameters.hits.empty() && parameters.rest == LocalRest::kWhole;
}

/// The largest value for the parts without an entry of `assigned` and for those of each entry. Copies the parameters only once.
template <class Value>
double most_of_entries(const FractureParameters& parameters, const Value& value) {
  FractureParameters entry = parameters_of_entry(parameters, kNoIndex);
  double most = value(entry);
  for (const AssignedParts& assigned : parameters.assigned) {
    entry.sites = parameters.sites;
    take_entry(entry, *assigned.breaks);
    most = std::fmax(most, value(entry));
  }
  return most;
}

/// The pieces that hits make, from number `first` on.
double pieces_of_hits(const FractureParameters& parameters, const SolidFigures* figures,
                      const Selection& selection, std::size_t first) {
  if (first >= parameters.hits.size()) return 0;
  const double cells = cells_per_fragment(parameters);
  if (figures) {
    const Solid* const solid = &figures->solid();
    FractureParameters before = parameters;
    before.hits.clear();
    const double fragments = leaves_whole(parameters) ? static_cast<double>(solid->parts.size())
                             : parameters.size.fragments > 0
                                 ? parameters.size.fragments
                                 : expected_sites(before, solid, selection) / cells;
    return cells * expected_of_hits(parameters, *figures, fragments, 0, first).fragments;
  }
  double sites = 0;
  for (std::size_t k = first; k < parameters.hits.size(); ++k) sites += cells * parameters.hits[k].sites;
  return kPiecesPerSite * sites;
}

}  // namespace

double expected_sites(const FractureParameters& parameters, const Solid* solid, const Selection& selection) {
  // The sites are shared among the materials, so the one with the most is a bound.
  if (!parameters.assigned.empty()) {
    return most_of_entries(
        parameters, [&](const FractureParameters& entry) { return expected_sites(entry, solid, selection); });
  }
  double sites = 1;  // of a solid that is whole until a hit breaks it
  if (!leaves_whole(parameters)) {
    sites = solid ? expected_sites(parameters, solid->box) : parameters.sites;
    sites = std::fmax(sites, sites_for_fragments(parameters));
    // A cell that is too large gets further sites until its pieces are below the limit. On average they end up at half of it.
    if (solid && parameters.max_volume > 0)
      sites = std::fmax(sites, 2 * solid->report.volume / parameters.max_volume);
  }
  const double cells = cells_per_fragment(parameters);
  for (const LocalImpact& hit : parameters.hits) sites += cells * hit.sites;
  sites = std::fmin(sites, parameters.most_sites);
  if (selection.refracture) sites += std::fmin(cells * selection.refracture->sites, parameters.most_sites);
  return sites;
}

double expected_rough_triangles(const FractureParameters& parameters, double sites) {
  if (!parameters.assigned.empty()) {
    return most_of_entries(
        parameters, [&](const FractureParameters& entry) { return expected_rough_triangles(entry, sites); });
  }
  const Roughness& rough = parameters.roughness;
  if (!(rough.amplitude > 0) || is_barycentric(parameters)) return 0;
  // The faces of a random Voronoi cell have the area 5.82 volume^(2/3) (Meijering 1953). Two cells share each face.
  double area = 0.5 * 5.82 * std::cbrt(sites);  // in units of the solid's size, squared
  // Cuts inside aggregates are not rough. Cuts between aggregates are larger by kRaggedness because they are ragged.
  if (const double cells = cells_per_fragment(parameters); cells > 1) area *= kRaggedness / std::cbrt(cells);
  const double length =
      1 / (kEdgesPerWave * rough.frequency * std::ldexp(1, static_cast<int>(rough.octaves) - 1));
  return std::fmin(kMostRoughTriangles, area / (0.433 * length * length));
}

ExpectedWork expected_work(const FractureParameters& parameters, std::uint64_t mesh_bytes, const Solid* solid,
                           std::uint64_t triangles, const Selection& selection, const SolidFigures* figures) {
  std::optional<SolidFigures> own;
  if (solid && !figures) figures = &own.emplace(*solid);
  const double sites = expected_sites(parameters, solid, selection);
  if (solid) triangles = solid->triangles.size();
  if (parameters.intact) triangles *= 2;
  ExpectedWork expected = work(mesh_bytes, triangles, sites, leaves_whole(parameters) ? 0 : parameters.lloyd,
                               expected_rough_triangles(parameters, sites));
  expected.seconds += kSecondsPerSite * pieces_of_hits(parameters, figures, selection, 0);
  if (solid && !solid->parts.empty()) {
    const double reading = kBytesPerRequest + kBytesPerMeshByte * static_cast<double>(mesh_bytes);
    expected.bytes =
        static_cast<std::uint64_t>(reading + expected_working_bytes(parameters, *figures, selection));
  }
  return expected;
}

double expected_further_seconds(const RequestParameters& asked, std::uint64_t mesh_bytes) {
  double seconds = 0;
  if (asked.hollow.any() && mesh_bytes > 0)
    seconds += kSecondsForWalls + kSecondsOfWallsPerMeshByte * static_cast<double>(mesh_bytes);
  const CutDetail detail = asked.interior.detail;
  if (detail != CutDetail::kNone && asked.delta != DeltaAnswer::kOnly && !has_detail_maps(detail))
    seconds += kSecondsForDetailMaps;
  return seconds;
}

ExpectedWork expected_hit_work(const FractureParameters& parameters, const Selection& selection,
                               const Solid* solid, const SolidFigures* figures) {
  std::optional<SolidFigures> own;
  if (solid && !figures) figures = &own.emplace(*solid);
  const ExpectedWork whole = expected_work(parameters, 0, solid, 0, selection, figures);
  const std::size_t fresh = selection.new_hits ? selection.new_hits->count : 0;
  const double pieces = pieces_of_hits(parameters, figures, selection,
                                       parameters.hits.size() - std::min(fresh, parameters.hits.size()));
  const bool part = selection.new_hits && selection.new_hits->only_changed;
  const double seconds =
      kSecondsPerRequest + kSecondsPerSite * pieces + (part ? kShareToPass : kShareToCopy) * whole.seconds;
  const auto bytes = static_cast<std::uint64_t>(kBytesPerRequest + kBytesPerSite * pieces +
                                                kBytesToPass * expected_sites(parameters, solid, selection));
  return {std::fmin(seconds, whole.seconds), part ? std::min(bytes, whole.bytes) : whole.bytes};
}

ExpectedWork expected_decoding(std::uint64_t decoded_bytes) {
  return {kSecondsPerDecodedByte * static_cast<double>(decoded_bytes), 0};
}

ExpectedWork expected_reading(std::uint64_t bytes) {
  return {kSecondsPerByteRead * static_cast<double>(bytes), 0};
}

ExpectedWork expected_coding(std::uint64_t plain_bytes) {
  return {kSecondsPerCodedByte * static_cast<double>(plain_bytes), 2 * plain_bytes};
}

double seconds_of_estimate(const FractureParameters& parameters, const Solid& solid, int evaluations) {
  const auto entries = static_cast<double>(parameters.assigned.size()),
             hits = static_cast<double>(parameters.hits.size()),
             parts = static_cast<double>(solid.parts.size()),
             contacts = solid.contacts ? static_cast<double>(solid.contacts->contacts.size()) : 0;
  return evaluations *
         (kSecondsForNumbers + kSecondsPerEntry * entries + kSecondsPerPart * (parts + contacts) +
          hits * (kSecondsPerHit + kSecondsPerPairOfHits * hits + kSecondsPerPartOfHit * parts));
}

ExpectedWork expected_work(std::uint64_t mesh_bytes) { return work(mesh_bytes, 0, 0, 0, 0); }

}  // namespace fracture
