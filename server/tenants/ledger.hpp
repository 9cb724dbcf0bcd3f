// Records which names have made which answers. An answer's address is a digest that others can learn or compute, so only the
// names recorded here may fetch the answer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace fracture::tenants {

/// Thread-safe. Takes at most `capacity` bytes. If it is full, the name with the most answers loses its least recently used
/// one.
class AnswerLedger {
 public:
  /// Bytes that an entry takes (measured in tests/server/tenants/tenant_account_test.cpp).
  static constexpr std::uint64_t kBytesPerEntry = 512;

  explicit AnswerLedger(std::uint64_t capacity) : capacity_(capacity) {}

  /// Records that `owner` has made or received the answer. If the owner's answers exceed `limit` bytes, the least recently
  /// used ones are removed. If the new answer alone exceeds the limit, it is also removed. Returns the keys that no name has
  /// any more.
  std::vector<std::string> add(const std::string& owner, const std::string& key, std::uint64_t bytes,
                               std::uint64_t limit);
  /// Returns whether `owner` has the answer. Counts as a use.
  bool has(const std::string& owner, const std::string& key);
  std::uint64_t bytes_of(const std::string& owner) const;
  /// Returns the memory that the ledger itself takes.
  std::uint64_t held_bytes() const;

 private:
  struct Entry {
    std::string key;
    std::uint64_t bytes;
  };
  struct Owned {
    std::list<Entry> entries;  // most recently used first
    std::unordered_map<std::string_view, std::list<Entry>::iterator> index;
    std::uint64_t bytes = 0;
  };
  using Owners = std::map<std::string, Owned>;
  void drop_last(Owners::iterator owner, std::vector<std::string>& nobodys);

  const std::uint64_t capacity_;
  mutable std::mutex mutex_;
  Owners owned_;                                           // contains only owners with entries
  std::unordered_map<std::string, std::uint32_t> owners_;  // number of owners by key
  std::uint64_t entries_ = 0;
};

}  // namespace fracture::tenants
