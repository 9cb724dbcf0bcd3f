// Rows for hits that break only the area around them, on an earlier answer or together with it.
#include <algorithm>
#include <numeric>
#include <string_view>

#include "common/base/words.hpp"
#include "common/parameters/fields.hpp"
#include "common/parameters/parameters.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {
namespace {

using parameter_fields::kFar;
using parameter_fields::kFarPlace;
using parameter_fields::kLeastLength;
using parameter_fields::with_member;

constexpr std::size_t kMostHits = 64;
constexpr std::uint64_t kMostHitSites = 10'000;  // total over all hits of an answer
constexpr std::size_t kKeyDigits = 64;

ParameterSpec of_row() {
  ParameterSpec spec{
      .name = "of",
      .type = Type::kText,
      .max = 300,
      .doc =
          "Address of an earlier answer for the same mesh, from the answer's Content-Location header. The new hits "
          "follow that answer's hits and use its parameters. If the server no longer has the answer (404), send that "
          "answer's parameters and all hits instead; the bytes are the same."};
  spec.check = [](const ParameterValue& value) -> std::optional<std::string> {
    if (!answer_key_in(std::get<std::string>(value)).empty()) return std::nullopt;
    return "be the address of an answer, /fractures/sha256: followed by 64 lower-case hex digits";
  };
  spec.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.of = answer_key_in(std::get<std::string>(value));
  };
  // The canonical form contains that answer's parameters instead.
  spec.get = [](const RequestParameters&, const ParameterSpec&) { return nlohmann::json(); };
  return spec;
}

std::string counted(std::size_t n, const char* what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

/// Repeats a single value for every point. Returns an error if the numbers of values and points differ.
template <class T>
std::optional<Error> spread(const char* name, std::vector<T>& values, std::size_t points) {
  if (values.size() == 1) values.resize(points, values.front());
  if (values.size() == points) return std::nullopt;
  return bad_parameter(name, std::string("'") + name + "' has " + counted(values.size(), "number") +
                                 ", but 'local_point' has " + counted(points, "point") +
                                 ". Give one number per point, or a single number for all points.");
}

}  // namespace

std::string answer_key_in(std::string_view address) {
  constexpr std::string_view kScheme = "sha256:", kFolder = "/fractures/";
  if (address.size() < kScheme.size() + kKeyDigits) return {};
  const std::string_view key = address.substr(address.size() - kKeyDigits);
  address.remove_suffix(kKeyDigits);
  if (!address.ends_with(kScheme)) return {};
  address.remove_suffix(kScheme.size());
  if (!address.empty() && !address.ends_with(kFolder)) return {};
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  return std::all_of(key.begin(), key.end(), is_digit) ? std::string(key) : std::string();
}

