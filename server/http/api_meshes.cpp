// Stored meshes: PUT, POST, GET and DELETE /meshes, fracturing a stored mesh, and estimating the cost of doing so.
// A game sends a fracture request on a collision: it is a few bytes, because the mesh is already stored.
#include <algorithm>
#include <stop_token>

#include "common/base/json_text.hpp"
#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/parameters/parameter_object.hpp"
#include "server/http/api.hpp"
#include "server/http/mesh_input.hpp"
#include "server/http/parameter_weight.hpp"
#include "server/service/admission.hpp"
#include "server/service/estimate.hpp"
#include "server/service/mesh_report.hpp"

namespace fracture::http {
namespace {

constexpr const char* kFormOfId =
    "The id of a mesh is sha256: followed by the 64 lower-case hex digits of its SHA-256";

/// `id`: as the request gave it.
Problem no_mesh(std::string_view id) {
  if (!digest_in(id))
    return Problem(HttpProblem::kNotFound,
                   std::string(kFormOfId) + "; it was '" + shortened(printable(id)) + "'.");
  return Problem(HttpProblem::kNotFound,
                 "This mesh is not stored here, or has been deleted. PUT it to /meshes/" + std::string(id) +
                     ", then send the request again.");
}

constexpr std::string_view kOfMesh = "Send a smaller mesh, or allow more time.";

Error of_upload(Error error) {
  if (error.code == ErrorCode::kDeadlineExceeded) error.detail = "The mesh was not stored. " + error.detail;
  return error;
}

MeshDescription describe(const FractureRequest& mesh, const PreparedMesh& prepared,
                         const StoreConfig& config) {
  std::uint64_t bytes = input_bytes(mesh.mesh, mesh.files);
  for (const ImportFile& file : mesh.files) bytes += file.name.size();
  const nlohmann::ordered_json document = {{"id", std::string(kDigestScheme) + mesh.digest},
                                           {"format", extension_of(mesh.format)},
                                           {"bytes", bytes},
                                           {"files", mesh.files.size()},
                                           {"ttl_s", config.ttl.count() / 1000},
                                           {"report", mesh_report(prepared)}};
  return {std::make_shared<const std::string>(json_text(document, 2) + "\n"),
          prepared.solid.triangles.size()};
}

Response description_of(const StoredMesh& mesh, int status) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.body = {reinterpret_cast<const std::uint8_t*>(mesh.description->data()), mesh.description->size()};
  response.owner = mesh.description;
  return response;
}

}  // namespace

Answered Api::put_mesh(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                       const Reply& reply) {
  std::string wanted;  // empty: accept any digest
  if (request->admission.route->operation == Operation::kPutMesh) {
    const auto digest = digest_in(request->admission.segment);
    if (!digest) return tl::unexpected<Problem>(no_mesh(request->admission.segment));
    wanted = *digest;
  }
  return with_mesh_input(
      request, gone, reply,
      [this, request, reply, wanted](FractureRequest input, const std::shared_ptr<Body>& body,
                                     const Terms& terms) -> Answered {
        if (!wanted.empty() && input.digest != wanted)
          return refuse(
              HttpProblem::kDigestMismatch,
              "The digest of this mesh is sha256:" + input.digest + ", not sha256:" + wanted +
                  ". (If the mesh has additional files, the digest also covers their names and digests: see openapi.json.)");
        const std::uint64_t bytes = input_bytes(input.mesh, input.files);
        if (bytes > meshes_.config().quota_bytes)
          return refuse(HttpProblem::kBodyTooLarge,
                        "The mesh has " + data_size(bytes) +
                            "; the limit for all stored meshes together is " +
                            data_size(meshes_.config().quota_bytes) +
                            " (--mesh-store). Send a smaller mesh, or raise the limit.");
        const auto asked = std::make_shared<FractureRequest>(input);
        const auto keep = [this, request, reply, asked, body,
                           terms](const std::shared_ptr<const PreparedMesh>& prepared) -> Answered {
          // Describing the mesh is too slow for an io thread. Copying a large mesh, or comparing it with the stored
          // one, is a separate step, because it must let others go first: they may wait for this call to return.
          Terms storing = terms;
          storing.needs_seat = false;
          storing.is_computed = WorkerPool::turn() != nullptr;
          const std::uint64_t size = body->bytes.size();
          if (!storing.is_computed)
            return on_pool(expected_reading(size), request, storing, reply,
                           [this, request, asked, body, prepared](const Execution& execution) {
                             return store(*request, *asked, describe(*asked, *prepared, meshes_.config()),
                                          *body, execution);
                           });
          // The step keeps the description and not the solid, because a solid that waits here is not counted.
          const MeshDescription description = describe(*asked, *prepared, meshes_.config());
          const bool copies = is_kept_as_copy(*asked, body->bytes.capacity());
          if (size <= kBytesBetweenPolls || (!copies && !meshes_.has(asked->digest)))
            return store(*request, *asked, description, *body, kUninterrupted);
          return on_pool(expected_reading(size), request, storing, reply,
                         [this, request, asked, body, description](const Execution& execution) {
                           return store(*request, *asked, description, *body, execution);
                         });
        };
        std::optional<Error> overload = dispatcher_.prepare(
            std::move(input), terms,
            [this, request, reply, keep](Expected<std::shared_ptr<const PreparedMesh>> prepared) {
              answering(*request, reply, [&]() -> Answered {
                if (!prepared)
                  return refusal(of_upload(with_time(std::move(prepared.error()), *request, kOfMesh)),
                                 request->id);
                return keep(*prepared);
              });
            });
        if (overload) return tl::unexpected<Problem>(to_problem(std::move(*overload)));
        return std::nullopt;
      });
}

