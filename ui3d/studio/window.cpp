#include "ui3d/studio/window.h"

#include <vulkan/vulkan_core.h>  // Before GLFW, which declares surfaces only then.

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "ui3d/studio/kit/layout.h"

// As <GLFW/glfw3native.h> and <X11/Xlib.h> have them: the first wants headers of more X libraries, the second's macros
// have our names.
extern "C" {
struct _XDisplay;
_XDisplay* glfwGetX11Display(void);
unsigned long glfwGetX11Window(GLFWwindow*);
int XPending(_XDisplay*);
int XConnectionNumber(_XDisplay*);
}

namespace argil::studio {
namespace {

constexpr int kLeastWidth = 640, kLeastHeight = 400;

std::string lastError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

// Shortcuts go by what is written on the key, GLFW's codes by where it is on an American keyboard. Digits stay digits
// on keyboards that have them on the shifted level.
Key keyOf(int code, int scancode) {
  if (code >= GLFW_KEY_ESCAPE && code <= GLFW_KEY_END) return Key(code);
  if (code >= GLFW_KEY_F1 && code <= GLFW_KEY_F12) return Key(code);
  if (code >= GLFW_KEY_KP_0 && code <= GLFW_KEY_KP_9) return Key(code);
  switch (code) {
    case GLFW_KEY_KP_ENTER:
      return Key::enter;
    case GLFW_KEY_KP_DECIMAL:
      return Key('.');
    case GLFW_KEY_KP_DIVIDE:
      return Key('/');
    case GLFW_KEY_KP_MULTIPLY:
      return Key('*');
    case GLFW_KEY_KP_SUBTRACT:
      return Key('-');
    case GLFW_KEY_KP_ADD:
      return Key('+');
    case GLFW_KEY_KP_EQUAL:
      return Key('=');
    case GLFW_KEY_LEFT_SHIFT:
    case GLFW_KEY_RIGHT_SHIFT:
      return Key::shift;
    case GLFW_KEY_LEFT_CONTROL:
    case GLFW_KEY_RIGHT_CONTROL:
      return Key::control;
    case GLFW_KEY_LEFT_ALT:
    case GLFW_KEY_RIGHT_ALT:
      return Key::alt;
    case GLFW_KEY_LEFT_SUPER:
    case GLFW_KEY_RIGHT_SUPER:
      return Key::super;
    case GLFW_KEY_SPACE:
      return Key(' ');
    default:
      break;
  }
  if (code >= '0' && code <= '9') return Key(code);
  if (const char* name = glfwGetKeyName(code, scancode); name && name[0] > ' ' && name[0] < 127 && name[1] == 0) {
    const char c = name[0];
    return Key(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  }
  return code > ' ' && code < 127 ? Key(code) : Key::none;
}

uint8_t modifierOf(Key key) {
  switch (key) {
    case Key::shift:
      return kShift;
    case Key::control:
      return kControl;
    case Key::alt:
      return kAlt;
    case Key::super:
      return kSuper;
    default:
      return 0;
  }
}

float displayScale(float told) {
  return std::clamp(std::isfinite(told) && told > 0 ? told : 1.0f, 0.5f, 4.0f);
}

}  // namespace

struct Window::State {
  GLFWwindow* window = nullptr;
  int64_t startNs = 0;
  float wantedScale = 0, toldScale = 0;
  int wake = -1;
  std::vector<Event> events;
  uint8_t modifiers = 0;
  float x = 0, y = 0;
  std::array<int, 4> windowed{};  // Place and size before full screen.
  std::array<GLFWcursor*, 7> cursors{};
  CursorShape shape = CursorShape::arrow;
  // What another thread may ask for.
  std::atomic<int> width{0}, height{0};
  std::atomic<bool> minimised{false};

  [[nodiscard]] float scale() const {
    float x1 = 1, y1 = 1;
    if (wantedScale <= 0) glfwGetWindowContentScale(window, &x1, &y1);
    return scaleThatFits(wantedScale > 0 ? wantedScale : displayScale(x1), width, height);
  }
  [[nodiscard]] double nowS() const { return double(haptics::nowNs() - startNs) * 1e-9; }

