// argil-reader-cad many times: OpenCASCADE is loaded once, and each file is read by a fork of that, under the reader's
// own limits and confinement. What a test starts in place of the reader is the small program beside, reader_fork.
//   reader_forks SOCKET

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <IGESControl_Controller.hxx>
#include <STEPControl_Controller.hxx>
#include <XCAFApp_Application.hxx>
#include <array>
#include <csignal>
#include <cstring>
#include <string>
#include <vector>

#include "io/cad_reader/read_cad.h"
#include "io/reader/run.h"
#include "tests/support/reader_fork.h"

namespace {

using namespace argil::io::reader;
constexpr std::array<Reads, 1> kTable{{{"cad", [](const auto& file, int, Sender& sender) { readCad(file, sender); }}}};

// The reader itself; does not return.
void read(std::vector<std::string>& words, const int (&streams)[3]) {
  for (int i = 0; i < 3; ++i) ::dup2(streams[i], i);
  ::closefrom(3);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  run(int(words.size()), argv.data(), kTable);
}

// Reads for one asker, and dies with it.
void serve(int asker) {
  std::vector<std::string> words;
  int streams[3];
  if (!argil::tests::receiveCall(asker, words, streams)) return;
  const pid_t child = ::fork();
  if (child == 0) read(words, streams);
  const int fd = int(::syscall(SYS_pidfd_open, child, 0));
  pollfd waits[2] = {{fd, POLLIN, 0}, {asker, POLLIN, 0}};
  (void)::poll(waits, 2, -1);
  if (waits[0].revents == 0) ::kill(child, SIGKILL);
  int status = 0;
  (void)::waitpid(child, &status, 0);
  (void)!::write(asker, &status, sizeof status);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
  (void)std::signal(SIGCHLD, SIG_IGN);
  const int server = argil::tests::forkSocket(argv[1], true);
  if (server < 0) return 2;
  STEPControl_Controller::Init();
  IGESControl_Controller::Init();
  (void)XCAFApp_Application::GetApplication();
  for (;;) {
    const int asker = ::accept4(server, nullptr, nullptr, SOCK_CLOEXEC);
    if (asker < 0) continue;
    if (::fork() == 0) {
      (void)std::signal(SIGCHLD, SIG_DFL);
      ::close(server);
      serve(asker);
      ::_exit(0);
    }
    ::close(asker);
  }
}
