#include "ui3d/studio/input/event_log.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "clay/base/error.h"

namespace argil::studio {
namespace {

using Json = nlohmann::ordered_json;
using Kind = Event::Kind;

constexpr std::array kKinds = {
    std::pair{Kind::move, "move"},     std::pair{Kind::press, "press"},     std::pair{Kind::release, "release"},
    std::pair{Kind::wheel, "wheel"},   std::pair{Kind::keyDown, "down"},    std::pair{Kind::keyUp, "up"},
    std::pair{Kind::text, "text"},     std::pair{Kind::enter, "enter"},     std::pair{Kind::leave, "leave"},
    std::pair{Kind::resize, "resize"}, std::pair{Kind::drop, "drop"},       std::pair{Kind::focus, "focus"},
    std::pair{Kind::close, "close"},   std::pair{Kind::motion6, "motion6"}, std::pair{Kind::screenshot, "screenshot"},
    std::pair{Kind::check, "check"},   std::pair{Kind::lose, "lose"}};
constexpr std::array kButtons = {std::pair{Button::left, "left"}, std::pair{Button::right, "right"},
                                 std::pair{Button::middle, "middle"}};
constexpr std::array kModifiers = {std::pair{kShift, "shift"}, std::pair{kControl, "ctrl"}, std::pair{kAlt, "alt"},
                                   std::pair{kSuper, "super"}};
// In the order of Key, from escape, f1, keypad0 and shift on.
constexpr std::array kNamed = {"escape", "enter", "tab", "backspace", "insert",    "delete", "right",
                               "left",   "down",  "up",  "page up",   "page down", "home",   "end"};
constexpr std::array kHeld = {"shift", "ctrl", "alt", "super"};
constexpr int kNamedFirst = int(Key::escape), kFunctionFirst = int(Key::f1), kKeypadFirst = int(Key::keypad0),
              kHeldFirst = int(Key::shift);

template <class Table, class Value>
const char* nameIn(const Table& table, Value value) {
  for (const auto& [v, name] : table)
    if (v == value) return name;
  return "";
}

template <class Table>
auto valueIn(const Table& table, const std::string& name, const char* what) {
  for (const auto& [value, known] : table)
    if (name == known) return value;
  throw Error(fmt::format("\"{}\" is no {}", name, what));
}

std::string keyName(Key key) {
  const int k = int(key);
  if (k > 32 && k < 127) return std::string(1, char(k));
  if (k == 32) return "space";
  if (k >= kNamedFirst && k < kNamedFirst + int(kNamed.size())) return kNamed[size_t(k - kNamedFirst)];
  if (k >= kFunctionFirst && k < kFunctionFirst + 12) return fmt::format("f{}", k - kFunctionFirst + 1);
  if (k >= kKeypadFirst && k < kKeypadFirst + 10) return fmt::format("keypad {}", k - kKeypadFirst);
  if (k >= kHeldFirst && k < kHeldFirst + int(kHeld.size())) return kHeld[size_t(k - kHeldFirst)];
  return "none";
}

Key keyNamed(const std::string& name) {
  for (int k = 0; k <= int(Key::super); ++k)
    if (keyName(Key(k)) == name) return Key(k);
  throw Error(fmt::format("\"{}\" is no key", name));
}

// Recordings are read by people too: six digits are enough for any of these numbers.
double rounded(double value) {
  return std::round(value * 1e6) / 1e6;
}

double number(const Json& json, const char* name, double otherwise) {
  const auto found = json.find(name);
  if (found == json.end()) return otherwise;
  if (!found->is_number()) throw Error(fmt::format("\"{}\" must be a number", name));
  const double value = found->get<double>();
  if (!std::isfinite(value) || std::abs(value) > 1e9) throw Error(fmt::format("\"{}\" is out of range", name));
  return value;
}

std::string word(const Json& json, const char* name, const char* otherwise) {
  const auto found = json.find(name);
  if (found == json.end() && otherwise) return otherwise;
  if (found == json.end() || !found->is_string()) throw Error(fmt::format("\"{}\" must be a text", name));
  return found->get<std::string>();
}

bool flag(const Json& json, const char* name) {
  const auto found = json.find(name);
  if (found == json.end()) return false;
  if (!found->is_boolean()) throw Error(fmt::format("\"{}\" must be true or false", name));
  return found->get<bool>();
}

bool hasPlace(Kind kind) {
  return kind == Kind::move || kind == Kind::press || kind == Kind::release || kind == Kind::wheel ||
         kind == Kind::enter;
}

}  // namespace

std::string toLine(const Event& event) {
  Json json;
  json["t"] = rounded(event.timeS);
  json["kind"] = nameIn(kKinds, event.kind);
  if (hasPlace(event.kind)) {
    json["x"] = rounded(event.x);
    json["y"] = rounded(event.y);
    if (event.pressure >= 0) {
      json["pressure"] = rounded(event.pressure);
      json["tilt"] = {rounded(event.tiltX), rounded(event.tiltY)};
      if (event.eraser) json["eraser"] = true;
    }
  }
  switch (event.kind) {
    case Kind::press:
    case Kind::release:
      json["button"] = nameIn(kButtons, event.button);
      break;
    case Kind::wheel:
      json["dx"] = rounded(event.dx);
      json["dy"] = rounded(event.dy);
      break;
    case Kind::keyDown:
    case Kind::keyUp:
      json["key"] = keyName(event.key);
      if (event.repeat) json["repeat"] = true;
      break;
    case Kind::text:
      json["character"] = event.character;
      break;
    case Kind::resize:
      json["width"] = event.width;
      json["height"] = event.height;
      json["scale"] = rounded(event.scale);
      break;
    case Kind::focus:
      json["on"] = event.on;
      break;
    case Kind::motion6:
      for (const float axis : event.axes) json["axes"].push_back(rounded(axis));
      break;
    case Kind::drop:
    case Kind::screenshot:
      json["text"] = event.text;
      break;
    default:
      break;
  }
  for (const auto& [bit, name] : kModifiers)
    if (event.modifiers & bit) json["modifiers"].push_back(name);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);  // File names may hold anything.
}

