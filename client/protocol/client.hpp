// The client of the service for a game: asks without waiting, answers are polled from the frame.
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
// What goes wrong is tried again as long as Settings::patience allows: a server that is absent (with growing
// pauses), one that is busy (after its Retry-After), a mesh that it has forgotten (PUT, then once more), an
// answer that is cut off or whose digest is wrong. All requests are repeatable: the same one gives the same
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
  /// Cancels what is open; waits for its own thread, not for the server.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Sends the mesh to be prepared, and keeps it for a server that forgets it. Returns its id, "sha256:…".
  /// `query`: what it will be fractured with, as far as that decides the solid ("material=glass" has walls); where
  /// it is missing, the first fracture prepares the mesh again. Hashes the bytes (1 ms for a megabyte): for the
  /// start of a level. The ticket's answer may be ignored.
  std::string add_mesh(std::string bytes, const std::string& content_type, const std::string& query = {},
                       Ticket* ticket = nullptr);

  /// Fragments as GLB. `parameters` as GET /patterns lists them. A mesh that was not added is answered with
  /// kRefused unless the server has it.
  Ticket fracture(const std::string& mesh, const nlohmann::json& parameters);

  /// GET /patterns: JSON.
  Ticket patterns();

  /// The answer will be kCancelled, unless it was on its way already. Unknown tickets are ignored.
  void cancel(Ticket ticket);

  /// The answers since the last call, in the order of their arrival. Never waits.
  std::vector<Answer> poll();

  Status status() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture::protocol
