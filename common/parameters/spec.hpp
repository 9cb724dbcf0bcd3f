// One parameter of a request: its range, its meaning and its place in RequestParameters.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/matrix3.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/part_selector.hpp"

namespace fracture {

struct RequestParameters;
struct ParameterSpec;

/// A value from the request: text from a query or a form field, or a JSON value.
struct RawParameter {
  std::string name;
  nlohmann::json value;  ///< a string if it was sent as text
  bool is_text =
      true;  ///< text is converted ("50" is a number); JSON values must already have the right type
};

/// An entry of `assign`: the parts that it chooses, and their parameters, which are not checked yet.
struct RawAssignment {
  PartSelector selector{};
  std::vector<RawParameter> parameters{};
};
/// Maximum number of entries of `assign`.
inline constexpr std::size_t kMostAssignments = 64;

/// A value that has passed its checks. A choice is stored as an index into `choices`.
using ParameterValue =
    std::variant<std::uint64_t, double, std::string, std::vector<std::string>, Vec3d, std::vector<Vec3d>,
                 Matrix3, std::vector<std::uint64_t>, std::vector<double>, std::vector<RawAssignment>>;

/// Maximum number of values in a list.
inline constexpr std::size_t kMaxIntegers = 10'000;
/// Maximum number of bytes in a text, unless its row specifies another.
inline constexpr std::size_t kMaxText = 63;

/// The result that a parameter determines. Each cache key contains only the parameters that determine the cached value.
enum class Decides { kSolid, kSites, kAnswer };

struct ParameterSpec {
  enum class Type {
    kInteger,      ///< whole number from min to max
    kIntegers,     ///< up to kMaxIntegers whole numbers from min to max: text a,b,c, a JSON array or number
    kNumber,       ///< finite number from low to high
    kNumbers,      ///< up to kMaxIntegers numbers, in the same forms as kIntegers
    kChoice,       ///< one of choices
    kNames,        ///< names separated by commas; in JSON, an array of strings or the same text
    kText,         ///< 1 to max (0: kMaxText) bytes of UTF-8
    kColor,        ///< sRGB as "#rrggbb"
    kVector,       ///< three numbers from low to high: text x,y,z or a JSON array
    kDirection,    ///< a vector that is not zero
    kVectors,      ///< min to max vectors: text x,y,z;x,y,z or a JSON array of arrays (or one vector)
    kMatrix,       ///< three rows of three numbers, in the same forms as kVectors
    kAssignments,  ///< up to kMostAssignments entries (assignments.hpp)
  };
  std::string name;
  Type type = Type::kInteger;
  std::string unit{};  ///< "m", "kg/m³", …; empty: none
  std::uint64_t min = 0, max = 0;
  std::size_t longest_text() const { return max > 0 ? static_cast<std::size_t>(max) : kMaxText; }
  double low = 0, high = 0;
  std::vector<std::string> choices{};
  std::string doc{};
  Decides decides = Decides::kAnswer;
  /// Names of the patterns that the parameter belongs to; empty: all patterns.
  std::vector<std::string> patterns{};
  /// Null if the parameter has no default, or if its default depends on the mesh or the pattern (see doc).
  nlohmann::json default_value{};

  /// A further check. If it fails, it returns the end of the sentence "'name' must …", which to_value() completes to an error
  /// message with the name and the value.
  std::function<std::optional<std::string>(const ParameterValue&)> check{};
  std::function<void(RequestParameters&, const ParameterSpec&, const ParameterValue&)> set{};
  /// Returns the canonical value; null means that the parameter was not given. Called only if the parameter
  /// belongs to the pattern.
  std::function<nlohmann::json(const RequestParameters&, const ParameterSpec&)> get{};
  /// Whether the value has an effect in this request. If not, the canonical form omits it. Empty: it always has one.
  std::function<bool(const RequestParameters&)> matters{};
};

}  // namespace fracture
