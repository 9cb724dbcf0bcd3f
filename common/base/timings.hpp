// Wall-clock time by stage, in the order the stages first ran: the source of Server-Timing and of bake
// reports. Timings never reach the GLB (its bytes depend on input and parameters only).
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace fracture {

class StageTimings {
 public:
  /// Adds milliseconds to the stage.
  void add(const std::string& stage, double milliseconds) {
    for (auto& [name, ms] : stages_)
      if (name == stage) {
        ms += milliseconds;
        return;
      }
    stages_.emplace_back(stage, milliseconds);
  }
  const std::vector<std::pair<std::string, double>>& stages() const { return stages_; }
  double milliseconds(const std::string& stage) const {
    for (const auto& [name, ms] : stages_)
      if (name == stage) return ms;
    return 0;
  }

  /// Adds the time from its construction to its destruction.
  class Scope {
   public:
    Scope(StageTimings& timings, std::string stage) : timings_(timings), stage_(std::move(stage)) {}
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;
    ~Scope() {
      const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start_;
      timings_.add(stage_, ms.count());
    }

   private:
    StageTimings& timings_;
    std::string stage_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  };

 private:
  std::vector<std::pair<std::string, double>> stages_;
};

}  // namespace fracture
