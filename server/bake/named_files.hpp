// The files that meshes refer to (textures, buffers, material libraries), which no output may overwrite, because they are inputs too.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// Several threads may call all functions at once.
class NamedFiles {
 public:
  /// Adds the files that the job's mesh refers to.
  void add(const InputFile& input, const BakeJob& job);

  /// Returns kFileAccess if the job would overwrite such a file by its output, the output's materials or `depfile` (may be empty).
  std::optional<Error> loss_by(const BakeJob& job, const std::string& depfile) const;

  /// Returns kFileAccess if `path` is such a file.
  std::optional<Error> loss_of(const std::string& path) const;

 private:
  mutable std::mutex mutex_;
  std::map<FileIdentity, std::string> named_;  ///< each file, and how an error names it
};

}  // namespace fracture::bake