Event fromLine(const std::string& line) {
  Json json;
  try {
    json = Json::parse(line);
  } catch (const Json::exception&) {
    throw Error("not JSON");
  }
  if (!json.is_object())
    throw Error("must be an object such as {\"t\": 0.5, \"kind\": \"move\", \"x\": 10, \"y\": 20}");
  Event e;
  e.kind = valueIn(kKinds, word(json, "kind", nullptr), "kind of event");
  e.timeS = number(json, "t", 0);
  e.x = float(number(json, "x", 0));
  e.y = float(number(json, "y", 0));
  e.dx = float(number(json, "dx", 0));
  e.dy = float(number(json, "dy", 0));
  e.button = valueIn(kButtons, word(json, "button", "left"), "button");
  if (json.contains("key")) e.key = keyNamed(word(json, "key", nullptr));
  e.repeat = flag(json, "repeat");
  e.on = flag(json, "on");
  const double character = number(json, "character", 0);
  if (character < 0 || character > 0x10FFFF) throw Error("\"character\" must be a Unicode number");
  e.character = uint32_t(character);
  e.width = int(number(json, "width", 0));
  e.height = int(number(json, "height", 0));
  e.scale = float(number(json, "scale", 1));
  if (e.kind == Kind::resize &&
      (e.width < 0 || e.height < 0 || e.width > 16384 || e.height > 16384 || e.scale < 0.25f || e.scale > 8))
    throw Error("a size is 0 to 16384 pixels, a scale 0.25 to 8");
  e.pressure = float(number(json, "pressure", -1));
  if (e.pressure > 1) throw Error("\"pressure\" is 0 to 1");
  e.eraser = flag(json, "eraser");
  e.text = word(json, "text", "");
  if (const auto tilt = json.find("tilt"); tilt != json.end()) {
    if (!tilt->is_array() || tilt->size() != 2 || !(*tilt)[0].is_number() || !(*tilt)[1].is_number())
      throw Error("\"tilt\" must be two angles in radians");
    e.tiltX = (*tilt)[0].get<float>();
    e.tiltY = (*tilt)[1].get<float>();
  }
  if (const auto axes = json.find("axes"); axes != json.end()) {
    if (!axes->is_array() || axes->size() != e.axes.size()) throw Error("\"axes\" must be six numbers");
    for (size_t i = 0; i < e.axes.size(); ++i) {
      if (!(*axes)[i].is_number()) throw Error("\"axes\" must be six numbers");
      e.axes[i] = (*axes)[i].get<float>();
    }
  }
  if (const auto modifiers = json.find("modifiers"); modifiers != json.end()) {
    if (!modifiers->is_array()) throw Error("\"modifiers\" must be a list such as [\"ctrl\"]");
    for (const Json& name : *modifiers) {
      if (!name.is_string()) throw Error("\"modifiers\" must be a list such as [\"ctrl\"]");
      e.modifiers = uint8_t(e.modifiers | valueIn(kModifiers, name.get<std::string>(), "modifier"));
    }
  }
  return e;
}

std::vector<Event> readEvents(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw Error(fmt::format("{}: cannot be read; check the name", file.string()));
  std::vector<Event> events;
  size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    try {
      events.push_back(fromLine(line));
      if (events.size() > 1 && events.back().timeS < events[events.size() - 2].timeS)
        throw Error("\"t\" is earlier than in the line before");
    } catch (const Error& e) {
      throw Error(fmt::format("{}:{}: {}", file.string(), number, e.what()));
    }
  }
  return events;
}

EventWriter::EventWriter(const std::filesystem::path& file) : file_(file) {
  if (std::filesystem::exists(file))
    throw Error(fmt::format("{}: is there already; give another name for the recording", file.string()));
  out_.open(file);
  if (!out_) throw Error(fmt::format("{}: cannot be written; check the folder", file.string()));
}

void EventWriter::write(const Event& event) {
  out_ << toLine(event) << '\n' << std::flush;
  if (!out_) throw Error(fmt::format("{}: cannot be written; is the disk full?", file_.string()), Error::Kind::work);
}

}  // namespace argil::studio
