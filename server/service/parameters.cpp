#include "server/service/parameters.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <utility>

namespace fracture {
namespace {

constexpr MeshFormat kAllFormats[] = {
    MeshFormat::kGlb, MeshFormat::kGltf,  MeshFormat::kObj, MeshFormat::kStl, MeshFormat::kPly,
    MeshFormat::kOff, MeshFormat::kBlend, MeshFormat::kFbx, MeshFormat::kDae, MeshFormat::k3ds};

std::string join(const std::vector<std::string>& words) {
  std::string s;
  for (std::size_t i = 0; i < words.size(); ++i)
    s += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return s;
}

/// The value as a person typed it, short enough for an error message and free of control characters.
std::string shown(const nlohmann::json& value) {
  if (value.is_structured())
    return value.is_array() ? "an array" : "an object";  // dump() recurses: never on depth
  std::string s = value.is_string() ? value.get<std::string>() : value.dump();
  if (s.size() > 40) s = s.substr(0, 40) + "...";
  for (char& c : s)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return s;
}

std::optional<std::uint64_t> to_integer(const RawParameter& raw) {
  if (!raw.is_text) {
    const bool whole = raw.value.is_number_unsigned() ||
                       (raw.value.is_number_integer() && raw.value.get<std::int64_t>() >= 0);
    return whole ? std::optional(raw.value.get<std::uint64_t>()) : std::nullopt;
  }
  const auto& text = raw.value.get_ref<const std::string&>();
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return number;
}

std::string expectation(const ParameterSpec& spec) {
  if (spec.type == ParameterSpec::Type::kChoice) return "must be " + join(spec.choices);
  return "must be a whole number from " + std::to_string(spec.min) + " to " + std::to_string(spec.max);
}

}  // namespace

FormatSet::FormatSet() {
  for (const MeshFormat format : kAllFormats)
    if (enabled_by_default(format)) formats_.push_back(format);
}

FormatSet FormatSet::all() {
  FormatSet set;
  set.formats_.assign(std::begin(kAllFormats), std::end(kAllFormats));
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

ParameterTable::ParameterTable(std::uint32_t max_sites, FormatSet formats) : formats_(std::move(formats)) {
  using Type = ParameterSpec::Type;
  const FractureParameters defaults;
  specs_ = {
      {.name = "sites",
       .type = Type::kInteger,
       .min = 1,
       .max = max_sites,
       .default_value = defaults.sites,
       .doc = "How many random Voronoi sites are placed uniformly inside the solid."},
      {.name = "seed",
       .type = Type::kInteger,
       .min = 0,
       .max = kMaxSeed,
       .default_value = defaults.seed,
       .doc = "Seed of the random sites: the same seed gives the same bytes."},
      {.name = "dual",
       .type = Type::kChoice,
       .choices = {"circumcenter", "barycenter"},
       .default_value = "circumcenter",
       .doc = "circumcenter: Voronoi cells, an exact partition. barycenter: hulls of the tetrahedra's "
              "barycentres, "
              "a softer look that is no partition."},
      {.name = "format",
       .type = Type::kChoice,
       .choices = formats_.names(),
       .doc = "Format of the mesh, where the Content-Type does not say it."},
  };
}

const ParameterSpec* ParameterTable::find(std::string_view name) const {
  for (const ParameterSpec& spec : specs_)
    if (spec.name == name) return &spec;
  return nullptr;
}

Expected<RequestParameters> ParameterTable::parse(const std::vector<RawParameter>& given) const {
  RequestParameters result;
  std::optional<Error> first;
  nlohmann::json offenders = nlohmann::json::array();
  const auto offend = [&](ErrorCode code, const RawParameter& raw, std::string detail) {
    const std::string name = shown(raw.name);
    nlohmann::json entry = {{"detail", detail}};
    entry[raw.is_text ? "parameter" : "pointer"] = raw.is_text ? name : "/" + name;
    offenders.push_back(std::move(entry));
    if (!first) first = Error{code, std::move(detail), name};
  };

  std::set<std::string> seen;
  for (const RawParameter& raw : given) {
    const ParameterSpec* spec = find(raw.name);
    if (!spec) {
      std::vector<std::string> known;
      for (const ParameterSpec& s : specs_) known.push_back(s.name);
      offend(ErrorCode::kUnknownParameter, raw,
             "There is no parameter '" + shown(raw.name) + "'. The parameters are " + join(known) + ".");
      continue;
    }
    if (!seen.insert(raw.name).second) {
      offend(ErrorCode::kBadParameter, raw, "'" + raw.name + "' was given more than once.");
      continue;
    }
    const std::string complaint =
        "'" + raw.name + "' " + expectation(*spec) + "; it was '" + shown(raw.value) + "'.";
    if (spec->type == ParameterSpec::Type::kInteger) {
      const std::optional<std::uint64_t> number = to_integer(raw);
      if (!number || *number < spec->min || *number > spec->max) {
        offend(ErrorCode::kBadParameter, raw, complaint);
        continue;
      }
      if (raw.name == "sites") result.fracture.sites = static_cast<std::uint32_t>(*number);
      if (raw.name == "seed") result.fracture.seed = *number;
    } else {
      std::string choice = raw.value.is_string() ? raw.value.get<std::string>() : std::string();
      if (raw.name == "format")  // file endings come in both cases: part.STL
        for (char& c : choice)
          if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
      if (std::find(spec->choices.begin(), spec->choices.end(), choice) == spec->choices.end()) {
        offend(raw.name == "format" ? ErrorCode::kUnknownFormat : ErrorCode::kBadParameter, raw, complaint);
        continue;
      }
      if (raw.name == "dual")
        result.fracture.dual = choice == "barycenter" ? Dual::kBarycenter : Dual::kCircumcenter;
      if (raw.name == "format") result.format = format_from_extension(choice);
    }
  }
  if (first) {
    first->extra = {{"errors", std::move(offenders)}};
    return tl::unexpected<Error>(std::move(*first));
  }
  return result;
}

nlohmann::json ParameterTable::to_json() const {
  nlohmann::json list = nlohmann::json::array();
  for (const ParameterSpec& spec : specs_) {
    nlohmann::json entry = {{"name", spec.name}, {"description", spec.doc}};
    if (!spec.default_value.is_null()) entry["default"] = spec.default_value;
    if (spec.type == ParameterSpec::Type::kInteger) {
      entry["type"] = "integer";
      entry["minimum"] = spec.min;
      entry["maximum"] = spec.max;
    } else {
      entry["type"] = "string";
      entry["enum"] = spec.choices;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

nlohmann::json canonical_parameters(const FractureParameters& parameters) {
  return {{"dual", parameters.dual == Dual::kBarycenter ? "barycenter" : "circumcenter"},
          {"seed", parameters.seed},
          {"sites", parameters.sites}};
}

}  // namespace fracture
