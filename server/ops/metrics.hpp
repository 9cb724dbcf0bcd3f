// Counts and gauges of a running server in the exposition format of Prometheus.
//
// Events (requests, connections) are counted here as they happen; everything that somebody else already keeps
// (queue, caches, memory) is asked for when the figures are read, through sources.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/ops/request_record.hpp"

namespace fracture::ops {

/// Collects what the sources say. Every name has one type and one help text; the labels make the difference.
class MetricWriter {
 public:
  using Labels = std::vector<std::pair<std::string, std::string>>;
  virtual ~MetricWriter() = default;
  /// Never falls while the process lives; the name ends in _total.
  virtual void counter(const std::string& name, const std::string& help, double value,
                       const Labels& labels = {}) = 0;
  virtual void gauge(const std::string& name, const std::string& help, double value,
                     const Labels& labels = {}) = 0;
};

/// Thread-safe.
class Metrics {
 public:
  Metrics();
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  /// A request that has been answered, or whose client went away first (status 0). Also counts each cache
  /// that its Cache-Status names.
  void count_request(const RequestRecord& record);
  void count_connection();
  enum class Refusal { kFull, kTooManyOfAddress };
  void count_refused_connection(Refusal reason);
  /// An io thread of the public listener has served what was ready: so many processor seconds until it looked for the
  /// next.
  void count_io_turn(double seconds);
  /// A client reset its connection while its work waited or ran: the work was told to stop.
  void count_abandoned_work();

  /// Called for every reading, from the thread that reads; must be quick and must not block on clients. What
  /// it captures must live until remove_source or the end of the metrics.
  using Source = std::function<void(MetricWriter&)>;
  int add_source(Source source);
  void remove_source(int id);

  /// Everything, as text/plain; version=0.0.4.
  std::string text() const;
  static constexpr const char* kContentType = "text/plain; version=0.0.4; charset=utf-8";

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

/// Memory, descriptors, CPU time, start time and lost log lines of this process.
void write_process_metrics(MetricWriter& writer);

}  // namespace fracture::ops
