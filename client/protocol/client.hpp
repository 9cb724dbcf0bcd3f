// A client of the service for games: it never blocks, and answers are polled from the frame thread.
//
//   frame thread:  add_mesh ── fracture ── cancel                    poll ── status
//                      │           │         │                        ▲
//                      ▼           ▼         ▼                        │ one lock, held for a swap of vectors
//   IO thread:     PUT by digest · POST …/fracture · retries ──> checked answers
//
//     Client client({.port = 8080});
//     const std::string barrel = client.add_mesh(glb_bytes, "model/gltf-binary");
//     …
//     const Ticket broken = client.fracture(barrel, {{"material", "wood"}, {"impacts", {0.1, 0.4, 0.2}}});
//     …
//     for (Answer& answer : client.poll()) …   // every frame
//
// client/README.md shows a second hit on the same answer.
//
// Settings::patience limits how long failed requests are retried. A retry follows if the server is absent (after
// growing pauses) or busy (after its Retry-After), if it has forgotten a mesh (PUT, then one retry), or if an answer
// is cut off or its digest is wrong. All requests can be repeated safely, because identical requests give identical
// bytes.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>

#include "client/protocol/protocol.hpp"

namespace fracture::protocol {

class Client {
 public:
  explicit Client(Settings settings);
  /// Cancels open requests. Waits for its own thread, but not for the server.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Sends the mesh to be prepared, and keeps it in case the server forgets it. Returns its id, "sha256:…".
  /// `query`: the parameters of its fractures that shape the solid ("material=glass" has walls). If it is missing,
  /// the first fracture prepares the mesh again. Hashes the bytes (1 ms per megabyte), so call it when a level starts.
  /// The ticket's answer may be ignored.
  std::string add_mesh(std::string bytes, const std::string& content_type, const std::string& query = {},
                       Ticket* ticket = nullptr);

  /// Requests fragments as GLB. `parameters`: those listed by GET /patterns. The answer for a mesh that was not added is
  /// kRefused, unless the server has the mesh.
  Ticket fracture(const std::string& mesh, const nlohmann::json& parameters);

  /// GET /patterns: JSON.
  Ticket patterns();

  /// The answer will be kCancelled, unless it was already on its way. Unknown tickets are ignored.
  void cancel(Ticket ticket);

  /// The answers since the last call, in order of arrival. Never blocks.
  std::vector<Answer> poll();

  Status status() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture::protocol
