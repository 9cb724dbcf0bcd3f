#include "server/cli/memory_metrics.hpp"

#include <unistd.h>

#include <fstream>
#include <map>
#include <string>

#include "server/cli/memory_plan.hpp"

namespace fracture::cli {

std::uint64_t resident_bytes(pid_t process) {
  std::ifstream statm("/proc/" + std::to_string(process) + "/statm");
  std::uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void write_memory_metrics(const ServeOptions& options, http::Api& api, Dispatcher& dispatcher,
                          const ImportPool& imports, std::size_t connections, ops::MetricWriter& writer) {
  const FractureService::Figures caches = dispatcher.service().figures();
  const MemoryBudget& bodies = api.bodies().whole();
  const std::map<std::string, std::uint64_t> reserved = {
      {"connections", connections * http::kConnectionBytes},
      {"bodies", bodies.used() - bodies.small_used()},
      {"small_bodies", bodies.small_used()},
      {"answers", api.answers().used()},
      {"working", dispatcher.working().used()},
      {"mesh_cache", caches.meshes.bytes},
      {"diagram_cache", caches.diagrams.bytes},
      {"result_cache", caches.results.bytes},
      {"mesh_store", api.meshes().figures().bytes},
      {"job_results", api.jobs().figures().result_bytes},
      {"answer_ledger", api.ledger().held_bytes()}};
  writer.gauge(
      "fracture_memory_limit_bytes",
      "Limit on this server's resident memory: --memory, or the limit of its control group or machine.",
      static_cast<double>(options.memory));
  writer.gauge("fracture_memory_base_bytes", "Part of the limit that is reserved for an idle server.",
               static_cast<double>(base_memory(options)));
  for (const MemoryShare& share : memory_shares(options)) {
    const ops::MetricWriter::Labels labels = {{"part", share.part}};
    writer.gauge("fracture_memory_budget_bytes", "Maximum number of bytes in each part of the memory.",
                 static_cast<double>(share.bytes), labels);
    writer.gauge("fracture_memory_reserved_bytes",
                 "Bytes in each part of the memory, as counted by the server.",
                 static_cast<double>(reserved.at(share.part)), labels);
  }
  std::uint64_t workers = 0;
  // Workers share unmodified pages with the zygote that they were forked from. These pages, at most 11 MiB,
  // are counted twice.
  for (const pid_t worker : imports.pids()) workers += resident_bytes(worker);
  if (const pid_t zygote = imports.zygote_pid(); zygote > 0) workers += resident_bytes(zygote);
  writer.gauge("fracture_memory_resident_bytes", "Resident memory by process, as the system reports it.",
               static_cast<double>(resident_bytes(::getpid())), {{"process", "server"}});
  writer.gauge("fracture_memory_resident_bytes", "Resident memory by process, as the system reports it.",
               static_cast<double>(workers), {{"process", "import"}});
}

}  // namespace fracture::cli
