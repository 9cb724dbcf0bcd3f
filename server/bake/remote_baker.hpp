// Bakes through a running server, or through a farm behind a proxy that routes by the mesh digest in the
// path.
//
//   POST /meshes/sha256:<digest>/fracture   Prefer: respond-async
//     ├─ 404 ──> PUT /meshes/sha256:<digest>, once for all jobs on that mesh ──> again
//     └─ 202 ──> GET /jobs/<id>/events, until its last event
//                  ├─ done ───> GET /fractures/sha256:<key>, digest checked
//                  ├─ failed ─> refused as the server words it
//                  └─ the job, or its result, is forgotten (a restart) ──> again from the top
//
// The key of a result is a hash of everything that decides its bytes, including the algorithm version. This
// program computes it too, and never writes an answer with another key. If the parameters are too long for
// this path, they are sent with the mesh in one POST /fracture, which a proxy need not route. Every request
// may be repeated, because equal requests have equal answers.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "server/bake/baker.hpp"
#include "server/bake/patient_caller.hpp"

namespace fracture::bake {

struct RemoteConfig {
  protocol::ConnectionSettings server;  ///< parse_server_url(), with the token and one connection per job
  Patience patience;
};

/// Creates a remote baker and checks the server first. Returns kUnavailable (one sentence) if the server is
/// absent, wants a token, is not a fracture-server, or runs another algorithm version, whose bytes would
/// differ from those of a local bake. `say` receives messages while the server is being waited for.
Expected<std::unique_ptr<Baker>> remote_baker(const RemoteConfig& config, const std::stop_token& stop,
                                              const std::function<void(const std::string&)>& say);
/// Creates a remote baker without contacting the server. Only parse() is useful.
std::unique_ptr<Baker> unasked_remote_baker(const RemoteConfig& config);

}  // namespace fracture::bake
