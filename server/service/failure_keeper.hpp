// What is needed to see a failure again: the mesh, the files it names, what was asked, and a command that
// asks it again.
//
//   <folder>/<first digits of the result's key>/
//     request.json     parameters, versions, what went wrong, the certificate, "command"
//     mesh/barrel.obj  the bytes of the request
//     mesh/...         its further files under the names that the mesh has for them
//     job.ndjson       the manifest that "command" names, only where a command line cannot say the parameters
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
  std::string folder;  ///< made when the first failure is kept; empty: nothing is kept
  std::size_t max_failures = 100;
  std::uint64_t max_bytes = 1ull << 30;  ///< of all failures together; each file counts as 4 KiB at least
  std::string program = {};              ///< name and version, for request.json
};

struct KeptFailures {
  std::size_t kept = 0;     ///< by this process; the folder may hold earlier ones
  std::size_t known = 0;    ///< were there already, from an earlier process too
  std::size_t dropped = 0;  ///< found no room: the oldest stay
  std::size_t unwritten = 0;
};

/// Thread-safe; several processes may share a folder, with bounds that then are approximate by one failure
/// for each of them.
class FailureKeeper {
 public:
  /// `say` is told once, in a sentence, when a failure cannot be written.
  explicit FailureKeeper(FailureKeeperConfig config, std::function<void(const std::string&)> say = {});

  /// Should it be kept: is it a bug of ours (kUnsound, kInternal)?
  static bool concerns(ErrorCode code) { return code == ErrorCode::kUnsound || code == ErrorCode::kInternal; }
  /// Writes the reproduction whole or not at all. Never throws. `certificate` as in extras.fracture; null:
  /// what the error says of it, or there is none. `mesh_name`: what the mesh's file was called; empty:
  /// nothing is known.
  void keep(const FractureRequest& request, const Error& error, const nlohmann::json& certificate = nullptr,
            std::string_view mesh_name = {}) noexcept;

  bool any() const { return !config_.folder.empty(); }
  /// Makes the folder, where there is to be one. kFileAccess when it cannot be made or written.
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