Answered Api::store(const Request& request, const FractureRequest& asked, const MeshDescription& description,
                    Body& body, const Execution& execution) {
  const std::uint64_t capacity = body.bytes.capacity();
  if (is_kept_as_copy(asked, capacity) && !body.reservation.grow_to(2 * capacity))
    return tl::unexpected<Problem>(no_memory(body.reservation));
  const std::shared_ptr<StoredMesh> stored = stored_mesh_of(asked, capacity, execution);
  stored->description = description.text;
  stored->triangles = description.triangles;
  MeshStore::Owner owner{holder_of(request)};
  if (!owner_of(request).empty()) owner.share = request.payer.account->shares().stored_bytes;
  const MeshStore::Put put = meshes_.put(stored, owner, MeshStore::Clock::now(), execution);
  if (put == MeshStore::Put::kOverShare)
    return refuse(HttpProblem::kBodyTooLarge,
                  "The mesh takes " + data_size(stored->held()) + "; the limit for all stored meshes of '" +
                      owner.name + "' is " + data_size(owner.share) +
                      ". Delete meshes that you no longer need, or send a smaller one.");
  if (put == MeshStore::Put::kOverQuota)
    return refuse(HttpProblem::kBodyTooLarge,
                  "The mesh takes " + data_size(stored->held()) + "; the limit for all stored meshes is " +
                      data_size(meshes_.config().quota_bytes) +
                      " (--mesh-store). Send a smaller mesh, or raise the limit.");
  if (put == MeshStore::Put::kNoRoom)
    return tl::unexpected<Problem>(
        Problem(ErrorCode::kOverloaded, "Meshes in use by requests occupy most of the " +
                                            data_size(meshes_.config().quota_bytes) +
                                            " for stored meshes (--mesh-store). Try again after Retry-After.")
            .with("Retry-After", "2"));
  // From here on, the body is counted in the store's quota if the store keeps it. Otherwise it is freed with
  // its reservation.
  if (stored->owner == asked.owner) body.reservation = {};
  Response response = description_of(*stored, put == MeshStore::Put::kCreated ? 201 : 200);
  response.headers.emplace_back("Location", "/meshes/" + std::string(kDigestScheme) + stored->digest);
  return response;
}

OrProblem<std::shared_ptr<const StoredMesh>> Api::stored_mesh(const Request& request, std::string_view id) {
  const auto digest = digest_in(id);
  auto mesh = digest ? meshes_.find(*digest, holder_of(request), whose(request)) : nullptr;
  if (!mesh) return tl::unexpected<Problem>(no_mesh(id));
  return mesh;
}

Answered Api::get_mesh(const Request& request) {
  auto mesh = stored_mesh(request, request.admission.segment);
  if (!mesh) return tl::unexpected<Problem>(std::move(mesh.error()));
  return description_of(**mesh, 200);
}

Answered Api::delete_mesh(const Request& request) {
  const auto digest = digest_in(request.admission.segment);
  const std::string owner = owner_of(request);
  // Deletes the mesh of this owner first. An administrator deletes those of others next. Without tokens, all
  // clients are one owner.
  if (!digest || (!meshes_.erase(*digest, owner) && !meshes_.erase(*digest, owner, whose(request))))
    return tl::unexpected<Problem>(no_mesh(request.admission.segment));
  Response response;
  response.status = 204;
  return response;
}

Answered Api::fracture_stored(const std::shared_ptr<Request>& request, std::string_view text,
                              std::string_view id, const std::stop_token& gone, const Reply& reply) {
  OrProblem<Terms> terms = terms_of(*request, gone);
  if (!terms) return tl::unexpected<Problem>(std::move(terms.error()));
  return with_parameters(
      text.size() + request->head.query.size(), kParseInline, request, *terms, reply,
      [this, request, text, id = std::string(id), terms = *terms, reply]() mutable -> Answered {
        std::vector<RawParameter> given = raw_parameters(request->admission.query);
        if (!text.empty()) {
          Expected<std::vector<RawParameter>> more = read_parameters(text, "body");
          if (!more) return tl::unexpected<Problem>(to_problem(std::move(more.error())));
          given.insert(given.end(), more->begin(), more->end());
        }
        if (id.empty()) {  // POST /fracture: the body contains "mesh" too
          const auto mesh = std::find_if(given.begin(), given.end(),
                                         [](const RawParameter& p) { return p.name == "mesh"; });
          if (mesh == given.end() || !mesh->value.is_string())
            return tl::unexpected<Problem>(to_problem(
                {ErrorCode::kBadParameter,
                 "A JSON body must name a stored mesh: {\"mesh\": \"sha256:...\", \"sites\": 50}. To send a glTF "
                 "file, use Content-Type: model/gltf+json.",
                 "mesh"}));
          id = mesh->value.get<std::string>();
          given.erase(mesh);
        }
        if (std::any_of(given.begin(), given.end(), [](const RawParameter& p) { return p.name == "format"; }))
          return tl::unexpected<Problem>(
              to_problem({ErrorCode::kBadParameter,
                          "The format of a stored mesh is already known: leave 'format' out.", "format"}));
        // Even a request of two hundred bytes may refer to an answer whose parameters are a megabyte of
        // points, or may have fifty entries of 'assign'.
        const std::uint64_t own =
            parse_weight(text.size() + request->head.query.size(), given, service_.parameters());
        const std::uint64_t all =
            service_.earlier_bytes(given) + (own > kParseInline ? kEarlierInline + own : 0);
        return with_parameters(all, kEarlierInline, request, terms, reply,
                               [this, request, given = std::move(given), id = std::move(id), terms, reply] {
                                 return fracture_stored_mesh(request, given, id, terms, reply);
                               });
      });
}

