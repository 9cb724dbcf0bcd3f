// Parameters as the text of one JSON object, in a request, in a cached answer or in a job on the disk. Strangers may have written any
// of these texts, so one reader with one set of limits reads all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/base/json_reader.hpp"
#include "common/parameters/parameters.hpp"

namespace fracture {

/// Levels of arrays and objects; a list of vectors needs three.
inline constexpr std::uint32_t kParameterDepth = 8;

struct ParameterTextLimits {
  std::size_t text;  ///< bytes
  std::size_t held;  ///< bytes of memory that the parsed object may hold
};
/// About 30,000 points. Parsed points use half of the memory.
inline constexpr ParameterTextLimits kOfRequest{1u << 20, 8u << 20};
/// The canonical form of such a request writes numbers in full: `9e5` becomes `900000.0`.
inline constexpr ParameterTextLimits kOfKept{4u << 20, 16u << 20};

/// The most sites that any server can be told to allow (--max-sites).
inline constexpr std::uint32_t kMostSitesAnywhere = 10'000'000;

/// Names and values of a JSON object, in the order of the text. Errors, about `params`: kBadJson for text that is too long, is not
/// one object, is nested too deeply or needs too much memory; kBadParameter for a repeated member, because a JSON parser would
/// silently keep one of them. `what` names the text in errors: "part 'params'".
Expected<std::vector<RawParameter>> read_parameters(std::string_view text, std::string_view what);

/// The parameters of an answer from a place where others may have written, in their canonical form, whose types are known.
/// Nothing if the text is not a JSON object within kOfKept, or if no server accepts the parameters in a request.
std::optional<nlohmann::json> read_kept_parameters(std::string_view text);

/// Whether some server accepts these parameters in a request, without an earlier answer. False for a value that is not an object.
bool are_parameters(const nlohmann::json& value);

/// The members of an object as parameters.
std::vector<RawParameter> raw_parameters(const nlohmann::json& object);

}  // namespace fracture
