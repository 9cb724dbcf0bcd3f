// Counts buffers that a cache or store shares with requests: answers that slow clients read, and stored
// meshes in use by computations. Evicting such a buffer frees no memory while it is in use. So the use of
// each client is counted and limited here.
//
// An answer may be larger than its client's part of this memory. The rest is then set aside elsewhere, as
// working memory of the client. So however large the answers are, the next client finds room here.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/service/fair_share.hpp"

namespace fracture::http {

/// Thread-safe. Must outlive its holds. A buffer in use by several requests is counted once.
class HeldBuffers {
 public:
  enum class Refusal { kFull, kOverShare };

  /// Sets aside memory elsewhere: fills `aside`, whose destructor gives the memory back, or returns the reason
  /// for the refusal. Called with the lock; the destructor is called without it.
  using SetAside = std::function<std::optional<Refusal>(const std::string& client, std::uint64_t bytes,
                                                        std::shared_ptr<const void>& aside)>;

  /// `share`: bytes that one client may hold if it is the only one (FairShare). `set_aside` is called for the
  /// part of a client's first buffer that exceeds this limit. If it is empty, a single buffer may exceed the
  /// limit, and also the capacity if no other buffer is held.
  HeldBuffers(std::uint64_t capacity, std::uint64_t share, SetAside set_aside = {})
      : fair_{capacity, share}, set_aside_(std::move(set_aside)) {}

  /// A held buffer, which is counted until this object is destroyed.
  class Hold {
   public:
    Hold() = default;
    Hold(Hold&& other) noexcept
        : memory_(std::exchange(other.memory_, nullptr)),
          client_(std::move(other.client_)),
          buffer_(other.buffer_) {}
    Hold& operator=(Hold&& other) noexcept {
      std::swap(memory_, other.memory_);
      std::swap(client_, other.client_);
      std::swap(buffer_, other.buffer_);
      return *this;
    }
    ~Hold() {
      if (memory_) memory_->release(client_, buffer_);
    }

   private:
    friend HeldBuffers;
    HeldBuffers* memory_ = nullptr;
    std::string client_;
    const void* buffer_ = nullptr;
  };

  /// Fills `hold`, which must be empty, or returns the reason for the refusal. If it throws (no memory),
  /// nothing has changed.
  std::optional<Refusal> take(const std::string& client, const void* buffer, std::uint64_t bytes,
                              Hold& hold) {
    std::shared_ptr<const void> aside;  // before the lock: if an exception drops it, that is without the lock
    const std::lock_guard lock(mutex_);
    const auto of_client = by_client_.find(client);
    const auto known = all_.buffers.find(buffer);
    const bool holds = of_client != by_client_.end();
    const std::uint64_t shared = known == all_.buffers.end() ? 0 : known->second.bytes;
    const bool mine = holds && of_client->second.buffers.count(buffer) > 0;
    if (mine) {
      bytes = 0;  // counted already, here and elsewhere
    } else if (set_aside_ && !holds) {
      const std::uint64_t here = std::min(bytes, fair_.first(all_.bytes - shared, by_client_.size()));
      if (here < bytes)
        if (const auto refusal = set_aside_(client, bytes - here, aside)) {
          // If others hold the buffer, all of it is counted. Memory that they set aside then stays for this client.
          if (known != all_.buffers.end()) aside = known->second.by_others.lock();
          if (!aside && shared < bytes) return refusal;
        }
      bytes = here;
    } else if (const auto refusal =
                   refuses(holds ? &of_client->second : nullptr, bytes, known != all_.buffers.end())) {
      return refusal;
    }
    std::string name = client;
    Account& account = entries_of(client, buffer);  // the last allocation
    Buffer &everywhere = all_.add(buffer, bytes), &own = account.add(buffer, bytes);
    if (aside) {
      everywhere.by_others = aside;
      own.aside = std::move(aside);
    }
    hold.memory_ = this;
    hold.client_ = std::move(name);
    hold.buffer_ = buffer;
    return std::nullopt;
  }

  std::uint64_t used() const {
    const std::lock_guard lock(mutex_);
    return all_.bytes;
  }

 private:
  struct Buffer {
    std::size_t holders = 0;
    std::uint64_t bytes = 0;
    std::shared_ptr<const void> aside;    ///< memory for the rest; only in the accounts of clients
    std::weak_ptr<const void> by_others;  ///< the same of any of its holders; only in all_
  };
  struct Account {
    std::map<const void*, Buffer> buffers;
    std::uint64_t bytes = 0;

    /// Adds a holder to the buffer's entry, which must exist, and returns the entry.
    Buffer& add(const void* buffer, std::uint64_t size) {
      Buffer& entry = buffers.find(buffer)->second;
      ++entry.holders;
      if (entry.bytes >= size) return entry;
      bytes += size - entry.bytes;
      entry.bytes = size;
      return entry;
    }
    /// Removes an entry that has no holders.
    void tidy(const void* buffer) {
      const auto at = buffers.find(buffer);
      if (at != buffers.end() && at->second.holders == 0) buffers.erase(at);
    }
    /// Returns what was set aside for the buffer, if this was its last holder.
    std::shared_ptr<const void> remove(const void* buffer) {
      const auto at = buffers.find(buffer);
      if (--at->second.holders > 0) return nullptr;
      bytes -= at->second.bytes;
      std::shared_ptr<const void> aside = std::move(at->second.aside);
      buffers.erase(at);
      return aside;
    }
  };

  /// Makes the entries of the client and the buffer, still without holders, and returns the client's.
  /// Requires the lock.
  Account& entries_of(const std::string& client, const void* buffer) {
    const auto account = by_client_.try_emplace(client).first;
    try {
      account->second.buffers.try_emplace(buffer);
      all_.buffers.try_emplace(buffer);
    } catch (...) {
      account->second.tidy(buffer);
      if (account->second.buffers.empty()) by_client_.erase(account);
      throw;
    }
    return account->second;
  }

  /// Returns the reason why a client may not hold this buffer. `account`: the buffers that the client holds;
  /// null: it holds none. `shared`: others hold the buffer. Requires the lock.
  std::optional<Refusal> refuses(const Account* account, std::uint64_t bytes, bool shared) const {
    const std::uint64_t all = all_.bytes + (shared ? 0 : bytes), own = (account ? account->bytes : 0) + bytes;
    const bool may_exceed = all_.bytes == 0 && !set_aside_;
    if (may_exceed || fair_.allows(own, all, by_client_.size() - (account ? 1 : 0), !account))
      return std::nullopt;
    const bool have_shares = fair_.share < fair_.capacity;
    const bool by_own = have_shares && account && (all <= fair_.capacity || own > fair_.share);
    return by_own ? Refusal::kOverShare : Refusal::kFull;
  }

  void release(const std::string& client, const void* buffer) {
    std::shared_ptr<const void> aside;  // given back without the lock
    const std::lock_guard lock(mutex_);
    all_.remove(buffer);
    const auto at = by_client_.find(client);
    aside = at->second.remove(buffer);
    if (at->second.buffers.empty()) by_client_.erase(at);
  }

  const FairShare fair_;
  const SetAside set_aside_;
  mutable std::mutex mutex_;
  Account all_;
  std::map<std::string, Account> by_client_;
};

}  // namespace fracture::http
