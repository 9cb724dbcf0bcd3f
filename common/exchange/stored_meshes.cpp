#include "common/exchange/stored_meshes.hpp"

#include <utility>

#include "common/digest/digest.hpp"

namespace fracture::protocol {

std::string mesh_id(std::string_view bytes) { return "sha256:" + sha256(bytes).hex(); }

HttpRequest put_request(const std::string& mesh, std::string content_type,
                        std::shared_ptr<const std::string> body, const std::string& query) {
  return {.method = "PUT",
          .target = "/meshes/" + mesh + (query.empty() ? "" : "?" + query),
          .content_type = std::move(content_type),
          .body = std::move(body)};
}

HttpRequest fracture_request(const std::string& mesh, std::string parameters) {
  return {.method = "POST",
          .target = "/meshes/" + mesh + "/fracture",
          .content_type = "application/json",
          .body = std::make_shared<const std::string>(std::move(parameters))};
}

bool mesh_is_missing(int status, std::string_view problem_slug) {
  return status == 404 && problem_slug == "not-found";
}

PutOnce::Role PutOnce::begin(const std::string& mesh, Clock::time_point sent) {
  if (const auto last = stored_.find(mesh); last != stored_.end() && last->second >= sent)
    return Role::kRetry;
  return pending_.insert(mesh).second ? Role::kPut : Role::kWait;
}

void PutOnce::done(const std::string& mesh, bool stored) {
  pending_.erase(mesh);
  if (stored) stored_[mesh] = Clock::now();
}

}  // namespace fracture::protocol
