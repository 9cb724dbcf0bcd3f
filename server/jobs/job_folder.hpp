// Jobs on the disk, so that they outlive the process. A file appears under its name only when it is whole and
// on the disk (written beside, fsync, rename, fsync of the folder), and is believed only when its digest says
// so; what is not is put aside.
//
//   <folder>/lock               held by the one server that uses the folder
//   <folder>/records/<job id>   a job: what is asked while it is to be computed, what it came to afterwards
//   <folder>/meshes/<digest>    a mesh with its files, for as long as a job that is to be computed needs it
//   <folder>/begun/<job id>     one byte for each process that began to compute it and did not end it
//   <folder>/tmp/...            being written; emptied at the start
//   <folder>/quarantine/...     what was found damaged, a few of them, to look at
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
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
  std::uint64_t max_bytes = 1ull << 30;  ///< of records and meshes together
  /// With keys every record is signed, and one that is not counts as damaged. Meshes are named by their
  /// digest.
  FarmKeys keys{};
  std::size_t max_jobs = 1000;  ///< that restore() takes; further ones stay where they are, for a later start
};

struct JobFolderFigures {
  std::size_t jobs = 0;
  std::uint64_t bytes = 0, writes = 0;
  std::uint64_t failures = 0;     ///< reads or writes that the system refused
  std::uint64_t quarantined = 0;  ///< files that were found damaged
};

/// Invariant: the bytes of all jobs that have a place are at most max_bytes, where a mesh that several jobs
/// need counts once; those of one owner, counted for itself, were at most its share when it got the place, and those of
/// one client at most its part.
/// Thread-safe; what is said to block blocks for as long as the disk takes.
class JobFolder {
 public:
  /// The folder is not touched before take().
  explicit JobFolder(JobFolderConfig config) : config_(std::move(config)) {}
  JobFolder(const JobFolder&) = delete;
  JobFolder& operator=(const JobFolder&) = delete;

  /// Takes the folder over: makes it, removes what an earlier process left half-written. False while another
  /// server has it: to be called again, before all else. kFileAccess when the folder cannot be used. Blocks.
  Expected<bool> take();

  /// A job that is there from an earlier process.
  struct Found {
    JobRecord record;
    std::uint64_t begun = 0;  ///< in how many processes it was being computed when they ended
  };
  /// What is there, each with its place, the oldest first; without parameters, which read() has, and with the size that
  /// its mesh has on the disk. After take(), before all else. Blocks.
  std::vector<Found> restore();

  enum class Room {
    kThere,
    kFull,       ///< other jobs have it
    kOverShare,  ///< this owner's other jobs have its share
    kOverPart,  ///< this client's other jobs have its part, whatever its share (FairShare: half, when it is alone)
    kTooLarge,  ///< for the folder or the share, were they empty
    kUnfit,     ///< it cannot be written down: a text of it is not UTF-8
  };
  /// A place for a job, until remove(). It counts as the client's; nobody in particular ("") has no part. Does not touch
  /// the disk.
  Room reserve(const JobRecord& record, std::uint64_t share, const std::string& client = "");
  /// Mesh and record. False when they could not be written. Blocks.
  bool write(const JobRecord& record, const FractureRequest& request);
  /// What write() wrote of a job that is to be computed. Nothing where it is gone or damaged (which puts it
  /// aside). Blocks.
  std::optional<JobRecord> read(const std::string& id) { return get_record(id); }
  /// The record of a job that has ended, in place of what was to be computed. Blocks.
  bool write_end(const JobRecord& record);
  /// Record, mark and place, and the mesh where no other job needs it. Blocks.
  void remove(const std::string& id);
  /// Nothing where it is gone or damaged (which puts it aside). Blocks.
  std::optional<KeptMesh> read_mesh(const std::string& digest);

  /// Leaves the mark that this process computes the job, or takes it away. It outlives the process but not
  /// the machine: what takes the power away was not the job.
  void begun(const std::string& id) noexcept;
  void not_begun(const std::string& id) noexcept;

  std::uint64_t bytes_of(const std::string& owner) const;
  JobFolderFigures figures() const;

 private:
  struct Place {
    std::string owner, client;
    std::string digest;  ///< of the mesh that it needs; empty: none (any more)
    std::uint64_t bytes = 0;
  };
  struct Mesh {
    std::uint64_t bytes = 0;
    bool written = false;
    std::map<std::string, std::size_t> needed;  ///< by how many jobs of each owner
  };

  std::string path(const char* kind, const std::string& name) const {
    return config_.folder + "/" + kind + "/" + name;
  }
  bool put(const char* kind, const std::string& name, std::string_view head,
           std::span<const std::span<const std::byte>> parts);
  SignedAs signed_as(std::string_view id) const { return {"jobs", id, 0}; }
  bool put_record(const JobRecord& record);
  /// Nothing where it is damaged or not signed, which puts it aside.
  std::optional<JobRecord> get_record(const std::string& id);
  void put_aside(const char* kind, const std::string& name);
  // With the lock.
  void take_place(const JobRecord& record, std::uint64_t record_bytes, const std::string& client);
  /// What this client's jobs take, each mesh once; `with` is a mesh that one more of them needs.
  std::uint64_t bytes_of_client(const std::string& client, const JobRecord& with) const;
  void let_mesh_go(Place& place);
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
