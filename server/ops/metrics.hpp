// Counters and gauges of a running server in the text format of Prometheus.
//
// Events (requests, connections) are counted here when they happen. Values that other parts already keep
// (queue, caches, memory) are read through sources when the metrics are requested.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/ops/request_record.hpp"

namespace fracture::ops {

/// Collects the values of the sources. Each name has one type and one help text; samples differ by their
/// labels.
class MetricWriter {
 public:
  using Labels = std::vector<std::pair<std::string, std::string>>;
  virtual ~MetricWriter() = default;
  /// A counter never decreases while the process lives. Its name ends with _total.
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

  /// Counts a request that was answered, or whose client left before that (status 0). Also counts each cache
  /// named in its Cache-Status.
  void count_request(const RequestRecord& record);
  void count_connection();
  enum class Refusal { kFull, kTooManyOfAddress };
  void count_refused_connection(Refusal reason);
  /// Counts one turn of an io thread of the public listener: the processor seconds from one wait for events
  /// to the next.
  void count_io_turn(double seconds);
  /// Counts work that was stopped because its client left while it waited or ran.
  void count_abandoned_work();

  /// A source is called for every reading, from the reading thread. It must be quick and must not wait for
  /// clients. Its captures must live until remove_source() or the end of the metrics.
  using Source = std::function<void(MetricWriter&)>;
  int add_source(Source source);
  void remove_source(int id);

  /// Returns all metrics as text/plain; version=0.0.4.
  std::string text() const;
  static constexpr const char* kContentType = "text/plain; version=0.0.4; charset=utf-8";

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

/// Writes memory, descriptors, CPU time, start time and dropped log lines of this process.
void write_process_metrics(MetricWriter& writer);

}  // namespace fracture::ops
