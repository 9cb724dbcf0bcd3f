// A child that draws: `fracture-render --list`, which makes pictures of files one after the other.
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

/// The program that draws: `named` where that is one, and if it is empty fracture-render beside this program, in the client's
/// part of the build tree that this program lies in, or in PATH. kNoProgram where there is none.
Expected<std::string> find_renderer(const std::string& named);

class RendererProcess {
 public:
  /// `threads`: that draw, where no graphics card does; 0: one for each core. It gets this program's environment without
  /// the variables of this project, one of which is a token. kNoProgram where it cannot be started.
  static Expected<RendererProcess> start(const std::string& program, int threads);
  RendererProcess(RendererProcess&& other) noexcept;
  RendererProcess& operator=(RendererProcess&&) = delete;
  /// Kills it, with whatever it has started.
  ~RendererProcess();

  /// One picture, by the line of client/cli/draw_list.hpp. What the renderer says against the file is an error of its
  /// own code. kNoProgram: it ended, or did not answer within the limit, and is dead now. kCancelled: so did the stop.
  Expected<void> draw(const nlohmann::json& line, std::chrono::milliseconds limit,
                      const std::stop_token& stop);
  bool alive() const { return pid_ > 0; }

 private:
  RendererProcess() = default;
  void kill();
  /// Why it is dead, in words.
  std::string last_words();
  Error died(const std::string& how);
  void listen_to_complaints();

  pid_t pid_ = 0;
  Descriptor talk_;        ///< its standard input and output
  Descriptor complaints_;  ///< its standard error
  std::string heard_;      ///< of an answer that is not complete yet
  std::string complaint_;  ///< the end of what it said on standard error
};

}  // namespace fracture::bake
