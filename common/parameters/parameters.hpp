// The table of all parameters. It validates a URL's query, a JSON object and the flags of `bake`, and writes the error messages.
// It produces a request's canonical form and fills GET /limits and GET /patterns. A test compares proto/openapi.yaml with it. The
// rows are in rows.cpp and the files *_rows.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/hollow/hollow.hpp"
#include "common/import/import_input.hpp"
#include "common/materials/materials.hpp"
#include "common/mesh/frame.hpp"
#include "common/mesh/proxies.hpp"
#include "common/mesh/selection.hpp"
#include "common/parameters/selection.hpp"
#include "common/parameters/spec.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Integers are at most 2^53 - 1, so that every language's JSON parser reads them exactly.
inline constexpr std::uint64_t kMaxSeed = (1ull << 53) - 1;

/// How an answer reports its differences from the answer without the new hits.
enum class DeltaAnswer {
  kNone,
  kStated,  ///< the IDs of new, changed and removed fragments
  kOnly,    ///< the same IDs, but only the new and changed fragments
};

struct RequestParameters;

/// An entry of `assign`.
struct Assignment {
  PartSelector selector{};
  std::vector<std::string> given{};  ///< names of the parameters that the entry has
  /// All parameters of the parts that it decides. Only those that a material sets have an effect.
  std::shared_ptr<const RequestParameters> parameters{};
};

struct RequestParameters {
  FrameOptions frame;
  PartSelection parts;  ///< sorted, each entry once
  Proxies proxies = Proxies::kHulls;
  SolidOptions solid;
  HollowOptions hollow;
  FractureParameters fracture;
  Selection selection;
  Physics physics = Physics::kKhr;
  UeCollision ue_collision = UeCollision::kNone;
  std::optional<Vec3d> keep_center{};  ///< with keep_radius: fracture.keep
  std::optional<double> keep_radius{};
  /// RequestKeys::result of an earlier answer. parse() takes only the given parameters; FractureService::parse() adds the parameters
  /// of that answer.
  std::string of{};
  std::vector<Vec3d> local_point{};            ///< with the next two: fracture.hits
  std::vector<double> local_radius{};          ///< one value per point, or one for all points
  std::vector<std::uint64_t> local_sites{30};  ///< one value per point, or one for all points
  std::uint32_t local_new = 1;                 ///< with delta: selection.new_hits
  DeltaAnswer delta = DeltaAnswer::kNone;
  std::optional<std::uint64_t> fragment{};  ///< with the next two: selection.refracture
  std::uint32_t fragment_sites = Refracture{}.sites;
  std::uint64_t fragment_seed = Refracture{}.seed;
  Vec3d gravity{0, -9.81, 0};           ///< m/s², for the support analysis
  std::vector<std::uint64_t> broken{};  ///< IDs of fragments that are gone, for the support analysis
  std::string material;                 ///< name of the preset that set the other members; empty: none
  PhysicalProperties physical;
  InteriorLook interior;
  ExteriorLook exterior;
  std::string interior_color;  ///< as given, when interior.color is set
  std::string mortar;          ///< as given, when interior.mortar is set
  /// In the order of the request; also in fracture.assigned and hollow.by_part
  std::vector<Assignment> assign{};
  /// With barycentric cells: the aggregation that was asked for, which has no effect. That of `fracture` is then of single cells.
  std::optional<Aggregation> idle_aggregation{};
  std::optional<double> mass;        ///< kg, of all fragments; if given, it determines the density
  std::optional<MeshFormat> format;  ///< as given by `format=`; empty if absent
};

/// The mesh formats that a server reads.
class FormatSet {
 public:
  FormatSet();  ///< the formats that are enabled by default
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

  /// Checks all parameters before it returns. The error lists each wrong parameter in extra.errors as {parameter | pointer,
  /// detail}, and `Error::pointer` names the first. Errors: kUnknownParameter, kUnknownFormat, and kBadParameter, which includes
  /// parameters that are given twice or belong to another pattern. The material applies first, then the pattern, then the rest,
  /// regardless of their order in the request.
  Expected<RequestParameters> parse(const std::vector<RawParameter>& given) const;

  /// Returns the JSON for `parameters` in GET /limits: each parameter with its range and its synonyms (groups.hpp).
  nlohmann::json to_json() const;
  /// Returns the JSON for GET /patterns: every pattern, every material and every parameter.
  nlohmann::json patterns_to_json() const;

 private:
  class Parsing;

  FormatSet formats_;
  std::vector<ParameterSpec> specs_;
};

/// Returns the key at the end of an answer's address (`of`); empty if there is none.
std::string answer_key_in(std::string_view address);

/// Returns the unique form of a request: sorted keys, including defaults. It is part of every cache key and
/// of the GLB's extras, and is the same for a query, JSON and `bake`.
nlohmann::json canonical_parameters(const RequestParameters& parameters);
/// Returns the canonical parameters that determine the solid.
nlohmann::json canonical_solid_parameters(const RequestParameters& parameters);
/// Returns the canonical parameters that determine the sites. They are the same for a material and for its
/// values given one by one.
nlohmann::json canonical_site_parameters(const RequestParameters& parameters);
/// Returns the parameters of an earlier answer. For a request with `delta`: the answer that its new hits
/// start from. With `hit`: the answer that further hits start from.
nlohmann::json canonical_base_parameters(const RequestParameters& parameters, bool hit);

}  // namespace fracture
