// The client for which a computation runs. The computation takes this client's turn, and its time is charged to the client's
// account.
#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "server/service/worker_pool.hpp"
#include "server/tenants/account.hpp"

namespace fracture {

struct Payer {
  /// Returns the turn that the payer's requests take.
  Flow turn() const { return {flow.name, flow.weight, account}; }

  std::shared_ptr<tenants::Account> account{};  ///< null: the server does not ask for tokens
  Flow flow{};  ///< identified by the payer's name, or else by the client's address
};

/// A payer, and the class of its request, which decides how much its seconds count.
struct Waits {
  Payer payer;
  Priority priority = Priority::kBatch;
};

/// All payers that have waited for one computation, each once. A payer that leaves early stays in the list, because the
/// computation also ran for this payer. Thread-safe.
class Payers {
 public:
  /// Adds a payer. Returns the seconds that all others have been charged so far; the caller must charge the new payer for
  /// them. Returns 0 if the payer was already in the list.
  double add(Payer payer, Priority priority) {
    const std::lock_guard lock(mutex_);
    const bool known = std::any_of(all_.begin(), all_.end(),
                                   [&](const Waits& p) { return p.payer.flow.name == payer.flow.name; });
    if (known) return 0;
    all_.push_back({std::move(payer), priority});
    return charged_;
  }
  /// Adds further seconds, and returns the payers to charge. Each payer is charged for all of the seconds.
  std::vector<Waits> charge(double seconds) {
    const std::lock_guard lock(mutex_);
    charged_ += seconds;
    return all_;
  }

 private:
  std::mutex mutex_;
  std::vector<Waits> all_;
  double charged_ = 0;
};

}  // namespace fracture
