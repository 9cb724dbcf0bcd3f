// Client side of meshes that a server stores by the digest of their bytes. No network.
//
//   POST /meshes/sha256:<digest>/fracture
//     └─ 404 not-found ──> PUT /meshes/sha256:<digest>, once for all requests that need it ──> again
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

/// Maximum number of bytes of the parameters in one fracture_request(): the server's limit.
inline constexpr std::size_t kMaxParameterBytes = 64u << 10;

/// "sha256:" and the digest in hex: the id of a mesh.
std::string mesh_id(std::string_view bytes);

/// PUT /meshes/{id}?{query}.
HttpRequest put_request(const std::string& mesh, std::string content_type,
                        std::shared_ptr<const std::string> body, const std::string& query = {});
/// POST /meshes/{id}/fracture with parameters as JSON text.
HttpRequest fracture_request(const std::string& mesh, std::string parameters);

/// Whether the answer to a fracture_request() says that the server does not have the mesh. A 404 from a proxy
/// has no problem of this service.
bool mesh_is_missing(int status, std::string_view problem_slug);

/// Ensures that only one of several requests that need the same missing mesh uploads it. Not thread-safe.
class PutOnce {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Role {
    kPut,    ///< upload the mesh, then call done()
    kWait,   ///< another request is uploading it: wait until it is no longer pending, then ask again
    kRetry,  ///< it was uploaded while the answer was on its way: ask again
  };

  /// For a request that was sent at `sent` and whose answer says that the mesh is missing.
  Role begin(const std::string& mesh, Clock::time_point sent);
  bool pending(const std::string& mesh) const { return pending_.contains(mesh); }
  void done(const std::string& mesh, bool stored);

 private:
  std::set<std::string> pending_;
  std::map<std::string, Clock::time_point> stored_;  ///< end time of the last successful PUT of each mesh
};

}  // namespace fracture::protocol
