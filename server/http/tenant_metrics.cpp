#include "server/http/tenant_metrics.hpp"

#include <string>

namespace fracture::http {
namespace {

void write(ops::MetricWriter& writer, const std::string& name, const tenants::Account::Figures& figures,
           const Holdings& holds) {
  const auto count = [&](const char* metric, const char* help, double value,
                         const ops::MetricWriter::Labels& more = {}) {
    ops::MetricWriter::Labels labels = {{"tenant", name}};
    labels.insert(labels.end(), more.begin(), more.end());
    writer.counter(metric, help, value, labels);
  };
  count("fracture_tenant_requests_total", "Requests from each name, including refused ones.",
        static_cast<double>(figures.requests));
  count("fracture_tenant_over_share_total", "Requests refused because the name exceeded its share.",
        static_cast<double>(figures.over_share));
  count("fracture_tenant_processor_seconds_total", "Processor seconds that count towards each name's share.",
        figures.processor_seconds);
  constexpr const char* kBytes = "Bytes of request and response bodies of each name.";
  count("fracture_tenant_body_bytes_total", kBytes, static_cast<double>(figures.bytes_in),
        {{"direction", "in"}});
  count("fracture_tenant_body_bytes_total", kBytes, static_cast<double>(figures.bytes_out),
        {{"direction", "out"}});
  writer.gauge("fracture_tenant_computations", "Queued and running computations of each name.",
               static_cast<double>(figures.computations), {{"tenant", name}});
  writer.gauge("fracture_tenant_stored_mesh_bytes",
               "Bytes of each name's stored meshes, including meshes that other names have stored too.",
               static_cast<double>(holds.stored), {{"tenant", name}});
  writer.gauge("fracture_tenant_answer_bytes", "Bytes of answers that each name can fetch again.",
               static_cast<double>(holds.cached), {{"tenant", name}});
}

}  // namespace

void write_tenant_metrics(const tenants::Accounts& accounts,
                          const std::function<Holdings(const std::string& name)>& holdings,
                          ops::MetricWriter& writer) {
  Holdings of_others;
  tenants::Account::Figures others;
  std::size_t written = 0;
  bool any_other = false;
  for (const auto& account : accounts.all()) {
    const tenants::Account::Figures figures = account->figures();
    if (written < kNamesInMetrics) {
      ++written;
      write(writer, account->name(), figures, holdings(account->name()));
      continue;
    }
    any_other = true;
    const Holdings theirs = holdings(account->name());
    of_others.stored += theirs.stored;
    of_others.cached += theirs.cached;
    others.requests += figures.requests;
    others.over_share += figures.over_share;
    others.processor_seconds += figures.processor_seconds;
    others.bytes_in += figures.bytes_in;
    others.bytes_out += figures.bytes_out;
    others.computations += figures.computations;
  }
  if (any_other) write(writer, kOtherNames, others, of_others);
}

}  // namespace fracture::http
