#include "common/parameters/parameters.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "common/base/bulk.hpp"
#include "common/base/nearest_name.hpp"
#include "common/parameters/assignments.hpp"
#include "common/parameters/effects.hpp"
#include "common/parameters/groups.hpp"
#include "common/parameters/rows.hpp"
#include "common/parameters/values.hpp"

namespace fracture {
namespace {

/// Rows for canonical forms, which do not depend on a server's limits.
const std::vector<ParameterSpec>& rows() {
  static const std::vector<ParameterSpec> all = parameter_rows(1, FormatSet());
  return all;
}

/// `with_idle`: whether to include parameters that do not matter but that the report mentions.
template <class Wanted>
nlohmann::json canonical(const RequestParameters& parameters, bool with_idle, const Wanted& wanted) {
  nlohmann::json json = nlohmann::json::object();
  std::optional<RequestParameters> baseline;
  for (const ParameterSpec& row : rows()) {
    if (!wanted(row) || !belongs(row, parameters.fracture.pattern)) continue;
    const bool matters = !row.matters || row.matters(parameters);
    if (!matters && !(with_idle && has_effect_check(row.name))) continue;
    nlohmann::json value = row.get(parameters, row);
    if (!matters) {
      if (!baseline) baseline = baseline_of(parameters);
      if (value == row.get(*baseline, row)) continue;
    }
    if (!value.is_null()) json[row.name] = std::move(value);
  }
  return json;
}

/// Limits for the error response, because a request can contain thousands of errors.
constexpr std::size_t kMostOffences = 16;

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

/// Bytes whose hashing takes about as long as comparing an unknown name with all names, and as reading an entry of `assign`.
constexpr std::size_t kUnknownAsHashed = 2u << 10, kEntryAsHashed = 4u << 10;

using Given = std::map<std::string, const RawParameter*>;

/// Returns the error text. Only the first such error says where all parameters are listed.
std::string unknown_parameter(const std::vector<std::string>& known, const std::string& name, bool first) {
  const std::optional<std::string> meant = parameter_meant_by(name, known);
  const std::string near = did_you_mean(name, known);
  // A synonym is better than names that are only spelt like it.
  const bool synonym = meant && near.find("'" + *meant + "'") == std::string::npos;
  return "'" + shown(name) + "' is not a parameter." + (synonym ? " Did you mean '" + *meant + "'?" : near) +
         (first ? " GET /limits and `fracture-server bake --help` list all " + std::to_string(known.size()) +
                      " parameters."
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

/// If a caller gives `impacts` but no pattern, the mesh should break there. So if the default pattern or the
/// material's own pattern has no impacts, the pattern becomes impact.
void choose_impact(SitePattern& pattern, bool of_material) {
  if (!std::holds_alternative<UniformPattern>(pattern) && !std::holds_alternative<ClusteredPattern>(pattern))
    return;
  ImpactPattern impact;
  if (of_material) {
    impact.exponent = 1.5;
    impact.share = 0.55;
  }
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

/// Parses one request.
class ParameterTable::Parsing {
 public:
  explicit Parsing(const ParameterTable& table) : table_(table) {}

  Expected<RequestParameters> run(const std::vector<RawParameter>& given) {
    Given seen;
    Values values;
    for (const RawParameter& raw : given) read(raw, "", seen, values);
    RequestParameters result = applied(values, seen, {});
    check(values, seen, result);
    if (const auto assign = values.find("assign"); assign != values.end())
      add_assignments(std::get<std::vector<RawAssignment>>(assign->second), values, result);
    if (!offences_.any())
      if (std::optional<Error> wrong = complete_structure(result))
        offences_.add_missing(wrong->pointer, std::move(wrong->detail));
    if (offences_.any()) return tl::unexpected<Error>(std::move(offences_).error());
    return result;
  }

 private:
  using Values = std::map<std::string, ParameterValue>;

  /// Reads a parameter. `place`: of the entry of `assign` that contains it; empty: it is one of the request.
  void read(const RawParameter& raw, const std::string& place, Given& seen, Values& values) {
    const ParameterSpec* spec = table_.find(raw.name);
    if (!spec) {
      if (!offences_.full()) count_bulk(kUnknownAsHashed);
      if (names_.empty())
        for (const ParameterSpec& known : table_.specs_) names_.push_back(known.name);
      if (offences_.full())
        offences_.count();
      else
        add(ErrorCode::kUnknownParameter, raw, place, unknown_parameter(names_, raw.name, !offences_.any()));
      return;
    }
    if (!place.empty() && !is_assignable(raw.name))
      return add(
          ErrorCode::kBadParameter, raw, place,
          "'" + raw.name +
              "' is not a property of a material, so an entry of 'assign' cannot have it. Give it for the whole request.");
    if (!seen.emplace(raw.name, &raw).second)
      return add(ErrorCode::kBadParameter, raw, place,
                 "'" + raw.name + "' was given more than once. Give it once.");
    Expected<ParameterValue> value = to_value(*spec, raw);
    if (value)
      values.emplace(raw.name, std::move(*value));
    else
      add(value.error().code, raw, place, std::move(value.error().detail), value.error().pointer);
  }

  void add(ErrorCode code, const RawParameter& raw, const std::string& place, std::string detail,
           const std::string& inside = {}) {
    if (place.empty()) return offences_.add(code, raw, std::move(detail), inside);
    const std::string entry = "Entry " + std::to_string(1 + std::stoul(place.substr(1))) + " of 'assign': ";
    offences_.add(code, {"assign", {}, false}, entry + detail, place + "/" + raw.name + inside);
  }

  /// Applies values in the order of the table: the material, then the pattern, then the pattern's parameters. Parameters that are
  /// not in `seen` come from the request around an entry, and have no effect if the pattern has no such parameter.
  RequestParameters applied(const Values& values, const Given& seen, const std::string& place) {
    RequestParameters result;
    result.fracture.most_sites = static_cast<std::uint32_t>(table_.find("sites")->max);
    for (const ParameterSpec& spec : table_.specs_) {
      const auto value = values.find(spec.name);
      if (value == values.end()) continue;
      if (spec.name == "impacts" && !values.contains("pattern"))
        choose_impact(result.fracture.pattern, values.contains("material"));
      if (!belongs(spec, result.fracture.pattern)) {
        const auto own = seen.find(spec.name);
        const bool of_entries = spec.name == "impacts" && values.contains("assign");
        if (own != seen.end() && !of_entries)
          add(ErrorCode::kBadParameter, *own->second, place,
              "'" + spec.name + "' belongs to the " + join(spec.patterns) + " pattern, but this " +
                  (place.empty() ? "request" : "entry of 'assign'") + " uses the " +
                  kPatternTraits[result.fracture.pattern.index()].name + " pattern. Leave '" + spec.name +
                  "' out, or change 'pattern'.");
        continue;
      }
      spec.set(result, spec, value->second);
    }
    if (const std::uint32_t wanted = result.fracture.size.fragments; wanted > 0)
      if (!values.contains("sites") && belongs(*table_.find("sites"), result.fracture.pattern))
        result.fracture.sites = wanted;
    check_grain(seen);
    if (const auto* points = std::get_if<PointsPattern>(&result.fracture.pattern)) {
      if (points->points.empty() && seen.count("points") == 0)
        offences_.add_missing(
            "points", "The points pattern needs 'points': " + expectation(*table_.find("points")) + ".");
      result.fracture.sites = static_cast<std::uint32_t>(points->points.size());
    }
    return result;
  }

  void check_grain(const Given& seen) {
    refuse_both(offences_, seen, "stretch_matrix", "stretch",
                "the matrix includes the stretch. Leave one of them out.");
    refuse_both(offences_, seen, "stretch_matrix", "grain",
                "the matrix includes the grain. Leave one of them out.");
    refuse_both(offences_, seen, "stretch_matrix", "grain_of",
                "the matrix includes the grain. Leave one of them out.");
    refuse_both(offences_, seen, "grain", "grain_of",
                "'grain' sets one direction for the whole mesh. Leave one of them out.");
  }

  /// Checks what concerns the whole request.
  void check(const Values& values, const Given& seen, const RequestParameters& result) {
    if (result.fracture.size.fragments > 0) {
      refuse_both(offences_, seen, "fragments", "levels",
                  "the last level sets the number. Leave one of them out.");
      if (result.fracture.dual == Dual::kBarycenter)
        refuse_both(offences_, seen, "fragments", "dual",
                    "barycentric cells cannot be merged. Leave one of them out.");
    }
    if (result.solid.thickness > 0 && result.solid.sheets != SheetsMode::kSolid)
      refuse_both(offences_, seen, "thickness", "sheets",
                  "a thickness needs sheets=solid. Leave one of them out, or use sheets=solid.");
    refuse_both(offences_, seen, "mass", "density", "each determines the other. Leave one of them out.");
    if (result.exterior.choice == ExteriorChoice::kMaterial && result.material.empty() && result.of.empty() &&
        !values.contains("assign"))
      offences_.add_missing(
          "exterior",
          "'exterior' is 'material', but no 'material' is given. Give one, or leave 'exterior' out.");
    // An answer's parameters contain both, and a client may send them again.
    const auto levels = values.find("levels"), sites = values.find("sites");
    if (levels != values.end() && sites != values.end() &&
        std::get<std::vector<std::uint64_t>>(levels->second).back() != std::get<std::uint64_t>(sites->second))
      refuse_both(offences_, seen, "levels", "sites",
                  "the last level is the number of sites. Leave 'sites' out.");
    if (values.contains("assign") && !(result.physical.bond_strength > 0))
      offences_.add_missing(
          "bond_strength",
          "'bond_strength' must be above 0 with 'assign', because the strengths of entries are relative to "
          "it. Give 1 instead of 0.");
  }

  /// Adds the entries of `assign`. Each starts from the parameters of the request that no material sets.
  void add_assignments(const std::vector<RawAssignment>& entries, const Values& request,
                       RequestParameters& result) {
    for (std::size_t k = 0; k < entries.size(); ++k) {
      count_bulk(kEntryAsHashed);
      Given seen;
      Values values;
      const std::string place = "/" + std::to_string(k);
      for (const RawParameter& raw : entries[k].parameters) read(raw, place, seen, values);
      Assignment assignment{.selector = entries[k].selector};
      for (const auto& [name, raw] : seen) assignment.given.push_back(name);
      for (const auto& [name, value] : request)
        if (name != "assign" && is_inherited(name)) values.emplace(name, value);
      auto own = std::make_shared<RequestParameters>(applied(values, seen, place));
      drop_aggregation(*own);
      result.fracture.assigned.push_back(
          {.selector = assignment.selector,
           .breaks = std::make_shared<const FractureParameters>(own->fracture),
           .density = own->physical.density / result.physical.density,
           .strength = own->physical.bond_strength / result.physical.bond_strength});
      result.hollow.by_part.push_back({.selector = assignment.selector,
                                       .thickness = own->hollow.thickness,
                                       .fraction = own->hollow.fraction,
                                       .least_ball = own->hollow.least_ball});
      assignment.parameters = std::move(own);
      result.assign.push_back(std::move(assignment));
    }
    if (!result.hollow.any()) result.hollow.by_part.clear();
  }

  const ParameterTable& table_;
  Offences offences_;
  std::vector<std::string> names_;  // of all parameters; filled when a name is unknown
};

Expected<RequestParameters> ParameterTable::parse(const std::vector<RawParameter>& given) const {
  return Parsing(*this).run(given);
}

nlohmann::json canonical_solid_parameters(const RequestParameters& parameters) {
  nlohmann::json json =
      canonical(parameters, false, [](const ParameterSpec& row) { return row.decides == Decides::kSolid; });
  // A material with its walls turned off is equivalent to a material without walls.
  if (!(parameters.hollow.fraction > 0)) json.erase("shell_fraction");
  if (!parameters.hollow.by_part.empty()) json["assign"] = walls_as_assignments(parameters.hollow);
  return json;
}

nlohmann::json canonical_site_parameters(const RequestParameters& parameters) {
  nlohmann::json json =
      canonical(parameters, false, [](const ParameterSpec& row) { return row.decides == Decides::kSites; });
  // Barycentric cells have no frames and keep no region, so only then do they have other sites.
  const FractureParameters& fracture = parameters.fracture;
  if (fracture.dual == Dual::kBarycenter &&
      (fracture.keep || std::holds_alternative<RadialPattern>(fracture.pattern)))
    json["dual"] = "barycenter";
  return json;
}

RequestParameters baseline_of(const RequestParameters& parameters) {
  RequestParameters baseline;
  const auto set = [&](std::string_view name, std::size_t choice) {
    const auto row = std::find_if(rows().begin(), rows().end(),
                                  [&](const ParameterSpec& spec) { return spec.name == name; });
    row->set(baseline, *row, std::uint64_t{choice});
  };
  if (const MaterialPreset* preset = find_material_preset(parameters.material))
    set("material", static_cast<std::size_t>(preset - material_presets().data()));
  set("pattern", parameters.fracture.pattern.index());
  return baseline;
}

nlohmann::json canonical_parameters(const RequestParameters& parameters) {
  return canonical(parameters, true, [](const ParameterSpec&) { return true; });
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
    drop_aggregation(base);  // as in the request without these hits
  }
  // Without the parameters of the support analysis, which change from hit to hit.
  return canonical(base, false,
                   [](const ParameterSpec& row) { return row.name != "broken" && row.name != "gravity"; });
}

}  // namespace fracture