std::vector<ParameterSpec> hit_parameter_rows() {
  std::vector<ParameterSpec> rows{of_row()};
  const std::size_t first = rows.size();
  rows.push_back(with_member(
      {.name = "local_point",
       .type = Type::kVectors,
       .unit = "m",
       .min = 1,
       .max = kMostHits,
       .low = -kFarPlace,
       .high = kFarPlace,
       .doc =
           "Points where the mesh is hit (for a hole or a chipped corner), measured from the file's origin. Each hit "
           "breaks only what is within its radius. A later hit cuts the pieces of earlier ones. Requires `local_radius`."},
      [](auto& r) -> auto& { return r.local_point; }));
  rows.push_back(with_member(
      {.name = "local_radius",
       .type = Type::kNumbers,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Radius of each hit: one number per hit, or one for all. Nothing is cut beyond 1.25 times the radius; parts "
           "entirely beyond the radius stay whole. With `stretch` or `stretch_matrix`, a hit is an ellipsoid, and the "
           "radius is its longest half-axis. Requires `local_point`."},
      [](auto& r) -> auto& { return r.local_radius; }));
  rows.push_back(with_member(
      {.name = "local_sites",
       .type = Type::kIntegers,
       .min = 1,
       .max = kMostHitSites,
       .doc =
           "Number of cells with which each hit cuts fragments: one number per hit, or one for all (at most 10,000 in "
           "total)."},
      [](auto& r) -> auto& { return r.local_sites; }));
  rows.push_back(with_member(
      {.name = "local_rest",
       .type = Type::kChoice,
       .choices = {"whole", "fractured"},
       .doc =
           "The pieces that the hits break. `whole`: the parts of the mesh. `fractured`: the pieces of the pattern. The "
           "rest of a piece that is hit keeps the piece's ID. `fractured` is always used if `of` names an answer "
           "without hits."},
      [](auto& r) -> auto& { return r.fracture.rest; }));
  for (std::size_t k = first; k < rows.size(); ++k) {
    rows[k].decides = Decides::kSites;
    rows[k].matters = [](const RequestParameters& r) { return !r.local_point.empty(); };
  }
  rows.push_back(with_member(
      {.name = "delta",
       .type = Type::kChoice,
       .choices = {"none", "stated", "only"},
       .doc =
           "How the answer reports the changes that the new hits made. `none`: not at all. `stated`: the report lists new, "
           "changed and removed fragments, and the server keeps the answer for further hits. This is the default "
           "with `of` and hits. `only`: like `stated`, but the answer contains only new and changed fragments. Not with "
           "`levels`."},
      [](auto& r) -> auto& { return r.delta; }));
  rows.push_back(with_member(
      {.name = "local_new",
       .type = Type::kInteger,
       .min = 1,
       .max = kMostHits,
       .doc =
           "Number of points at the end of `local_point` that are new hits. Only with `delta` and without `of`."},
      [](auto& r) -> auto& { return r.local_new; }));
  rows[rows.size() - 2].matters = [](const RequestParameters& r) { return r.delta != DeltaAnswer::kNone; };
  rows.back().matters = [](const RequestParameters& r) {
    return r.delta != DeltaAnswer::kNone && !r.local_point.empty();
  };
  return rows;
}

std::optional<Error> complete_hits(RequestParameters& r) {
  FractureParameters& f = r.fracture;
  if (r.local_point.empty() != r.local_radius.empty())
    return r.local_point.empty()
               ? bad_parameter("local_point",
                               "'local_radius' requires 'local_point': the position of each hit, in metres.")
               : bad_parameter("local_radius",
                               "'local_point' requires 'local_radius': how far each hit reaches, in metres.");
  const std::size_t points = r.local_point.size();
  if (points > 0) {
    if (auto wrong = spread("local_radius", r.local_radius, points)) return wrong;
    if (auto wrong = spread("local_sites", r.local_sites, points)) return wrong;
    const std::uint64_t sites = std::accumulate(r.local_sites.begin(), r.local_sites.end(), std::uint64_t{0});
    if (sites > kMostHitSites)
      return bad_parameter("local_sites", "All hits together can have at most " + grouped(kMostHitSites) +
                                              " sites, but 'local_sites' gives them " + grouped(sites) +
                                              ". Lower 'local_sites'.");
  }
  f.hits.clear();
  for (std::size_t k = 0; k < points; ++k)
    f.hits.push_back({r.local_point[k], r.local_radius[k], static_cast<std::uint32_t>(r.local_sites[k])});
  r.selection.kept = false;
  r.selection.new_hits.reset();
  if (!r.of.empty() || r.delta == DeltaAnswer::kNone) return std::nullopt;

  if (points == 0 && r.delta == DeltaAnswer::kOnly)
    return bad_parameter(
        "delta",
        "delta=only leaves out the fragments that the hits did not change, so it requires hits. Give 'local_point'.");
  if (points > 0 && r.local_new > points)
    return bad_parameter("local_new", "'local_new' must be at most the number of hits, which is " +
                                          std::to_string(points) + ".");
  if (r.fragment)
    return bad_parameter(
        "delta",
        "'delta' compares whole answers, so it cannot be used with 'fragment'. Leave one of the two out.");
  if (r.delta == DeltaAnswer::kOnly && !f.levels.empty())
    return bad_parameter(
        "delta", "The hierarchy of 'levels' needs fragments that delta=only leaves out. Use delta=stated.");
  r.selection.kept = true;
  if (points > 0) r.selection.new_hits = NewHits{r.local_new, r.delta == DeltaAnswer::kOnly};
  return std::nullopt;
}

}  // namespace fracture
