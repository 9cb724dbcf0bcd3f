#include "server/service/mesh_store.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// A mesh is kept within the request's buffer if the rest of the buffer is at most this plus a sixteenth of the mesh.
constexpr std::uint64_t kSlack = 4096;

std::uint64_t size_of(const FractureRequest& request) { return input_bytes(request.mesh, request.files); }

}  // namespace

std::uint64_t StoredMesh::own_bytes() const {
  // The object, and its nodes in three tables, with digest and owner (measured in mesh_store_test.cpp).
  constexpr std::uint64_t kTables = 1024;
  return kTables + files.capacity() * sizeof(ImportFile) + description->capacity();
}

bool is_kept_as_copy(const FractureRequest& request, std::uint64_t capacity) {
  const std::uint64_t size = size_of(request);
  return !request.owner || capacity > size + size / 16 + kSlack;
}

std::shared_ptr<StoredMesh> stored_mesh_of(const FractureRequest& request, std::uint64_t capacity,
                                           const Execution& execution) {
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
    append_with_polls(execution, *copy, bytes);
    bytes = std::span(*copy).subspan(at, bytes.size());
  };
  keep(stored->mesh);
  for (ImportFile& file : stored->files) keep(file.bytes);
  stored->owner = copy;
  stored->capacity = copy->capacity();
  return stored;
}

std::shared_ptr<const StoredMesh> MeshStore::equal_of(const StoredMesh& mesh, const Execution& execution) {
  std::shared_ptr<const StoredMesh> other;
  {
    const std::lock_guard lock(mutex_);
    if (const Iterator found = at(mesh.digest, "", Whose::kAnybodys); found != entries_.end())
      other = found->mesh;
  }
  // Compares all bytes, because an equal digest alone must not give a client another client's mesh.
  const auto same = [&execution](std::span<const std::byte> a, std::span<const std::byte> b) {
    if (a.size() != b.size()) return false;
    for (std::size_t at = 0; at < a.size(); at += kBytesBetweenPolls) {
      execution.poll();
      if (std::memcmp(a.data() + at, b.data() + at, std::min(a.size() - at, kBytesBetweenPolls)) != 0)
        return false;
    }
    return true;
  };
  if (!other || !same(mesh.mesh, other->mesh) || mesh.files.size() != other->files.size()) return nullptr;
  for (std::size_t k = 0; k < mesh.files.size(); ++k)
    if (mesh.files[k].name != other->files[k].name || !same(mesh.files[k].bytes, other->files[k].bytes))
      return nullptr;
  return other;
}

std::shared_ptr<const void> MeshStore::counted(const std::shared_ptr<Sum>& sum, const StoredMesh& mesh) {
  struct Counted {
    Counted(std::shared_ptr<Sum> its_sum, std::shared_ptr<const void> its_owner, std::uint64_t its_bytes)
        : sum(std::move(its_sum)), owner(std::move(its_owner)), bytes(its_bytes) {
      sum->bytes += bytes;
      ++sum->meshes;
    }
    ~Counted() {
      sum->bytes -= bytes;
      --sum->meshes;
    }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    const std::shared_ptr<Sum> sum;
    const std::shared_ptr<const void> owner;
    const std::uint64_t bytes;
  };
  const auto held = std::make_shared<const Counted>(sum, mesh.owner, mesh.shared_bytes());
  return {held, mesh.owner.get()};
}

MeshStore::Put MeshStore::put(std::shared_ptr<const StoredMesh> mesh, const Owner& owner,
                              Clock::time_point now, const Execution& execution) {
  const std::uint64_t bytes = mesh->held(), shared = mesh->shared_bytes(), own = mesh->own_bytes();
  if (bytes > config_.quota_bytes) return Put::kOverQuota;
  if (bytes > owner.share) return Put::kOverShare;
  const auto equal = equal_of(*mesh, execution);
  if (equal) {
    auto with_its_bytes = std::make_shared<StoredMesh>(*mesh);
    with_its_bytes->owner = equal->owner;
    with_its_bytes->mesh = equal->mesh;
    with_its_bytes->files = equal->files;
    with_its_bytes->capacity = equal->capacity;
    mesh = std::move(with_its_bytes);
  }
  const std::lock_guard lock(mutex_);
  expire(now);
  const auto known = index_.find({mesh->digest, owner.name});
  const bool replaces = known != index_.end();
  const std::uint64_t needed = own + (equal ? 0 : shared);
  const std::uint64_t would_hold =
      figures_.bytes + sum_->bytes + needed - (replaces ? known->second->mesh->own_bytes() : 0);
  if (would_hold > config_.quota_bytes && !can_free(would_hold - config_.quota_bytes)) return Put::kNoRoom;
  if (replaces) remove(known->second);
  while (bytes_of_locked(owner.name) + bytes > owner.share) {
    remove_least_recent_of(owner.name);
    ++figures_.evicted;
  }
  while (figures_.bytes + sum_->bytes + needed > config_.quota_bytes) {
    if (!remove_one_of_most()) return Put::kNoRoom;
    ++figures_.evicted;
  }
  if (!equal) {
    auto with_counted_bytes = std::make_shared<StoredMesh>(*mesh);
    with_counted_bytes->owner = counted(sum_, *mesh);
    mesh = std::move(with_counted_bytes);
  }
  figures_.bytes += own;
  entries_.push_front({std::move(mesh), owner.name, bytes, now});
  Owned& owned = owned_[owner.name];
  owned.bytes += bytes;
  owned.entries.push_front(entries_.begin());
  entries_.front().among_own = owned.entries.begin();
  index_.emplace(std::pair(entries_.front().mesh->digest, owner.name), entries_.begin());
  ++figures_.stored;
  return replaces ? Put::kReplaced : Put::kCreated;
}

