// Which name has made which answer. The address of an answer is a digest that others can learn or work out;
// it opens the answer only to names that stand here.
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

/// Thread-safe. Takes `capacity` bytes at most: where it is full, names forget their least recently used
/// answers, whoever has most of them first.
class AnswerLedger {
 public:
  /// What an entry takes (measured: tests/server/tenants/tenant_account_test.cpp).
  static constexpr std::uint64_t kBytesPerEntry = 512;

  explicit AnswerLedger(std::uint64_t capacity) : capacity_(capacity) {}

  /// `owner` made the answer, or was given it. Its least recently used ones leave while all of them together
  /// have more than `limit` bytes, this one too where it alone does. Returns what nobody has any more.
  std::vector<std::string> add(const std::string& owner, const std::string& key, std::uint64_t bytes,
                               std::uint64_t limit);
  /// A use.
  bool has(const std::string& owner, const std::string& key);
  std::uint64_t bytes_of(const std::string& owner) const;
  /// Of the ledger itself.
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
  Owners owned_;                                           // none without entries
  std::unordered_map<std::string, std::uint32_t> owners_;  // how many, by key
  std::uint64_t entries_ = 0;
};

}  // namespace fracture::tenants
