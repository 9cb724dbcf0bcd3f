// L1: a folder of entries that survives the process. A file appears under its name only when it is complete: it is written
// under a temporary name, synced and renamed. An entry is used only if its checksum is right. All other disk errors are
// counted and otherwise ignored, because a cache may always miss.
//
//   <folder>/lock              locked by the only server that uses the folder
//   <folder>/tmp/...           files that are being written; emptied at startup
//   <folder>/3f/3f0c…d2        entries, grouped by the first two digits of their keys
//   <folder>/quarantine/...    a few damaged entries, for inspection
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "common/base/error.hpp"
#include "server/cache/entry.hpp"
#include "server/cache/farm_keys.hpp"
#include "server/cache/folder_lock.hpp"

namespace fracture {

/// An entry, together with the bytes that it refers to.
struct StoredEntry {
  std::vector<std::uint8_t> bytes;
  CacheEntry entry;
};

struct DiskFigures {
  std::uint64_t hits = 0, misses = 0, writes = 0, evictions = 0;
  std::uint64_t failures = 0;     ///< reads or writes that failed in the system
  std::uint64_t quarantined = 0;  ///< damaged entries
  std::uint64_t bytes = 0;
  std::size_t entries = 0;
};

/// Thread-safe; calls block for as long as the disk takes.
class DiskCache {
 public:
  /// Takes the folder, unless another server has it. When `budget` bytes are used up, the least recently used entries are
  /// evicted, except pinned ones. With keys, every entry is signed for the algorithm version (farm_keys.hpp), and an
  /// unsigned entry counts as damaged.
  DiskCache(std::string folder, std::uint64_t budget, FarmKeys keys = {}, int algorithm = 0);
  DiskCache(const DiskCache&) = delete;
  DiskCache& operator=(const DiskCache&) = delete;

  /// kFileAccess if the folder could not be used at startup.
  const std::optional<Error>& unusable() const { return unusable_; }
  /// Returns whether this server has the folder. Until then, find() always misses, and insert() does nothing.
  bool held() const { return held_; }
  /// Locks the folder, deletes unfinished files from an earlier process, and indexes the entries. Returns false while another
  /// server has the folder; then try again later. Must not be called by several threads at the same time. Errors: kFileAccess.
  Expected<bool> take();

  /// Returns the size of the entry's file as it was written; nothing if there is none.
  std::optional<std::uint64_t> size_of(const std::string& key) const;
  /// Reads an entry. Keys have 4 to 128 lower-case hex digits; other keys always miss. Allocates at most size_of() bytes,
  /// whatever has happened to the file. Throws Interrupted.
  std::optional<StoredEntry> find(const std::string& key, const Execution& execution = kUninterrupted);
  /// Returns false if the entry could not be written.
  bool insert(const CacheEntry& entry);
  /// Quarantines the entry with this key. For entries that are intact but have wrong content.
  void refuse(const std::string& key);

  /// Protects the entry with this key from eviction, now or as soon as it is inserted, until as many calls of unpin().
  /// Returns whether there is an entry. The caller keeps all pinned entries within most_pinned(), because others only have
  /// what pins leave.
  bool pin(const std::string& key);
  void unpin(const std::string& key);
  /// Half of the budget, in bytes.
  std::uint64_t most_pinned() const { return budget_ / 2; }
  /// While this is on, nothing is evicted, and only entries are inserted for which there is room. For the time until the
  /// pins of an earlier process are known.
  void keep_all(bool keep);

  DiskFigures figures() const;

 private:
  struct File {
    std::string key;
    std::uint64_t size;
  };

  std::string path_of(const std::string& key) const { return folder_ + "/" + key.substr(0, 2) + "/" + key; }
  SignedAs signed_as(std::string_view key) const { return {"disk", key, algorithm_}; }
  /// Returns the entry in a file's bytes; nothing if it is damaged, or not signed although keys are set.
  std::optional<CacheEntry> decoded(std::span<const std::uint8_t> file, const std::string& key,
                                    const Execution& execution) const;
  void learn_what_is_there();
  /// Evicts entries until `size` more bytes fit into the budget. Evicts nothing and returns false if they cannot fit.
  bool make_room(std::uint64_t size);
  /// Adds the most recently used entry.
  void add(File file);
  std::list<File>& list_of(const std::string& key) { return pins_.contains(key) ? pinned_ : files_; }
  void quarantine(const std::string& key);
  void forget(const std::string& key);
  bool write(const std::string& temporary, const std::string& path, std::string_view head,
             std::span<const std::uint8_t> payload);

  const std::string folder_;
  const std::uint64_t budget_;
  const FarmKeys keys_;
  const int algorithm_;
  std::optional<Error> unusable_;
  FolderLock lock_;
  std::atomic<bool> held_{false};
  mutable std::mutex mutex_;
  std::list<File> files_;                              // most recently used first
  std::list<File> pinned_;                             // entries that are never evicted
  std::unordered_map<std::string, std::size_t> pins_;  // pins of each key, even without an entry
  std::uint64_t pinned_bytes_ = 0;
  bool keeps_all_ = false;
  std::unordered_map<std::string, std::list<File>::iterator> index_;
  std::uint64_t next_temporary_ = 0;
  DiskFigures figures_;
};

}  // namespace fracture