  Event make(Event::Kind kind) const {
    Event e;
    e.kind = kind;
    e.timeS = nowS();
    e.x = x;
    e.y = y;
    e.modifiers = modifiers;
    return e;
  }
  void resized() {
    int w = 0, h = 0;
    glfwGetFramebufferSize(window, &w, &h);
    width = w;
    height = h;
    toldScale = scale();
    // A storm of sizes is one event.
    std::erase_if(events, [](const Event& e) { return e.kind == Event::Kind::resize; });
    Event e = make(Event::Kind::resize);
    e.width = w;
    e.height = h;
    e.scale = toldScale;
    events.push_back(e);
  }
  void moved(double px, double py) {
    int w = 1, fw = 1;
    glfwGetWindowSize(window, &w, nullptr);
    glfwGetFramebufferSize(window, &fw, nullptr);
    const double units = double(fw) / std::max(w, 1) / scale();
    x = float(px * units);
    y = float(py * units);
    events.push_back(make(Event::Kind::move));
  }
  static State& of(GLFWwindow* w) { return *static_cast<State*>(glfwGetWindowUserPointer(w)); }
  void listen();
};

void Window::State::listen() {
  glfwSetWindowUserPointer(window, this);
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { of(w).resized(); });
  glfwSetWindowContentScaleCallback(window, [](GLFWwindow* w, float, float) { of(w).resized(); });
  glfwSetWindowIconifyCallback(window, [](GLFWwindow* w, int on) {
    of(w).minimised = on != 0;
    of(w).resized();
  });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { of(w).resized(); });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double px, double py) { of(w).moved(px, py); });
  glfwSetCursorEnterCallback(window, [](GLFWwindow* w, int in) {
    of(w).events.push_back(of(w).make(in ? Event::Kind::enter : Event::Kind::leave));
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
    State& s = of(w);
    s.modifiers = uint8_t(mods & 15);
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    // Without a window manager nobody gives the keyboard to the window that is clicked.
    if (action == GLFW_PRESS && !glfwGetWindowAttrib(w, GLFW_FOCUSED)) glfwFocusWindow(w);
    Event e = s.make(action == GLFW_PRESS ? Event::Kind::press : Event::Kind::release);
    e.button = Button(button);
    s.events.push_back(e);
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double dx, double dy) {
    Event e = of(w).make(Event::Kind::wheel);
    e.dx = float(dx);
    e.dy = float(dy);
    of(w).events.push_back(e);
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int code, int scancode, int action, int mods) {
    State& s = of(w);
    const Key key = keyOf(code, scancode);
    // X tells the modifiers as they were before the key itself.
    const uint8_t own = modifierOf(key);
    s.modifiers = uint8_t(action == GLFW_RELEASE ? (mods & 15) & ~own : (mods & 15) | own);
    if (key == Key::none) return;
    Event e = s.make(action == GLFW_RELEASE ? Event::Kind::keyUp : Event::Kind::keyDown);
    e.key = key;
    e.repeat = action == GLFW_REPEAT;
    s.events.push_back(e);
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned int character) {
    Event e = of(w).make(Event::Kind::text);
    e.character = character;
    of(w).events.push_back(e);
  });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    for (int i = 0; i < count; ++i) {
      Event e = of(w).make(Event::Kind::drop);
      e.text = paths[i];
      of(w).events.push_back(e);
    }
  });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int on) {
    State& s = of(w);
    if (!on) s.modifiers = 0;
    Event e = s.make(Event::Kind::focus);
    e.on = on != 0;
    s.events.push_back(e);
  });
  glfwSetWindowCloseCallback(window, [](GLFWwindow* w) {
    glfwSetWindowShouldClose(w, GLFW_FALSE);
    of(w).events.push_back(of(w).make(Event::Kind::close));
  });
}

Window::Window(const Options& options) : state_(std::make_unique<State>()) {
  if (!glfwInit())
    throw Error(
        fmt::format("no display ({}): start it on a desktop, or use argil sculpt, which needs none", lastError()),
        Error::Kind::work);
  State& s = *state_;
  s.startNs = options.startNs;
  s.wantedScale = options.scale;
  s.wake = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  int width = options.width, height = options.height;
  std::array<int, 4> area{};  // Of the screen, without the desktop's own bars.
  bool maximised = false;
  if (width <= 0 || height <= 0) {
    width = 1280;
    height = 720;
    if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) {
      float x1 = 1, y1 = 1;
      glfwGetMonitorWorkarea(monitor, &area[0], &area[1], &area[2], &area[3]);
      glfwGetMonitorContentScale(monitor, &x1, &y1);
      const FirstWindow first = firstWindow(area[2], area[3], options.scale > 0 ? options.scale : displayScale(x1));
      width = first.width;
      height = first.height;
      maximised = first.maximised;
    }
  }
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  glfwWindowHint(GLFW_MAXIMIZED, maximised ? GLFW_TRUE : GLFW_FALSE);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "argil");
  glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "argil");
  s.window = glfwCreateWindow(std::max(width, kLeastWidth), std::max(height, kLeastHeight), options.title.c_str(),
                              nullptr, nullptr);
  if (!s.window) {
    const std::string why = lastError();
    glfwTerminate();
    throw Error(fmt::format("no window can be opened ({}): use argil sculpt, which needs none", why),
                Error::Kind::work);
  }
  glfwSetWindowSizeLimits(s.window, kLeastWidth, kLeastHeight, GLFW_DONT_CARE, GLFW_DONT_CARE);
  s.listen();
  if (maximised && !glfwGetWindowAttrib(s.window, GLFW_MAXIMIZED)) {  // Nobody here maximises windows.
    glfwSetWindowPos(s.window, area[0], area[1]);
    glfwSetWindowSize(s.window, area[2], area[3]);
  }
  glfwShowWindow(s.window);
  s.resized();
}

