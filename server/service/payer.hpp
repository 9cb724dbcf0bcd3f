// For whom something is computed: whose turn it takes, and who is charged for it.
#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "server/service/fair_queue.hpp"
#include "server/tenants/account.hpp"

namespace fracture {

struct Payer {
  std::shared_ptr<tenants::Account> account{};  ///< null: nobody is asked for a token
  Flow flow{};                                  ///< of the name, else of the client's address
};

/// All who have waited for one computation, each once. Who left while it ran stays: it ran for them, too.
/// Thread-safe.
class Payers {
 public:
  void add(Payer payer) {
    const std::lock_guard lock(mutex_);
    const bool known =
        std::any_of(all_.begin(), all_.end(), [&](const Payer& p) { return p.flow.name == payer.flow.name; });
    if (!known) all_.push_back(std::move(payer));
  }
  std::vector<Payer> all() const {
    const std::lock_guard lock(mutex_);
    return all_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Payer> all_;
};

}  // namespace fracture
