#include "server/service/service.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include "common/base/digest.hpp"

namespace fracture {
namespace {

template <class T>
std::size_t heap(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}

template <class T>
std::size_t nested_heap(const std::vector<std::vector<T>>& v) {
  std::size_t bytes = heap(v);
  for (const std::vector<T>& inner : v) bytes += heap(inner);
  return bytes;
}

std::size_t memory_size(const Mesh& mesh) {
  std::size_t bytes = sizeof mesh + heap(mesh.positions) + heap(mesh.attributes.normals) +
                      heap(mesh.attributes.tangents) + nested_heap(mesh.attributes.uvs) +
                      nested_heap(mesh.attributes.colors) + heap(mesh.triangles) + heap(mesh.material) +
                      heap(mesh.node);
  for (const std::string& name : mesh.node_names) bytes += sizeof name + name.capacity();
  for (const Image& image : mesh.library->images) bytes += sizeof image + heap(image.bytes);
  // A parsed JSON value takes several times its text; materials are small, so an upper guess does no harm.
  bytes += 512 * (mesh.library->materials.size() + mesh.library->textures.size());
  // The library is shared: counted twice, which does no harm either.
  if (mesh.passed_through) bytes += memory_size(*mesh.passed_through);
  return bytes;
}

std::string hex_of(std::string_view material) { return sha256(material).hex(); }

CacheOutcome stored(bool kept) { return kept ? CacheOutcome::kMissStored : CacheOutcome::kMissNotStored; }

}  // namespace

std::size_t memory_size(const PreparedMesh& mesh) {
  const Solid& solid = mesh.solid;
  std::size_t bytes = sizeof mesh + heap(solid.positions) + heap(solid.triangles) + heap(solid.wedges) +
                      heap(solid.material) + heap(solid.edges) + heap(solid.edge_vertices) +
                      heap(solid.shell) + heap(solid.part) + heap(solid.parts);
  for (const Part& part : solid.parts) bytes += heap(part.shells);
  if (solid.source) bytes += memory_size(*solid.source);
  return bytes;
}

std::size_t memory_size(const Diagram& diagram) {
  const Tetrahedralization& t = diagram.tetrahedralization;
  return sizeof diagram + heap(diagram.sites) + heap(t.points) + heap(t.tets) + heap(t.tet_of_site) +
         heap(t.site_of_input);
}

Digest digest_of(const FractureRequest& request) {
  if (request.files.empty()) return sha256(request.mesh);
  std::vector<const ImportFile*> files;
  for (const ImportFile& file : request.files) files.push_back(&file);
  std::sort(files.begin(), files.end(), [](const ImportFile* a, const ImportFile* b) {
    return std::lexicographical_compare(a->name.begin(), a->name.end(), b->name.begin(), b->name.end());
  });
  std::string list = "files\n" + sha256(request.mesh).hex() + "\n";
  for (const ImportFile* file : files)  // the length keeps names with line breaks apart
    list += std::to_string(file->name.size()) + " " + file->name + " " + sha256(file->bytes).hex() + "\n";
  return sha256(list);
}

FractureService::FractureService(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine)
    : config_(config),
      parameters_(config.max_sites, config.formats),
      engine_(std::move(engine)),
      meshes_(config.mesh_cache_bytes),
      diagrams_(config.diagram_cache_bytes),
      results_(config.result_cache_bytes) {}

namespace {

Error interrupted_error(const Interrupted& interrupted) {
  return {interrupted.code,
          interrupted.code == ErrorCode::kDeadlineExceeded
              ? "The work was given up because its deadline passed. Ask for fewer sites or a "
                "smaller mesh, or raise the server's --deadline."
              : "The work was cancelled before it was done."};
}

/// Bytes, format and everything that decides the solid: one solid for each key.
std::string mesh_key_of(const FractureRequest& request, const std::string& digest) {
  return digest + "." + extension_of(request.format) + "\n" +
         canonical_solid_parameters(request.parameters).dump();
}

GltfOptions output_options(const RequestParameters& parameters, const FragmentSet& fragments) {
  GltfOptions options;
  options.parameters = canonical_parameters(parameters);
  options.algorithm = kAlgorithmVersion;
  options.physics = parameters.physics;
  options.ue_collision = parameters.ue_collision;
  options.density = parameters.density;
  const double volume = fragments.certificate.volume_out;
  if (parameters.mass && volume > 0) options.density = *parameters.mass / volume;
  return options;
}

}  // namespace

Expected<FractureAnswer> FractureService::fracture(const FractureRequest& request,
                                                   const Execution& execution) {
  try {
    execution.poll();  // the time in the queue may have used up the deadline
    return compute(request, execution);
  } catch (const Interrupted& interrupted) {
    return tl::unexpected<Error>(interrupted_error(interrupted));
  }
}

Expected<std::shared_ptr<const PreparedMesh>> FractureService::prepare(const FractureRequest& request,
                                                                       const Execution& execution) {
  try {
    FractureAnswer unused;
    return prepared(request, mesh_key_of(request, digest_of(request).hex()), execution, unused);
  } catch (const Interrupted& interrupted) {
    return tl::unexpected<Error>(interrupted_error(interrupted));
  }
}

Expected<std::shared_ptr<const PreparedMesh>> FractureService::prepared(const FractureRequest& request,
                                                                        const std::string& mesh_key,
                                                                        const Execution& execution,
                                                                        FractureAnswer& answer) {
  if (request.mesh.empty())
    return fail(ErrorCode::kEmptyBody,
                "The mesh has 0 bytes. Send the file as the body, or as the part 'mesh'.", "mesh");
  answer.mesh_cache = CacheOutcome::kHit;
  if (auto found = meshes_.find(mesh_key)) return found;

  auto result = std::make_shared<PreparedMesh>();
  auto mesh = std::make_shared<Mesh>();
  {
    const StageTimings::Scope scope(answer.timings, "import");
    Expected<Mesh> imported =
        engine_->import(request.mesh, request.format, request.files, config_.import_limits, execution);
    if (!imported) return tl::unexpected<Error>(std::move(imported.error()));
    *mesh = std::move(*imported);
    Expected<nlohmann::json> frame = to_metres_y_up(*mesh, request.parameters.frame);
    if (!frame) return tl::unexpected<Error>(std::move(frame.error()));
    result->frame = std::move(*frame);
    if (auto restricted = restrict_to(*mesh, request.parameters.parts); !restricted)
      return tl::unexpected<Error>(std::move(restricted.error()));
  }
  const StageTimings::Scope scope(answer.timings, "prepare");
  Expected<Solid> made = engine_->prepare(std::move(mesh), request.parameters.solid, execution);
  if (!made) return tl::unexpected<Error>(std::move(made.error()));
  result->solid = std::move(*made);
  answer.mesh_cache = stored(meshes_.insert(mesh_key, result, memory_size(*result)));
  return result;
}

Expected<FractureAnswer> FractureService::compute(const FractureRequest& request,
                                                  const Execution& execution) {
  FractureAnswer answer;
  const std::string digest = digest_of(request).hex();
  const std::string mesh_key = mesh_key_of(request, digest);
  const std::string version = std::to_string(kAlgorithmVersion);
  const std::string result_key =
      digest.substr(0, 16) +
      hex_of("result\n" + mesh_key + "\n" + canonical_parameters(request.parameters).dump() + "\n" + version +
             (request.output == OutputFormat::kGltf ? "\ngltf" : "\nglb"))
          .substr(0, 48);

  if ((answer.result = results_.find(result_key))) {
    answer.result_cache = CacheOutcome::kHit;
    return answer;
  }
  const Expected<std::shared_ptr<const PreparedMesh>> mesh = prepared(request, mesh_key, execution, answer);
  if (!mesh) return tl::unexpected<Error>(mesh.error());
  const Solid& solid = (*mesh)->solid;

  FractureParameters parameters = request.parameters.fracture;
  const bool hulls =
      request.parameters.physics != Physics::kNone || request.parameters.ue_collision != UeCollision::kNone;
  parameters.hulls = hulls ? Hulls::kConvex : Hulls::kNone;

  // Only the sites decide the tetrahedralization: every dual and output format shares it.
  const std::string diagram_key = hex_of("diagram\n" + mesh_key + "\n" + std::to_string(parameters.sites) +
                                         "\n" + std::to_string(parameters.seed) + "\n" + version);
  std::shared_ptr<const Diagram> diagram = diagrams_.find(diagram_key);
  answer.diagram_cache = CacheOutcome::kHit;
  if (!diagram) {
    const StageTimings::Scope scope(answer.timings, "tetrahedralize");
    Expected<Diagram> made = engine_->diagram(solid, parameters, execution, answer.inner);
    if (!made) return tl::unexpected<Error>(std::move(made.error()));
    diagram = std::make_shared<const Diagram>(std::move(*made));
    answer.diagram_cache = stored(diagrams_.insert(diagram_key, diagram, memory_size(*diagram)));
  }

  auto result = std::make_shared<FractureResult>();
  result->key = result_key;
  result->mesh_digest = "sha256:" + digest;
  result->format = request.output;
  Expected<FragmentSet> fragments = [&] {
    const StageTimings::Scope scope(answer.timings, "clip");
    return engine_->cut(solid, *diagram, parameters, execution, answer.inner);
  }();
  if (!fragments) return tl::unexpected<Error>(std::move(fragments.error()));
  execution.poll();
  {
    const StageTimings::Scope scope(answer.timings, "encode");
    fragments->report["frame"] = (*mesh)->frame;
    if (solid.source->passed_through)
      fragments->report["passed_through"] = {{"triangles", solid.source->passed_through->triangles.size()}};
    GltfOptions options = output_options(request.parameters, *fragments);
    options.mesh_digest = result->mesh_digest;
    result->file = engine_->encode(*fragments, options, request.output);
    result->certificate = fragments->certificate;
  }
  answer.result = result;
  answer.result_cache = stored(results_.insert(result_key, result, sizeof *result + result->file.capacity()));
  return answer;
}

nlohmann::json figures_of(const FractureResult& result) {
  // Layout of a GLB (glTF 2.0, section 4.4): 12 bytes of header, then the JSON chunk as length, type, text.
  const std::vector<std::uint8_t>& glb = result.file;
  std::uint32_t length = 0;
  if (glb.size() < 20) throw InternalError("figures_of: the GLB is shorter than its header");
  std::memcpy(&length, glb.data() + 12, 4);
  if (length > glb.size() - 20) throw InternalError("figures_of: the JSON chunk is longer than the GLB");
  const auto* text = reinterpret_cast<const char*>(glb.data()) + 20;
  const nlohmann::json document = nlohmann::json::parse(text, text + length);
  for (const nlohmann::json& node : document.value("nodes", nlohmann::json::array()))
    if (node.contains("extras") && node["extras"].contains("fracture") &&
        node["extras"]["fracture"].contains("bonds"))
      return node["extras"]["fracture"];
  throw InternalError("figures_of: no node carries extras.fracture");
}

}  // namespace fracture
