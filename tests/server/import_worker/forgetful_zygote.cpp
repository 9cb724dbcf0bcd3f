// A zygote that forks a worker as the real one does, and dies before it reports the worker.
#include <sched.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "server/import_worker/protocol.hpp"

int main() {
  using namespace fracture;
  const ZygoteHello hello;
  if (!send_message(kWorkerSocket, &hello, sizeof hello)) return 2;
  ForkRequest request;
  const Received received = receive_message(kWorkerSocket, &request, sizeof request);
  if (!received.whole) return 2;
  if (::syscall(SYS_clone, CLONE_PARENT, 0, 0, 0, 0) == 0)
    for (;;) ::pause();
  ::kill(::getpid(), SIGKILL);
}
