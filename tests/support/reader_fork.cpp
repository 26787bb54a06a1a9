// Stands in for argil-reader-cad: lets a fork of reader_forks read, and ends as that ended.
//   reader_fork cad FILE [MEMORY-BYTES SECONDS]

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>

#include "tests/support/reader_fork.h"

int main(int argc, char** argv) {
  (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int socket = argil::tests::forkSocket(argil::tests::forkName(::getppid()).c_str(), false);
  int status = 0;
  if (socket < 0 || !argil::tests::sendCall(socket, argc, argv)) return 3;
  // Who reads must see the end of the fork's output, not of this one's.
  ::close(1);
  if (::read(socket, &status, sizeof status) != sizeof status) return 3;
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  const rlimit none{0, 0};
  (void)::setrlimit(RLIMIT_CORE, &none);
  (void)std::signal(WTERMSIG(status), SIG_DFL);
  (void)::raise(WTERMSIG(status));
  return 3;
}
