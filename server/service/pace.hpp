// The ratio of measured to expected time: how many seconds work takes for each second that admission expects.
//
// Each client has a ratio of its own. Estimates of some requests are a thousand times too low, and the longest request
// dominates a sum. With one ratio for everybody, a single client would decide the predicted wait of all others. A new
// client starts with the lower median of the known clients' ratios and the start value. A minority of the clients cannot
// move this median. With two candidates in the middle, the lower one is used: it lets requests be tried that the higher one
// would refuse.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace fracture {

/// Not thread-safe.
class Pace {
 public:
  /// Records that work of this client took `seconds` when `cost` seconds were expected.
  void measured(const std::string& client, double cost, double seconds) {
    constexpr double kKept = 0.95;      // about the last twenty measurements matter
    constexpr double kStartCost = 0.1;  // seconds; gives the start value the weight of a typical request
    Sums& sums = clients_.try_emplace(client, Sums{kStartCost * usual_, kStartCost}).first->second;
    sums.took = kKept * sums.took + seconds;
    sums.cost = kKept * sums.cost + cost;
    sums.measured = ++now_;
    if (clients_.size() > kMostClients) clients_.erase(least_recently_measured());
    usual_ = lower_median();
  }
  /// Returns the ratio of this client.
  double of(const std::string& client) const {
    const auto at = clients_.find(client);
    return at == clients_.end() ? usual_ : at->second.ratio();
  }
  std::size_t known() const { return clients_.size(); }

  /// With more clients than this, the least recently measured one is forgotten.
  static constexpr std::size_t kMostClients = 256;
  static constexpr double kStart = 1;

 private:
  /// Decaying sums.
  struct Sums {
    double ratio() const { return took / cost; }
    double took, cost;
    std::uint64_t measured = 0;  ///< when it was last measured, in measurements of all clients
  };
  using Clients = std::unordered_map<std::string, Sums>;

  Clients::const_iterator least_recently_measured() const {
    return std::min_element(clients_.begin(), clients_.end(), [](const auto& a, const auto& b) {
      return a.second.measured < b.second.measured;
    });
  }
  double lower_median() const {
    std::vector<double> ratios{kStart};
    for (const auto& [name, sums] : clients_) ratios.push_back(sums.ratio());
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>((ratios.size() - 1) / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
  }

  Clients clients_;
  std::uint64_t now_ = 0;
  double usual_ = kStart;
};

}  // namespace fracture
