// Formats of a job's files on disk. A record is a line with its kind and version, a line with the SHA-256 of
// the rest, and JSON. A mesh file is a list of sizes followed by the mesh and its files; it is only valid if
// its digest matches its name.
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
  /// Key of the client that pays (Flow::name): a name, or an address (IPv6: its /64). The address is not hashed,
  /// because there are so few IPv4 addresses that a hash is easy to undo, even with a salt in the same folder.
  /// Empty if unknown, as in records of algorithm 27.
  std::string client{};
  JobState state = JobState::kQueued;  ///< kQueued: not finished, as far as the disk knows
  std::chrono::sys_time<std::chrono::microseconds> created{};
  std::optional<std::chrono::sys_time<std::chrono::microseconds>> finished_at{};
  std::chrono::milliseconds patience{0};  ///< its deadline, counted from the first attempt in a process
  std::string digest;                     ///< of the mesh
  std::uint64_t mesh_bytes = 0;           ///< of the mesh and its files, including their names
  MeshFormat format = MeshFormat::kGlb;
  OutputFormat output = OutputFormat::kGlb;
  std::uint64_t triangles = 0;                           ///< of the solid, if already counted
  nlohmann::json parameters = nlohmann::json::object();  ///< canonical_parameters(), while unfinished
  std::string result_key;
  std::optional<Error> error;  ///< if it failed or was cancelled
};

/// Returns whether the text is 16 hex digits, a hyphen and 16 hex digits. Only such ids are used as file
/// names.
bool is_job_id(std::string_view id);

/// Throws nlohmann::json::exception if a text is not UTF-8.
std::string encode_record(const JobRecord& record);
/// Returns nothing if encode_record() could not have written it. Checks depth, size, types and ranges.
std::optional<JobRecord> decode_record(std::string_view bytes);

/// A mesh with its additional files. All of them refer to one buffer.
struct KeptMesh {
  std::shared_ptr<const std::vector<std::uint8_t>> owner;
  std::span<const std::byte> mesh;
  std::vector<ImportFile> files;
};
/// Returns the header of a mesh file. The bytes of the mesh and of its files follow it.
std::string encode_mesh_head(const FractureRequest& request);
/// Parses a mesh file, whose header starts at `at`. Returns nothing if its digest is not `digest`.
std::optional<KeptMesh> decode_mesh(std::shared_ptr<const std::vector<std::uint8_t>> bytes, std::size_t at,
                                    std::string_view digest);

}  // namespace fracture
