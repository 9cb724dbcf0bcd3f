// Metrics of the Api and everything below it. The memory metrics are written by the program
// (server/cli/memory_metrics.cpp).
#include "common/pipeline/algorithm_version.hpp"
#include "server/http/api.hpp"

namespace fracture::http {

void Api::write_metrics(ops::MetricWriter& writer) const {
  writer.gauge("fracture_build_info",
               "Always 1; the labels are the versions of the server and its algorithm.", 1,
               {{"version", FRACTURE_VERSION}, {"algorithm", std::to_string(kAlgorithmVersion)}});
  writer.gauge("fracture_ready",
               "1 while the server is ready, 0 while it is draining or waiting for a folder that another "
               "server is using.",
               ready() ? 1 : 0);
  const WorkerPool& pool = dispatcher_.pool();
  writer.gauge("fracture_queue_depth", "Computations waiting for a computing thread.",
               static_cast<double>(pool.queued()));
  writer.gauge("fracture_jobs_running", "Computations that are running.",
               static_cast<double>(pool.running()));
  writer.counter("fracture_jobs_escaped_total", "Computations that ended with an exception, which is a bug.",
                 static_cast<double>(pool.escaped()));
  writer.gauge("fracture_compute_threads", "Computing threads.", pool.threads());
  constexpr std::pair<Priority, const char*> kClasses[] = {
      {Priority::kRealtime, "realtime"}, {Priority::kBatch, "batch"}, {Priority::kBackground, "background"}};
  for (const auto& [priority, name] : kClasses)
    writer.gauge(
        "fracture_predicted_wait_seconds",
        "Predicted queue time of a new computation, by priority class. The prediction is for the client that "
        "has used the most processor time, because that client waits longest.",
        pool.backlog(priority).count(), {{"class", name}});

  const Dispatcher::Figures work = dispatcher_.figures();
  const auto count = [&writer](const char* name, const char* help, std::uint64_t value) {
    writer.counter(name, help, static_cast<double>(value));
  };
  count("fracture_results_computed_total", "Results whose computation was completed.", work.computed);
  count("fracture_requests_collapsed_total", "Requests that waited for another request's computation.",
        work.collapsed);
  count("fracture_waiters_left_total",
        "Requests that ended before their result was ready: closed, cancelled or past their deadline.",
        work.abandoned);
  count("fracture_jobs_expired_total", "Computations whose deadline had passed when their turn came.",
        work.expired);
  count("fracture_requests_not_admitted_total", "Requests refused at once for lack of time or memory.",
        work.refused);
  writer.gauge("fracture_flights", "Results that are being computed or are waiting for a thread.",
               static_cast<double>(work.flights));

  const auto cache = [&writer](const char* name, const CacheFigures& figures, std::size_t budget) {
    const ops::MetricWriter::Labels labels = {{"cache", name}, {"tier", "memory"}};
    writer.gauge("fracture_cache_bytes", "Bytes held by each cache.", static_cast<double>(figures.bytes),
                 labels);
    writer.gauge("fracture_cache_limit_bytes", "Bytes that each cache may hold.", static_cast<double>(budget),
                 labels);
    writer.gauge("fracture_cache_entries", "Entries of each cache.", static_cast<double>(figures.entries),
                 labels);
    writer.counter("fracture_cache_evictions_total", "Entries deleted to make room for others.",
                   static_cast<double>(figures.evictions), labels);
  };
  const FractureService::Figures caches = service_.figures();
  count("fracture_unsound_total", "Answers that failed their check and were not sent.", caches.unsound);
  const ServiceConfig& config = service_.config();
  cache("mesh", caches.meshes, config.mesh_cache_bytes);
  cache("diagram", caches.diagrams, config.diagram_cache_bytes);
  cache("result", caches.results, config.result_cache_bytes);

  const StoreFigures store = meshes_.figures();
  writer.gauge("fracture_stored_meshes", "Meshes in the store.", static_cast<double>(store.meshes));
  count("fracture_meshes_stored_total", "Meshes that clients have stored, including deleted ones.",
        store.stored);
  count("fracture_meshes_expired_total",
        "Stored meshes deleted because they were not used within --mesh-ttl.", store.expired);
  count("fracture_meshes_evicted_total", "Stored meshes deleted to make room for others.", store.evicted);

  const JobFigures jobs = jobs_.figures();
  writer.gauge("fracture_jobs", "Jobs, including finished ones.", static_cast<double>(jobs.jobs));
  writer.gauge("fracture_jobs_unfinished", "Jobs waiting or running.", static_cast<double>(jobs.unfinished));
  count("fracture_jobs_started_total", "Jobs started by requests with Prefer: respond-async.", jobs.started);
  count("fracture_jobs_forgotten_total", "Finished jobs deleted after --job-ttl.", jobs.expired);
  count("fracture_jobs_resumed_total", "Jobs that continued after a restart.", jobs.resumed);
  if (const auto disk = jobs_.disk_figures()) {
    writer.gauge("fracture_jobs_durable", "Jobs on disk, including finished ones.",
                 static_cast<double>(disk->jobs));
    writer.gauge("fracture_job_store_bytes", "Bytes of jobs on disk.", static_cast<double>(disk->bytes));
    count("fracture_job_store_failures_total", "Job files that could not be read or written.",
          disk->failures);
    count("fracture_job_store_damaged_total", "Damaged job files that were set aside.", disk->quarantined);
  }
  count("fracture_jobs_evicted_total", "Finished jobs deleted to make room for others.", jobs.evicted);
  count(
      "fracture_job_results_evicted_total",
      "Results of finished jobs deleted to make room for others (--job-results). The jobs themselves are kept.",
      jobs.results_evicted);

  const TiersFigures tiers = service_.tiers().figures();
  const auto up = [&](const char* tier, bool is_up) {
    writer.gauge(
        "fracture_cache_tier_up",
        "1 if this cache tier (the folder or Redis) can be used; 0 if the folder cannot be used or another server is using it, or "
        "if Redis does not answer.",
        is_up, {{"cache", "result"}, {"tier", tier}});
  };
  if (tiers.disk || tiers.disk_unusable)
    up("disk", !tiers.disk_unusable && !service_.tiers().waits_for_folder());
  if (tiers.redis) up("redis", !tiers.redis->open);
  if (tiers.disk) {
    const ops::MetricWriter::Labels labels = {{"cache", "result"}, {"tier", "disk"}};
    writer.gauge("fracture_cache_bytes", "Bytes held by each cache.", static_cast<double>(tiers.disk->bytes),
                 labels);
    writer.gauge("fracture_cache_entries", "Entries of each cache.", static_cast<double>(tiers.disk->entries),
                 labels);
    writer.counter("fracture_cache_evictions_total", "Entries deleted to make room for others.",
                   static_cast<double>(tiers.disk->evictions), labels);
    writer.counter("fracture_cache_damaged_total", "Damaged entries that were set aside.",
                   static_cast<double>(tiers.disk->quarantined), labels);
    writer.counter("fracture_cache_failures_total", "Reads and writes that failed.",
                   static_cast<double>(tiers.disk->failures), labels);
  }
  if (tiers.redis) {
    const ops::MetricWriter::Labels labels = {{"cache", "result"}, {"tier", "redis"}};
    writer.counter("fracture_cache_damaged_total", "Damaged entries that were set aside.",
                   static_cast<double>(tiers.redis->damaged), labels);
    writer.counter("fracture_cache_failures_total", "Reads and writes that failed.",
                   static_cast<double>(tiers.redis->failures), labels);
    writer.counter("fracture_cache_skipped_total",
                   "Requests that did not use Redis because it had not answered earlier requests.",
                   static_cast<double>(tiers.redis->skipped), labels);
  }
  count(
      "fracture_results_unwritten_total",
      "Results that were not written to the folder or to Redis because too many were waiting or memory was short.",
      tiers.dropped);
}

}  // namespace fracture::http
