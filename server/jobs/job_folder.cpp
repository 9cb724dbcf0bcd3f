#include "server/jobs/job_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "server/jobs/durable_file.hpp"
#include "server/service/fair_share.hpp"

namespace fracture {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRecords = "records";
constexpr const char* kMeshes = "meshes";
constexpr const char* kBegun = "begun";
/// Maximum size of a record: the parameters can contain thousands of points.
constexpr std::uint64_t kMostOfRecord = 4u << 20;
/// Disk space that even a small file takes.
constexpr std::uint64_t kLeastBytes = 4096;
constexpr std::size_t kMaxQuarantined = 16;

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  return names;
}

/// Returns whether there is a regular file, and not a link, a FIFO or a folder.
bool is_file(const std::string& path) {
  std::error_code gone;
  return fs::is_regular_file(fs::symlink_status(path, gone));
}

/// Returns the size of a regular file in bytes, and 0 for anything else.
std::uint64_t size_of(const std::string& path) {
  if (!is_file(path)) return 0;
  std::error_code gone;
  const std::uint64_t size = fs::file_size(path, gone);
  return gone ? 0 : size;
}

std::uint64_t charged(std::uint64_t bytes) { return std::max(bytes, kLeastBytes); }

}  // namespace

Expected<bool> JobFolder::take() {
  const Expected<bool> taken = lock_.take(config_.folder);
  if (!taken || !*taken) return taken;
  try {
    fs::remove_all(config_.folder + "/tmp");
    for (const char* kind : {"tmp", "quarantine", kRecords, kMeshes, kBegun}) {
      const std::string folder = config_.folder + "/" + kind;
      fs::create_directories(folder);
      std::error_code not_ours;  // also closes files of earlier releases, which all users could read
      fs::permissions(folder, fs::perms::owner_all, not_ours);
    }
  } catch (const fs::filesystem_error& e) {
    return tl::unexpected<Error>(unusable_folder(config_.folder, e));
  }
  return true;
}

std::vector<JobFolder::Found> JobFolder::restore() {
  std::vector<Found> found;
  {
    const std::lock_guard lock(mutex_);
    places_.clear();
    meshes_.clear();
    figures_.bytes = 0;
  }
  try {
    std::set<std::string> known, needed;
    bool all = true;
    for (const std::string& id : names_in(config_.folder + "/" + kRecords)) {
      if (found.size() >= config_.max_jobs) {
        all = false;
        break;
      }
      std::optional<JobRecord> record = get_record(id);
      if (!record) continue;
      known.insert(id);
      const bool open = record->state == JobState::kQueued;
      if (open) {
        // The size on disk counts, not the size in the record. A larger mesh is set aside, because its job
        // would be refused again and again.
        record->mesh_bytes = size_of(path(kMeshes, record->digest));
        if (record->mesh_bytes > config_.max_bytes) {
          put_aside(kMeshes, record->digest);
          record->mesh_bytes = 0;
        }
        needed.insert(record->digest);
      }
      {
        const std::lock_guard lock(mutex_);
        take_place(*record, size_of(path(kRecords, id)));
        if (open) meshes_[record->digest].written = is_file(path(kMeshes, record->digest));
      }
      record->parameters = nlohmann::json::object();
      found.push_back({std::move(*record), size_of(path(kBegun, id))});
    }
    if (all) {  // otherwise jobs left for a later start may need the files
      keep_files(kMeshes, needed);
      keep_files(kBegun, known);
    }
  } catch (const fs::filesystem_error&) {
    const std::lock_guard lock(mutex_);
    ++figures_.failures;
  }
  std::sort(found.begin(), found.end(),
            [](const Found& a, const Found& b) { return a.record.created < b.record.created; });
  return found;
}

void JobFolder::keep_files(const char* kind, const std::set<std::string>& wanted) {
  for (const std::string& name : names_in(config_.folder + "/" + kind)) {
    if (!is_file(path(kind, name)))
      put_aside(kind, name);
    else if (!wanted.contains(name))
      ::unlink(path(kind, name).c_str());
  }
}

// -- space

