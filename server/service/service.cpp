#include "server/service/service.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/parameters/effects.hpp"
#include "common/parameters/parameter_object.hpp"
#include "common/pipeline/algorithm_version.hpp"
#include "common/pipeline/below_root.hpp"
#include "common/solid/size_check.hpp"
#include "common/structure/support.hpp"
#include "server/service/earlier_answer.hpp"
#include "server/service/estimate.hpp"
#include "server/service/part_options.hpp"

namespace fracture {
namespace {

/// Budget for the parameters of answers that further requests may name: enough for some thousand answers.
constexpr std::size_t kAnswerBytes = 4u << 20;

std::size_t memory_size(const nlohmann::json& parameters) {
  return sizeof parameters + json_bytes(parameters);
}

CacheOutcome stored(bool kept) { return kept ? CacheOutcome::kMissStored : CacheOutcome::kMissNotStored; }

GltfOptions output_options(const RequestParameters& parameters, const FragmentSet& fragments) {
  GltfOptions options;
  options.parameters = canonical_parameters(parameters);
  options.algorithm = kAlgorithmVersion;
  options.physics = parameters.physics;
  options.ue_collision = parameters.ue_collision;
  options.density = parameters.physical.density;
  options.friction = parameters.physical.friction;
  options.restitution = parameters.physical.restitution;
  options.bond_strength = parameters.physical.bond_strength;
  // Hits do not change this volume. So fragments that a hit does not touch keep their mass bit for bit. The sum of the
  // fragments' volumes would not do, because it depends on the order of its terms.
  if (parameters.mass && fragments.weighed_volume > 0)
    options.density = *parameters.mass / fragments.weighed_volume;
  return options;
}

/// Returns the parameters for this mesh, with collision hulls if the request asks for physics or Unreal collision. A hit's
/// answer has no unbroken mesh. Errors: those of below_root().
Expected<FractureParameters> for_mesh(const RequestParameters& asked, const PreparedMesh& mesh) {
  Expected<FractureParameters> placed = below_root(asked.fracture, mesh.frame.offset);
  if (!placed) return placed;
  FractureParameters& parameters = *placed;
  const bool hulls = asked.physics != Physics::kNone || asked.ue_collision != UeCollision::kNone;
  parameters.hulls = hulls ? Hulls::kConvex : Hulls::kNone;
  parameters.intact = asked.fracture.intact && asked.delta == DeltaAnswer::kNone;
  parameters.filters = asked.physics == Physics::kKhr ? HullFilters::kSystems : HullFilters::kNone;
  return placed;
}

/// Says what the places in an error about a mesh are relative to. Without an offset, they are those of the file.
Error relative_to(const Vec3d& offset, Error error) {
  if (!(offset == Vec3d{}))
    error.detail +=
        " All positions are relative to " + to_text(offset) + ", because the mesh is far from its origin.";
  return error;
}

/// An execution that may hold at most `limit` bytes of memory (0: any number), unless it already has an allowance.
class Limited {
 public:
  Limited(const Execution& execution, std::uint64_t limit) : execution_(execution) {
    if (execution.allowance || limit == 0) return;
    execution_.allowance = &allowance_.emplace(0, limit, [limit](std::uint64_t bytes) {
      return bytes <= limit ? Allowance::Answer::kGranted : Allowance::Answer::kNever;
    });
  }
  Limited(const Limited&) = delete;
  Limited& operator=(const Limited&) = delete;
  const Execution& operator*() const { return execution_; }

