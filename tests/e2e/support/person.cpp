#include "tests/e2e/support/person.h"
#include "tests/support/tier.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>
#include <X11/keysym.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stb_image.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

extern char** environ;

namespace argil::tests {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kPatience = 300;  // s: a software driver on a machine that does other things too
constexpr double kStill = 0.3;     // At scale 1; a picture of four times the pixels takes its time.
constexpr double kBetween = 0.1;   // Two looks.
constexpr double kReady = 0.3;     // The window's manager may hold back a press until it has looked at it.
constexpr double kHeld = 0.03;
constexpr size_t kTurnsBytes = 2 * sizeof(uint64_t);
constexpr double kBlinking = 60;  // Pixels at scale 1: the cursor of a text field, which never rests.
constexpr double kTold = 3;       // s at rest by what the studio tells: enough, whatever still changes in the picture.

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

// Two counts, shared with the studio.
const std::atomic<uint64_t>* mapTurns(const fs::path& file) {
  const int opened = open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  void* bytes = MAP_FAILED;
  if (opened >= 0 && ftruncate(opened, kTurnsBytes) == 0)
    bytes = mmap(nullptr, kTurnsBytes, PROT_READ, MAP_SHARED, opened, 0);
  if (opened >= 0) close(opened);
  if (bytes == MAP_FAILED) throw std::runtime_error("cannot share " + file.string());
  return static_cast<const std::atomic<uint64_t>*>(bytes);
}

void keepPicturesPlain(const fs::path& home) {
  const fs::path file = home / "argil" / "studio.json";
  if (longTier() || fs::exists(file)) return;
  fs::create_directories(file.parent_path());
  std::ofstream(file)
      << R"({"quality":{"supersample":1,"key_shadow":false,"cavity":false,"detail":4,"frames_per_second":5}})";
}

}  // namespace

RunningStudio::RunningStudio(const std::vector<std::string>& arguments, const fs::path& home) : err_(home / "said") {
  keepPicturesPlain(home);
  std::vector<std::string> words{ARGIL_COMMAND};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv, environment;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  static int studios = 0;
  const std::string rest = (home / ("rest" + std::to_string(++studios))).string();
  turns_ = mapTurns(rest);
  std::array<std::string, 4> own = {"XDG_CONFIG_HOME=" + home.string(), "XDG_CACHE_HOME=" + home.string(),
                                    "ARGIL_STATE=" + (home / "state").string(), "ARGIL_REST=" + rest};
  for (char** e = environ; *e; ++e)
    if (std::none_of(own.begin(), own.end(), [&](const std::string& variable) {
          return std::string(*e).starts_with(variable.substr(0, variable.find('=') + 1));
        }))
      environment.push_back(*e);
  for (std::string& variable : own) environment.push_back(variable.data());
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
  if (running()) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  munmap(const_cast<std::atomic<uint64_t>*>(turns_), kTurnsBytes);
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

RunningStudio::Turns RunningStudio::turns() const {
  return {turns_[0].load(std::memory_order_acquire), turns_[1].load(std::memory_order_acquire)};
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
  // A server on a busy machine dates what waited for it with one millisecond; GLFW takes the second press of a key at
  // that time for the first one told twice, and drops it. A person's presses have times of their own.
  void dated() const { XSync(display, False); }
  void keyEvent(KeySym symbol, bool down) const {
    const KeyCode code = XKeysymToKeycode(display, symbol);
    if (!code) throw std::runtime_error("this keyboard has no such key: " + std::to_string(symbol));
    XTestFakeKeyEvent(display, code, down ? True : False, 0);
    dated();
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
  state_->dated();
}

void Person::release(int button) {
  XTestFakeButtonEvent(state_->display, unsigned(button), False, 0);
  state_->dated();
}

void Person::click(double x, double y, int button) {
  move(x, y);
  sleep(kHeld);
  press(button);
  sleep(kHeld);
  release(button);
  sleep(kHeld);
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
    sleep(kHeld);
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
    sleep(kHeld);
  }
  for (auto word = words.rbegin(); word != words.rend(); ++word) {
    keyUp(*word);
    sleep(kHeld);
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

namespace {

// Whether the studio rests: for how long, by what it tells of its turns.
class Rest {
 public:
  explicit Rest(const RunningStudio& studio) : studio_(studio), from_(studio.turns()) {}
  void begin() {
    from_ = studio_.turns();
    begin_ = Clock::now();
  }
  // A turn that was under way when something came has not seen it: three are two whole ones.
  bool lasts(double seconds) {
    const RunningStudio::Turns now = studio_.turns();
    if (now.acting != from_.acting) begin();
    return now.resting >= from_.resting + 3 && since(begin_) >= seconds;
  }

 private:
  const RunningStudio& studio_;
  RunningStudio::Turns from_;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace

void Person::ready() const {
  XSync(state_->display, False);  // The server has handed on what was done.
  const auto begin = Clock::now();
  Rest rest(*state_->studio);
  while (!rest.lasts(kReady)) {
    if (!state_->studio->running()) return;
    if (since(begin) > kPatience) {
      std::fprintf(stderr, "the studio does not come to rest\n");
      return;
    }
    sleep(0.02);
  }
}

render::Image Person::settled() const {
  XSync(state_->display, False);
  const auto begin = Clock::now();
  Rest rest(*state_->studio), told(*state_->studio);
  // Looking costs as much as drawing: nothing is looked at before the studio rests.
  std::optional<render::Image> before;
  while (true) {
    if (!state_->studio->running()) throw std::runtime_error("the studio has ended: " + state_->studio->said());
    const bool late = since(begin) > kPatience;
    if (late) std::fprintf(stderr, "the picture does not come to rest\n");
    if (rest.lasts(kStill * state_->scale) || late) {
      render::Image now = look();
      const double blinking = kBlinking * state_->scale * state_->scale;
      if (late || told.lasts(kTold) || (before && changedPixels(*before, now) <= blinking)) return now;
      before = std::move(now);
    } else {
      before.reset();
    }
    sleep(kBetween);
  }
}

render::Image Person::shot(const std::string& name) const {
  render::Image image = settled();
  keep(image, name);
  return image;
}

void keep(const render::Image& image, std::string name) {
  const char* folder = std::getenv("ARGIL_SHOTS");
  if (!folder) return;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c) && c != '_'; }, '-');
  fs::create_directories(folder);
  render::writePng(image, (fs::path(folder) / (name + ".png")).string());
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
