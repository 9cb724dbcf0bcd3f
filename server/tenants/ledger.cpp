#include "server/tenants/ledger.hpp"

#include <utility>

namespace fracture::tenants {

std::vector<std::string> AnswerLedger::add(const std::string& owner, const std::string& key,
                                           std::uint64_t bytes, std::uint64_t limit) {
  const std::lock_guard lock(mutex_);
  Owned& owned = owned_[owner];
  if (const auto at = owned.index.find(key); at != owned.index.end()) {
    owned.bytes -= at->second->bytes;
    at->second->bytes = bytes;
    owned.entries.splice(owned.entries.begin(), owned.entries, at->second);
  } else {
    owned.entries.push_front({key, bytes});
    owned.index.emplace(key, owned.entries.begin());
    ++owners_[key];
  }
  owned.bytes += bytes;
  std::vector<std::string> nobodys;
  while (owned.bytes > limit || owned.entries.size() > kMostAnswers) drop_last(owned, nobodys);
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

void AnswerLedger::drop_last(Owned& owned, std::vector<std::string>& nobodys) {
  Entry& last = owned.entries.back();
  owned.bytes -= last.bytes;
  owned.index.erase(last.key);
  const auto owners = owners_.find(last.key);
  if (--owners->second == 0) {
    owners_.erase(owners);
    nobodys.push_back(std::move(last.key));
  }
  owned.entries.pop_back();
}

}  // namespace fracture::tenants
