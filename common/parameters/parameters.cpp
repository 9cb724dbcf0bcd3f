#include "common/parameters/parameters.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "common/parameters/groups.hpp"
#include "common/parameters/nearest_name.hpp"
#include "common/parameters/rows.hpp"
#include "common/parameters/values.hpp"

namespace fracture {
namespace {

/// Rows for canonical forms, which do not depend on a server's limits.
const std::vector<ParameterSpec>& rows() {
  static const std::vector<ParameterSpec> all = parameter_rows(1, FormatSet());
  return all;
}

template <class Wanted>
nlohmann::json canonical(const RequestParameters& parameters, const Wanted& wanted) {
  nlohmann::json json = nlohmann::json::object();
  for (const ParameterSpec& row : rows()) {
    if (!wanted(row) || !belongs(row, parameters.fracture.pattern)) continue;
    if (row.matters && !row.matters(parameters)) continue;
    nlohmann::json value = row.get(parameters, row);
    if (!value.is_null()) json[row.name] = std::move(value);
  }
  return json;
}

/// Limits for the error response, because a request can contain thousands of errors.
constexpr std::size_t kMostOffences = 16, kMostNames = 20;

/// Collects the errors of a request.
class Offences {
 public:
  void add(ErrorCode code, const RawParameter& raw, std::string detail, const std::string& inside = {}) {
    if (!another()) return;
    const std::string name = shown(raw.name);
    nlohmann::json entry = {{"detail", detail}};
    entry[raw.is_text ? "parameter" : "pointer"] = raw.is_text ? name : "/" + name + inside;
    entries_.push_back(std::move(entry));
    if (!first_) first_ = Error{code, std::move(detail), name};
  }
  /// Adds an error about a parameter that is missing.
  void add_missing(const std::string& name, std::string detail) {
    if (!another()) return;
    entries_.push_back({{"detail", detail}, {"parameter", name}});
    if (!first_) first_ = Error{ErrorCode::kBadParameter, std::move(detail), name};
  }
  bool any() const { return first_.has_value(); }
  /// Whether the list is full; further errors are only counted.
  bool full() const { return entries_.size() >= kMostOffences; }
  void count() { ++more_; }
  Error error() && {
    nlohmann::json figures = {{"errors", std::move(entries_)}};
    if (more_ > 0) figures["more_errors"] = more_;
    first_->extra = Figures(std::move(figures));
    return std::move(*first_);
  }

 private:
  bool another() {
    if (!full()) return true;
    count();
    return false;
  }

