#include "common/base/spawn.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "common/base/descriptor.hpp"

namespace fracture {
namespace {

/// Runs a shell command with a pipe as its standard output. Returns its output, followed by its exit code.
std::string run(const std::string& command, const std::vector<std::string>* variables, bool reset = false) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return "no pipe";
  const Descriptor reads(ends[0]);
  Descriptor writes(ends[1]);
  Spawn spawn;
  spawn.give(writes.get(), STDOUT_FILENO);
  spawn.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  spawn.close_from(3);
  spawn.lead_group();
  if (reset) spawn.reset_signals();
  pid_t child = 0;
  if (const int error = spawn.start("sh", {"sh", "-c", command}, variables, child); error != 0)
    return "error " + std::to_string(error);
  writes.reset();
  std::string said;
  char bytes[256];
  for (ssize_t n = 0; (n = ::read(reads.get(), bytes, sizeof bytes)) != 0;)
    if (n > 0) said.append(bytes, static_cast<std::size_t>(n));
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return said + "exit " + std::to_string(WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

TEST(Spawn, GivesArgumentsDescriptorsAndVariables) {
  const std::vector<std::string> variables{"GREETING=hello you"};
  EXPECT_EQ(run("echo \"$GREETING\"; cat; exit 7", &variables), "hello you\nexit 7");
}

TEST(Spawn, InheritsTheEnvironmentIfNoneIsGiven) {
  ASSERT_EQ(::setenv("FRACTURE_SPAWN_TEST", "inherited", 1), 0);
  EXPECT_EQ(run("echo $FRACTURE_SPAWN_TEST", nullptr), "inherited\nexit 0");
  ::unsetenv("FRACTURE_SPAWN_TEST");
}

TEST(Spawn, ResetsIgnoredSignals) {
  struct sigaction ignore {
  }, before{};
  ignore.sa_handler = SIG_IGN;
  ASSERT_EQ(::sigaction(SIGTERM, &ignore, &before), 0);
  EXPECT_EQ(run("kill -TERM $$; echo survived", nullptr), "survived\nexit 0");
  EXPECT_EQ(run("kill -TERM $$; echo survived", nullptr, true), "exit -1") << "ended by the signal";
  ::sigaction(SIGTERM, &before, nullptr);
}

TEST(Spawn, ReturnsTheNumberOfTheError) {
  pid_t child = 0;
  EXPECT_EQ(Spawn().start("/nonexistent/program", {"program"}, nullptr, child), ENOENT);
  EXPECT_EQ(Spawn().start("/dev/null", {"null"}, nullptr, child), EACCES);
}

TEST(Spawn, AKilledChildIsWaitedFor) {
  Spawn spawn;
  spawn.lead_session();
  pid_t child = 0;
  ASSERT_EQ(spawn.start("sleep", {"sleep", "3600"}, nullptr, child), 0);
  EXPECT_EQ(::getsid(child), child);
  ::kill(child, SIGKILL);
  wait_for_end(child);
  EXPECT_EQ(::waitpid(child, nullptr, 0), -1);
  EXPECT_EQ(errno, ECHILD);
}

}  // namespace
}  // namespace fracture
