// What of a job is on the disk, and as which bytes. A record is a line that names its kind and version, a
// line with the SHA-256 of what follows, and JSON; a mesh is its files behind a list of their sizes, and is
// believed when it has the digest that it is named by.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/job.hpp"
#include "server/service/request.hpp"

namespace fracture {

struct JobRecord {
  std::string id, owner;
  JobState state = JobState::kQueued;  ///< queued: to be computed, as far as the disk knows
  std::chrono::sys_time<std::chrono::microseconds> created{};
  std::optional<std::chrono::sys_time<std::chrono::microseconds>> finished_at{};
  std::chrono::milliseconds patience{0};  ///< its deadline, from when it is computed
  std::string digest;                     ///< of the mesh
  std::uint64_t mesh_bytes = 0;           ///< of it and its files, names included
  MeshFormat format = MeshFormat::kGlb;
  OutputFormat output = OutputFormat::kGlb;
  std::uint64_t triangles = 0;  ///< of the solid, when they were counted before
  nlohmann::json parameters =
      nlohmann::json::object();  ///< canonical_parameters(), while it is to be computed
  std::string result_key;
  std::optional<Error> error;  ///< of a job that failed or was cancelled
};

/// 16 hex digits, a hyphen, 16 hex digits: nothing else is a job's id, or becomes the name of a file.
bool is_job_id(std::string_view id);

/// Throws nlohmann::json::exception for text that is not UTF-8.
std::string encode_record(const JobRecord& record);
/// Nothing for anything that encode_record() does not write: limits of depth and size, types and ranges are checked.
std::optional<JobRecord> decode_record(std::string_view bytes);

/// A mesh with its further files, out of one buffer.
struct KeptMesh {
  std::shared_ptr<const std::vector<std::uint8_t>> owner;
  std::span<const std::byte> mesh;
  std::vector<ImportFile> files;
};
/// What stands before the bytes of the mesh and those of its files, one after the other.
std::string encode_mesh_head(const FractureRequest& request);
/// `bytes` begins with the head at `at`. Nothing unless its digest is this one.
std::optional<KeptMesh> decode_mesh(std::shared_ptr<const std::vector<std::uint8_t>> bytes, std::size_t at,
                                    std::string_view digest);

}  // namespace fracture
