#include "common/base/spawn.hpp"

#include <signal.h>
#include <sys/wait.h>

#include <cerrno>

extern char** environ;  // POSIX: the environment of this process

namespace fracture {
namespace {

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

}  // namespace

Spawn::Spawn() {
  ::posix_spawn_file_actions_init(&actions_);
  ::posix_spawnattr_init(&attributes_);
}

Spawn::~Spawn() {
  ::posix_spawn_file_actions_destroy(&actions_);
  ::posix_spawnattr_destroy(&attributes_);
}

void Spawn::add_flags(int more) {
  flags_ = static_cast<short>(flags_ | more);
  ::posix_spawnattr_setflags(&attributes_, flags_);
}

void Spawn::give(int ours, int theirs) { ::posix_spawn_file_actions_adddup2(&actions_, ours, theirs); }

void Spawn::open(int theirs, const char* path, int flags) {
  ::posix_spawn_file_actions_addopen(&actions_, theirs, path, flags, 0);
}

void Spawn::close_from(int first) { ::posix_spawn_file_actions_addclosefrom_np(&actions_, first); }

void Spawn::lead_group() {
  ::posix_spawnattr_setpgroup(&attributes_, 0);
  add_flags(POSIX_SPAWN_SETPGROUP);
}

void Spawn::lead_session() { add_flags(POSIX_SPAWN_SETSID); }

void Spawn::reset_signals() {
  sigset_t none, all;
  ::sigemptyset(&none);
  ::sigfillset(&all);
  ::posix_spawnattr_setsigmask(&attributes_, &none);
  ::posix_spawnattr_setsigdefault(&attributes_, &all);
  add_flags(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
}

int Spawn::start(const std::string& program, std::vector<std::string> arguments,
                 const std::vector<std::string>* variables, pid_t& child) const {
  std::vector<std::string> given = variables ? *variables : std::vector<std::string>();
  std::vector<char*> list = pointers(given);
  char** const environment = variables ? list.data() : environ;
  const auto spawn = program.find('/') == std::string::npos ? &::posix_spawnp : &::posix_spawn;
  return spawn(&child, program.c_str(), &actions_, &attributes_, pointers(arguments).data(), environment);
}

void wait_for_end(pid_t child) {
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace fracture
