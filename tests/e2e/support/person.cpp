#include "tests/e2e/support/person.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>
#include <X11/keysym.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stb_image.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

extern char** environ;

namespace argil::tests {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kPatience = 60;  // s: a software driver on a machine that does other things too
constexpr double kStill = 0.6;    // At scale 1; a picture of four times the pixels takes its time.
constexpr double kReady = 0.6;    // Without work it has done what it was asked.
constexpr double kLongest = 15;   // Some never rest.
constexpr double kKeyHeld = 0.03, kClickHeld = 0.15;
constexpr double kRest = 0.25;    // Of a processor: a studio whose threads all do less has nothing to do.
constexpr double kBlinking = 60;  // Pixels at scale 1: the cursor of a text field, which never rests.

void sleep(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}
double since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// By more than 8 in some channel; all of them in pictures of different size.
size_t changedPixels(const render::Image& a, const render::Image& b) {
  if (a.width != b.width || a.height != b.height) return b.rgba.size() / 4;
  size_t count = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    bool differs = false;
    for (size_t c = 0; c < 3; ++c) differs |= std::abs(int(a.rgba[i + c]) - int(b.rgba[i + c])) > 8;
    count += differs ? 1 : 0;
  }
  return count;
}

}  // namespace

RunningStudio::RunningStudio(const std::vector<std::string>& arguments, const fs::path& home) : err_(home / "said") {
  std::vector<std::string> words{ARGIL_COMMAND};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv, environment;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::string config = "XDG_CONFIG_HOME=" + home.string(), state = "ARGIL_STATE=" + (home / "state").string();
  for (char** e = environ; *e; ++e)
    if (std::string(*e).rfind("XDG_CONFIG_HOME=", 0) != 0 && std::string(*e).rfind("ARGIL_STATE=", 0) != 0)
      environment.push_back(*e);
  environment.push_back(config.data());
  environment.push_back(state.data());
  environment.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, home.c_str());  // Where exports go when nobody says where.
  posix_spawn_file_actions_addopen(&actions, 2, err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int failed = posix_spawn(&pid_, ARGIL_COMMAND, &actions, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (failed) throw std::runtime_error("cannot run " ARGIL_COMMAND);
}

RunningStudio::~RunningStudio() {
  if (!running()) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool RunningStudio::running() {
  if (ended_) return false;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
  ended_ = true;
  code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return false;
}

int RunningStudio::wait(double seconds) {
  const auto begin = Clock::now();
  while (running()) {
    if (since(begin) > seconds) return -1;
    sleep(0.02);
  }
  return code_;
}

std::string RunningStudio::said() const {
  return slurp(err_);
}

uint64_t RunningStudio::residentBytes() const {
  std::ifstream in("/proc/" + std::to_string(pid_) + "/statm");
  uint64_t total = 0, resident = 0;
  in >> total >> resident;
  return resident * uint64_t(sysconf(_SC_PAGESIZE));
}

double RunningStudio::cpuSeconds() const {
  const std::string stat = slurp("/proc/" + std::to_string(pid_) + "/stat");
  std::istringstream in(stat.substr(stat.rfind(')') + 1));
  std::string word;
  for (int i = 0; i < 11; ++i) in >> word;
  double user = 0, system = 0;
  in >> user >> system;
  return (user + system) / double(sysconf(_SC_CLK_TCK));
}

std::map<pid_t, double> RunningStudio::workSeconds() const {
  std::map<pid_t, double> work;
  std::error_code gone;  // Threads end while they are looked at.
  for (fs::directory_iterator task(fs::path("/proc") / std::to_string(pid_) / "task", gone), end; !gone && task != end;
       task.increment(gone)) {
    const std::string name = slurp(task->path() / "comm");
    if (name == "argil-servo\n" || name == "argil-watchdog\n" || name == "argil-device\n") continue;
    std::istringstream in(slurp(task->path() / "schedstat"));
    double ranNs = 0, waitedNs = 0;
    in >> ranNs >> waitedNs;
    const pid_t id = std::stoi(task->path().filename().string());
    const bool draws = id == pid_ || !name.starts_with("argil");  // the window's thread and those of its driver
    work[id] = 1e-9 * (ranNs + (draws ? waitedNs : 0));
  }
  return work;
}

struct Person::State {
  RunningStudio* studio = nullptr;
  Display* display = nullptr;
  Window window = 0;
  double scale = 1;

  Window find(Window at) const {
    XClassHint hint{};
    if (XGetClassHint(display, at, &hint)) {
      const bool ours = hint.res_class && std::string(hint.res_class) == "argil";
      XFree(hint.res_name);
      XFree(hint.res_class);
      XWindowAttributes a;
      if (ours && XGetWindowAttributes(display, at, &a) && a.map_state == IsViewable) return at;
    }
    Window root = 0, parent = 0, *children = nullptr, found = 0;
    unsigned count = 0;
    if (!XQueryTree(display, at, &root, &parent, &children, &count)) return 0;
    for (unsigned i = 0; i < count && !found; ++i) found = find(children[i]);
    if (children) XFree(children);
    return found;
  }
  [[nodiscard]] std::pair<int, int> origin() const {
    int x = 0, y = 0;
    Window child = 0;
    XTranslateCoordinates(display, window, DefaultRootWindow(display), 0, 0, &x, &y, &child);
    return {x, y};
  }
  void keyEvent(KeySym symbol, bool down) const {
    const KeyCode code = XKeysymToKeycode(display, symbol);
    if (!code) throw std::runtime_error("this keyboard has no such key: " + std::to_string(symbol));
    XTestFakeKeyEvent(display, code, down ? True : False, 0);
    XFlush(display);
  }
  void tell(Atom type, long a, long b) const {
    XEvent e{};
    e.xclient.type = ClientMessage;
    e.xclient.window = window;
    e.xclient.message_type = type;
    e.xclient.format = 32;
    e.xclient.data.l[0] = a;
    e.xclient.data.l[1] = b;
    XSendEvent(display, window, False, NoEventMask, &e);
    XFlush(display);
  }
};

namespace {

// The symbol of a key and whether it needs Shift. Names are Argil's or X's, in any case.
std::pair<KeySym, bool> symbolOf(const std::string& name) {
  static const std::map<std::string, KeySym> named{
      {"ctrl", XK_Control_L}, {"shift", XK_Shift_L},       {"alt", XK_Alt_L},      {"enter", XK_Return},
      {"space", XK_space},    {"backspace", XK_BackSpace}, {"pageup", XK_Page_Up}, {"pagedown", XK_Page_Down}};
  if (const auto found = named.find(name); found != named.end()) return {found->second, false};
  if (name.size() > 1) {
    std::string capital = name;
    capital[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    for (const std::string& ofX : {capital, name})  // "Right", "F4", "Escape"; "comma".
      if (const KeySym symbol = XStringToKeysym(ofX.c_str())) return {symbol, false};
  }
  if (name.size() != 1) throw std::runtime_error("no key is called " + name);
  const char c = name[0];
  // As an American keyboard has them, which is Xvfb's.
  static const std::string shifted = "~!@#$%^&*()_+{}|:\"<>?";
  return {KeySym(static_cast<unsigned char>(c)), (c >= 'A' && c <= 'Z') || shifted.find(c) != std::string::npos};
}

int quiet(Display*, XErrorEvent*) {
  return 0;
}

}  // namespace

Person::Person(RunningStudio& studio, double scale) : state_(std::make_unique<State>()) {
  XSetErrorHandler(quiet);  // Windows come and go while they are looked for.
  state_->studio = &studio;
  state_->scale = scale;
  state_->display = XOpenDisplay(nullptr);
  if (!state_->display) throw std::runtime_error("no display");
  // A busy machine may hold a key for longer than it was meant to be: Ctrl+Z once is not to be twice.
  XAutoRepeatOff(state_->display);
  const auto begin = Clock::now();
  while (!state_->window) {
    if (!studio.running()) throw std::runtime_error("the studio has ended: " + studio.said());
    if (since(begin) > kPatience) throw std::runtime_error("the studio shows no window: " + studio.said());
    state_->window = state_->find(DefaultRootWindow(state_->display));
    sleep(0.02);
  }
  (void)settled();
}

Person::~Person() {
  XCloseDisplay(state_->display);
}

void Person::move(double x, double y) {
  const auto [left, top] = state_->origin();
  XTestFakeMotionEvent(state_->display, -1, left + int(std::lround(x * state_->scale)),
                       top + int(std::lround(y * state_->scale)), 0);
  XFlush(state_->display);
}

void Person::press(int button) {
  XTestFakeButtonEvent(state_->display, unsigned(button), True, 0);
  XFlush(state_->display);
}

void Person::release(int button) {
  XTestFakeButtonEvent(state_->display, unsigned(button), False, 0);
  XFlush(state_->display);
}

void Person::click(double x, double y, int button) {
  move(x, y);
  sleep(kClickHeld);
  press(button);
  sleep(kClickHeld);  // longer than a frame of a software driver on a slow machine
  release(button);
  sleep(kKeyHeld);
}

void Person::drag(const std::vector<std::array<double, 2>>& points, double seconds, int button) {
  move(points.front()[0], points.front()[1]);
  sleep(0.1);
  press(button);
  sleep(0.05);
  const int steps = std::max(2, int(seconds * 120));  // A usual mouse
  for (int i = 1; i <= steps; ++i) {
    const double at = double(i) / steps * double(points.size() - 1);
    const size_t k = std::min(size_t(at), points.size() - 2);
    const double f = at - double(k);
    move(points[k][0] + f * (points[k + 1][0] - points[k][0]), points[k][1] + f * (points[k + 1][1] - points[k][1]));
    sleep(seconds / steps);
  }
  sleep(0.05);
  release(button);
  sleep(0.05);
}

void Person::wheel(int clicks) {
  for (int i = 0; i < std::abs(clicks); ++i) {
    press(clicks > 0 ? 4 : 5);
    release(clicks > 0 ? 4 : 5);
    sleep(kKeyHeld);
  }
}

void Person::keyDown(const std::string& key) {
  state_->keyEvent(symbolOf(key).first, true);
}
void Person::keyUp(const std::string& key) {
  state_->keyEvent(symbolOf(key).first, false);
}

void Person::key(const std::string& keys) {
  std::vector<std::string> words;
  std::string rest = keys;
  for (size_t plus; rest.size() > 1 && (plus = rest.find('+')) != std::string::npos && plus > 0;
       rest = rest.substr(plus + 1))
    words.push_back(rest.substr(0, plus));
  words.push_back(rest);
  for (const std::string& word : words) {
    keyDown(word);
    sleep(kKeyHeld);
  }
  for (auto word = words.rbegin(); word != words.rend(); ++word) {
    keyUp(*word);
    sleep(kKeyHeld);
  }
}

void Person::type(const std::string& text) {
  for (const char c : text) {
    const auto [symbol, shift] = symbolOf(c == ' ' ? "space" : std::string(1, c));
    if (shift) state_->keyEvent(XK_Shift_L, true);
    state_->keyEvent(symbol, true);
    sleep(0.01);
    state_->keyEvent(symbol, false);
    if (shift) state_->keyEvent(XK_Shift_L, false);
    sleep(0.01);
  }
}

void Person::resize(int width, int height) {
  XResizeWindow(state_->display, state_->window, unsigned(width), unsigned(height));
  XFlush(state_->display);
}

void Person::minimise() {
  XIconifyWindow(state_->display, state_->window, DefaultScreen(state_->display));
  XFlush(state_->display);
}

void Person::restore() {
  XMapWindow(state_->display, state_->window);
  XFlush(state_->display);
}

void Person::close() {
  state_->tell(XInternAtom(state_->display, "WM_PROTOCOLS", False),
               long(XInternAtom(state_->display, "WM_DELETE_WINDOW", False)), CurrentTime);
}

void Person::pause(double seconds) const {
  sleep(seconds);
}

render::Image Person::look() const {
  // From the root: what a person sees, also where something covers the window.
  XWindowAttributes a;
  render::Image image;
  if (!XGetWindowAttributes(state_->display, state_->window, &a))
    throw std::runtime_error("the window is gone: " + state_->studio->said());
  const auto [left, top] = state_->origin();
  const Screen* screen = DefaultScreenOfDisplay(state_->display);
  const int x = std::max(0, left), y = std::max(0, top);
  image.width = std::min(left + a.width, screen->width) - x;
  image.height = std::min(top + a.height, screen->height) - y;
  if (image.width <= 0 || image.height <= 0) throw std::runtime_error("the window is off the screen");
  XImage* pixels =
      XGetImage(state_->display, screen->root, x, y, unsigned(image.width), unsigned(image.height), AllPlanes, ZPixmap);
  if (!pixels) throw std::runtime_error("the screen cannot be read");
  image.rgba.resize(4 * size_t(image.width) * size_t(image.height));
  for (int row = 0; row < image.height; ++row) {
    const auto* line = reinterpret_cast<const uint32_t*>(pixels->data + size_t(row) * size_t(pixels->bytes_per_line));
    uint8_t* out = &image.rgba[4 * size_t(row) * size_t(image.width)];
    for (int column = 0; column < image.width; ++column, out += 4) {
      out[0] = uint8_t(line[column] >> 16);
      out[1] = uint8_t(line[column] >> 8);
      out[2] = uint8_t(line[column]);
      out[3] = 255;
    }
  }
  XDestroyImage(pixels);
  return image;
}

// Whether the studio had more to do since the last time that it was asked.
class Person::Watch {
 public:
  explicit Watch(const RunningStudio& studio) : studio_(studio), before_(studio.workSeconds()) {}
  bool busy() {
    std::map<pid_t, double> work = studio_.workSeconds();
    const double rest = kRest * since(std::exchange(looked_, Clock::now()));
    const bool some =
        std::any_of(work.begin(), work.end(), [&](const auto& t) { return t.second - before_[t.first] > rest; });
    before_ = std::move(work);
    return some;
  }

 private:
  const RunningStudio& studio_;
  std::map<pid_t, double> before_;
  Clock::time_point looked_ = Clock::now();
};

void Person::ready() const {
  XSync(state_->display, False);  // The server has handed on what was done.
  const auto begin = Clock::now();
  auto worked = begin;
  Watch watch(*state_->studio);
  while (since(worked) < kReady && since(begin) < kLongest) {
    if (!state_->studio->running()) return;
    sleep(0.05);
    if (watch.busy()) worked = Clock::now();
  }
}

render::Image Person::settled() const {
  const auto begin = Clock::now();
  render::Image still = look(), now = still;
  auto changed = Clock::now();
  Watch watch(*state_->studio);
  while (since(changed) < kStill * state_->scale) {
    if (!state_->studio->running()) throw std::runtime_error("the studio has ended: " + state_->studio->said());
    if (since(begin) > kPatience) break;
    sleep(0.1);
    const bool busy = watch.busy();
    now = look();
    if (!busy && changedPixels(still, now) <= kBlinking * state_->scale * state_->scale) continue;
    still = now;
    changed = Clock::now();
  }
  return now;
}

render::Image Person::shot(const std::string& name) const {
  render::Image image = settled();
  if (const char* folder = std::getenv("ARGIL_SHOTS")) {
    fs::create_directories(folder);
    render::writePng(image, (fs::path(folder) / (name + ".png")).string());
  }
  return image;
}

render::Image readPng(const fs::path& file) {
  render::Image image;
  int channels = 0;
  stbi_uc* pixels = stbi_load(file.c_str(), &image.width, &image.height, &channels, 4);
  if (!pixels) throw std::runtime_error(file.string() + " is no picture");
  image.rgba.assign(pixels, pixels + 4 * size_t(image.width) * size_t(image.height));
  stbi_image_free(pixels);
  return image;
}

double difference(const render::Image& a, const render::Image& b) {
  if (a.width != b.width || a.height != b.height) return 1;
  return double(changedPixels(a, b)) / (double(a.rgba.size()) / 4);
}

}  // namespace argil::tests
