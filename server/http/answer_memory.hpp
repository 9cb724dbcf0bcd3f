// Answers on their way: a cache that lets go of a result frees nothing while somebody still reads it, so what
// slow readers hold is counted and bounded too.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace fracture::http {

/// Thread-safe; outlives its holds. A buffer that many connections are sent from is held once.
class AnswerMemory {
 public:
  enum class Refusal { kFull, kOverShare };

  /// `share`: what one address may hold. Whoever holds nothing else may exceed both.
  AnswerMemory(std::uint64_t capacity, std::uint64_t share) : capacity_(capacity), share_(share) {}

  /// Counted from now until it is destroyed.
  class Hold {
   public:
    Hold() = default;
    Hold(Hold&& other) noexcept
        : memory_(std::exchange(other.memory_, nullptr)),
          address_(std::move(other.address_)),
          buffer_(other.buffer_) {}
    Hold& operator=(Hold&& other) noexcept {
      std::swap(memory_, other.memory_);
      std::swap(address_, other.address_);
      std::swap(buffer_, other.buffer_);
      return *this;
    }
    ~Hold() {
      if (memory_) memory_->release(address_, buffer_);
    }

   private:
    friend AnswerMemory;
    AnswerMemory* memory_ = nullptr;
    std::string address_;
    const void* buffer_ = nullptr;
  };

  /// Fills `hold`, or says why not.
  std::optional<Refusal> take(const std::string& address, const void* buffer, std::uint64_t bytes,
                              Hold& hold) {
    const std::lock_guard lock(mutex_);
    const auto held = all_.buffers.find(buffer);
    const auto of_address = by_address_.find(address);
    const bool mine = of_address != by_address_.end() && of_address->second.buffers.count(buffer) > 0;
    if (!mine && share_ < capacity_ && of_address != by_address_.end() &&
        of_address->second.bytes + bytes > share_)
      return Refusal::kOverShare;
    if (held == all_.buffers.end() && all_.bytes > 0 && all_.bytes + bytes > capacity_) return Refusal::kFull;
    all_.add(buffer, bytes);
    by_address_[address].add(buffer, bytes);
    hold = Hold();
    hold.memory_ = this;
    hold.address_ = address;
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

  void release(const std::string& address, const void* buffer) {
    const std::lock_guard lock(mutex_);
    all_.remove(buffer);
    const auto at = by_address_.find(address);
    at->second.remove(buffer);
    if (at->second.buffers.empty()) by_address_.erase(at);
  }

  const std::uint64_t capacity_, share_;
  mutable std::mutex mutex_;
  Account all_;
  std::map<std::string, Account> by_address_;
};

}  // namespace fracture::http