JobFolder::Room JobFolder::reserve(const JobRecord& record, std::uint64_t share) {
  std::uint64_t own = 0;
  try {
    own = encode_record(record).size();
  } catch (const nlohmann::json::exception&) {
    return Room::kUnfit;
  }
  if (own > kMostOfRecord) return Room::kUnfit;
  own = charged(own);
  const std::uint64_t all = own + charged(record.mesh_bytes);
  if (all > config_.max_bytes || all > share) return Room::kTooLarge;
  const std::lock_guard lock(mutex_);
  const auto mesh = meshes_.find(record.digest);
  const bool there = mesh != meshes_.end(), theirs = there && mesh->second.needed.contains(record.owner);
  if (bytes_of_locked(record.owner) + (theirs ? own : all) > share) return Room::kOverShare;
  const FairShare fair{config_.max_bytes, config_.max_bytes / 2};
  const std::uint64_t of_client = bytes_of_client(record) + own, used = figures_.bytes + (there ? own : all);
  const bool alone = of_client == all;
  std::set<std::string_view> others;
  for (const auto& [id, place] : places_)
    if (place.client != record.client) others.insert(place.client);
  if (record.client.empty() ? used > fair.capacity : !fair.allows(of_client, used, others.size(), alone))
    return !record.client.empty() && !alone && (used <= fair.capacity || of_client > fair.share)
               ? Room::kOverPart
               : Room::kFull;
  take_place(record, own);
  return Room::kThere;
}

std::uint64_t JobFolder::bytes_of_client(const JobRecord& with) const {
  std::uint64_t bytes = charged(with.mesh_bytes);
  std::set<std::string_view> meshes{with.digest};
  for (const auto& [id, place] : places_) {
    if (place.client != with.client) continue;
    bytes += place.bytes;
    if (!place.digest.empty() && meshes.insert(place.digest).second) bytes += meshes_.at(place.digest).bytes;
  }
  return bytes;
}

void JobFolder::take_place(const JobRecord& record, std::uint64_t record_bytes) {
  Place& place = places_[record.id];
  place = {record.owner, record.client, {}, charged(record_bytes)};
  figures_.bytes += place.bytes;
  if (record.state != JobState::kQueued) return;
  place.digest = record.digest;
  Mesh& mesh = meshes_[record.digest];
  if (mesh.needed.empty()) figures_.bytes += mesh.bytes = charged(record.mesh_bytes);
  ++mesh.needed[record.owner];
}

JobFolder::Unneeded JobFolder::let_mesh_go(Place& place) {
  const auto mesh = meshes_.find(std::exchange(place.digest, {}));
  if (mesh == meshes_.end()) return {};
  const auto needed = mesh->second.needed.find(place.owner);
  if (needed != mesh->second.needed.end() && --needed->second == 0) mesh->second.needed.erase(needed);
  if (!mesh->second.needed.empty()) return {};
  Unneeded unneeded;
  // Renamed under the lock: a job that needs this mesh later writes a new file under the old name.
  if (mesh->second.written) {
    unneeded = {config_.folder + "/tmp/" + std::to_string(next_temporary_++), mesh->second.bytes};
    const std::string file = path(kMeshes, mesh->first);
    if (::rename(file.c_str(), unneeded.path.c_str()) != 0) {
      ::unlink(file.c_str());
      unneeded = {};
    }
  }
  if (unneeded.path.empty()) figures_.bytes -= mesh->second.bytes;
  meshes_.erase(mesh);
  return unneeded;
}

void JobFolder::delete_mesh(const Unneeded& mesh) {
  if (mesh.path.empty()) return;
  if (config_.before_delete) config_.before_delete();
  ::unlink(mesh.path.c_str());
  const std::lock_guard lock(mutex_);
  figures_.bytes -= mesh.bytes;
}

std::uint64_t JobFolder::bytes_of_locked(const std::string& owner) const {
  std::uint64_t bytes = 0;
  for (const auto& [id, place] : places_)
    if (place.owner == owner) bytes += place.bytes;
  for (const auto& [digest, mesh] : meshes_)
    if (mesh.needed.contains(owner)) bytes += mesh.bytes;
  return bytes;
}

std::uint64_t JobFolder::bytes_of(const std::string& owner) const {
  const std::lock_guard lock(mutex_);
  return bytes_of_locked(owner);
}

JobFolderFigures JobFolder::figures() const {
  const std::lock_guard lock(mutex_);
  JobFolderFigures figures = figures_;
  figures.jobs = places_.size();
  return figures;
}

// -- files

bool JobFolder::put(const char* kind, const std::string& name, std::string_view head,
                    std::span<const std::span<const std::byte>> parts) {
  std::string temporary;
  {
    const std::lock_guard lock(mutex_);
    temporary = config_.folder + "/tmp/" + std::to_string(next_temporary_++);
  }
  const bool written = write_durably(temporary, path(kind, name), head, parts);
  const std::lock_guard lock(mutex_);
  ++(written ? figures_.writes : figures_.failures);
  return written;
}

