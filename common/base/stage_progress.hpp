// Reports how far a stage is, updated by its parallel loops. The total work of a stage is not known in
// advance. So each loop takes a part of the remaining stage (or of the part that reaches() names), and loops
// with fewer blocks take less. The reported value grows with every loop and never passes the end.
//
//     0 ├──── loop 1 ────┼── loop 2 ──┼─ 3 ─┼┄┄┤ reaches(0.6) ├──── loop 4 ────┼┄┄┄┄┤ 1
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <functional>
#include <tuple>
#include <utility>

#include "common/base/stage.hpp"

namespace fracture {

/// The progress of one stage of one computation. Parts, reaches() and loops must be used on one thread at a
/// time; the blocks of a loop may run on any thread.
class StageProgress {
 public:
  using Tell = std::function<void(Stage, double)>;
  /// Borrows `tell`. If `tell` is empty, nothing is reported.
  StageProgress(Stage stage, const Tell& tell) : stage_(stage), tell_(tell) {}
  StageProgress(const StageProgress&) = delete;
  StageProgress& operator=(const StageProgress&) = delete;

  /// The following work takes the stage, or its innermost Part, to `end`, in (0, 1]. If the stage is already
  /// past `end` (because work is repeated), goes half-way through the remainder instead.
  void reaches(double end) {
    if (looping_) return;  // called within a block, which is already part of a loop
    if (std::exchange(divided_, true)) position_ = std::max(position_, end_);
    const double last = first_ + span_, wanted = first_ + span_ * end;
    end_ = wanted > position_ ? wanted : position_ + std::max(0.0, last - position_) / 2;
    if (tell_) tell_(stage_, position_);
  }

  /// While it exists, reaches() refers to this part of the stage. For work that is divided itself and is done
  /// several times. Does nothing if `stage` is null.
  class Part {
   public:
    Part(StageProgress* stage, double end) : stage_(stage && !stage->looping_ ? stage : nullptr) {
      if (!stage_) return;
      before_ = {stage_->first_, stage_->span_};
      stage_->reaches(end);
      last_ = stage_->end_;
      stage_->first_ = stage_->position_;
      stage_->span_ = last_ - stage_->position_;
      stage_->divided_ = false;
    }
    ~Part() {
      if (!stage_) return;
      std::tie(stage_->first_, stage_->span_) = before_;
      stage_->end_ = last_;
      stage_->divided_ = true;
    }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

   private:
    StageProgress* const stage_;
    std::pair<double, double> before_{};
    double last_ = 1;
  };

  /// While it exists, a loop with this many blocks runs. Among nested loops, only the outermost one reports.
  class Loop {
   public:
    Loop(StageProgress* stage, std::size_t blocks) {
      if (!stage || !stage->tell_ || stage->looping_.exchange(true)) return;
      stage_ = stage;
      blocks_ = static_cast<double>(blocks);
      share_ = (stage->end_ - stage->position_) * blocks_ / (2 * blocks_ + kFewBlocks);
      mask_ = std::bit_floor(std::max<std::size_t>(1, blocks / kTold)) - 1;
    }
    ~Loop() {
      if (!stage_) return;
      stage_->position_ += share_;
      stage_->looping_ = false;
    }
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;

    /// Reports that a block begins.
    void at(std::size_t block) {
      if (!stage_ || (block & mask_) != 0) return;
      stage_->tell_(stage_->stage_, stage_->position_ + share_ * static_cast<double>(block) / blocks_);
    }

   private:
    static constexpr double kFewBlocks = 32;
    static constexpr std::size_t kTold = 32;  ///< minimum number of reports if there are as many blocks
    StageProgress* stage_ = nullptr;
    double blocks_ = 1, share_ = 0;
    std::size_t mask_ = 0;
  };

 private:
  const Stage stage_;
  const Tell& tell_;
  double position_ = 0, end_ = 1;
  bool divided_ = false;         // reaches() has set an end, and the next range begins at end_
  double first_ = 0, span_ = 1;  // the range that reaches() refers to
  std::atomic<bool> looping_{false};
};

}  // namespace fracture
