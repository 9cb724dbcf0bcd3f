// Wall-clock time by stage, for Server-Timing and the reports of bake. Timings are never in the GLB, whose
// bytes depend only on input and parameters.
#pragma once

#include <array>
#include <chrono>
#include <optional>

#include "common/base/stage.hpp"

namespace fracture {

class StageTimings {
 public:
  void add(Stage stage, double milliseconds) {
    std::optional<double>& sum = milliseconds_[index_of(stage)];
    sum = sum.value_or(0) + milliseconds;
  }
  void add(const StageTimings& more) {
    for (const StageRow& row : kStages)
      if (more.ran(row.stage)) add(row.stage, more.milliseconds(row.stage));
  }
  bool ran(Stage stage) const { return milliseconds_[index_of(stage)].has_value(); }
  bool empty() const { return milliseconds_ == decltype(milliseconds_){}; }
  /// 0 for a stage that did not run.
  double milliseconds(Stage stage) const { return milliseconds_[index_of(stage)].value_or(0); }

  /// Adds the time between its construction and its destruction.
  class Scope {
   public:
    Scope(StageTimings& timings, Stage stage) : timings_(timings), stage_(stage) {}
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;
    ~Scope() {
      const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start_;
      timings_.add(stage_, ms.count());
    }

   private:
    StageTimings& timings_;
    const Stage stage_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  };

 private:
  std::array<std::optional<double>, kStages.size()> milliseconds_{};
};

}  // namespace fracture
