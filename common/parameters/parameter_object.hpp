// Parameters as the text of one JSON object: of a request, of an answer that a cache has kept, of a job on the disk.
// Whoever wrote the text is a stranger, so one reader with one set of limits reads all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/base/json_reader.hpp"
#include "common/parameters/parameters.hpp"

namespace fracture {

/// Arrays and objects within one another: a list of vectors needs three.
inline constexpr std::uint32_t kParameterDepth = 8;

struct ParameterTextLimits {
  std::size_t text;  ///< bytes
  std::size_t held;  ///< bytes of memory that the parsed object may hold
};
/// About 30,000 points, which hold half of it when they are parsed.
inline constexpr ParameterTextLimits kOfRequest{1u << 20, 8u << 20};
/// The canonical form of such a request writes numbers in full: `9e5` becomes `900000.0`.
inline constexpr ParameterTextLimits kOfKept{4u << 20, 16u << 20};

/// The most sites that any server can be told to allow (--max-sites).
inline constexpr std::uint32_t kMostSitesAnywhere = 10'000'000;

/// Names and values of a JSON object, in the order of the text. Errors, about `params`: kBadJson for text that is too
/// long, that is not one object, or that is nested too deeply or holds too much; kBadParameter for a member given twice, of
/// which a JSON parser would silently keep one. `what` names the text in errors: "part 'params'".
Expected<std::vector<RawParameter>> read_parameters(std::string_view text, std::string_view what);

/// The parameters of an answer from a place where others may have written, in their canonical form, whose types are known.
/// Nothing for what is no JSON object within kOfKept, and for parameters that no server accepts in a request.
std::optional<nlohmann::json> read_kept_parameters(std::string_view text);

/// Whether some server accepts these parameters in a request, without an earlier answer. False for a value that is not an object.
bool are_parameters(const nlohmann::json& value);

/// The members of an object as parameters.
std::vector<RawParameter> raw_parameters(const nlohmann::json& object);

}  // namespace fracture
