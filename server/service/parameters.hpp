// What may be asked, in one table: it validates the query of a URL, a JSON object and the flags of `bake`,
// words the errors, fills GET /limits, and a test holds proto/openapi.yaml to it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/import/import.hpp"
#include "common/mesh/frame.hpp"
#include "common/mesh/selection.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Whole numbers go up to 2^53 - 1, so that they are exact in the JSON of every language.
inline constexpr std::uint64_t kMaxSeed = (1ull << 53) - 1;

struct ParameterSpec {
  enum class Type {
    kInteger,  ///< whole number from min to max
    kNumber,   ///< finite number from low to high
    kChoice,   ///< one of choices
    kNames,    ///< names separated by commas; in JSON an array of strings or such a text
    kText,     ///< 1 to 63 bytes of UTF-8
    kColor,    ///< sRGB as "#rrggbb"
  };
  std::string name;
  Type type = Type::kInteger;
  std::uint64_t min = 0, max = 0;
  double low = 0, high = 0;
  std::vector<std::string> choices{};
  nlohmann::json default_value{};  ///< null: no default
  std::string doc;
};

/// One given value: text from a query or a form field, or a JSON value.
struct RawParameter {
  std::string name;
  nlohmann::json value;  ///< a string when it came as text
  bool is_text =
      true;  ///< text is converted ("50" is a number); JSON values must already have the right type
};

struct RequestParameters {
  FrameOptions frame;
  PartSelection parts;  ///< sorted, each entry once
  SolidOptions solid;
  FractureParameters fracture;
  Physics physics = Physics::kKhr;
  UeCollision ue_collision = UeCollision::kNone;
  double density = 1000;  ///< kg/m³
  InteriorLook interior;
  std::string interior_color;        ///< as given, when interior.color is set
  std::optional<double> mass;        ///< kg, of all fragments; when given it decides the density
  std::optional<MeshFormat> format;  ///< as given by `format=`; nothing when absent
};

/// Which mesh formats a server reads.
class FormatSet {
 public:
  FormatSet();  ///< those that are enabled by default
  void enable(MeshFormat format);
  bool contains(MeshFormat format) const;
  const std::vector<MeshFormat>& formats() const { return formats_; }  ///< in the order of the enum
  std::vector<std::string> names() const;                              ///< their extensions
  static FormatSet all();

 private:
  std::vector<MeshFormat> formats_;
};

class ParameterTable {
 public:
  ParameterTable(std::uint32_t max_sites, FormatSet formats);

  const std::vector<ParameterSpec>& specs() const { return specs_; }
  const ParameterSpec* find(std::string_view name) const;
  const FormatSet& formats() const { return formats_; }

  /// Checks everything before it answers: the error carries each offender in extra.errors as {parameter |
  /// pointer, detail}; `Error::pointer` names the first. kUnknownParameter, kBadParameter (also: given
  /// twice), kUnknownFormat.
  Expected<RequestParameters> parse(const std::vector<RawParameter>& given) const;

  nlohmann::json to_json() const;

 private:
  FormatSet formats_;
  std::vector<ParameterSpec> specs_;
};

/// The one spelling of a request: sorted keys, defaults filled in. Part of every cache key and of the GLB's
/// extras, and the same for every way to ask (query, JSON, `bake`).
nlohmann::json canonical_parameters(const RequestParameters& parameters);
/// Those of them that decide the solid.
nlohmann::json canonical_solid_parameters(const RequestParameters& parameters);

}  // namespace fracture
