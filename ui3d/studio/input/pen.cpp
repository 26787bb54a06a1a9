#include "ui3d/studio/input/pen.h"

#include <X11/Xlib.h>
#include <X11/extensions/XInput2.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

namespace argil::studio {
namespace {

constexpr double kFreshS = 0.1;
constexpr float kSteepest = 1.5f;  // What the pointer takes.

float part(const PenAxis& axis, double value) {
  return axis.most > axis.least ? float(std::clamp((value - axis.least) / (axis.most - axis.least), 0.0, 1.0)) : 0.0f;
}

float tilt(double degrees) {
  return std::clamp(float(degrees * std::numbers::pi / 180), -kSteepest, kSteepest);
}

// A device may vanish between two calls; X's own answer to that is to end the program.
int forgive(Display*, XErrorEvent*) {
  return 0;
}

}  // namespace

PenState decodePen(const PenAxes& axes, std::span<const unsigned char> mask, std::span<const double> values,
                   PenState before) {
  size_t next = 0;
  for (int bit = 0; bit < int(mask.size()) * 8 && next < values.size(); ++bit) {
    if (!(mask[size_t(bit) / 8] & (1 << (bit % 8)))) continue;
    const double value = values[next++];
    if (!std::isfinite(value)) continue;
    if (axes.pressure && axes.pressure->number == bit) before.pressure = part(*axes.pressure, value);
    if (axes.tiltX && axes.tiltX->number == bit) before.tiltX = tilt(value);
    if (axes.tiltY && axes.tiltY->number == bit) before.tiltY = tilt(value);
  }
  return before;
}

bool namesEraser(std::string_view device) {
  constexpr std::string_view kWord = "eraser";
  return std::search(device.begin(), device.end(), kWord.begin(), kWord.end(),
                     [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; }) != device.end();
}

struct Pen::State {
  Display* display = nullptr;
  Window window = 0;
  int opcode = 0;
  struct End {
    PenAxes axes;
    bool eraser = false;
  };
  std::map<int, End> pens;  // By X's device number.
  PenState now;
  double heardS = -1;

  void select(int device, std::initializer_list<int> kinds, Window where) const {
    unsigned char bits[XIMaskLen(XI_LASTEVENT)] = {};
    for (const int kind : kinds) XISetMask(bits, kind);
    XIEventMask mask{device, int(sizeof bits), bits};
    XISelectEvents(display, where, &mask, 1);
  }

  void find() {
    pens.clear();
    int count = 0;
    XIDeviceInfo* all = XIQueryDevice(display, XIAllDevices, &count);
    for (int i = 0; all && i < count; ++i) {
      const XIDeviceInfo& device = all[i];
      if (device.use != XISlavePointer && device.use != XIFloatingSlave) continue;
      PenAxes axes;
      for (int c = 0; c < device.num_classes; ++c) {
        if (device.classes[c]->type != XIValuatorClass) continue;
        const auto& v = *reinterpret_cast<const XIValuatorClassInfo*>(device.classes[c]);
        char* label = v.label ? XGetAtomName(display, v.label) : nullptr;
        const std::string_view name = label ? label : "";
        const PenAxis axis{v.number, v.min, v.max};
        if (name == "Abs Pressure") axes.pressure = axis;
        if (name == "Abs Tilt X") axes.tiltX = axis;
        if (name == "Abs Tilt Y") axes.tiltY = axis;
        if (label) XFree(label);
      }
      if (!axes.pressure) continue;
      pens[device.deviceid] = {axes, namesEraser(device.name ? device.name : "")};
      select(device.deviceid, {XI_Motion, XI_ButtonPress, XI_ButtonRelease}, window);
    }
    if (all) XIFreeDeviceInfo(all);
    XFlush(display);
  }
};

Pen::Pen(unsigned long window) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.display = XOpenDisplay(nullptr);
  if (!s.display) return;
  int event = 0, error = 0, major = 2, minor = 2;
  if (!XQueryExtension(s.display, "XInputExtension", &s.opcode, &event, &error) ||
      XIQueryVersion(s.display, &major, &minor) != Success) {
    XCloseDisplay(s.display);
    s.display = nullptr;
    return;
  }
  s.window = window;
  const XErrorHandler before = XSetErrorHandler(forgive);
  s.select(XIAllDevices, {XI_HierarchyChanged, XI_DeviceChanged}, DefaultRootWindow(s.display));
  s.find();
  XSync(s.display, False);
  XSetErrorHandler(before);
}

Pen::~Pen() {
  if (state_->display) XCloseDisplay(state_->display);
}

int Pen::descriptor() const {
  return state_->display ? ConnectionNumber(state_->display) : -1;
}
bool Pen::active(double nowS) const {
  return state_->heardS >= 0 && nowS - state_->heardS < kFreshS;
}
const PenState& Pen::state() const {
  return state_->now;
}
int Pen::count() const {
  return int(state_->pens.size());
}

void Pen::poll(double nowS, float scale, std::vector<Event>& events) {
  State& s = *state_;
  if (!s.display) return;
  bool changed = false;
  while (XPending(s.display) > 0) {
    XEvent x;
    XNextEvent(s.display, &x);
    if (x.xcookie.type != GenericEvent || x.xcookie.extension != s.opcode || !XGetEventData(s.display, &x.xcookie))
      continue;
    if (x.xcookie.evtype == XI_HierarchyChanged || x.xcookie.evtype == XI_DeviceChanged) {
      changed = true;
    } else {
      const auto& e = *static_cast<const XIDeviceEvent*>(x.xcookie.data);
      if (const auto pen = s.pens.find(e.sourceid); pen != s.pens.end() && e.deviceid == e.sourceid) {
        const std::span mask(e.valuators.mask, size_t(e.valuators.mask_len));
        size_t told = 0;
        for (const unsigned char byte : mask) told += size_t(__builtin_popcount(byte));
        s.now = decodePen(pen->second.axes, mask, std::span(e.valuators.values, told), s.now);
        s.now.eraser = pen->second.eraser;
        s.heardS = nowS;
        if (e.evtype == XI_Motion) {
          Event move;
          move.timeS = nowS;
          move.x = float(e.event_x) / scale;
          move.y = float(e.event_y) / scale;
          move.modifiers =
              uint8_t(((e.mods.effective & ShiftMask) ? kShift : 0) |
                      ((e.mods.effective & ControlMask) ? kControl : 0) | ((e.mods.effective & Mod1Mask) ? kAlt : 0));
          move.pressure = s.now.pressure;
          move.tiltX = s.now.tiltX;
          move.tiltY = s.now.tiltY;
          move.eraser = s.now.eraser;
          events.push_back(move);
        }
      }
    }
    XFreeEventData(s.display, &x.xcookie);
  }
  if (changed) {
    const XErrorHandler before = XSetErrorHandler(forgive);
    s.find();
    XSync(s.display, False);
    XSetErrorHandler(before);
  }
}

}  // namespace argil::studio