  std::size_t more_ = 0;
  std::optional<Error> first_;
  nlohmann::json entries_ = nlohmann::json::array();
};

using Given = std::map<std::string, const RawParameter*>;

/// Returns the error text. Only the first such error lists the nearest parameters.
std::string unknown_parameter(const std::vector<std::string>& known, const std::string& name, bool first) {
  const std::optional<std::string> nearest = parameter_meant_by(name, known);
  return "There is no parameter '" + shown(name) + "'." + (nearest || first ? " " : "") +
         (nearest ? "Did you mean '" + *nearest + "'?" : std::string()) + (nearest && first ? " " : "") +
         (first ? "The closest of the " + std::to_string(known.size()) + " parameters are " +
                      join(nearest_names(name, known, kMostNames)) +
                      "; GET /limits and `fracture-server bake --help` list all of them."
                : std::string());
}

/// Refuses two parameters that exclude each other.
void refuse_both(Offences& offences, const Given& given, const char* name, const char* other,
                 const char* why) {
  const auto it = given.find(name);
  if (it == given.end() || given.count(other) == 0) return;
  offences.add(ErrorCode::kBadParameter, *it->second,
               std::string("'") + name + "' and '" + other + "' were both given: " + why);
}

/// If a caller gives a material and `impacts`, it should break there. So if the material's own pattern has
/// no impacts, the pattern becomes impact.
void hit_material(SitePattern& pattern) {
  if (!std::holds_alternative<UniformPattern>(pattern) && !std::holds_alternative<ClusteredPattern>(pattern))
    return;
  ImpactPattern impact;
  impact.exponent = 1.5;
  impact.share = 0.55;
  pattern = impact;
}

}  // namespace

FormatSet::FormatSet() {
  for (const FormatInfo& info : all_formats())
    if (info.enabled_by_default) formats_.push_back(info.format);
}

FormatSet FormatSet::all() {
  FormatSet set;
  for (const FormatInfo& info : all_formats()) set.enable(info.format);
  return set;
}

void FormatSet::enable(MeshFormat format) {
  if (contains(format)) return;
  formats_.push_back(format);
  std::sort(formats_.begin(), formats_.end());
}

bool FormatSet::contains(MeshFormat format) const {
  return std::find(formats_.begin(), formats_.end(), format) != formats_.end();
}

std::vector<std::string> FormatSet::names() const {
  std::vector<std::string> names;
  for (const MeshFormat format : formats_) names.emplace_back(extension_of(format));
  return names;
}

ParameterTable::ParameterTable(std::uint32_t max_sites, FormatSet formats)
    : formats_(std::move(formats)), specs_(parameter_rows(max_sites, formats_)) {}

const ParameterSpec* ParameterTable::find(std::string_view name) const {
  for (const ParameterSpec& spec : specs_)
    if (spec.name == name) return &spec;
  return nullptr;
}

Expected<RequestParameters> ParameterTable::parse(const std::vector<RawParameter>& given) const {
  Offences offences;
  Given seen;
  std::vector<std::string> names;  // of all parameters; filled when a name is unknown
  std::map<std::string, ParameterValue> values;
  for (const RawParameter& raw : given) {
    const ParameterSpec* spec = find(raw.name);
    if (!spec) {
      if (names.empty())
        for (const ParameterSpec& known : specs_) names.push_back(known.name);
      if (offences.full())
        offences.count();
      else
        offences.add(ErrorCode::kUnknownParameter, raw, unknown_parameter(names, raw.name, !offences.any()));
      continue;
    }
    if (!seen.emplace(raw.name, &raw).second) {
      offences.add(ErrorCode::kBadParameter, raw,
                   "'" + raw.name + "' was given more than once. Give it once.");
      continue;
    }
    Expected<ParameterValue> value = to_value(*spec, raw);
    if (value)
      values.emplace(raw.name, std::move(*value));
    else
      offences.add(value.error().code, raw, std::move(value.error().detail), value.error().pointer);
  }

  // In the order of the table: the material, then the pattern, then the pattern's parameters.
  RequestParameters result;
  result.fracture.most_sites = static_cast<std::uint32_t>(find("sites")->max);
  for (const ParameterSpec& spec : specs_) {
    const auto value = values.find(spec.name);
    if (value == values.end()) continue;
    if (spec.name == "impacts" && values.contains("material") && !values.contains("pattern"))
      hit_material(result.fracture.pattern);
    if (!belongs(spec, result.fracture.pattern)) {
      offences.add(ErrorCode::kBadParameter, *seen.at(spec.name),
                   "'" + spec.name + "' belongs to the " + join(spec.patterns) +
                       " pattern, but this request uses the " +
                       kPatternTraits[result.fracture.pattern.index()].name + " pattern. Leave '" +
                       spec.name + "' out, or change 'pattern'.");
      continue;
    }
    spec.set(result, spec, value->second);
  }
  if (const std::uint32_t wanted = result.fracture.size.fragments; wanted > 0) {
    if (!values.contains("sites") && belongs(*find("sites"), result.fracture.pattern))
      result.fracture.sites = wanted;
    refuse_both(offences, seen, "fragments", "levels",
                "the last level sets the number. Leave one of them out.");
    if (result.fracture.dual == Dual::kBarycenter)
      refuse_both(offences, seen, "fragments", "dual",
                  "barycentric cells cannot be merged. Leave one of them out.");
  }
  refuse_both(offences, seen, "mass", "density", "each determines the other. Leave one of them out.");
  refuse_both(offences, seen, "stretch_matrix", "stretch",
              "the matrix includes the stretch. Leave one of them out.");
  refuse_both(offences, seen, "stretch_matrix", "grain",
              "the matrix includes the grain. Leave one of them out.");
  refuse_both(offences, seen, "stretch_matrix", "grain_of",
              "the matrix includes the grain. Leave one of them out.");
  refuse_both(offences, seen, "grain", "grain_of",
              "'grain' sets one direction for the whole mesh. Leave one of them out.");
  if (const auto* points = std::get_if<PointsPattern>(&result.fracture.pattern)) {
    if (points->points.empty() && seen.count("points") == 0)
      offences.add_missing("points",
                           "The points pattern needs 'points': " + expectation(*find("points")) + ".");
    result.fracture.sites = static_cast<std::uint32_t>(points->points.size());
  }
  if (result.exterior.choice == ExteriorChoice::kMaterial && result.material.empty() && result.of.empty())
    offences.add_missing(
        "exterior",
        "'exterior' is 'material', but no 'material' is given. Give one, or leave 'exterior' out.");
  // An answer's parameters contain both, and a client may send them again.
  const auto levels = values.find("levels"), sites = values.find("sites");
  if (levels != values.end() && sites != values.end() &&
      std::get<std::vector<std::uint64_t>>(levels->second).back() != std::get<std::uint64_t>(sites->second))
    refuse_both(offences, seen, "levels", "sites",
                "the last level is the number of sites. Leave 'sites' out.");
  if (!offences.any())
    if (std::optional<Error> wrong = complete_structure(result))
      offences.add_missing(wrong->pointer, std::move(wrong->detail));
  if (offences.any()) return tl::unexpected<Error>(std::move(offences).error());
  return result;
}

nlohmann::json canonical_solid_parameters(const RequestParameters& parameters) {
  nlohmann::json json =
      canonical(parameters, [](const ParameterSpec& row) { return row.decides == Decides::kSolid; });
  // A material with its walls turned off is equivalent to a material without walls.
  if (!(parameters.hollow.fraction > 0)) json.erase("shell_fraction");
  return json;
}

nlohmann::json canonical_site_parameters(const RequestParameters& parameters) {
  return canonical(parameters, [](const ParameterSpec& row) { return row.decides == Decides::kSites; });
}

nlohmann::json canonical_parameters(const RequestParameters& parameters) {
  return canonical(parameters, [](const ParameterSpec&) { return true; });
}

nlohmann::json canonical_base_parameters(const RequestParameters& parameters, bool hit) {
  RequestParameters base = parameters;
  base.delta = DeltaAnswer::kNone;
  if (!hit) {
    const std::size_t before =
        base.fracture.hits.size() - (base.selection.new_hits ? base.selection.new_hits->count : 0);
    base.local_point.resize(before);
    base.local_radius.resize(before);
    base.local_sites.resize(before);
  }
  // Without the parameters of the support analysis, which change from hit to hit.
  return canonical(base,
                   [](const ParameterSpec& row) { return row.name != "broken" && row.name != "gravity"; });
}

}  // namespace fracture
