// Keeps everything that is needed to reproduce a failure: the mesh, the files it refers to, the parameters, and a command
// that repeats the request.
//
//   <folder>/<first digits of the result's key>/
//     request.json     parameters, versions, the error, the certificate, "command"
//     mesh/barrel.obj  the mesh's bytes from the request
//     mesh/...         its additional files, under the names by which the mesh refers to them
//     job.ndjson       the manifest for "command", only if a command line cannot express the parameters
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "server/service/request.hpp"

namespace fracture {

struct FailureKeeperConfig {
  std::string folder;  ///< created if it is missing; empty: nothing is kept
  std::size_t max_failures = 100;
  std::uint64_t max_bytes = 1ull << 30;  ///< of all failures together; each file counts as at least 4 KiB
  std::string program = {};              ///< name and version, for request.json
};

struct KeptFailures {
  std::size_t kept = 0;     ///< kept by this process; the folder may contain earlier ones
  std::size_t known = 0;    ///< were already in the folder, possibly from an earlier process
  std::size_t dropped = 0;  ///< not kept because there was no room: the oldest failures stay
  std::size_t unwritten = 0;
};

/// Thread-safe. Several processes may share a folder. Then each of them may exceed the limits by one failure.
class FailureKeeper {
 public:
  /// `say` is called once with a message, the first time that a failure cannot be written.
  explicit FailureKeeper(FailureKeeperConfig config, std::function<void(const std::string&)> say = {});

  /// Returns whether an error should be kept, because it is a defect of this program (kUnsound, kInternal).
  static bool concerns(ErrorCode code) { return code == ErrorCode::kUnsound || code == ErrorCode::kInternal; }
  /// Writes the reproduction, completely or not at all. Never throws. `certificate`: as in extras.fracture; null: the one in
  /// the error is used, if there is one. `mesh_name`: the name of the mesh's file; empty: not known.
  void keep(const FractureRequest& request, const Error& error, const nlohmann::json& certificate = nullptr,
            std::string_view mesh_name = {}) noexcept;

  bool any() const { return !config_.folder.empty(); }
  /// Creates the folder if one is configured. Returns kFileAccess if it cannot be created or written.
  Expected<void> make_folder() const;
  const std::string& folder() const { return config_.folder; }
  KeptFailures figures() const;

 private:
  void write(const FractureRequest& request, const Error& error, const nlohmann::json& certificate,
             std::string_view mesh_name);
  bool has_room(std::uint64_t bytes) const;

  const FailureKeeperConfig config_;
  const std::function<void(const std::string&)> say_;
  mutable std::mutex mutex_;
  KeptFailures figures_;
};

}  // namespace fracture