 private:
  std::optional<Allowance> allowance_;
  Execution execution_;
};

/// Files of printers and measuring machines are in millimetres, unlike those of modelling tools.
bool is_in_millimetres(MeshFormat format) { return format == MeshFormat::kStl; }

}  // namespace

void check_size_of_pieces(const PreparedMesh& mesh, const FractureRequest& request, Remarks& remarks,
                          std::vector<Choice>& choices) {
  const std::string& material = request.parameters.material;
  check_size(mesh.solid, mesh.frame, is_in_millimetres(request.format), {material, usual_piece(material)},
             remarks, choices);
}

Error to_error(const Interrupted& interrupted) {
  if (interrupted.error) return *interrupted.error;
  return {
      interrupted.code,
      interrupted.code == ErrorCode::kDeadlineExceeded
          ? "The work was stopped because its deadline passed. Ask for fewer sites, send a smaller mesh, or allow "
            "more time."
          : "The work was cancelled before it was done."};
}

FractureService::FractureService(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine)
    : config_(config),
      parameters_(config.max_sites, config.formats),
      engine_(std::move(engine)),
      meshes_(config.mesh_cache_bytes),
      diagrams_(config.diagram_cache_bytes),
      results_(config.result_cache_bytes),
      answers_(kAnswerBytes),
      tiers_(config.tiers) {}

Expected<RequestParameters> FractureService::parse(const std::vector<RawParameter>& given,
                                                   const MaySee& may_see) {
  Expected<RequestParameters> own = parameters_.parse(given);
  if (!own || own->of.empty()) return own;
  const bool visible = !may_see || may_see(own->of);
  std::shared_ptr<const nlohmann::json> earlier = visible ? answers_.find(own->of) : nullptr;
  if (!earlier && visible)
    if (const auto result = results_.find(own->of))
      if (auto kept = read_kept_parameters(result->parameters)) {
        earlier = std::make_shared<const nlohmann::json>(std::move(*kept));
        answers_.insert(own->of, earlier, memory_size(*earlier));
      }
  if (!earlier)
    return fail(
        ErrorCode::kNoSuchAnswer,
        "This server does not have the answer sha256:" + own->of +
            ", or no longer has it. Instead of 'of', send the parameters that the answer contains: the result is the same.",
        "of");
  const auto all = on_earlier_answer(parameters_, given, *own, *earlier);
  if (!all) return tl::unexpected<Error>(all.error());
  Expected<RequestParameters> result = parameters_.parse(*all);
  if (result) result->of = own->of;
  return result;
}

std::uint64_t FractureService::earlier_bytes(const std::vector<RawParameter>& given) const {
  const auto of =
      std::find_if(given.begin(), given.end(), [](const RawParameter& raw) { return raw.name == "of"; });
  if (of == given.end() || !of->value.is_string()) return 0;
  const std::string key = answer_key_in(of->value.get_ref<const std::string&>());
  // Each entry of `assign` is a whole set of parameters. As text, each is an object.
  constexpr std::uint64_t kOfEntry = 100, kMostEntries = 64;
  if (const auto result = results_.peek(key)) {
    const auto head = std::string_view(result->parameters).substr(0, kOfEntry * kMostEntries);
    const auto objects = static_cast<std::uint64_t>(std::count(head.begin(), head.end(), '{'));
    return result->parameters.size() + kOfEntry * (std::max<std::uint64_t>(objects, 1) - 1);
  }
  // In memory, a number in a list takes five times the size of its text, and a member of an object ten times.
  constexpr std::uint64_t kOfText = 8;
  const auto kept = answers_.peek(key);
  if (!kept) return 0;
  const auto assign = kept->find("assign");
  return answers_.size_of(key).value_or(0) / kOfText +
         (assign != kept->end() ? kOfEntry * assign->size() : 0);
}

bool FractureService::fetch_result(const std::string& key, FractureAnswer& answer, const Room& room,
                                   const Execution& execution, const std::string& client) {
  ResultTiers::Found found = tiers_.find(key, room, execution, client);
  answer.disk_cache = found.disk;
  answer.redis_cache = found.redis;
  if (!found.result) return !found.no_room;
  answer.result_cache = stored(results_.insert(key, found.result, memory_size(*found.result)));
  answer.result = std::move(found.result);
  return true;
}

void FractureService::keep_variant(std::shared_ptr<const FractureResult> variant) {
  const std::size_t bytes = memory_size(*variant);
  const std::string key = variant->key;
  results_.insert(key, std::move(variant), bytes);
}

Expected<FractureAnswer> FractureService::fracture(const FractureRequest& request,
                                                   const Execution& execution) {
  FractureAnswer answer;
  const RequestKeys keys = keys_of(request);
  if (auto wrong = wrong_mesh(request, keys)) return tl::unexpected<Error>(std::move(*wrong));
  if ((answer.result = find_result(keys.result))) {
    answer.result_cache = CacheOutcome::kHit;
    return answer;
  }
  if (auto failure = find_failure(keys.result)) return tl::unexpected<Error>(std::move(*failure));
  const Limited limited(execution, config_.max_bytes_per_job);
  return fracture(request, keys, *limited, std::move(answer));
}

Expected<FractureAnswer> FractureService::fracture(const FractureRequest& request, const RequestKeys& keys,
                                                   const Execution& execution, FractureAnswer answer) {
  try {
    execution.poll();
    Step<PreparedMesh> mesh{find_mesh(keys), CacheOutcome::kHit, {}};
    if (!mesh.value) {
      auto made = make_mesh(request, keys, execution);
      if (!made) return tl::unexpected<Error>(std::move(made.error()));
      mesh = std::move(*made);
    }
    if (execution.allowance)
      if (auto error = cannot_fit(request.parameters, {mesh.value->solid, execution},
                                  execution.allowance->limit(), config_.memory_setting))
        return tl::unexpected<Error>(std::move(*error));
    Step<CutBase> diagram{find_diagram(keys), CacheOutcome::kHit, {}};
    if (!diagram.value) {
      auto made = make_diagram(*mesh.value, request, keys, execution);
      if (!made) return tl::unexpected<Error>(std::move(made.error()));
      diagram = std::move(*made);
    }
    answer.mesh_cache = mesh.cache;
    answer.diagram_cache = diagram.cache;
    for (const StageTimings* timings : {&mesh.timings, &diagram.timings}) answer.timings.add(*timings);
    auto made = make_result(*mesh.value, *diagram.value, request, keys, execution, answer);
    if (!made) return tl::unexpected<Error>(std::move(made.error()));
    return answer;
  } catch (const Interrupted& interrupted) {
    return tl::unexpected<Error>(to_error(interrupted));
  }
}

Expected<std::shared_ptr<const PreparedMesh>> FractureService::prepare(const FractureRequest& request,
                                                                       const Execution& execution) {
  const RequestKeys keys = keys_of(request);
  if (auto found = find_mesh(keys)) return found;
  const Limited limited(execution, config_.max_bytes_per_job);
  try {
    auto made = make_mesh(request, keys, *limited);
    if (!made) return tl::unexpected<Error>(std::move(made.error()));
    return made->value;
  } catch (const Interrupted& interrupted) {
    return tl::unexpected<Error>(to_error(interrupted));
  }
}

Expected<Step<PreparedMesh>> FractureService::make_mesh(const FractureRequest& request,
                                                        const RequestKeys& keys, const Execution& execution) {
  if (request.mesh.empty())
    return fail(ErrorCode::kEmptyBody,
                "The mesh has 0 bytes. Send the file as the body, or as the part 'mesh'.", "mesh");
  Step<PreparedMesh> step;
  auto result = std::make_shared<PreparedMesh>();
  auto mesh = std::make_shared<Mesh>();
  {
    if (execution.progress) execution.progress(Stage::kImport, 0);
    const StageTimings::Scope scope(step.timings, Stage::kImport);
    Expected<Mesh> imported = engine_->import(request.mesh, request.format, request.files, keys.digest,
                                              config_.import_limits, execution);
    if (!imported) return tl::unexpected<Error>(std::move(imported.error()));
    *mesh = std::move(*imported);
    // The real size of the mesh is known only now, because the file's size does not tell it. A small mesh fits into the
    // memory that every request is admitted with.
    constexpr std::size_t kSmall = 64u << 10;
    if (const std::size_t bytes = memory_size(*mesh); bytes > kSmall)
      execution.made(Product::kMeshBytes, bytes);
    execution.made(Product::kSurfaceTriangles, mesh->triangles.size());
    // The reader has ended, so other computations may use the memory that it no longer needs. (With `bake`, the reader keeps
    // running, but there the allowance reserves nothing.)
    if (execution.allowance) execution.allowance->shrink();
    const Expected<FrameReport> frame = to_metres_y_up(*mesh, request.parameters.frame);
    if (!frame) return tl::unexpected<Error>(frame.error());
    result->frame = *frame;
    if (auto restricted = restrict_to(*mesh, request.parameters.parts, execution); !restricted)
      return tl::unexpected<Error>(std::move(restricted.error()));
    if (request.parameters.proxies == Proxies::kHulls) take_proxies(*mesh, execution);
  }
  if (execution.progress) execution.progress(Stage::kPrepare, 0);
  {
    const StageTimings::Scope scope(step.timings, Stage::kPrepare);
    StageProgress progress(Stage::kPrepare, execution.progress);
    Execution telling = execution;
    telling.within = &progress;
    Expected<Solid> made =
        engine_->prepare(std::move(mesh), request.parameters.solid, request.parameters.hollow, telling);
    if (!made) return tl::unexpected<Error>(relative_to(result->frame.offset, std::move(made.error())));
    result->solid = std::move(*made);
    measure_edges(result->solid, telling);
    SolidReport& report = result->solid.report;
    check_size(result->solid, result->frame, is_in_millimetres(request.format), report.remarks,
               report.choices);
  }
  step.value = result;
  step.cache = stored(meshes_.insert(keys.mesh, result, memory_size(*result)));
  return step;
}

Expected<Step<CutBase>> FractureService::make_diagram(const PreparedMesh& mesh,
                                                      const FractureRequest& request, const RequestKeys& keys,
                                                      const Execution& execution) {
  if (execution.progress) execution.progress(Stage::kTetrahedralize, 0);
  const Expected<FractureParameters> parameters = for_mesh(request.parameters, mesh);
  if (!parameters) return tl::unexpected<Error>(parameters.error());
  Step<CutBase> step;
  std::shared_ptr<const CutBase> base;
  {
    const StageTimings::Scope scope(step.timings, Stage::kTetrahedralize);
    StageProgress progress(Stage::kTetrahedralize, execution.progress);
    Execution telling = execution;
    telling.within = &progress;
    Expected<CutBase> made = engine_->base(mesh.solid, *parameters, request.parameters.selection, telling);
    if (!made)
      return tl::unexpected<Error>(with_advice(std::move(made.error()), request.parameters,
                                               {mesh.solid, execution}, config_.memory_setting));
    base = std::make_shared<const CutBase>(std::move(*made));
  }
  step.value = base;
  step.cache = stored(diagrams_.insert(keys.diagram, base, memory_size(*base)));
  return step;
}

Expected<FracturedSolid> FractureService::make_result(const PreparedMesh& mesh, const CutBase& base,
                                                      const FractureRequest& request, const RequestKeys& keys,
                                                      const Execution& execution, FractureAnswer& answer,
                                                      const std::string& client) {
  if (execution.progress) execution.progress(Stage::kClip, 0);
  InteriorLook look = request.parameters.interior;
  look.has_maps = request.parameters.delta == DeltaAnswer::kOnly;
  const Expected<FractureParameters> placed = for_mesh(request.parameters, mesh);
  if (!placed) return tl::unexpected<Error>(placed.error());
  const FractureParameters& fracture = *placed;
  const std::uint32_t pieces = fracture.size.fragments > 0 ? fracture.size.fragments : fracture.sites;
  const PartOptions parts(request.parameters, mesh.solid, execution);
  auto interior = parts.interior(look, mesh.solid, pieces, execution);
  if (!interior) return tl::unexpected<Error>(std::move(interior.error()));
  Expected<Cut> cut = [&] {
    const StageTimings::Scope scope(answer.timings, Stage::kClip);
    StageProgress progress(Stage::kClip, execution.progress);
    Execution telling = execution;
    telling.within = &progress;
    return engine_->cut(mesh.solid, base, fracture, request.parameters.selection, telling);
  }();
  if (!cut) {
    if (cut.error().code == ErrorCode::kUnsound) failures_.add(keys.result, cut.error());
    return tl::unexpected<Error>(with_advice(std::move(cut.error()), request.parameters,
                                             {mesh.solid, execution}, config_.memory_setting));
  }
  FracturedSolid& fractured = cut->fractured;
  execution.poll();

  if (execution.progress) execution.progress(Stage::kEncode, 0);
  auto result = std::make_shared<FractureResult>();
  result->key = keys.result;
  result->mesh_digest = "sha256:" + keys.digest;
  result->format = request.output;
  {
    const StageTimings::Scope scope(answer.timings, Stage::kEncode);
    fractured.report.frame = mesh.frame;
    check_size_of_pieces(mesh, request, fractured.report.remarks, fractured.report.choices);
    if (const auto& rest = mesh.solid.source->passed_through)
      fractured.report.passed_through = rest->triangles.size();
    GltfOptions options = output_options(request.parameters, fractured.set);
    // The support analysis needs all fragments, so an answer with only the changed fragments has none.
    if (request.parameters.fracture.anchors.any() && request.parameters.delta != DeltaAnswer::kOnly) {
      const SupportOptions support{request.parameters.gravity, options.density, options.bond_strength,
                                   request.parameters.broken};
      fractured.support = analyze_support(fractured.set, fractured.anchored, support, execution);
    }
    for (std::string& sentence : parameters_without_effect(request.parameters, fractured))
      fractured.report.remarks.warn(std::move(sentence));
    options.interior = std::move(*interior);
    options.exterior = parts.exterior(mesh.solid, execution);
    parts.add_surfaces(options);
    options.mesh_digest = result->mesh_digest;
    GltfFile encoded = engine_->encode(fractured, options, request.output, execution);
    result->file = std::move(encoded.bytes);
    result->file_digest = sha256(std::as_bytes(std::span(result->file)), execution);
    result->figures = encoded.figures;
    result->figures_digest = sha256(std::as_bytes(result->bytes_of(result->figures)), execution);
    result->parameters = options.parameters.dump();
    result->summary = summary_of(fractured);
  }
  if (cut->kept) diagrams_.insert(keys.kept, cut->kept, memory_size(*cut->kept));
  auto canonical = std::make_shared<const nlohmann::json>(canonical_parameters(request.parameters));
  answers_.insert(keys.result, canonical, memory_size(*canonical));
  answer.result = result;
  answer.result_cache = stored(results_.insert(keys.result, result, memory_size(*result)));
  tiers_.store(std::move(result), client);
  return std::move(fractured);
}

}  // namespace fracture
