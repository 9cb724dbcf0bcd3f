// Meshes that clients have left here, by their digest: sent once, fractured as often as they break. The bytes
// are kept, not the prepared solid: that one lives in the mesh cache and is made again from the bytes when it
// has left it.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "server/service/request.hpp"

namespace fracture {

struct StoreConfig {
  std::uint64_t quota_bytes = 1ull << 30;    ///< of all stored meshes together
  std::chrono::milliseconds ttl{3'600'000};  ///< after its last use a mesh is forgotten
};

/// Immutable; `owner` keeps the bytes of the mesh and its further files, and not much else.
struct StoredMesh {
  std::string digest;  ///< digest_of() in hex
  MeshFormat format = MeshFormat::kGlb;
  std::shared_ptr<const void> owner;
  std::span<const std::byte> mesh;
  std::vector<ImportFile> files;
  /// What GET says of it, as JSON: written once, because a file of many nodes has a long report. Never null.
  std::shared_ptr<const std::string> description = std::make_shared<const std::string>();
  std::uint64_t triangles = 0;  ///< of the solid: what a fracture of it costs
  std::uint64_t capacity = 0;   ///< bytes that `owner` keeps, where that is more than bytes()

  /// Of the mesh and its files, names included.
  std::uint64_t bytes() const {
    std::uint64_t sum = input_bytes(mesh, files);
    for (const ImportFile& file : files) sum += file.name.size();
    return sum;
  }
  /// What it takes of the quota: everything that is kept for it. Of that, what equal meshes share, and what
  /// each has for itself (its description, its places in the tables of the store).
  std::uint64_t held() const { return shared_bytes() + own_bytes(); }
  std::uint64_t shared_bytes() const { return std::max(bytes(), capacity); }
  std::uint64_t own_bytes() const;
};

/// Whether a mesh whose owner has `capacity` bytes is kept as a copy, because too much came around it.
bool is_kept_as_copy(const FractureRequest& request, std::uint64_t capacity);
/// A stored mesh of the request's digest, format, mesh and files: with its owner, or with a copy of mesh and
/// files.
std::shared_ptr<StoredMesh> stored_mesh_of(const FractureRequest& request, std::uint64_t capacity);

struct StoreFigures {
  std::uint64_t stored = 0;   ///< meshes that were put in
  std::uint64_t expired = 0;  ///< forgotten because nobody used them
  std::uint64_t evicted = 0;  ///< forgotten because others needed their room
  std::uint64_t bytes = 0;    ///< held, those of evicted meshes that are computed on included
  std::size_t meshes = 0;
};

/// Each owner has meshes of its own: what another stored is not there for it. Equal bytes are kept once,
/// whoever stored them, and leave with the last owner; format and description are each owner's. Where nobody is
/// asked who it is, all are one owner, "".
///
/// Invariant: the bytes of all meshes that were stored and are still in memory are at most the quota; equal ones count once.
/// The meshes of one owner, counted for itself, are at most its share. Whoever holds an evicted mesh keeps it alive, and it
/// counts against the quota until then: a limit counts what is held.
/// Thread-safe.
class MeshStore {
 public:
  using Clock = std::chrono::steady_clock;
  struct Owner {
    std::string name{};
    std::uint64_t share = UINT64_MAX;  ///< bytes
  };
  enum class Whose { kOwn, kAnybodys };

  explicit MeshStore(const StoreConfig& config) : config_(config) {}

  enum class Put {
    kCreated,
    kReplaced,
    kOverQuota,  ///< it is larger than the quota
    kOverShare,  ///< it is larger than the share of its owner
    kNoRoom,     ///< meshes that are computed on leave too little of the quota for now
  };
  /// The owner's least recently used ones leave for it where its share needs them to; where the quota does,
  /// those of whoever has most.
  Put put(std::shared_ptr<const StoredMesh> mesh, const Owner& owner, Clock::time_point now = Clock::now());
  Put put(std::shared_ptr<const StoredMesh> mesh, Clock::time_point now = Clock::now()) {
    return put(std::move(mesh), {}, now);
  }
  /// Null when it is not there; a use. The owner's own before anybody's.
  std::shared_ptr<const StoredMesh> find(const std::string& digest, const std::string& owner, Whose whose,
                                         Clock::time_point now = Clock::now());
  std::shared_ptr<const StoredMesh> find(const std::string& digest, Clock::time_point now = Clock::now()) {
    return find(digest, "", Whose::kOwn, now);
  }
  /// Takes it away from this owner, or from everybody. False when there was none.
  bool erase(const std::string& digest, const std::string& owner = "", Whose whose = Whose::kOwn);
  /// What this owner has.
  std::uint64_t bytes_of(const std::string& owner) const;
  /// Forgets what has expired; put() and find() do it too, a little at a time.
  void sweep(Clock::time_point now = Clock::now());

  StoreFigures figures() const;
  const StoreConfig& config() const { return config_; }

 private:
  struct Entry;
  using Iterator = std::list<Entry>::iterator;
  struct Entry {
    std::shared_ptr<const StoredMesh> mesh;
    std::string owner;
    std::uint64_t bytes;
    Clock::time_point used;
    std::list<Iterator>::iterator among_own{};
  };
  struct Owned {
    std::uint64_t bytes = 0;
    std::list<Iterator> entries{};  // most recently used first
  };
  /// The bytes of a mesh, of which equal meshes have one: they count for as long as anybody has them.
  struct Sum {
    std::atomic<std::uint64_t> bytes{0};
    std::atomic<std::size_t> meshes{0};
  };
  static std::shared_ptr<const void> counted(const std::shared_ptr<Sum>& sum, const StoredMesh& mesh);
  /// The entry of this owner, else, with kAnybodys, of any.
  Iterator at(const std::string& digest, const std::string& owner, Whose whose);
  void remove(Iterator at);
  void remove_least_recent_of(const std::string& owner);
  /// Meshes that nobody else holds have so many bytes: if not, a mesh is refused before others leave for it in vain.
  bool can_free(std::uint64_t bytes) const;
  /// The least recently used mesh that nobody else holds, of the owner with most that has one: false, and nothing is done,
  /// if there is none.
  bool remove_one_of_most();
  std::shared_ptr<const StoredMesh> equal_of(const StoredMesh& mesh);
  std::uint64_t bytes_of_locked(const std::string& owner) const;
  bool has_expired(const Entry& entry, Clock::time_point now) const {
    return entry.used + config_.ttl <= now;
  }
  /// At most so many: others wait for the lock. False: there may be more.
  bool expire(Clock::time_point now);
  static constexpr int kExpiredAtOnce = 16;

  const StoreConfig config_;
  mutable std::mutex mutex_;
  std::list<Entry> entries_;                                       // most recently used first
  std::map<std::pair<std::string, std::string>, Iterator> index_;  // by digest and owner
  const std::shared_ptr<Sum> sum_ = std::make_shared<Sum>();
  std::map<std::string, Owned> owned_;  // by owner
  StoreFigures figures_;
};

}  // namespace fracture
