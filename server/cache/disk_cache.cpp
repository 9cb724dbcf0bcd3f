#include "server/cache/disk_cache.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/base/atomic_file.hpp"
#include "server/cache/stored_file.hpp"

namespace fracture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxQuarantined = 16;

bool is_key(std::string_view key) {
  return key.size() >= 4 && key.size() <= 128 && std::all_of(key.begin(), key.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

}  // namespace

DiskCache::DiskCache(std::string folder, std::uint64_t budget, FarmKeys keys, int algorithm)
    : folder_(std::move(folder)), budget_(budget), keys_(std::move(keys)), algorithm_(algorithm) {
  if (const Expected<bool> taken = take(); !taken) unusable_ = taken.error();
}

Expected<bool> DiskCache::take() {
  if (held_) return true;
  const Expected<bool> locked = lock_.take(folder_);
  if (!locked || !*locked) return locked;
  try {
    fs::remove_all(folder_ + "/tmp");
    fs::create_directories(folder_ + "/tmp");
    fs::create_directories(folder_ + "/quarantine");
    learn_what_is_there();
  } catch (const fs::filesystem_error& e) {
    return tl::unexpected<Error>(unusable_folder(folder_, e));
  }
  held_ = true;
  return true;
}

void DiskCache::learn_what_is_there() {
  const std::lock_guard lock(mutex_);
  files_.clear();
  pinned_.clear();
  index_.clear();
  figures_.bytes = pinned_bytes_ = 0;
  std::vector<std::pair<fs::file_time_type, File>> found;
  for (const fs::directory_entry& sub : fs::directory_iterator(folder_)) {
    const std::string prefix = sub.path().filename();
    std::error_code unknown;
    if (prefix.size() != 2 || !sub.is_directory(unknown)) continue;
    for (const fs::directory_entry& file : fs::directory_iterator(sub)) {
      const std::string key = file.path().filename();
      std::error_code gone;
      const std::uint64_t size = file.file_size(gone);
      if (gone || !is_key(key) || key.substr(0, 2) != prefix) continue;
      if (size > budget_)  // from a larger budget, or damaged: it cannot be kept
        quarantine(key);
      else
        found.push_back({file.last_write_time(gone), {key, size}});
    }
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  // If they exceed the budget, which may be smaller than before, the next insert() evicts them: by then, pins are known.
  for (auto at = found.rbegin(); at != found.rend(); ++at) add(std::move(at->second));
}

void DiskCache::add(File file) {
  std::list<File>& list = list_of(file.key);
  list.push_front(std::move(file));
  const File& added = list.front();
  index_.emplace(added.key, list.begin());
  figures_.bytes += added.size;
  if (&list == &pinned_) pinned_bytes_ += added.size;
}

std::optional<std::uint64_t> DiskCache::size_of(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto at = index_.find(key);
  return at == index_.end() ? std::nullopt : std::optional(at->second->size);
}

std::optional<StoredEntry> DiskCache::find(const std::string& key, const Execution& execution) {
  if (!held_ || !is_key(key)) return std::nullopt;
  std::uint64_t size = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto at = index_.find(key);
    if (at == index_.end()) {
      ++figures_.misses;
      return std::nullopt;
    }
    std::list<File>& list = list_of(key);
    list.splice(list.begin(), list, at->second);
    size = at->second->size;
  }
  errno = 0;
  const std::optional<StoredFile> file = open_stored(path_of(key));
  const bool gone = !file && errno == ENOENT;
  std::optional<std::vector<std::uint8_t>> bytes;
  if (!file && errno == EINVAL) bytes.emplace();  // not a file, so it is damaged
  // The whole file is read only if the file, the index and the entry's header agree on the size. A file that has become longer
  // is damaged (a sparse file may claim terabytes).
  if (file) {
    const std::size_t signature = keys_.empty() ? 0 : FarmKeys::kHead;
    bytes = read_bytes(*file, std::min<std::uint64_t>(signature + kEntryHeader, size));
    if (bytes && (file->size != size || bytes->size() < signature ||
                  size_of_entry(std::span(*bytes).subspan(signature)) != size - signature))
      bytes->clear();
    else if (bytes)
      bytes = ::lseek(file->file.get(), 0, SEEK_SET) == 0 ? read_bytes(*file, size, execution) : std::nullopt;
  }
  std::optional<StoredEntry> stored;
  if (bytes) {
    if (const auto entry = decoded(*bytes, key, execution)) stored = StoredEntry{std::move(*bytes), *entry};
  }
  const std::lock_guard lock(mutex_);
  if (stored) {
    ++figures_.hits;
    return stored;
  }
  ++figures_.misses;
  if (bytes)
    quarantine(key);
  else if (!gone)
    ++figures_.failures;
  forget(key);
  return std::nullopt;
}

void DiskCache::refuse(const std::string& key) {
  const std::lock_guard lock(mutex_);
  if (!index_.contains(key)) return;
  quarantine(key);
  forget(key);
}

bool DiskCache::pin(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto at = index_.find(key);
  if (++pins_[key] == 1 && at != index_.end()) {
    pinned_.splice(pinned_.begin(), files_, at->second);
    pinned_bytes_ += at->second->size;
  }
  return at != index_.end();
}

void DiskCache::unpin(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto pins = pins_.find(key);
  if (pins == pins_.end() || --pins->second > 0) return;
  pins_.erase(pins);
  const auto at = index_.find(key);
  if (at == index_.end()) return;
  files_.splice(files_.begin(), pinned_, at->second);
  pinned_bytes_ -= at->second->size;
}

void DiskCache::keep_all(bool keep) {
  const std::lock_guard lock(mutex_);
  keeps_all_ = keep;
}

bool DiskCache::make_room(std::uint64_t size) {
  if ((keeps_all_ ? figures_.bytes : pinned_bytes_) + size > budget_) return false;
  while (figures_.bytes + size > budget_ && !files_.empty()) {
    const std::string oldest = files_.back().key;
    ::unlink(path_of(oldest).c_str());
    forget(oldest);
    ++figures_.evictions;
  }
  return true;
}

std::optional<CacheEntry> DiskCache::decoded(std::span<const std::uint8_t> file, const std::string& key,
                                             const Execution& execution) const {
  if (keys_.empty()) return decode_entry(file, key, execution);
  const auto opened = keys_.open(signed_as(key), file, execution);
  return opened ? decode_entry(*opened, key, execution) : std::nullopt;
}

bool DiskCache::insert(const CacheEntry& entry) {
  const std::string key(entry.key);
  if (!held_ || !is_key(key)) return false;
  std::string head = encode_entry_head(entry);
  if (!keys_.empty()) {
    const FarmKeys::Bytes before(reinterpret_cast<const std::uint8_t*>(head.data()), head.size());
    head.insert(0, keys_.head(signed_as(entry.key), {before, entry.payload}));
  }
  const std::uint64_t size = head.size() + entry.payload.size();
  if (size > budget_) return false;
  std::string temporary;
  {
    const std::lock_guard lock(mutex_);
    if (index_.count(key) > 0) return true;  // the key determines the bytes
    if (!make_room(size)) return false;
    temporary = folder_ + "/tmp/" + std::to_string(next_temporary_++);
  }
  if (!write(temporary, path_of(key), head, entry.payload)) {
    const std::lock_guard lock(mutex_);
    ++figures_.failures;
    return false;
  }
  const std::lock_guard lock(mutex_);
  ++figures_.writes;
  if (index_.count(key) > 0) return true;  // another thread has written the same entry in the meantime
  add({key, size});
  return true;
}

bool DiskCache::write(const std::string& temporary, const std::string& path, std::string_view head,
                      std::span<const std::uint8_t> payload) {
  AtomicFile file;
  // Flushed: without that, the rename may reach the disk before the bytes, and a power cut would leave a file of zeros. The
  // checksum would detect that, but the entry would be lost.
  if (!file.open(path, {.temporary = temporary, .mode = 0644}) ||
      !file.append(std::as_bytes(std::span(head))) || !file.append_paced(std::as_bytes(payload)))
    return false;
  std::error_code ignored;
  fs::create_directory(fs::path(path).parent_path(), ignored);
  return file.commit();
}

void DiskCache::quarantine(const std::string& key) {
  ++figures_.quarantined;
  const std::string name = folder_ + "/quarantine/" + std::to_string(figures_.quarantined % kMaxQuarantined);
  std::error_code ignored;
  fs::remove_all(name, ignored);  // a file cannot replace a folder, nor a folder a file
  if (::rename(path_of(key).c_str(), name.c_str()) != 0) fs::remove_all(path_of(key), ignored);
}

void DiskCache::forget(const std::string& key) {
  const auto at = index_.find(key);
  if (at == index_.end()) return;
  std::list<File>& list = list_of(key);
  figures_.bytes -= at->second->size;
  if (&list == &pinned_) pinned_bytes_ -= at->second->size;
  list.erase(at->second);
  index_.erase(at);
}

DiskFigures DiskCache::figures() const {
  const std::lock_guard lock(mutex_);
  DiskFigures figures = figures_;
  figures.entries = index_.size();
  return figures;
}

}  // namespace fracture
