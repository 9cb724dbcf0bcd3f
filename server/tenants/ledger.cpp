#include "server/tenants/ledger.hpp"

#include <algorithm>
#include <utility>

namespace fracture::tenants {

std::vector<std::string> AnswerLedger::add(const std::string& owner, const std::string& key,
                                           std::uint64_t bytes, std::uint64_t limit) {
  const std::lock_guard lock(mutex_);
  const auto mine = owned_.try_emplace(owner).first;
  Owned& owned = mine->second;
  if (const auto at = owned.index.find(key); at != owned.index.end()) {
    owned.bytes -= at->second->bytes;
    at->second->bytes = bytes;
    owned.entries.splice(owned.entries.begin(), owned.entries, at->second);
  } else {
    owned.entries.push_front({key, bytes});
    owned.index.emplace(owned.entries.front().key, owned.entries.begin());
    ++owners_[key];
    ++entries_;
  }
  owned.bytes += bytes;
  std::vector<std::string> nobodys;
  while (owned.bytes > limit && owned.entries.size() > 1) drop_last(mine, nobodys);
  if (owned.bytes > limit) drop_last(mine, nobodys);
  while (entries_ * kBytesPerEntry > capacity_)
    drop_last(std::max_element(owned_.begin(), owned_.end(),
                               [](const auto& a, const auto& b) {
                                 return a.second.entries.size() < b.second.entries.size();
                               }),
              nobodys);
  return nobodys;
}

bool AnswerLedger::has(const std::string& owner, const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto owned = owned_.find(owner);
  if (owned == owned_.end()) return false;
  const auto at = owned->second.index.find(key);
  if (at == owned->second.index.end()) return false;
  auto& entries = owned->second.entries;
  entries.splice(entries.begin(), entries, at->second);
  return true;
}

std::uint64_t AnswerLedger::bytes_of(const std::string& owner) const {
  const std::lock_guard lock(mutex_);
  const auto at = owned_.find(owner);
  return at == owned_.end() ? 0 : at->second.bytes;
}

std::uint64_t AnswerLedger::held_bytes() const {
  const std::lock_guard lock(mutex_);
  return entries_ * kBytesPerEntry;
}

/// Removes the owner's least recently used answer, and the owner with its last answer.
void AnswerLedger::drop_last(Owners::iterator owner, std::vector<std::string>& nobodys) {
  Owned& owned = owner->second;
  Entry& last = owned.entries.back();
  owned.bytes -= last.bytes;
  owned.index.erase(last.key);
  const auto owners = owners_.find(last.key);
  if (--owners->second == 0) {
    owners_.erase(owners);
    nobodys.push_back(std::move(last.key));
  }
  owned.entries.pop_back();
  --entries_;
  if (owned.entries.empty()) owned_.erase(owner);
}

}  // namespace fracture::tenants