Problem Api::mesh_is_not_held(HeldBuffers::Refusal refusal) const {
  const bool share = refusal == HeldBuffers::Refusal::kOverShare;
  return Problem(share ? ErrorCode::kOverShare : ErrorCode::kOverloaded,
                 (share ? std::string("This client's requests are using its whole share of the ")
                        : std::string("The requests in progress are using all of the ")) +
                     data_size(meshes_.config().quota_bytes) +
                     " for stored meshes (--mesh-store). Send the request again when some of those "
                     "requests are finished.")
      .with("Retry-After", "2");
}

Answered Api::fracture_stored_mesh(const std::shared_ptr<Request>& request,
                                   const std::vector<RawParameter>& given, const std::string& id,
                                   const Terms& terms, const Reply& reply) {
  Expected<RequestParameters> parameters =
      service_.parse(given, [&](const std::string& key) { return may_see(*request, key); });
  if (!parameters) return tl::unexpected<Problem>(to_problem(std::move(parameters.error())));
  auto mesh = stored_mesh(*request, id);
  if (!mesh) return tl::unexpected<Problem>(std::move(mesh.error()));

  // Held while the request waits: the stored mesh, and the memory of its body and of the earlier answer's
  // parameters.
  struct Held {
    std::shared_ptr<const StoredMesh> mesh;
    MemoryBudget::Reservation parameters;
    HeldBuffers::Hold part;  ///< counted, because the store cannot evict a mesh in use
  };
  if (const std::uint64_t earlier = service_.earlier_bytes(given); earlier > kParseInline)
    if (!request->reservation.grow_to(request->reservation.bytes() + earlier))
      return tl::unexpected<Problem>(no_memory(request->reservation));
  HeldBuffers::Hold part;
  if (const auto refusal =
          held_meshes_.take(terms.payer.flow.name, (*mesh)->owner.get(), (*mesh)->shared_bytes(), part))
    return tl::unexpected<Problem>(mesh_is_not_held(*refusal));
  const auto held =
      std::make_shared<Held>(Held{std::move(*mesh), std::move(request->reservation), std::move(part)});
  const StoredMesh& stored = *held->mesh;
  FractureRequest asked{stored.mesh, stored.format, std::move(*parameters), stored.files};
  asked.digest = stored.digest;
  asked.triangles = stored.triangles;
  asked.owner = held;
  if (request->admission.route->operation == Operation::kPostMeshEstimate)
    return estimate(request, std::move(asked), terms, reply);
  return fracture(request, std::move(asked), terms, reply);
}

Answered Api::estimate(const std::shared_ptr<Request>& request, FractureRequest asked, const Terms& terms,
                       const Reply& reply) {
  auto parameters = std::make_shared<const RequestParameters>(asked.parameters);
  const std::shared_ptr<const void> owner = asked.owner;
  std::optional<Error> overload = dispatcher_.prepare(
      std::move(asked), terms,
      [this, request, terms, reply, parameters,
       owner](Expected<std::shared_ptr<const PreparedMesh>> prepared) {
        answering(*request, reply, [&]() -> Answered {
          if (!prepared) return refusal(with_time(std::move(prepared.error()), *request), request->id);
          const Step answer = [this, parameters, owner,
                               mesh = *prepared](const Execution& execution) -> Answered {
            const nlohmann::json document =
                estimate_document(*parameters, {mesh->solid, execution}, dispatcher_.most_bytes());
            return Response::text(200, "application/json", json_text(document, 2) + "\n");
          };
          // This may be an io thread, or the thread of another client's request for the same mesh.
          const double seconds =
              seconds_of_estimate(parameters->fracture, (*prepared)->solid, kEvaluationsWithAdvice);
          if (seconds <= kEstimateInline) return answer(kUninterrupted);
          return on_pool({seconds, 0}, request, terms, reply, answer);
        });
      });
  if (overload) return tl::unexpected<Problem>(to_problem(std::move(*overload)));
  return std::nullopt;
}

}  // namespace fracture::http
