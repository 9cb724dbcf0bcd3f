// fracture-server bake: the service without HTTP, for artists and farms.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>

#include "server/cli/import_workers.hpp"
#include "server/cli/input_file.hpp"
#include "server/cli/options.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture::cli {
namespace {

std::atomic<bool> interrupted{false};
void on_interrupt(int) { interrupted = true; }

/// Whole or not at all: a temporary file beside the target, flushed to the disk, then renamed over it.
bool write_file(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  const std::string temporary = path + ".tmp." + std::to_string(::getpid());
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) return false;
  std::size_t written = 0;
  bool good = true;
  while (good && written < bytes.size()) {
    const ssize_t n = ::write(fd, bytes.data() + written, bytes.size() - written);
    if (n < 0 && errno == EINTR) continue;
    good = n > 0;
    if (good) written += static_cast<std::size_t>(n);
  }
  good = good && ::fsync(fd) == 0;
  good = ::close(fd) == 0 && good;
  good = good && std::rename(temporary.c_str(), path.c_str()) == 0;
  if (!good) {
    const int reason = errno;
    ::unlink(temporary.c_str());
    errno = reason;
  }
  return good;
}

/// A bar that redraws itself on a terminal; one line for each stage elsewhere. Called from any thread.
class Progress {
 public:
  explicit Progress(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

  void show(const char* stage, double fraction) {
    if (quiet_) return;
    const std::lock_guard lock(mutex_);
    const int percent = static_cast<int>(100 * std::min(1.0, std::max(0.0, fraction)));
    const bool new_stage = stage_ != stage;
    if (!new_stage && percent == percent_) return;
    stage_ = stage;
    percent_ = percent;
    if (terminal_) {
      constexpr int kWidth = 40;
      const int full = percent * kWidth / 100;
      std::fprintf(stderr, "\r%-16s [%s%s] %3d%%", stage,
                   std::string(static_cast<std::size_t>(full), '#').c_str(),
                   std::string(static_cast<std::size_t>(kWidth - full), '.').c_str(), percent);
      std::fflush(stderr);
      drawn_ = true;
    } else if (seen_.insert(stage).second) {
      std::fprintf(stderr, "%s\n", stage);
    }
  }
  /// Removes the bar, so that what is printed next begins on an empty line.
  void finish() {
    const std::lock_guard lock(mutex_);
    if (drawn_) std::fprintf(stderr, "\r\033[K");
    drawn_ = false;
  }

 private:
  const bool quiet_, terminal_;
  std::mutex mutex_;
  std::string stage_;
  std::set<std::string> seen_;
  int percent_ = -1;
  bool drawn_ = false;
};

int refuse(const Error& error) {
  std::fprintf(stderr, "fracture-server bake: %s: %s\n  %s\n", slug(error.code), title(error.code),
               error.detail.c_str());
  if (error.extra.contains("errors") && error.extra["errors"].size() > 1)
    for (std::size_t i = 1; i < error.extra["errors"].size(); ++i)
      std::fprintf(stderr, "  %s\n", error.extra["errors"][i].value("detail", "").c_str());
  return error.code == ErrorCode::kCancelled ? kExitInterrupted : kExitRefused;
}

}  // namespace

int bake(const BakeOptions& options) {
  FractureService service(options.service, make_engine(one_import_worker()));
  Expected<RequestParameters> parameters = service.parse(options.parameters);
  if (!parameters) return refuse(parameters.error());
  const Expected<MeshFormat> format = format_of_input(options.input, *parameters);
  if (!format) return refuse(format.error());
  const std::optional<InputFile> input = read_input(options.input, *format);
  if (!input) {
    std::fprintf(stderr, "fracture-server bake: cannot read %s: %s\n", options.input.c_str(),
                 std::strerror(errno));
    return kExitSystem;
  }

  Progress progress(options.quiet);
  std::stop_source stop;
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A signal handler may not touch a stop_source: a watcher carries the message.
  std::jthread watcher([&stop](std::stop_token end) {
    while (!end.stop_requested()) {
      if (interrupted) stop.request_stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  Execution execution;
  execution.threads = options.threads > 0 ? options.threads : available_cores();
  execution.stop = stop.get_token();
  execution.progress = [&progress](const char* stage, double fraction) { progress.show(stage, fraction); };

  const bool gltf =
      format_from_extension(options.output.substr(options.output.rfind('.') + 1)) == MeshFormat::kGltf;
  const OutputFormat output = gltf ? OutputFormat::kGltf : OutputFormat::kGlb;
  const auto start = std::chrono::steady_clock::now();
  const Expected<FractureAnswer> answer = service.fracture(
      {input->view(), *format, *parameters, as_import_files(input->siblings), output}, execution);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  progress.finish();
  if (!answer) return refuse(answer.error());
  if (!write_file(options.output, answer->result->file)) {
    std::fprintf(stderr, "fracture-server bake: cannot write %s: %s\n", options.output.c_str(),
                 std::strerror(errno));
    return kExitSystem;
  }
  if (!options.quiet) {
    const Certificate& c = answer->certificate;
    std::printf("%s: %u fragments, volume in %.9g m3, out %.9g m3, relative error %.2g, %" PRIu64
                " open edges, %zu bytes, %.3f s (",
                options.output.c_str(), c.fragments, c.volume_in, c.volume_out, c.relative_error,
                c.open_edges, answer->result->file.size(), took.count());
    const char* separator = "";
    for (const auto& [stage, ms] : answer->timings.stages()) {
      std::printf("%s%s %.1f ms", separator, stage.c_str(), ms);
      separator = ", ";
    }
    std::printf(")\n");
  }
  return kExitDone;
}

}  // namespace fracture::cli
