// The report of a game without a window at its end, as JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "client/app/options.hpp"
#include "client/game/game.hpp"
#include "client/protocol/client.hpp"

namespace fracture::app {

/// The state of the game, its bodies and its server. Positions in m, velocities in m/s, energies in J.
nlohmann::json summary(const game::Game& game, const protocol::Client& client, const Options& options);

/// Number, median, 99th percentile and maximum of times in milliseconds, and the times in their order. The
/// object is empty if `times` is.
nlohmann::json summary_of_frames(std::vector<double> times);

/// Frame times of a run, in milliseconds.
class FrameTimes {
 public:
  /// `swapped`: fragments replaced an object in this frame. `waits`: a request is open.
  void add(double spent, bool swapped, bool waits) {
    all_.push_back(spent);
    if (swapped)
      add_to(swapping_, first_swap_, spent);
    else if (waits)
      add_to(waiting_, first_wait_, spent);
  }
  /// Adds `frames`, `waiting_frames` and `swap_frames`.
  void write_to(nlohmann::json& result) &&;

 private:
  void add_to(std::vector<double>& times, std::size_t& first, double spent) const {
    if (times.empty()) first = all_.size() - 1;
    times.push_back(spent);
  }
  std::vector<double> all_, swapping_, waiting_;
  std::size_t first_swap_ = 0, first_wait_ = 0;
};

}  // namespace fracture::app
