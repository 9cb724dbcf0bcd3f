// Decides which computation runs if several share the processors. The library only marks the points where a
// computation can wait; the caller's scheduler decides (server/service/worker_pool.hpp).
#pragma once

namespace fracture {

/// Thread-safe: called by every thread of the computation.
class Turn {
 public:
  virtual ~Turn() = default;
  /// Called at each poll: waits, within a limit, while something more urgent needs the processor. Cheap if
  /// nothing does. Throws Interrupted if the computation must end in favour of others.
  virtual void give_way() = 0;
  /// Called instead of give_way() while the computation is away. Never waits, but may throw Interrupted.
  virtual void end_where_it_must() {}
  /// Between leave() and come_back(), the computation waits for work done elsewhere (in another process), and
  /// uses no processor here. Not nested; called only by the thread that the computation began on.
  virtual void leave() = 0;
  virtual void come_back() = 0;
  /// Adds processor seconds that work done elsewhere took. Called by the thread that the computation began
  /// on.
  virtual void spent_elsewhere(double /*seconds*/) {}
  /// Whether a client waits for the computation and cannot wait long. If so, it goes before others that wait
  /// for a processor. May change while the computation runs.
  virtual bool is_urgent() const { return true; }
};

/// Calls leave() now and come_back() on destruction. Does nothing if `turn` is null.
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
