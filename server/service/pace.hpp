// How long work takes for each second that admission expects of it.
//
// Each client has a ratio of its own. The estimates of some requests are a thousand times too low, and what takes longest
// decides a sum. With one ratio for everybody, one client would decide how long all others are predicted to wait. The
// ratio of a newcomer is the lower median over the known clients and the start value. A minority of the clients cannot move
// it. The lower of two candidates lets a request be tried that the higher one would refuse.
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
  /// Work of this client that was expected to take `cost` seconds took so many.
  void measured(const std::string& client, double cost, double seconds) {
    constexpr double kKept = 0.95;      // the last twenty or so decide
    constexpr double kStartCost = 0.1;  // seconds: as much as a usual request counts the start value
    Sums& sums = clients_.try_emplace(client, Sums{kStartCost * usual_, kStartCost}).first->second;
    sums.took = kKept * sums.took + seconds;
    sums.cost = kKept * sums.cost + cost;
    sums.measured = ++now_;
    if (clients_.size() > kMostClients) clients_.erase(least_recently_measured());
    usual_ = lower_median();
  }
  /// Seconds for each that is expected of work of this client.
  double of(const std::string& client) const {
    const auto at = clients_.find(client);
    return at == clients_.end() ? usual_ : at->second.ratio();
  }
  std::size_t known() const { return clients_.size(); }

  /// Beyond them, the one that was measured longest ago is forgotten.
  static constexpr std::size_t kMostClients = 256;
  static constexpr double kStart = 1;

 private:
  /// Decaying sums.
  struct Sums {
    double ratio() const { return took / cost; }
    double took, cost;
    std::uint64_t measured = 0;  ///< the last time
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
