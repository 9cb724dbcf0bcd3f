// A child process that draws: `fracture-render --list`, which draws pictures of files one after the other.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>
#include <string>

#include "common/base/descriptor.hpp"
#include "common/base/error.hpp"

namespace fracture::bake {

/// Returns the path of the renderer: `named` if it is a program. If `named` is empty, looks for
/// fracture-render next to this program, in the client's part of the same build tree, and in PATH. Returns
/// kNoProgram if it is not found.
Expected<std::string> find_renderer(const std::string& named);

class RendererProcess {
 public:
  /// Starts the renderer. `threads`: drawing threads without a graphics card; 0 means one per core. The child
  /// gets this program's environment without our own variables, one of which is a token. Returns kNoProgram
  /// if it cannot be started.
  static Expected<RendererProcess> start(const std::string& program, int threads);
  RendererProcess(RendererProcess&& other) noexcept;
  RendererProcess& operator=(RendererProcess&&) = delete;
  /// Kills the renderer and all processes that it has started.
  ~RendererProcess();

  /// Draws one picture, described by a line as in client/cli/draw_list.hpp. Errors that the renderer reports
  /// for the file keep their code. Returns kNoProgram if the process ended or did not answer within the
  /// limit, and kCancelled if a stop was requested; in both cases the process is dead afterwards.
  Expected<void> draw(const nlohmann::json& line, std::chrono::milliseconds limit,
                      const std::stop_token& stop);
  bool alive() const { return pid_ > 0; }

 private:
  RendererProcess() = default;
  void kill();
  /// Returns why the process is dead, for an error message.
  std::string last_words();
  Error died(const std::string& how);
  void listen_to_complaints();

  pid_t pid_ = 0;
  Descriptor talk_;        ///< the child's standard input and output
  Descriptor complaints_;  ///< the child's standard error
  std::string heard_;      ///< the incomplete answer received so far
  std::string complaint_;  ///< the end of its standard error
};

}  // namespace fracture::bake