MeshStore::Iterator MeshStore::at(const std::string& digest, const std::string& owner, Whose whose) {
  if (const auto own = index_.find({digest, owner}); own != index_.end()) return own->second;
  if (whose == Whose::kOwn) return entries_.end();
  const auto any = index_.lower_bound({digest, ""});
  return any != index_.end() && any->first.first == digest ? any->second : entries_.end();
}

std::shared_ptr<const StoredMesh> MeshStore::find(const std::string& digest, const std::string& owner,
                                                  Whose whose, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  expire(now);
  for (Iterator found; (found = at(digest, owner, whose)) != entries_.end();) {
    if (has_expired(*found, now)) {  // expire() has not reached it yet
      remove(found);
      ++figures_.expired;
      continue;
    }
    found->used = now;
    entries_.splice(entries_.begin(), entries_, found);
    std::list<Iterator>& own = owned_.at(found->owner).entries;
    own.splice(own.begin(), own, found->among_own);
    return found->mesh;
  }
  return nullptr;
}

bool MeshStore::has(const std::string& digest) {
  const std::lock_guard lock(mutex_);
  return at(digest, "", Whose::kAnybodys) != entries_.end();
}

bool MeshStore::erase(const std::string& digest, const std::string& owner, Whose whose) {
  const std::lock_guard lock(mutex_);
  bool any = false;
  for (Iterator found; (found = at(digest, owner, whose)) != entries_.end(); any = true) remove(found);
  return any;
}

std::uint64_t MeshStore::bytes_of(const std::string& owner) const {
  const std::lock_guard lock(mutex_);
  return bytes_of_locked(owner);
}

std::uint64_t MeshStore::bytes_of_locked(const std::string& owner) const {
  const auto owned = owned_.find(owner);
  return owned == owned_.end() ? 0 : owned->second.bytes;
}

bool MeshStore::can_free(std::uint64_t bytes) const {
  std::uint64_t sum = 0;
  for (auto at = index_.begin(); at != index_.end() && sum < bytes;) {
    // Equal meshes of several owners share memory. It becomes free with the last of them.
    const std::string& digest = at->first.first;
    bool all_free = true;
    std::uint64_t shared = 0;
    for (; at != index_.end() && at->first.first == digest; ++at) {
      const Entry& entry = *at->second;
      const std::uint64_t own = entry.mesh->own_bytes();
      shared = entry.mesh->shared_bytes();
      if (entry.mesh.use_count() == 1)
        sum += own;
      else
        all_free = false;
    }
    if (all_free) sum += shared;
  }
  return sum >= bytes;
}

bool MeshStore::remove_one_of_most() {
  const Owned* most = nullptr;
  Iterator chosen{};
  for (const auto& [name, owned] : owned_) {
    if (most && owned.bytes <= most->bytes) continue;
    const auto free = std::find_if(owned.entries.rbegin(), owned.entries.rend(),
                                   [](const Iterator& entry) { return entry->mesh.use_count() == 1; });
    if (free == owned.entries.rend()) continue;
    most = &owned;
    chosen = *free;
  }
  if (most) remove(chosen);
  return most != nullptr;
}

void MeshStore::remove_least_recent_of(const std::string& owner) { remove(owned_.at(owner).entries.back()); }

void MeshStore::sweep(Clock::time_point now) {
  for (bool done = false; !done;) {
    const std::lock_guard lock(mutex_);
    done = expire(now);
  }
}

StoreFigures MeshStore::figures() const {
  const std::lock_guard lock(mutex_);
  StoreFigures figures = figures_;
  figures.bytes += sum_->bytes;
  figures.meshes = sum_->meshes;
  return figures;
}

bool MeshStore::expire(Clock::time_point now) {
  int most = kExpiredAtOnce;
  for (; !entries_.empty() && has_expired(entries_.back(), now); --most) {
    if (most == 0) return false;
    remove(std::prev(entries_.end()));
    ++figures_.expired;
  }
  return true;
}

void MeshStore::remove(Iterator at) {
  figures_.bytes -= at->mesh->own_bytes();
  const auto owned = owned_.find(at->owner);
  owned->second.bytes -= at->bytes;
  owned->second.entries.erase(at->among_own);
  index_.erase({at->mesh->digest, at->owner});
  if (owned->second.entries.empty()) owned_.erase(owned);
  entries_.erase(at);
}

}  // namespace fracture
