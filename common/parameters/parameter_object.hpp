// Parameters as the text of a JSON object in a request, a cached answer or a stored job. Strangers may have written any of these
// texts, so a single reader with a single set of limits reads them all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/base/json_reader.hpp"
#include "common/parameters/parameters.hpp"

namespace fracture {

/// Nesting depth of arrays and objects; a list of vectors needs three levels.
inline constexpr std::uint32_t kParameterDepth = 8;

struct ParameterTextLimits {
  std::size_t text;  ///< bytes
  std::size_t held;  ///< bytes of memory that the parsed object may use
};
/// Enough for about 30,000 points, which use half of the memory when parsed.
inline constexpr ParameterTextLimits kOfRequest{1u << 20, 8u << 20};
/// The canonical form of such a request writes numbers in full: `9e5` becomes `900000.0`.
inline constexpr ParameterTextLimits kOfKept{4u << 20, 16u << 20};

/// The maximum number of sites that any server can be configured to allow (--max-sites).
inline constexpr std::uint32_t kMostSitesAnywhere = 10'000'000;

/// Returns the names and values of a JSON object, in the order of the text. Errors point to `params`. The
/// error is kBadJson if the text is too long, is not a single object, is nested too deeply or needs too
/// much memory. It is kBadParameter if a member is repeated, because a JSON parser would silently keep only
/// one of its values. `what` is the text's name in error messages, such as "part 'params'".
Expected<std::vector<RawParameter>> read_parameters(std::string_view text, std::string_view what);

/// Reads an answer's parameters in canonical form, from a place to which others may have written. Returns
/// nothing if the text is not a JSON object within kOfKept, or if no server accepts the parameters in a
/// request.
std::optional<nlohmann::json> read_kept_parameters(std::string_view text);

/// Whether any server accepts these parameters in a request that refers to no earlier answer. False if the
/// value is not an object.
bool are_parameters(const nlohmann::json& value);

/// Returns the members of an object as parameters.
std::vector<RawParameter> raw_parameters(const nlohmann::json& object);

}  // namespace fracture
