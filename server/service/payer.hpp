// For whom something is computed: whose turn it takes, and who is charged for it.
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
  /// What it asks for takes this turn.
  Flow turn() const { return {flow.name, flow.weight, account}; }

  std::shared_ptr<tenants::Account> account{};  ///< null: nobody is asked for a token
  Flow flow{};                                  ///< of the name, else of the client's address
};

/// A payer, and the class of its request, which says what its seconds count as.
struct Waits {
  Payer payer;
  Priority priority = Priority::kBatch;
};

/// All who have waited for one computation, each once. Who left while it ran stays: it ran for them, too.
/// Thread-safe.
class Payers {
 public:
  /// Returns the seconds that all others were charged by now: this one owes them as well, and nobody else
  /// will charge it.
  double add(Payer payer, Priority priority) {
    const std::lock_guard lock(mutex_);
    const bool known = std::any_of(all_.begin(), all_.end(),
                                   [&](const Waits& p) { return p.payer.flow.name == payer.flow.name; });
    if (known) return 0;
    all_.push_back({std::move(payer), priority});
    return charged_;
  }
  /// Who is to be charged so many seconds more, each all of them.
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
