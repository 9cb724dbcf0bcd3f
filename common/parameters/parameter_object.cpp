#include "common/parameters/parameter_object.hpp"

#include <string>
#include <utility>

#include "common/base/words.hpp"

namespace fracture {
namespace {

/// The table with the widest limits, because a server with lower limits may read parameters that another server stored.
const ParameterTable& widest_table() {
  static const ParameterTable table(kMostSitesAnywhere, FormatSet::all());
  return table;
}

/// Returns nothing for parameters that no server accepts, and for `of`: stored parameters contain those of
/// the earlier answer instead.
std::optional<RequestParameters> parsed(const nlohmann::json& object) {
  auto parameters = widest_table().parse(raw_parameters(object));
  if (!parameters || !parameters->of.empty()) return std::nullopt;
  return std::move(*parameters);
}

}  // namespace

Expected<std::vector<RawParameter>> read_parameters(std::string_view text, std::string_view what) {
  const std::string subject = "The " + std::string(what);
  if (text.size() > kOfRequest.text)
    return fail(ErrorCode::kBadJson,
                subject + " has " + counted(text.size(), "byte", "bytes") + "; the limit is " +
                    grouped(kOfRequest.text) + ". Give fewer or shorter parameters.",
                "params");
  auto read = read_json(text, {.depth = kParameterDepth, .bytes = kOfRequest.held});
  if (!read && read.error().kind == JsonFault::Kind::kRepeated)
    return fail(ErrorCode::kBadParameter, subject + " " + to_text(read.error()) + ".", read.error().name);
  if (!read && read.error().kind == JsonFault::Kind::kTooLarge)
    return fail(ErrorCode::kBadJson, subject + " " + to_text(read.error()) + ".", "params");
  if (!read || !read->value.is_object())
    return fail(ErrorCode::kBadJson,
                subject + " " + (read ? std::string("is not a JSON object") : to_text(read.error())) +
                    ". It must be a single JSON object such as {\"sites\": 50, \"seed\": 1}.",
                "params");
  std::vector<RawParameter> given;
  given.reserve(read->members.size());
  for (const std::string& name : read->members) given.push_back({name, std::move(read->value[name]), false});
  return given;
}

std::optional<nlohmann::json> read_kept_parameters(std::string_view text) {
  if (text.size() > kOfKept.text) return std::nullopt;
  const auto read = read_json(text, {.depth = kParameterDepth, .bytes = kOfKept.held});
  if (!read || !read->value.is_object()) return std::nullopt;
  const auto parameters = parsed(read->value);
  if (!parameters) return std::nullopt;
  return canonical_parameters(*parameters);
}

bool are_parameters(const nlohmann::json& value) { return value.is_object() && parsed(value).has_value(); }

std::vector<RawParameter> raw_parameters(const nlohmann::json& object) {
  std::vector<RawParameter> given;
  given.reserve(object.size());
  for (const auto& [name, value] : object.items()) given.push_back({name, value, false});
  return given;
}

}  // namespace fracture
