// Process metrics with the usual names of the Prometheus client libraries.
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"

namespace fracture::ops {
namespace {

const double kStart =
    std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

}  // namespace

void write_process_metrics(MetricWriter& writer) {
  if (std::ifstream statm("/proc/self/statm"); statm) {
    double virtual_pages = 0, resident_pages = 0;
    statm >> virtual_pages >> resident_pages;
    writer.gauge("process_resident_memory_bytes", "Resident memory.",
                 resident_pages * static_cast<double>(::sysconf(_SC_PAGESIZE)));
  }
  std::error_code ignored;
  double descriptors = 0;
  for (auto at = std::filesystem::directory_iterator("/proc/self/fd", ignored);
       at != std::filesystem::directory_iterator(); at.increment(ignored))
    ++descriptors;
  // At the descriptor limit, the folder itself cannot be opened, and the metric is left out.
  if (descriptors > 0) writer.gauge("process_open_fds", "Open file descriptors.", descriptors - 1);
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0)
    writer.gauge("process_max_fds", "Limit of open file descriptors.", static_cast<double>(limit.rlim_cur));
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) == 0)
    writer.counter("process_cpu_seconds_total", "CPU time, user and system.",
                   seconds(usage.ru_utime) + seconds(usage.ru_stime));
  writer.gauge("process_start_time_seconds", "Start of the process, Unix time.", kStart);
  writer.counter("fracture_log_lines_dropped_total",
                 "Log lines that were dropped because the log was not read fast enough.",
                 static_cast<double>(dropped_log_lines()));
}

}  // namespace fracture::ops