bool JobFolder::put_record(const JobRecord& record) {
  std::string bytes;
  try {
    bytes = encode_record(record);
  } catch (const nlohmann::json::exception&) {  // some text is not UTF-8
    return false;
  }
  if (!config_.keys.empty())
    bytes.insert(0, config_.keys.head(signed_as(record.id),
                                      {{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}}));
  return put(kRecords, record.id, bytes, {});
}

std::optional<JobRecord> JobFolder::get_record(const std::string& id) {
  std::optional<std::vector<std::uint8_t>> bytes;
  if (is_job_id(id)) bytes = read_whole(path(kRecords, id), kMostOfRecord + FarmKeys::kHead);
  std::optional<JobRecord> record;
  if (bytes) {
    std::optional<FarmKeys::Bytes> text = *bytes;
    if (!config_.keys.empty()) text = config_.keys.open(signed_as(id), *bytes);
    if (text) record = decode_record({reinterpret_cast<const char*>(text->data()), text->size()});
  }
  if (record && record->id == id) return record;
  put_aside(kRecords, id);
  return std::nullopt;
}

bool JobFolder::write(const JobRecord& record, const FractureRequest& request) {
  bool mesh_there = false;
  {
    const std::lock_guard lock(mutex_);
    const auto mesh = meshes_.find(record.digest);
    mesh_there = mesh != meshes_.end() && mesh->second.written;
  }
  if (!mesh_there) {
    std::vector<std::span<const std::byte>> parts{request.mesh};
    for (const ImportFile& file : request.files) parts.push_back(file.bytes);
    if (!put(kMeshes, record.digest, encode_mesh_head(request), parts)) return false;
    const std::lock_guard lock(mutex_);
    if (const auto mesh = meshes_.find(record.digest); mesh != meshes_.end()) mesh->second.written = true;
  }
  return put_record(record);  // last, because a record without its mesh would be useless
}

bool JobFolder::write_end(const JobRecord& record) {
  if (!put_record(record)) return false;
  ::unlink(path(kBegun, record.id).c_str());
  Unneeded unneeded;
  {
    const std::lock_guard lock(mutex_);
    if (const auto place = places_.find(record.id); place != places_.end())
      unneeded = let_mesh_go(place->second);
  }
  delete_mesh(unneeded);
  return true;
}

void JobFolder::remove(const std::string& id) {
  // Delete the record first: a mark without a record has no meaning.
  ::unlink(path(kRecords, id).c_str());
  ::unlink(path(kBegun, id).c_str());
  Unneeded unneeded;
  {
    const std::lock_guard lock(mutex_);
    const auto place = places_.find(id);
    if (place == places_.end()) return;
    unneeded = let_mesh_go(place->second);
    figures_.bytes -= place->second.bytes;
    places_.erase(place);
  }
  delete_mesh(unneeded);
}

std::optional<KeptMesh> JobFolder::read_mesh(const std::string& digest) {
  std::uint64_t size = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto mesh = meshes_.find(digest);
    if (mesh == meshes_.end()) return std::nullopt;
    size = mesh->second.bytes;
  }
  // The file's header is not included in the charged size.
  if (auto bytes = read_whole(path(kMeshes, digest), size + kMostOfRecord)) {
    auto mesh = decode_mesh(std::make_shared<const std::vector<std::uint8_t>>(std::move(*bytes)), 0, digest);
    if (mesh) return mesh;
  }
  put_aside(kMeshes, digest);
  const std::lock_guard lock(mutex_);
  if (const auto mesh = meshes_.find(digest); mesh != meshes_.end()) mesh->second.written = false;
  return std::nullopt;
}

void JobFolder::put_aside(const char* kind, const std::string& name) {
  const std::string from = path(kind, name);
  std::string to;
  {
    const std::lock_guard lock(mutex_);
    ++figures_.quarantined;
    to = path("quarantine", std::to_string(figures_.quarantined % kMaxQuarantined));
  }
  std::error_code ignored;
  fs::remove_all(to, ignored);
  if (::rename(from.c_str(), to.c_str()) != 0) fs::remove_all(from, ignored);
}

void JobFolder::begun(const std::string& id) noexcept {
  // O_NONBLOCK: otherwise open() would wait for a reader of a FIFO.
  const int file = ::open(path(kBegun, id).c_str(),
                          O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
  if (file < 0) return;
  if (::write(file, "x", 1) != 1) errno = 0;  // on failure, this attempt is not counted
  ::close(file);
}

void JobFolder::not_begun(const std::string& id) noexcept {
  const std::string mark = path(kBegun, id);
  if (const std::uint64_t size = size_of(mark); size > 1)
    (void)!::truncate(mark.c_str(), static_cast<off_t>(size - 1));
  else
    ::unlink(mark.c_str());
}

}  // namespace fracture
