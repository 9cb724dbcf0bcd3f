// --dump-stages: writes the result of each stage as Wavefront OBJ, for any viewer.
#pragma once

#include <atomic>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "server/service/engine.hpp"

namespace fracture::bake {

/// Returns the dump's files in the order of the stages. All are in metres, y up, in the same coordinates, so
/// that they can be overlaid; only the fragments are moved apart.
std::vector<std::string> stage_files(const std::string& folder);

/// Writes the files of a dump. Thread-safe.
class StageDump {
 public:
  /// `say` receives a message for each file that cannot be written.
  StageDump(std::string folder, std::function<void(const std::string& line)> say);

  /// Writes the file of one stage. An existing file is kept, which counts as a failure.
  void write(std::size_t stage, const std::function<void(std::ostream&)>& dump);
  bool failed() const { return failed_; }

 private:
  void fail(const std::string& path, int error);

  const std::string folder_;
  const std::function<void(const std::string& line)> say_;
  std::atomic<bool> failed_{false};
};

/// Wraps `inner` and writes the result of each step to `dump`.
std::unique_ptr<FractureEngine> dumping_engine(std::unique_ptr<FractureEngine> inner,
                                               std::shared_ptr<StageDump> dump);

}  // namespace fracture::bake
