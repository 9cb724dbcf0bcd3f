#include "server/service/mesh_store.hpp"

#include <iterator>
#include <utility>

namespace fracture {

MeshStore::Put MeshStore::put(std::shared_ptr<const StoredMesh> mesh, Clock::time_point now) {
  const std::uint64_t bytes = mesh->bytes();
  if (bytes > config_.quota_bytes) return Put::kOverQuota;
  const std::lock_guard lock(mutex_);
  expire(now);
  const auto at = index_.find(mesh->digest);
  const bool known = at != index_.end();
  if (known) remove(at->second);
  while (figures_.bytes + bytes > config_.quota_bytes) {
    remove(std::prev(entries_.end()));
    ++figures_.evicted;
  }
  entries_.push_front({std::move(mesh), now});
  index_.emplace(entries_.front().mesh->digest, entries_.begin());
  figures_.bytes += bytes;
  ++figures_.stored;
  return known ? Put::kReplaced : Put::kCreated;
}

std::shared_ptr<const StoredMesh> MeshStore::find(const std::string& digest, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  expire(now);
  const auto at = index_.find(digest);
  if (at == index_.end()) return nullptr;
  at->second->used = now;
  entries_.splice(entries_.begin(), entries_, at->second);
  return at->second->mesh;
}

bool MeshStore::erase(const std::string& digest) {
  const std::lock_guard lock(mutex_);
  const auto at = index_.find(digest);
  if (at == index_.end()) return false;
  remove(at->second);
  return true;
}

void MeshStore::sweep(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  expire(now);
}

StoreFigures MeshStore::figures() const {
  const std::lock_guard lock(mutex_);
  StoreFigures figures = figures_;
  figures.meshes = index_.size();
  return figures;
}

void MeshStore::expire(Clock::time_point now) {
  while (!entries_.empty() && entries_.back().used + config_.ttl <= now) {
    remove(std::prev(entries_.end()));
    ++figures_.expired;
  }
}

void MeshStore::remove(Iterator at) {
  figures_.bytes -= at->mesh->bytes();
  index_.erase(at->mesh->digest);
  entries_.erase(at);
}

}  // namespace fracture
