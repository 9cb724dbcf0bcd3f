// How the caller of a long computation stays in charge of it: threads, cancellation, deadline, progress.
// Passed by the caller to every stage (no globals); a default-constructed context means "one thread, never
// stop".
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

/// Thrown by poll() inside the geometry loops and turned into an Error by the pipeline. Not an error of the
/// library.
struct Interrupted {
  explicit Interrupted(ErrorCode why) : code(why) {}
  explicit Interrupted(Error why) : code(why.code), error(std::make_shared<const Error>(std::move(why))) {}

  ErrorCode code;  ///< kCancelled, kDeadlineExceeded; of an Allowance: kTooComplex, kOutOfMemory, kOverShare
  std::shared_ptr<const Error> error{};  ///< where the code alone does not say it
};

struct Execution {
  int threads = 1;  ///< how many threads parallel_for may use, the caller's included
  StopToken stop{};
  std::optional<std::chrono::steady_clock::time_point> deadline{};
  /// Called with (stage, fraction of it done in [0, 1]) from any worker thread; must be thread-safe and
  /// cheap.
  std::function<void(Stage, double)> progress{};
  /// Where the loops of a stage tell how far it is; borrowed. Null: nowhere.
  StageProgress* within = nullptr;
  /// What the computation may hold; borrowed. Null: as much as it likes.
  Allowance* allowance = nullptr;
  /// Where it stands back for others; borrowed. Null: nowhere.
  Turn* turn = nullptr;
  /// Called at each poll, for tests that measure what lies between two of them.
  std::function<void()> watch{};

  /// Counts what was made. Throws Interrupted where it is more than the computation may hold.
  void made(Product product, std::uint64_t count) const {
    if (allowance) allowance->add(product, count);
  }

  /// What follows takes the stage to here (StageProgress::reaches).
  void reaches(double end) const {
    if (within) within->reaches(end);
  }

  /// Throws Interrupted when the work is no longer wanted. Cheap enough for once per few hundred items. No
  /// thread may compute for longer than 10 ms of its processor time without a poll (base/pacer.hpp).
  void poll() const {
    if (watch) watch();
    if (turn) turn->give_way();
    if (stop.stop_requested()) throw Interrupted{ErrorCode::kCancelled};
    if (deadline && std::chrono::steady_clock::now() > *deadline)
      throw Interrupted{ErrorCode::kDeadlineExceeded};
  }
};

/// One thread, never stopped: for callers that are not in charge of anything.
inline const Execution kUninterrupted{};

/// Calls body(begin, end) for consecutive blocks of at most `grain` items that together cover [0, count).
/// Blocks run on up to execution.threads threads in any order; the *boundaries* do not depend on the number
/// of threads, so a result kept per block and joined in block order is the same for every thread count. Polls
/// the execution before each block. The first exception of a block is rethrown after all workers have
/// stopped.
void parallel_for(const Execution& execution, std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace fracture
