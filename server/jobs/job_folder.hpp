// Stores jobs on disk, so that they outlive the process. A file appears under its name only when it is
// complete and on disk (written to a temporary file, fsync, rename, fsync of the folder). It is only used if
// its digest matches; damaged files are moved to quarantine.
//
//   <folder>/lock               held by the one server that uses the folder
//   <folder>/records/<job id>   a job: its request while it is unfinished, its outcome afterwards
//   <folder>/meshes/<digest>    a mesh with its files, kept while an unfinished job needs it
//   <folder>/begun/<job id>     one byte for each process that ended while it computed the job
//   <folder>/tmp/...            files being written; emptied at the start
//   <folder>/quarantine/...     a few damaged files, for inspection
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "server/cache/farm_keys.hpp"
#include "server/cache/folder_lock.hpp"
#include "server/jobs/job_record.hpp"

namespace fracture {

struct JobFolderConfig {
  std::string folder;
  std::uint64_t max_bytes = 1ull << 30;  ///< for records and meshes together
  /// If there are keys, every record is signed, and an unsigned record counts as damaged. Meshes are checked
  /// by their digest.
  FarmKeys keys{};
  std::size_t max_jobs = 1000;  ///< limit for restore(); further jobs remain on disk for a later start
  std::function<void()> before_delete{};  ///< called before a mesh is deleted; tests hold the deletion here
};

struct JobFolderFigures {
  std::size_t jobs = 0;
  std::uint64_t bytes = 0, writes = 0;
  std::uint64_t failures = 0;     ///< reads and writes that failed
  std::uint64_t quarantined = 0;  ///< damaged files
};

/// Invariant: all jobs with a place take at most max_bytes, counting a mesh that several jobs need only once.
/// When a job gets its place, its owner's jobs take at most the owner's share, and its client's jobs at most
/// the client's part. Thread-safe. Functions that are said to block do so for the duration of the disk
/// operations.
class JobFolder {
 public:
  /// Does not access the folder before take().
  explicit JobFolder(JobFolderConfig config) : config_(std::move(config)) {}
  JobFolder(const JobFolder&) = delete;
  JobFolder& operator=(const JobFolder&) = delete;

  /// Takes over the folder: creates it and deletes incomplete files from an earlier process. Returns false
  /// while another server holds it; call again before using other functions. Returns kFileAccess if the
  /// folder cannot be used. Blocks.
  Expected<bool> take();

  /// A job from an earlier process.
  struct Found {
    JobRecord record;
    std::uint64_t begun = 0;  ///< number of processes that ended while they computed it
  };
  /// Loads the jobs in the folder, oldest first, and gives each a place. Their parameters are left out;
  /// read() returns them. Their mesh sizes are those of the files. Call after take() and before all other
  /// functions. Blocks.
  std::vector<Found> restore();

  enum class Room {
    kThere,
    kFull,       ///< other jobs use the space
    kOverShare,  ///< the owner's other jobs use up its share
    kOverPart,   ///< the client's other jobs use up its part (FairShare: half, if it is the only client)
    kTooLarge,   ///< larger than the folder or the share, even if they were empty
    kUnfit,      ///< cannot be stored: a text in it is not UTF-8, or it is too large
  };
  /// Reserves a place for a job until remove(). It is charged to the record's client; an empty client has no
  /// part. Does not access the disk.
  Room reserve(const JobRecord& record, std::uint64_t share);
  /// Writes the mesh and the record of a job. Returns false on failure. Blocks.
  bool write(const JobRecord& record, const FractureRequest& request);
  /// Reads the record of an unfinished job, as write() stored it. Returns nothing if it is missing or
  /// damaged; a damaged file is moved to quarantine. Blocks.
  std::optional<JobRecord> read(const std::string& id) { return get_record(id); }
  /// Replaces the record by that of an ended job. Blocks.
  bool write_end(const JobRecord& record);
  /// Deletes the record, the mark and the place, and also the mesh if no other job needs it. Blocks.
  void remove(const std::string& id);
  /// Reads a mesh. Returns nothing if it is missing or damaged; a damaged file is moved to quarantine.
  /// Blocks.
  std::optional<KeptMesh> read_mesh(const std::string& digest);

  /// Adds or removes the mark that this process computes the job. The mark survives the process, but is not
  /// flushed to disk, because a power failure is not the job's fault.
  void begun(const std::string& id) noexcept;
  void not_begun(const std::string& id) noexcept;

  std::uint64_t bytes_of(const std::string& owner) const;
  JobFolderFigures figures() const;

 private:
  struct Place {
    std::string owner, client;
    std::string digest;  ///< of the mesh that it needs; empty: no longer needed
    std::uint64_t bytes = 0;
  };
  struct Mesh {
    std::uint64_t bytes = 0;
    bool written = false;
    std::map<std::string, std::size_t> needed;  ///< number of jobs per owner that need it
  };

  /// A mesh file to delete, under a temporary name. Its bytes count until it is deleted.
  struct Unneeded {
    std::string path;  ///< empty: nothing to delete
    std::uint64_t bytes = 0;
  };

  std::string path(const char* kind, const std::string& name) const {
    return config_.folder + "/" + kind + "/" + name;
  }
  bool put(const char* kind, const std::string& name, std::string_view head,
           std::span<const std::span<const std::byte>> parts);
  SignedAs signed_as(std::string_view id) const { return {"jobs", id, 0}; }
  bool put_record(const JobRecord& record);
  /// Returns nothing if the record is damaged or not signed, and moves it to quarantine.
  std::optional<JobRecord> get_record(const std::string& id);
  void put_aside(const char* kind, const std::string& name);
  /// Deletes all files except the wanted ones, and puts aside everything that is not a file.
  void keep_files(const char* kind, const std::set<std::string>& wanted);
  /// Call without the lock, because deleting a large file takes long. Blocks.
  void delete_mesh(const Unneeded& mesh);
  // The following functions need the lock.
  void take_place(const JobRecord& record, std::uint64_t record_bytes);
  /// Returns the bytes of this client's jobs, counting each mesh once, including the mesh of its new job
  /// `with`.
  std::uint64_t bytes_of_client(const JobRecord& with) const;
  /// The place needs its mesh no longer. The caller passes the result to delete_mesh().
  [[nodiscard]] Unneeded let_mesh_go(Place& place);
  std::uint64_t bytes_of_locked(const std::string& owner) const;

  const JobFolderConfig config_;
  FolderLock lock_;
  mutable std::mutex mutex_;
  std::map<std::string, Place> places_;
  std::map<std::string, Mesh> meshes_;
  std::uint64_t next_temporary_ = 0;
  JobFolderFigures figures_;
};

}  // namespace fracture
