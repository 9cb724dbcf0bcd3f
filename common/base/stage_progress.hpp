// How far a stage is, told while it runs by its parallel loops. Nothing is known of a stage's work before it
// is done, so each loop takes a part of what is left of the stage (or of the part of it that reaches()
// named), the smaller the fewer blocks it has: what is told grows with every loop and never passes the end.
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

/// One stage of one computation. Parts, reaches() and loops on one thread at a time; blocks of a loop on any.
class StageProgress {
 public:
  using Tell = std::function<void(Stage, double)>;
  /// Borrows both; an empty `tell` makes all of this nothing.
  StageProgress(Stage stage, const Tell& tell) : stage_(stage), tell_(tell) {}
  StageProgress(const StageProgress&) = delete;
  StageProgress& operator=(const StageProgress&) = delete;

  /// What follows takes the stage, or the innermost Part of it, to here, in (0, 1]. Where it has come further
  /// already (work that is done again), to half of what is left.
  void reaches(double end) {
    if (looping_) return;  // said within a block, which is a part of its loop
    if (std::exchange(divided_, true)) position_ = std::max(position_, end_);
    const double last = first_ + span_, wanted = first_ + span_ * end;
    end_ = wanted > position_ ? wanted : position_ + std::max(0.0, last - position_) / 2;
    if (tell_) tell_(stage_, position_);
  }

  /// While it lives, what reaches() says is said of this part of the stage: for work that is itself divided,
  /// and done several times. Nothing where `stage` is null.
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

  /// While it lives, a loop of so many blocks. Only the outermost of nested loops tells.
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

    /// Block number `block` begins.
    void at(std::size_t block) {
      if (!stage_ || (block & mask_) != 0) return;
      stage_->tell_(stage_->stage_, stage_->position_ + share_ * static_cast<double>(block) / blocks_);
    }

   private:
    static constexpr double kFewBlocks = 32;
    static constexpr std::size_t kTold = 32;  ///< times a loop tells, at least, where it has as many blocks
    StageProgress* stage_ = nullptr;
    double blocks_ = 1, share_ = 0;
    std::size_t mask_ = 0;
  };

 private:
  const Stage stage_;
  const Tell& tell_;
  double position_ = 0, end_ = 1;
  bool divided_ = false;         // reaches() has named an end: end_ is where the next begins
  double first_ = 0, span_ = 1;  // what reaches() is said of
  std::atomic<bool> looping_{false};
};

}  // namespace fracture
