// Whose turn it is, where several computations share the processors. The library only says where a
// computation could stand back; who decides is its caller's caller (server/service/worker_pool.hpp).
#pragma once

namespace fracture {

/// Thread-safe: called by every thread of the computation.
class Turn {
 public:
  virtual ~Turn() = default;
  /// Called at each poll: waits while something more urgent needs the processor, within a limit. Cheap when
  /// nothing does. Throws Interrupted where the computation has to end for others.
  virtual void give_way() = 0;
  /// Instead of give_way() where it is away: never waits.
  virtual void end_where_it_must() {}
  /// Between these two the computation waits for work that is done elsewhere (another process), and uses no
  /// processor here. Not nested; only by the thread that the computation began on.
  virtual void leave() = 0;
  virtual void come_back() = 0;
  /// What was done elsewhere took so many seconds of a processor. By the thread that the computation began on.
  virtual void spent_elsewhere(double /*seconds*/) {}
  /// Somebody waits for the computation who cannot wait long: where it waits for others, it goes before them.
  /// May change while it runs.
  virtual bool is_urgent() const { return true; }
};

/// Away for as long as this lives; nothing where `turn` is null.
class Away {
 public:
  explicit Away(Turn* turn) : turn_(turn) {
    if (turn_) turn_->leave();
  }
  ~Away() {
    if (turn_) turn_->come_back();
  }
  Away(const Away&) = delete;
  Away& operator=(const Away&) = delete;

 private:
  Turn* turn_;
};

}  // namespace fracture
