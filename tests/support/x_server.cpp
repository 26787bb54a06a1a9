#include "tests/support/x_server.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace argil::support {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kPatience = 30s;  // a machine that is busy with other tests
constexpr int kTries = 3;        // two servers that start at once may want the same number

std::string programPath(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string file = folder + "/" + name;
    if (access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

/// Starts a program that ends when this process does. `keep`: a file descriptor that it inherits under its number, or
/// -1.
pid_t start(const std::vector<std::string>& command, int keep) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) throw std::runtime_error("cannot start " + command[0]);
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);
    setpgid(0, 0);  // a Ctrl-C for the tests is not for the server: it would die under open windows
    const int nowhere = open("/dev/null", O_RDWR);
    for (int standard = 0; standard < 3; ++standard) dup2(nowhere, standard);
    if (keep >= 0) fcntl(keep, F_SETFD, 0);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  return child;
}

bool running(pid_t child) {
  return waitpid(child, nullptr, WNOHANG) == 0;
}

void end(pid_t& child) noexcept {
  if (child < 0) return;
  kill(child, SIGTERM);
  const auto latest = steady_clock::now() + 3s;
  while (running(child)) {
    if (steady_clock::now() > latest) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
      break;
    }
    std::this_thread::sleep_for(2ms);
  }
  child = -1;
}

/// A window manager says that it is there by a property of the root window.
bool hasManager(Display* display) {
  const Atom name = XInternAtom(display, "_NET_SUPPORTING_WM_CHECK", False);
  Atom type = None;
  int format = 0;
  unsigned long count = 0, left = 0;
  unsigned char* data = nullptr;
  XGetWindowProperty(display, DefaultRootWindow(display), name, 0, 1, False, XA_WINDOW, &type, &format, &count, &left,
                     &data);
  if (data) XFree(data);
  return count == 1;
}

/// Shows a small window and waits until a manager has given it a frame. A manager that has just come up misses the
/// first ones.
bool managesWindows(Display* display) {
  const Window root = DefaultRootWindow(display);
  const Window window = XCreateSimpleWindow(display, root, 0, 0, 16, 16, 0, 0, 0);
  XSelectInput(display, window, StructureNotifyMask | VisibilityChangeMask);
  XMapWindow(display, window);
  XFlush(display);
  bool framed = false, seen = false;
  const auto latest = steady_clock::now() + 250ms;
  while (!(framed && seen) && steady_clock::now() < latest) {
    XEvent event;
    while (XPending(display) > 0) {
      XNextEvent(display, &event);
      framed = framed || (event.type == ReparentNotify && event.xreparent.parent != root);
      seen = seen || event.type == VisibilityNotify;
    }
    std::this_thread::sleep_for(2ms);
  }
  XDestroyWindow(display, window);
  XSync(display, True);
  return framed && seen;
}

}  // namespace

std::string XServer::missing(const Options& options) {
  if (programPath("Xvfb").empty()) return "Xvfb is not installed (Debian: xvfb): windows cannot be tested";
  if (options.windowManager && programPath("openbox").empty()) {
    return "openbox is not installed (Debian: openbox): windows that are managed cannot be tested";
  }
  return {};
}

XServer::XServer(const Options& options) {
  if (const std::string lack = missing(options); !lack.empty()) throw std::runtime_error(lack);
  if (const char* before = std::getenv("DISPLAY")) {
    hadDisplay_ = true;
    displayBefore_ = before;
  }
  try {
    for (int attempt = 1; display_.empty(); ++attempt) {
      startServer(options);
      if (display_.empty() && attempt == kTries) throw std::runtime_error("Xvfb does not start");
    }
    setenv("DISPLAY", display_.c_str(), 1);
    if (options.windowManager) startWindowManager();
  } catch (...) {
    stop();
    throw;
  }
}

XServer::~XServer() {
  stop();
}

void XServer::startServer(const Options& options) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe for Xvfb");
  const std::string screen = std::to_string(options.width) + "x" + std::to_string(options.height) + "x24";
  server_ = start({programPath("Xvfb"), "-displayfd", std::to_string(ends[1]), "-screen", "0", screen, "-nolisten",
                   "tcp", "-noreset"},
                  ends[1]);
  close(ends[1]);
  // It writes its number and a line's end when it is ready; the pipe closes when it fails.
  std::string number;
  const auto latest = steady_clock::now() + kPatience;
  while (number.empty() || number.back() != '\n') {
    pollfd wait{ends[0], POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(latest - steady_clock::now()).count();
    char letter = 0;
    if (left <= 0 || poll(&wait, 1, int(left)) <= 0 || read(ends[0], &letter, 1) != 1) break;
    number += letter;
  }
  close(ends[0]);
  if (!number.empty() && number.back() == '\n') {
    number.pop_back();
    display_ = ":" + number;
  } else {
    end(server_);
  }
}

void XServer::startWindowManager() {
  manager_ = start({programPath("openbox"), "--sm-disable", "--config-file", "/etc/xdg/openbox/rc.xml"}, -1);
  Display* display = XOpenDisplay(display_.c_str());
  if (!display) throw std::runtime_error("the X server does not answer");
  const auto latest = steady_clock::now() + kPatience;
  bool up = false;
  while (!(up = hasManager(display) && managesWindows(display)) && running(manager_) && steady_clock::now() < latest) {
    std::this_thread::sleep_for(5ms);
  }
  XCloseDisplay(display);
  if (!up) throw std::runtime_error("openbox does not start");
}

XServer::Pixels XServer::pixels(unsigned long window) const {
  Display* display = XOpenDisplay(display_.c_str());
  if (!display) throw std::runtime_error("the X server does not answer");
  // A window that goes or is hidden meanwhile is no reason to end the program, as Xlib thinks.
  const auto before = XSetErrorHandler([](Display*, XErrorEvent*) { return 0; });
  if (window == 0) window = DefaultRootWindow(display);
  Pixels result;
  XWindowAttributes about{};
  if (XGetWindowAttributes(display, window, &about) && about.map_state == IsViewable) {
    XImage* image = XGetImage(display, window, 0, 0, unsigned(about.width), unsigned(about.height), AllPlanes, ZPixmap);
    if (image) {
      result.width = about.width;
      result.height = about.height;
      result.rgba.reserve(4 * size_t(about.width) * size_t(about.height));
      for (int y = 0; y < about.height; ++y) {
        for (int x = 0; x < about.width; ++x) {
          const unsigned long p = XGetPixel(image, x, y);
          for (const unsigned shift : {16u, 8u, 0u}) result.rgba.push_back(uint8_t(p >> shift));
          result.rgba.push_back(255);
        }
      }
      XDestroyImage(image);
    }
  }
  XCloseDisplay(display);
  XSetErrorHandler(before);
  return result;
}

void XServer::stop() noexcept {
  end(manager_);
  end(server_);
  if (display_.empty()) return;
  if (hadDisplay_) {
    setenv("DISPLAY", displayBefore_.c_str(), 1);
  } else {
    unsetenv("DISPLAY");
  }
}

}  // namespace argil::support
