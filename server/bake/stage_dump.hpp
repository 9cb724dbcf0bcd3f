// --dump-stages: what each stage made, as Wavefront OBJ to look at in any viewer.
#pragma once

#include <atomic>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "server/service/engine.hpp"

namespace fracture::bake {

/// The files of a dump, in the order of the stages: all in metres, y up, at the same place, so that they may
/// be laid over one another; the fragments are moved apart.
std::vector<std::string> stage_files(const std::string& folder);

/// Writes them. Thread-safe.
class StageDump {
 public:
  /// `say` gets what cannot be written.
  StageDump(std::string folder, std::function<void(const std::string& line)> say);

  /// A file that is there already stays as it is, which is a failure.
  void write(std::size_t stage, const std::function<void(std::ostream&)>& dump);
  bool failed() const { return failed_; }

 private:
  void fail(const std::string& path, int error);

  const std::string folder_;
  const std::function<void(const std::string& line)> say_;
  std::atomic<bool> failed_{false};
};

/// What `inner` does, with what each of its steps made written to `dump`.
std::unique_ptr<FractureEngine> dumping_engine(std::unique_ptr<FractureEngine> inner,
                                               std::shared_ptr<StageDump> dump);

}  // namespace fracture::bake
