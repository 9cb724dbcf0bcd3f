// Meshes that clients have stored on the server, by their digest: a mesh is sent once and fractured many times. The store
// keeps the bytes, not the prepared solid. The solid is in the mesh cache; if it has been evicted there, it is made again
// from the bytes.
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
  std::uint64_t quota_bytes = 1ull << 30;    ///< for all stored meshes together
  std::chrono::milliseconds ttl{3'600'000};  ///< how long a mesh is kept after its last use
};

/// A stored mesh. Immutable. `owner` keeps the bytes of the mesh and its additional files alive, and little else.
struct StoredMesh {
  std::string digest;  ///< digest_of() in hex
  MeshFormat format = MeshFormat::kGlb;
  std::shared_ptr<const void> owner;
  std::span<const std::byte> mesh;
  std::vector<ImportFile> files;
  /// JSON document that GET returns. It is written once, because a file with many nodes has a long report. Never null.
  std::shared_ptr<const std::string> description = std::make_shared<const std::string>();
  std::uint64_t triangles = 0;  ///< number of the solid's triangles, for the cost of a fracture
  std::uint64_t capacity = 0;   ///< bytes that `owner` keeps, if that is more than bytes()

  /// Returns the size of the mesh and its files, including their names.
  std::uint64_t bytes() const {
    std::uint64_t sum = input_bytes(mesh, files);
    for (const ImportFile& file : files) sum += file.name.size();
    return sum;
  }
  /// Returns how many bytes of the quota the mesh uses.
  std::uint64_t held() const { return shared_bytes() + own_bytes(); }
  /// Returns the part of held() that equal meshes share.
  std::uint64_t shared_bytes() const { return std::max(bytes(), capacity); }
  /// Returns the part of held() that each mesh has for itself: its description, and its entries in the store's tables.
  std::uint64_t own_bytes() const;
};

/// Returns whether a mesh is copied when it is stored. This is done if its owner would keep too many other bytes alive.
/// `capacity`: bytes that the owner keeps.
bool is_kept_as_copy(const FractureRequest& request, std::uint64_t capacity);
/// Returns a stored mesh with the request's digest, format, mesh and files. It keeps the request's owner, or a copy of mesh
/// and files. Polls while it copies. Throws Interrupted.
std::shared_ptr<StoredMesh> stored_mesh_of(const FractureRequest& request, std::uint64_t capacity,
                                           const Execution& execution = kUninterrupted);

struct StoreFigures {
  std::uint64_t stored = 0;   ///< meshes that were stored
  std::uint64_t expired = 0;  ///< meshes removed because nobody used them
  std::uint64_t evicted = 0;  ///< meshes removed because others needed their room
  std::uint64_t bytes = 0;    ///< bytes held, including evicted meshes that are still in use
  std::size_t meshes = 0;
};

/// Each owner has its own meshes and does not see those of other owners. Equal bytes are kept only once, and are freed
/// together with the last mesh that uses them. Each owner has its own format and description of such a mesh. If the server
/// does not ask for names, all clients are one owner, "".
///
/// Invariants: all stored meshes that are still in memory take at most the quota together; equal bytes count once. The
/// meshes of one owner take at most its share; equal bytes count for each owner. A computation that uses an evicted mesh
/// keeps it alive, and the mesh counts against the quota until the computation releases it.
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
    kOverQuota,  ///< the mesh is larger than the quota
    kOverShare,  ///< the mesh is larger than the share of its owner
    kNoRoom,     ///< meshes that are in use leave too little of the quota for now
  };
  /// Stores a mesh. If the owner's share is used up, the owner's least recently used meshes are evicted. If the quota is used
  /// up, meshes of the owner with the most bytes are evicted. Polls while it compares the bytes with a known mesh. Throws
  /// Interrupted; then nothing was stored.
  Put put(std::shared_ptr<const StoredMesh> mesh, const Owner& owner, Clock::time_point now = Clock::now(),
          const Execution& execution = kUninterrupted);
  Put put(std::shared_ptr<const StoredMesh> mesh, Clock::time_point now = Clock::now()) {
    return put(std::move(mesh), {}, now);
  }
  /// Returns the mesh, and counts as a use. Returns null if there is none. The owner's own mesh is preferred to another
  /// owner's.
  std::shared_ptr<const StoredMesh> find(const std::string& digest, const std::string& owner, Whose whose,
                                         Clock::time_point now = Clock::now());
  std::shared_ptr<const StoredMesh> find(const std::string& digest, Clock::time_point now = Clock::now()) {
    return find(digest, "", Whose::kOwn, now);
  }
  /// Returns whether any owner has a mesh with this digest, with which put() would compare the bytes. Not a use.
  bool has(const std::string& digest);
  /// Removes the mesh of this owner, or of all owners. Returns false if there was none.
  bool erase(const std::string& digest, const std::string& owner = "", Whose whose = Whose::kOwn);
  /// Returns how many bytes this owner's meshes take.
  std::uint64_t bytes_of(const std::string& owner) const;
  /// Removes expired meshes. put() and find() also do this, for a few meshes at a time.
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
  /// Totals of all meshes in memory. Equal meshes share their bytes, so they count once, until nobody holds them any more.
  struct Sum {
    std::atomic<std::uint64_t> bytes{0};
    std::atomic<std::size_t> meshes{0};
  };
  static std::shared_ptr<const void> counted(const std::shared_ptr<Sum>& sum, const StoredMesh& mesh);
  /// Returns the entry of this owner. With kAnybodys, falls back to the entry of any owner.
  Iterator at(const std::string& digest, const std::string& owner, Whose whose);
  void remove(Iterator at);
  void remove_least_recent_of(const std::string& owner);
  /// Returns whether evicting meshes that are not in use would free enough bytes. put() checks this first, so that it does not
  /// evict meshes in vain.
  bool can_free(std::uint64_t bytes) const;
  /// Evicts the least recently used mesh that is not in use, of the owner with the most bytes among those that have such a
  /// mesh. Returns false if there is none.
  bool remove_one_of_most();
  std::shared_ptr<const StoredMesh> equal_of(const StoredMesh& mesh, const Execution& execution);
  std::uint64_t bytes_of_locked(const std::string& owner) const;
  bool has_expired(const Entry& entry, Clock::time_point now) const {
    return entry.used + config_.ttl <= now;
  }
  /// Removes at most kExpiredAtOnce expired meshes, because others wait for the lock. Returns false if there may be more.
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
