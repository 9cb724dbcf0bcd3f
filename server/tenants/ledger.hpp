// Which name has made which answer. The address of an answer is a digest that others can learn or work out;
// it opens the answer only to names that stand here.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

namespace fracture::tenants {

/// Thread-safe.
class AnswerLedger {
 public:
  /// Answers that one name has at most; the least recently used leave.
  static constexpr std::size_t kMostAnswers = 100'000;

  /// `owner` made the answer, or was given it. Its least recently used ones leave while all of them together
  /// have more than `limit` bytes, this one too where it alone does. Returns what nobody has any more.
  std::vector<std::string> add(const std::string& owner, const std::string& key, std::uint64_t bytes,
                               std::uint64_t limit);
  /// A use.
  bool has(const std::string& owner, const std::string& key);
  std::uint64_t bytes_of(const std::string& owner) const;

 private:
  struct Entry {
    std::string key;
    std::uint64_t bytes;
  };
  struct Owned {
    std::list<Entry> entries;  // most recently used first
    std::unordered_map<std::string, std::list<Entry>::iterator> index;
    std::uint64_t bytes = 0;
  };
  void drop_last(Owned& owned, std::vector<std::string>& nobodys);

  mutable std::mutex mutex_;
  std::map<std::string, Owned> owned_;
  std::unordered_map<std::string, std::uint32_t> owners_;  // how many, by key
};

}  // namespace fracture::tenants
