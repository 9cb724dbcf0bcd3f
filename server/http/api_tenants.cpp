// Ownership: a digest does not grant access. A name can only see what it has made or uploaded itself, even if
// it knows the address of other resources.
#include "server/http/api.hpp"
#include "server/http/result_response.hpp"

namespace fracture::http {

std::string Api::owner_of(const Request& request) {
  return request.payer.account ? request.payer.account->owner() : "";
}

std::string Api::holder_of(const Request& request) {
  std::string owner = owner_of(request);
  return owner.empty() ? request.payer.flow.name : owner;
}

MeshStore::Whose Api::whose(const Request& request) {
  return !request.payer.account || request.payer.account->sees("") ? MeshStore::Whose::kAnybodys
                                                                   : MeshStore::Whose::kOwn;
}

bool Api::may_see(const Request& request, const std::string& key) {
  if (whose(request) == MeshStore::Whose::kAnybodys) return true;
  const std::string owner = owner_of(request);
  return ledger_.has(owner, key) || jobs_.has_result(owner, key);
}

void Api::enter_in_ledger(const Request& request, Terms& terms) {
  const std::string owner = owner_of(request);
  if (owner.empty()) return;
  terms.answered = [this, owner, account = request.payer.account](const FractureResult& result) {
    enter_in_ledger(*account, owner, result.key, result.file.size());
  };
}

void Api::enter_in_ledger(const tenants::Account& account, const std::string& owner, const std::string& key,
                          std::uint64_t bytes) {
  for (const std::string& nobodys : ledger_.add(owner, key, bytes, account.shares().cached_bytes)) {
    if (jobs_.needs_result(nobodys)) continue;
    for (const std::string& name : kept_names_of(nobodys)) service_.forget_result(name);
  }
}

void Api::resume_jobs(
    const std::function<std::shared_ptr<tenants::Account>(const std::string& name)>& account_of) {
  const auto terms_of = [this, account_of](const std::string& owner) {
    Terms terms;
    terms.payer.flow.name = "jobs from an earlier process";  // if their records do not name the client
    const auto account = owner.empty() ? nullptr : account_of(owner);
    if (!account) return terms;  // the name is gone from the token file: only an administrator sees the job
    terms.payer = {account, {"name " + account->name(), account->shares().weight}};
    terms.answered = [this, owner, account](const FractureResult& result) {
      enter_in_ledger(*account, owner, result.key, result.file.size());
    };
    return terms;
  };
  jobs_.resume(terms_of, [this, account_of](const JobView& job) {
    const auto account = job.owner.empty() ? nullptr : account_of(job.owner);
    const auto bytes = service_.tiers().expected_bytes(job.result_key);
    if (account && bytes) enter_in_ledger(*account, job.owner, job.result_key, *bytes);
  });
}

bool Api::sees(const Payer& payer, const JobView& job) {
  return !payer.account || payer.account->sees(job.owner);
}

std::optional<Problem> Api::lost_result(const Request& request, const std::string& key, bool nowhere) {
  const auto sees = [&payer = request.payer](const std::string& owner) {
    return !payer.account || payer.account->sees(owner);
  };
  std::optional<Error> lost = jobs_.lost_result(key, sees, nowhere);
  return lost ? std::optional(to_problem(std::move(*lost))) : std::nullopt;
}

std::optional<JobView> Api::find_job(const Request& request) {
  std::optional<JobView> job = jobs_.find(request.admission.segment);
  if (job && !sees(request.payer, *job)) return std::nullopt;
  return job;
}

}  // namespace fracture::http
