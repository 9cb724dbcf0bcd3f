// L1: a folder of entries that survives the process. A file appears under its name only when it is whole
// (written beside, fsync, rename), and what is read is believed only when its checksum says so; whatever else
// goes wrong with the disk is counted and otherwise ignored, for a cache may always miss.
//
//   <folder>/lock              held by the one server that uses the folder
//   <folder>/tmp/...           being written; emptied at the start
//   <folder>/3f/3f0c…d2        entries, by the first two digits of their key
//   <folder>/quarantine/...    what was found damaged, a few of them, to look at
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

/// An entry with the bytes that it points into.
struct StoredEntry {
  std::vector<std::uint8_t> bytes;
  CacheEntry entry;
};

struct DiskFigures {
  std::uint64_t hits = 0, misses = 0, writes = 0, evictions = 0;
  std::uint64_t failures = 0;     ///< reads or writes that the system refused
  std::uint64_t quarantined = 0;  ///< entries that were found damaged
  std::uint64_t bytes = 0;
  std::size_t entries = 0;
};

/// Thread-safe; calls block for as long as the disk takes.
class DiskCache {
 public:
  /// Takes the folder over, unless another server has it. The least recently used entries leave when `budget`
  /// bytes are used. With keys every entry is signed (farm_keys.hpp) for the algorithm version, and one that
  /// is not counts as damaged.
  DiskCache(std::string folder, std::uint64_t budget, FarmKeys keys = {}, int algorithm = 0);
  DiskCache(const DiskCache&) = delete;
  DiskCache& operator=(const DiskCache&) = delete;

  /// kFileAccess when the folder could not be used at the start.
  const std::optional<Error>& unusable() const { return unusable_; }
  /// Until the folder is ours every find misses and insert does nothing.
  bool held() const { return held_; }
  /// Makes the folder, removes what an earlier process left half-written, learns what is there. False while
  /// another server has it: to be called again, by one thread at a time.
  Expected<bool> take();

  /// Bytes of the entry as it was written; nothing when there is none.
  std::optional<std::uint64_t> size_of(const std::string& key) const;
  /// Keys are lower-case hex digits, at least four; nothing is found under others. Allocates
  /// size_of() bytes at most, whatever the file has become.
  std::optional<StoredEntry> find(const std::string& key);
  /// False when it could not be written.
  bool insert(const CacheEntry& entry);
  /// What find() found of this key is intact and not what it should be: it is put aside as a damaged entry is.
  void refuse(const std::string& key);

  DiskFigures figures() const;

 private:
  struct File {
    std::string key;
    std::uint64_t size;
  };

  std::string path_of(const std::string& key) const { return folder_ + "/" + key.substr(0, 2) + "/" + key; }
  SignedAs signed_as(std::string_view key) const { return {"disk", key, algorithm_}; }
  /// The entry in the bytes of a file; nothing where it is damaged or not signed.
  std::optional<CacheEntry> decoded(std::span<const std::uint8_t> file, const std::string& key) const;
  void learn_what_is_there();
  /// Evicts until `size` bytes more are within the budget.
  void make_room(std::uint64_t size);
  void quarantine(const std::string& key);
  void forget(const std::string& key);
  bool write(const std::string& path, std::string_view head, std::span<const std::uint8_t> payload);

  const std::string folder_;
  const std::uint64_t budget_;
  const FarmKeys keys_;
  const int algorithm_;
  std::optional<Error> unusable_;
  FolderLock lock_;
  std::atomic<bool> held_{false};
  mutable std::mutex mutex_;
  std::list<File> files_;  // most recently used first
  std::unordered_map<std::string, std::list<File>::iterator> index_;
  std::uint64_t next_temporary_ = 0;
  DiskFigures figures_;
};

}  // namespace fracture