Window::~Window() {
  for (GLFWcursor* cursor : state_->cursors)
    if (cursor) glfwDestroyCursor(cursor);
  if (state_->window) glfwDestroyWindow(state_->window);
  glfwTerminate();
  if (state_->wake >= 0) close(state_->wake);
}

render::WindowHooks Window::hooks() const {
  uint32_t count = 0;
  const char** names = glfwGetRequiredInstanceExtensions(&count);
  if (!names)
    throw Error("Vulkan cannot draw in a window here: install libvulkan1 and a driver such as mesa-vulkan-drivers",
                Error::Kind::work);
  render::WindowHooks hooks;
  hooks.instanceExtensions.assign(names, names + count);
  State* s = state_.get();
  hooks.makeSurface = [s](void* instance) -> uint64_t {
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    if (glfwCreateWindowSurface(static_cast<VkInstance>(instance), s->window, nullptr, &surface) != VK_SUCCESS)
      return 0;
    return reinterpret_cast<uint64_t>(surface);
  };
  hooks.size = [s]() -> std::array<int, 2> {
    if (s->minimised) return {0, 0};
    return {s->width.load(), s->height.load()};
  };
  return hooks;
}

void Window::wait(double seconds, std::span<const int> descriptors) {
  _XDisplay* display = glfwGetX11Display();
  if (!state_->events.empty() || XPending(display) > 0) return;
  std::vector<pollfd> all{{XConnectionNumber(display), POLLIN, 0}, {state_->wake, POLLIN, 0}};
  for (const int d : descriptors) all.push_back({d, POLLIN, 0});
  ::poll(all.data(), all.size(), int(std::ceil(std::max(0.0, seconds) * 1000)));
  uint64_t count = 0;
  [[maybe_unused]] const ssize_t n = read(state_->wake, &count, sizeof count);
}

void Window::poll(std::vector<Event>& events) {
  glfwPollEvents();
  if (state_->scale() != state_->toldScale) state_->resized();
  events.insert(events.end(), state_->events.begin(), state_->events.end());
  state_->events.clear();
}

void Window::wake() noexcept {
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t n = write(state_->wake, &one, sizeof one);
}

double Window::nowS() const {
  return state_->nowS();
}
std::array<int, 2> Window::pixels() const {
  return {state_->width.load(), state_->height.load()};
}
bool Window::minimised() const {
  return state_->minimised;
}
float Window::scale() const {
  return state_->scale();
}
void Window::setScale(float scale) {
  state_->wantedScale = scale;
}
void Window::resize(int width, int height) {
  glfwSetWindowSize(state_->window, width, height);
}
void Window::setTitle(const std::string& title) {
  glfwSetWindowTitle(state_->window, title.c_str());
}

void Window::setIcon(const render::Image& icon) {
  std::vector<uint8_t> pixels = icon.rgba;
  const GLFWimage image{icon.width, icon.height, pixels.data()};
  glfwSetWindowIcon(state_->window, 1, &image);
}

void Window::setCursor(CursorShape shape) {
  if (shape == state_->shape) return;
  state_->shape = shape;
  glfwSetInputMode(state_->window, GLFW_CURSOR, shape == CursorShape::none ? GLFW_CURSOR_HIDDEN : GLFW_CURSOR_NORMAL);
  if (shape == CursorShape::none) return;
  constexpr std::array kShapes = {GLFW_ARROW_CURSOR,     GLFW_IBEAM_CURSOR,   GLFW_HAND_CURSOR,
                                  GLFW_CROSSHAIR_CURSOR, GLFW_HRESIZE_CURSOR, GLFW_VRESIZE_CURSOR};
  GLFWcursor*& cursor = state_->cursors[size_t(shape)];
  if (!cursor) cursor = glfwCreateStandardCursor(kShapes[size_t(shape)]);
  glfwSetCursor(state_->window, cursor);
}

void Window::setClipboard(const std::string& text) {
  glfwSetClipboardString(state_->window, text.c_str());
}

std::string Window::clipboard() const {
  const char* text = glfwGetClipboardString(state_->window);
  return text ? text : "";
}

void Window::toggleFullScreen() {
  GLFWwindow* w = state_->window;
  auto& [x, y, width, height] = state_->windowed;
  if (fullScreen()) {
    glfwSetWindowMonitor(w, nullptr, x, y, width, height, GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
  if (!mode) return;
  glfwGetWindowPos(w, &x, &y);
  glfwGetWindowSize(w, &width, &height);
  glfwSetWindowMonitor(w, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

bool Window::fullScreen() const {
  return glfwGetWindowMonitor(state_->window) != nullptr;
}
unsigned long Window::x11() const {
  return glfwGetX11Window(state_->window);
}

}  // namespace argil::studio
