// Counts buffers that a cache or store shares with requests: answers that slow clients read, and stored
// meshes in use by computations. Evicting such a buffer frees no memory while it is in use. So the use of
// each client is counted and limited here.
#pragma once

#include <cstdint>
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

  /// `share`: bytes that one client may hold if it is the only one (FairShare). If no other buffer is held, a
  /// buffer may be larger than the capacity.
  HeldBuffers(std::uint64_t capacity, std::uint64_t share) : fair_{capacity, share} {}

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

  /// Fills `hold`, or returns the reason for the refusal.
  std::optional<Refusal> take(const std::string& client, const void* buffer, std::uint64_t bytes,
                              Hold& hold) {
    const std::lock_guard lock(mutex_);
    const auto of_client = by_client_.find(client);
    const std::uint64_t before = of_client == by_client_.end() ? 0 : of_client->second.bytes;
    const bool mine = before > 0 && of_client->second.buffers.count(buffer) > 0;
    const std::uint64_t all = all_.bytes + (all_.buffers.count(buffer) > 0 ? 0 : bytes), own = before + bytes;
    const bool fits = mine || all_.bytes == 0 ||
                      fair_.allows(own, all, by_client_.size() - (before > 0 ? 1 : 0), before == 0);
    if (!fits) {
      const bool have_shares = fair_.share < fair_.capacity;
      const bool by_own = have_shares && before > 0 && (all <= fair_.capacity || own > fair_.share);
      return by_own ? Refusal::kOverShare : Refusal::kFull;
    }
    all_.add(buffer, bytes);
    by_client_[client].add(buffer, bytes);
    hold = Hold();
    hold.memory_ = this;
    hold.client_ = client;
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
  };
  struct Account {
    std::map<const void*, Buffer> buffers;
    std::uint64_t bytes = 0;

    void add(const void* buffer, std::uint64_t size) {
      Buffer& entry = buffers[buffer];
      ++entry.holders;
      if (entry.bytes >= size) return;
      bytes += size - entry.bytes;
      entry.bytes = size;
    }
    void remove(const void* buffer) {
      const auto at = buffers.find(buffer);
      if (--at->second.holders > 0) return;
      bytes -= at->second.bytes;
      buffers.erase(at);
    }
  };

  void release(const std::string& client, const void* buffer) {
    const std::lock_guard lock(mutex_);
    all_.remove(buffer);
    const auto at = by_client_.find(client);
    at->second.remove(buffer);
    if (at->second.buffers.empty()) by_client_.erase(at);
  }

  const FairShare fair_;
  mutable std::mutex mutex_;
  Account all_;
  std::map<std::string, Account> by_client_;
};

}  // namespace fracture::http
