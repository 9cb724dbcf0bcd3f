#include "server/bake/renderer_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/json_reader.hpp"
#include "common/base/spawn.hpp"

extern char** environ;

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr const char* kRenderer = "fracture-render";
/// An answer is one line with a few names. A program that writes more is not our renderer.
constexpr std::size_t kMaxAnswerBytes = 64u << 10;
/// The end of standard error is kept, because a driver explains there why it fails.
constexpr std::size_t kMaxComplaintBytes = 400;
/// Interval at which waits check for a stop.
constexpr std::chrono::milliseconds kLook{20};
/// A child that closed its end of the socket is about to exit. If it does not within this time, it is killed.
constexpr std::chrono::milliseconds kGrace{1000};

bool is_program(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
}

std::string folder_of_this_program() {
  char path[PATH_MAX];
  const ssize_t length = ::readlink("/proc/self/exe", path, sizeof path);
  return fs::path(std::string(path, static_cast<std::size_t>(std::max<ssize_t>(length, 0)))).parent_path();
}

/// Returns the environment without our own variables, because FRACTURE_TOKEN must stay secret. LP_NUM_THREADS
/// limits llvmpipe, which otherwise starts one thread per core in each process.
std::vector<std::string> environment(int threads) {
  std::vector<std::string> kept;
  for (char** at = environ; *at; ++at)
    if (const std::string_view variable = *at;
        !variable.starts_with("FRACTURE_") && (threads == 0 || !variable.starts_with("LP_NUM_THREADS=")))
      kept.emplace_back(variable);
  if (threads > 0) kept.push_back("LP_NUM_THREADS=" + std::to_string(threads));
  return kept;
}

}  // namespace

Expected<std::string> find_renderer(const std::string& named) {
  if (!named.empty()) {
    if (is_program(named)) return fs::absolute(named).string();
    return fail(ErrorCode::kNoProgram, "--renderer '" + named + "' is not an executable program.");
  }
  const fs::path here = folder_of_this_program();
  std::vector<fs::path> places{here / kRenderer, here / "../client/cli" / kRenderer};
  if (const char* path = std::getenv("PATH")) {
    std::istringstream folders(path);
    for (std::string folder; std::getline(folders, folder, ':');)
      if (folder.starts_with('/')) places.push_back(fs::path(folder) / kRenderer);
  }
  for (const fs::path& place : places)
    if (is_program(place)) return place.lexically_normal().string();
  return fail(ErrorCode::kNoProgram,
              "fracture-render was not found next to this program or in PATH: build the client "
              "(scripts/install-deps client), or give the path of fracture-render with --renderer.");
}

Expected<RendererProcess> RendererProcess::start(const std::string& program, int threads) {
  RendererProcess process;
  int talk[2], complaints[2];
  const auto failed = [&](int reason) {
    return fail(ErrorCode::kNoProgram, program + " cannot be started: " + std::strerror(reason) + ".");
  };
  // A socket instead of a pipe, so that sending to a dead process can fail without a signal.
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, talk) != 0) return failed(errno);
  process.talk_ = Descriptor(talk[0]);
  const Descriptor its_talk(talk[1]);
  if (::pipe2(complaints, O_CLOEXEC) != 0) return failed(errno);
  process.complaints_ = Descriptor(complaints[0]);
  const Descriptor its_complaints(complaints[1]);
  ::fcntl(process.complaints_.get(), F_SETFL, O_NONBLOCK);

  Spawn spawn;
  spawn.give(its_talk.get(), STDIN_FILENO);
  spawn.give(its_talk.get(), STDOUT_FILENO);
  spawn.give(its_complaints.get(), STDERR_FILENO);
  spawn.reset_signals();
  spawn.lead_group();
  const std::vector<std::string> variables = environment(threads);
  pid_t pid = 0;
  if (const int reason = spawn.start(program, {program, "--list", "--quiet"}, &variables, pid); reason != 0)
    return failed(reason);
  process.pid_ = pid;
  return process;
}

RendererProcess::RendererProcess(RendererProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)),
      talk_(std::move(other.talk_)),
      complaints_(std::move(other.complaints_)),
      heard_(std::move(other.heard_)),
      complaint_(std::move(other.complaint_)) {}

RendererProcess::~RendererProcess() { kill(); }

