// Lets the caller control a long computation: threads, cancellation, deadline, progress. The caller passes it
// to every stage (no globals). A default-constructed context means "one thread, never stop".
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/product.hpp"
#include "common/base/stage_progress.hpp"
#include "common/base/stop_token.hpp"
#include "common/base/turn.hpp"

namespace fracture {

/// Thrown by poll() inside the geometry loops. The pipeline turns it into an Error; it never leaves the
/// library.
struct Interrupted {
  explicit Interrupted(ErrorCode why) : code(why) {}
  explicit Interrupted(Error why) : code(why.code), error(std::make_shared<const Error>(std::move(why))) {}

  ErrorCode code;                        ///< kCancelled, kDeadlineExceeded, or an error of an Allowance
  std::shared_ptr<const Error> error{};  ///< set if the code alone does not describe the error
};

struct Execution {
  int threads = 1;  ///< maximum number of threads for parallel_for, including the caller's
  StopToken stop{};
  std::optional<std::chrono::steady_clock::time_point> deadline{};
  /// Called with (stage, fraction of it done in [0, 1]) from any worker thread; must be thread-safe and
  /// cheap.
  std::function<void(Stage, double)> progress{};
  /// Progress within the current stage, updated by its loops; borrowed. Null: not reported.
  StageProgress* within = nullptr;
  /// Limits the memory of the computation; borrowed. Null: no limit.
  Allowance* allowance = nullptr;
  /// Lets more urgent computations go first; borrowed. Null: never waits.
  Turn* turn = nullptr;
  /// Called at each poll, for tests that measure the work between two polls.
  std::function<void()> watch{};

  /// Counts new products. Throws Interrupted if the computation would exceed its allowance.
  void made(Product product, std::uint64_t count) const {
    if (allowance) allowance->add(product, count);
  }

  /// The following work takes the stage to this fraction (StageProgress::reaches).
  void reaches(double end) const {
    if (within) within->reaches(end);
  }

  /// Throws Interrupted if the work was cancelled or has timed out. Call it once per few hundred items: no
  /// thread may compute for more than 10 ms of processor time without a poll (base/pacer.hpp).
  void poll() const {
    if (watch) watch();
    if (turn) turn->give_way();
    if (stop.stop_requested()) throw Interrupted{ErrorCode::kCancelled};
    if (deadline && std::chrono::steady_clock::now() > *deadline)
      throw Interrupted{ErrorCode::kDeadlineExceeded};
  }
};

/// One thread, never stopped: for callers that do not control the computation.
inline const Execution kUninterrupted{};

/// Calls body(begin, end) for consecutive blocks of at most `grain` items that together cover [0, count).
/// Blocks run on up to execution.threads threads, in any order. The *boundaries* do not depend on the number
/// of threads. So results that are stored per block and joined in block order are the same for every thread
/// count. Polls the execution before each block. Rethrows the first exception of a block after all workers
/// have stopped.
void parallel_for(const Execution& execution, std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace fracture
