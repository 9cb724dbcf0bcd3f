#include "server/ops/metrics.hpp"
#include "common/base/text.hpp"

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <map>
#include <mutex>
#include <sstream>
#include <string_view>
#include <utility>

namespace fracture::ops {
namespace {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Histogram;
using prometheus::MetricType;

/// Bucket limits in seconds. They are close together around one frame (16 ms), the goal of the realtime
/// class.
const Histogram::BucketBoundaries kSeconds = {0.0005, 0.001, 0.002, 0.004, 0.008, 0.016, 0.033, 0.066, 0.125,
                                              0.25,   0.5,   1,     2,     4,     8,     16,    32,    64};

/// Bucket limits in seconds for a turn of an io thread, which should take at most 0.2 ms.
const Histogram::BucketBoundaries kTurnSeconds = {0.00002, 0.00005, 0.0001, 0.0002, 0.0005, 0.001, 0.002,
                                                  0.005,   0.01,    0.02,   0.05,   0.1,    0.5};

class FamilyWriter final : public MetricWriter {
 public:
  void counter(const std::string& name, const std::string& help, double value,
               const Labels& labels) override {
    at(name, help, MetricType::Counter, labels).counter.value = value;
  }
  void gauge(const std::string& name, const std::string& help, double value, const Labels& labels) override {
    at(name, help, MetricType::Gauge, labels).gauge.value = value;
  }
  std::vector<prometheus::MetricFamily> families() && {
    std::vector<prometheus::MetricFamily> all;
    for (auto& [name, family] : by_name_) all.push_back(std::move(family));
    return all;
  }

 private:
  prometheus::ClientMetric& at(const std::string& name, const std::string& help, MetricType type,
                               const Labels& labels) {
    prometheus::MetricFamily& family = by_name_[name];
    family.name = name;
    family.help = help;
    family.type = type;
    prometheus::ClientMetric& metric = family.metric.emplace_back();
    for (const auto& [label, text] : labels) metric.label.push_back({label, text});
    return metric;
  }
  std::map<std::string, prometheus::MetricFamily> by_name_;
};

}  // namespace

struct Metrics::Impl {
  prometheus::Registry registry;

  Family<Counter>& counter(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
  }
  Family<Histogram>& histogram(const char* name, const char* help) {
    return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
  }

  Family<Counter>& requests = counter(
      "fracture_requests_total",
      "Requests by route in openapi.json (none: unknown path or malformed request) and status (0: the client left before its "
      "request was complete; 499: the client left before the answer was ready).");
  Family<Counter>& bytes = counter("fracture_body_bytes_total", "Bytes of bodies by direction (in, out).");
  Family<Counter>& undelivered =
      counter("fracture_answers_undelivered_total", "Answers that the client did not read in full.");
  Family<Counter>& caches =
      counter("fracture_cache_lookups_total", "Lookups in each cache by outcome (hit, miss).");
  Family<Counter>& connections = counter(
      "fracture_connections_total", "Connections opened by clients, including those that were then refused.");
  Family<Counter>& refused = counter("fracture_connections_refused_total",
                                     "Connections that received only an error, because too many were open.");
  Family<Counter>& abandoned =
      counter("fracture_work_abandoned_total",
              "Requests that were stopped because their client closed or reset its connection (status 499).");
  Family<Histogram>& durations = histogram("fracture_request_duration_seconds",
                                           "Time from the complete header to the last byte of the answer.");
  Histogram& queue_wait = histogram("fracture_queue_wait_seconds",
                                    "Time from the complete request to the start of its computation.")
                              .Add({}, kSeconds);

  Histogram& io_turns =
      histogram(
          "fracture_io_turn_seconds",
          "Processor time of one turn of an I/O thread: the work for one client before the thread serves "
          "other clients.")
          .Add({}, kTurnSeconds);

  Counter& bytes_in = bytes.Add({{"direction", "in"}});
  Counter& bytes_out = bytes.Add({{"direction", "out"}});
  Counter& all_undelivered = undelivered.Add({});
  Counter& all_connections = connections.Add({});
  Counter& refused_full = refused.Add({{"reason", "full"}});
  Counter& refused_address = refused.Add({{"reason", "address"}});
  Counter& all_abandoned = abandoned.Add({});

  mutable std::mutex mutex;
  std::map<int, Source> sources;
  int next_source = 0;
};

Metrics::Metrics() : impl_(std::make_unique<Impl>()) {}
Metrics::~Metrics() = default;

void Metrics::count_request(const RequestRecord& record) {
  const std::string route = record.route.empty() ? "none" : record.route;
  const std::string listener = record.admin ? "admin" : "public";
  impl_->requests.Add({{"listener", listener}, {"route", route}, {"status", std::to_string(record.status)}})
      .Increment();
  if (record.admin) return;
  impl_->durations.Add({{"route", route}}, kSeconds).Observe(record.milliseconds / 1000);
  if (record.queue_milliseconds >= 0) impl_->queue_wait.Observe(record.queue_milliseconds / 1000);
  impl_->bytes_in.Increment(static_cast<double>(record.bytes_in));
  impl_->bytes_out.Increment(static_cast<double>(record.bytes_out));
  if (!record.delivered) impl_->all_undelivered.Increment();
  // Cache-Status (RFC 9211): "mesh; hit, result; fwd=miss; stored"
  for (std::string_view rest = record.cache; !rest.empty();) {
    const std::string_view member = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), member.size() + 1));
    const std::string name(trimmed(member.substr(0, member.find(';'))));
    const char* outcome = member.find("; hit") != std::string_view::npos ? "hit" : "miss";
    if (!name.empty()) impl_->caches.Add({{"cache", name}, {"outcome", outcome}}).Increment();
  }
}

void Metrics::count_connection() { impl_->all_connections.Increment(); }

void Metrics::count_refused_connection(Refusal reason) {
  (reason == Refusal::kFull ? impl_->refused_full : impl_->refused_address).Increment();
}

void Metrics::count_io_turn(double seconds) { impl_->io_turns.Observe(seconds); }

void Metrics::count_abandoned_work() { impl_->all_abandoned.Increment(); }

int Metrics::add_source(Source source) {
  const std::lock_guard lock(impl_->mutex);
  impl_->sources.emplace(impl_->next_source, std::move(source));
  return impl_->next_source++;
}

void Metrics::remove_source(int id) {
  const std::lock_guard lock(impl_->mutex);
  impl_->sources.erase(id);
}

std::string Metrics::text() const {
  std::vector<prometheus::MetricFamily> families = impl_->registry.Collect();
  {
    FamilyWriter writer;
    const std::lock_guard lock(impl_->mutex);  // no source is removed while it is read
    for (const auto& [id, source] : impl_->sources) source(writer);
    for (prometheus::MetricFamily& family : std::move(writer).families())
      families.push_back(std::move(family));
  }
  std::ostringstream out;
  prometheus::TextSerializer().Serialize(out, families);
  return std::move(out).str();
}

}  // namespace fracture::ops