void RendererProcess::kill() {
  if (pid_ <= 0) return;
  ::kill(-pid_, SIGKILL);
  wait_for_end(pid_);
  pid_ = 0;
  talk_.reset();
}

void RendererProcess::listen_to_complaints() {
  char text[512];
  for (ssize_t n = 0; (n = ::read(complaints_.get(), text, sizeof text)) > 0;) {
    complaint_.append(text, static_cast<std::size_t>(n));
    if (complaint_.size() > kMaxComplaintBytes) complaint_.erase(0, complaint_.size() - kMaxComplaintBytes);
  }
}

std::string RendererProcess::last_words() {
  int status = 0;
  pid_t reaped = 0;
  const auto until = Clock::now() + kGrace;
  while ((reaped = ::waitpid(pid_, &status, WNOHANG)) == 0 && Clock::now() < until) ::usleep(2000);
  std::string words = "closed its connection";
  if (reaped == pid_) {
    ::kill(-pid_, SIGKILL);  // kills the remaining processes of its group
    pid_ = 0;
    talk_.reset();
    words = WIFSIGNALED(status) ? "ended by signal " + std::to_string(WTERMSIG(status)) + " (" +
                                      ::strsignal(WTERMSIG(status)) + ")"
                                : "ended with exit code " + std::to_string(WEXITSTATUS(status));
  }
  return words;
}

Error RendererProcess::died(const std::string& how) {
  const std::string end = how.empty() ? last_words() : how;
  listen_to_complaints();
  kill();
  std::string said;
  for (const char c : complaint_)
    said += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;  // keeps the message on one line
  while (!said.empty() && said.back() == ' ') said.pop_back();
  return {ErrorCode::kNoProgram, "The renderer " + end + (said.empty() ? "." : ": " + said)};
}

Expected<void> RendererProcess::draw(const nlohmann::json& line, std::chrono::milliseconds limit,
                                     const std::stop_token& stop) {
  const auto until = Clock::now() + limit;
  std::string rest = line.dump() + "\n";
  for (std::size_t end = std::string::npos; (end = heard_.find('\n')) == std::string::npos;) {
    if (stop.stop_requested()) {
      kill();
      return fail(ErrorCode::kCancelled, "Stopped.");
    }
    const auto now = Clock::now();
    if (now >= until)
      return tl::unexpected(died("did not answer within " +
                                 std::to_string(std::chrono::ceil<std::chrono::seconds>(limit).count()) +
                                 " s"));
    const auto pause =
        std::min<std::chrono::milliseconds>(kLook, std::chrono::ceil<std::chrono::milliseconds>(until - now));
    pollfd waits[] = {{talk_.get(), static_cast<short>(rest.empty() ? POLLIN : POLLIN | POLLOUT), 0},
                      {complaints_.get(), POLLIN, 0}};
    if (::poll(waits, 2, static_cast<int>(pause.count())) <= 0) continue;
    if (waits[1].revents & POLLIN) listen_to_complaints();
    if (waits[0].revents & POLLOUT) {
      const ssize_t sent = ::send(talk_.get(), rest.data(), rest.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) rest.erase(0, static_cast<std::size_t>(sent));
      if (sent < 0 && errno != EAGAIN && errno != EINTR) return tl::unexpected(died({}));
    }
    if (waits[0].revents & (POLLIN | POLLHUP | POLLERR)) {
      char text[4096];
      const ssize_t got = ::recv(talk_.get(), text, sizeof text, MSG_DONTWAIT);
      if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return tl::unexpected(died({}));
      if (got > 0) heard_.append(text, static_cast<std::size_t>(got));
      if (heard_.size() > kMaxAnswerBytes)
        return tl::unexpected(died("does not answer like fracture-render"));
    }
  }
  const std::string text = heard_.substr(0, heard_.find('\n'));
  heard_.erase(0, text.size() + 1);
  const nlohmann::json answer = json_or_null(text);
  if (!answer.is_object() || !answer.contains("output"))
    return tl::unexpected(died("does not answer like fracture-render"));
  const auto problem = answer.find("problem");
  if (problem == answer.end()) return {};
  const std::string detail = problem->is_object() ? problem->value("detail", "") : std::string();
  return fail(ErrorCode::kBadImage, detail.empty() ? "The renderer gave no reason." : detail);
}

}  // namespace fracture::bake
