// Bakes through a running server, or a farm of them behind a proxy that hashes on the mesh digest in
// the path.
//
//   POST /meshes/sha256:<digest>/fracture   Prefer: respond-async
//     ├─ 404 ──> PUT /meshes/sha256:<digest>, once for all jobs on that mesh ──> again
//     └─ 202 ──> GET /jobs/<id>/events, until its last event
//                  ├─ done ───> GET /fractures/sha256:<key>, digest checked
//                  ├─ failed ─> refused as the server words it
//                  └─ the job, or its result, is forgotten (a restart) ──> again from the top
//
// The key of a result hashes all that decides its bytes, the algorithm's version included, and is computed
// here too: an answer under another key is never written. Parameters that are too long for the path above go
// with the mesh in one POST /fracture, which no proxy needs to route. Everything may be asked twice: the same
// question has the same answer.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "server/bake/baker.hpp"
#include "server/bake/patient_caller.hpp"

namespace fracture::bake {

struct RemoteConfig {
  protocol::ConnectionSettings
      server;  ///< parse_server_url(), with the token and as many connections as jobs
  Patience patience;
};

/// Asks the server who it is first. kUnavailable (one sentence): it is absent, wants a token, is no
/// fracture-server, or is of another algorithm version, so that its bytes would be others than those of a
/// local bake. `say`: while it is waited for.
Expected<std::unique_ptr<Baker>> remote_baker(const RemoteConfig& config, const std::stop_token& stop,
                                              const std::function<void(const std::string&)>& say);
/// The same without a word to the server: for what parse() says.
std::unique_ptr<Baker> unasked_remote_baker(const RemoteConfig& config);

}  // namespace fracture::bake
