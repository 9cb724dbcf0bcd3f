// The kernel's numbers for another process: its memory and that of its children, and its processor time.
#pragma once

#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace fracture::test {

/// Resident bytes; 0 if it has ended. Memory that two processes share is counted in both.
inline std::uint64_t resident_bytes(const std::string& pid) {
  std::ifstream statm("/proc/" + pid + "/statm");
  std::uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

inline std::vector<std::string> children_of(const std::string& pid) {
  std::vector<std::string> all;
  std::error_code gone;
  for (std::filesystem::directory_iterator task("/proc/" + pid + "/task", gone), end; !gone && task != end;
       task.increment(gone)) {
    std::ifstream children(task->path() / "children");
    for (std::string child; children >> child;) all.push_back(child);
  }
  return all;
}

/// Resident bytes of the process and all its descendants.
inline std::uint64_t resident_bytes_with_children(const std::string& pid) {
  std::uint64_t sum = resident_bytes(pid);
  for (const std::string& child : children_of(pid)) sum += resident_bytes_with_children(child);
  return sum;
}

/// Processor seconds of all its threads, independent of other processes on the machine; 0 if it has ended.
inline double processor_seconds(pid_t pid) {
  clockid_t clock{};
  timespec time{};
  if (::clock_getcpuclockid(pid, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Processor seconds of all processes on this machine since it was started, without waiting time.
inline double processor_seconds_of_the_machine() {
  std::ifstream stat("/proc/stat");
  std::string cpu;
  double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, irq = 0, softirq = 0, stolen = 0;
  stat >> cpu >> user >> nice >> system >> idle >> waiting >> irq >> softirq >> stolen;
  return (user + nice + system + irq + softirq + stolen) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

/// The peak of the resident memory of a process and its children, sampled every few milliseconds.
class ResidentPeak {
 public:
  explicit ResidentPeak(pid_t pid)
      : thread_([this, root = std::to_string(pid)] {
          while (!stop_) {
            const std::uint64_t now = resident_bytes_with_children(root);
            if (now > peak_) peak_ = now;
            // pause: the sampling interval
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
          }
        }) {}
  ~ResidentPeak() {
    stop_ = true;
    thread_.join();
  }
  ResidentPeak(const ResidentPeak&) = delete;
  ResidentPeak& operator=(const ResidentPeak&) = delete;
  std::uint64_t bytes() const { return peak_; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> peak_{0};
  std::thread thread_;
};

}  // namespace fracture::test
