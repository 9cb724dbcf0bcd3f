// Meshes that a server stores by the digest of their bytes, from the side of who sends them. No network.
//
//   POST /meshes/sha256:<digest>/fracture
//     └─ 404 not-found ──> PUT /meshes/sha256:<digest>, once for all who miss it ──> again
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

/// Bytes of the parameters of one fracture_request(): the server's limit.
inline constexpr std::size_t kMaxParameterBytes = 4096;

/// "sha256:" and the digest in hex: the id of a mesh.
std::string mesh_id(std::string_view bytes);

/// PUT /meshes/{id}?{query}.
HttpRequest put_request(const std::string& mesh, std::string content_type,
                        std::shared_ptr<const std::string> body, const std::string& query = {});
/// POST /meshes/{id}/fracture with parameters as JSON text.
HttpRequest fracture_request(const std::string& mesh, std::string parameters);

/// Does the answer to a fracture_request() say that the server has not got the mesh? A proxy's own 404 names no
/// problem of this service.
bool mesh_is_missing(int status, std::string_view problem_slug);

/// Of all who miss a mesh at the same time one puts it. Not thread-safe.
class PutOnce {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Role {
    kPut,    ///< puts it, and says done()
    kWait,   ///< somebody is putting it: waits until it is not pending any more, then asks again
    kRetry,  ///< it was put while the answer was on its way: asks again
  };

  /// For who sent a request at `sent` and was told that the mesh is missing.
  Role begin(const std::string& mesh, Clock::time_point sent);
  bool pending(const std::string& mesh) const { return pending_.contains(mesh); }
  void done(const std::string& mesh, bool stored);

 private:
  std::set<std::string> pending_;
  std::map<std::string, Clock::time_point> stored_;  ///< when the last PUT of a mesh had ended well
};

}  // namespace fracture::protocol
