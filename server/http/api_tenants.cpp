// Whose what is: a digest is no access token. What a name has not made or uploaded itself is not there for
// it, whatever address it gives.
#include "server/http/api.hpp"
#include "server/http/result_response.hpp"

namespace fracture::http {

std::string Api::owner_of(const Request& request) {
  return request.payer.account ? request.payer.account->owner() : "";
}

MeshStore::Whose Api::whose(const Request& request) {
  return !request.payer.account || request.payer.account->sees("") ? MeshStore::Whose::kAnybodys
                                                                   : MeshStore::Whose::kOwn;
}

bool Api::may_see(const Request& request, const std::string& key) {
  return whose(request) == MeshStore::Whose::kAnybodys || ledger_.has(owner_of(request), key);
}

void Api::enter_in_ledger(const Request& request, Terms& terms) {
  const std::string owner = owner_of(request);
  if (owner.empty()) return;
  terms.answered = [this, owner, account = request.payer.account](const FractureResult& result) {
    const std::uint64_t limit = account->shares().cached_bytes;
    for (const std::string& nobodys : ledger_.add(owner, result.key, result.file.size(), limit))
      for (const std::string& name : kept_names_of(nobodys)) service_.forget_result(name);
  };
}

std::optional<JobView> Api::find_job(const Request& request) {
  std::optional<JobView> job = jobs_.find(request.admission.segment);
  if (job && request.payer.account && !request.payer.account->sees(job->owner)) return std::nullopt;
  return job;
}

}  // namespace fracture::http
