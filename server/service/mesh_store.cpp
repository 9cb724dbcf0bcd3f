#include "server/service/mesh_store.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/base/json_reader.hpp"

namespace fracture {
namespace {

/// A mesh is kept with what came around it where that is at most this, and a sixteenth of it.
constexpr std::uint64_t kSlack = 4096;

std::uint64_t size_of(const FractureRequest& request) {
  std::uint64_t size = request.mesh.size();
  for (const ImportFile& file : request.files) size += file.bytes.size();
  return size;
}

}  // namespace

std::uint64_t StoredMesh::held() const {
  // Digest, index and list are not counted: some 300 bytes.
  return std::max(bytes(), capacity) + files.capacity() * sizeof(ImportFile) + json_bytes(report);
}

bool is_kept_as_copy(const FractureRequest& request, std::uint64_t capacity) {
  const std::uint64_t size = size_of(request);
  return !request.owner || capacity > size + size / 16 + kSlack;
}

std::shared_ptr<StoredMesh> stored_mesh_of(const FractureRequest& request, std::uint64_t capacity) {
  auto stored = std::make_shared<StoredMesh>();
  stored->digest = request.digest;
  stored->format = request.format;
  stored->files = request.files;
  stored->mesh = request.mesh;
  if (!is_kept_as_copy(request, capacity)) {
    stored->owner = request.owner;
    stored->capacity = capacity;
    return stored;
  }
  const auto copy = std::make_shared<std::vector<std::byte>>();
  copy->reserve(size_of(request));
  const auto keep = [&](std::span<const std::byte>& bytes) {
    const std::size_t at = copy->size();
    copy->insert(copy->end(), bytes.begin(), bytes.end());
    bytes = std::span(*copy).subspan(at, bytes.size());
  };
  keep(stored->mesh);
  for (ImportFile& file : stored->files) keep(file.bytes);
  stored->owner = copy;
  stored->capacity = copy->capacity();
  return stored;
}

MeshStore::Put MeshStore::put(std::shared_ptr<const StoredMesh> mesh, Clock::time_point now) {
  const std::uint64_t bytes = mesh->held();
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
  figures_.bytes -= at->mesh->held();
  index_.erase(at->mesh->digest);
  entries_.erase(at);
}

}  // namespace fracture
