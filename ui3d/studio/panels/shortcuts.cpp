#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <utility>

#include "clay/base/error.h"
#include "ui3d/studio/panels/actions.h"

namespace argil::studio {
namespace {

using NamedKey = std::pair<std::string_view, Key>;

// The first name of a key is the one that is shown.
constexpr std::array kNamedKeys{
    NamedKey{"Escape", Key::escape}, NamedKey{"Esc", Key::escape},        NamedKey{"Enter", Key::enter},
    NamedKey{"Return", Key::enter},  NamedKey{"Tab", Key::tab},           NamedKey{"Backspace", Key::backspace},
    NamedKey{"Insert", Key::insert}, NamedKey{"Delete", Key::remove},     NamedKey{"Right", Key::right},
    NamedKey{"Left", Key::left},     NamedKey{"Down", Key::down},         NamedKey{"Up", Key::up},
    NamedKey{"PageUp", Key::pageUp}, NamedKey{"PageDown", Key::pageDown}, NamedKey{"Home", Key::home},
    NamedKey{"End", Key::end},       NamedKey{"Space", Key(' ')},
};
constexpr std::array kModifiers{
    std::pair<std::string_view, uint8_t>{"Ctrl", kControl},    std::pair<std::string_view, uint8_t>{"Alt", kAlt},
    std::pair<std::string_view, uint8_t>{"Shift", kShift},     std::pair<std::string_view, uint8_t>{"Super", kSuper},
    std::pair<std::string_view, uint8_t>{"Control", kControl},
};

bool sameWord(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

// "F7" or "Keypad7": the number, 0 to `most`; −1: not of this kind.
int numbered(std::string_view word, std::string_view prefix, int most) {
  if (word.size() <= prefix.size() || word.size() > prefix.size() + 2 ||
      !sameWord(word.substr(0, prefix.size()), prefix))
    return -1;
  int number = 0;
  for (const char digit : word.substr(prefix.size())) {
    if (digit < '0' || digit > '9') return -1;
    number = 10 * number + (digit - '0');
  }
  return number <= most ? number : -1;
}

Key parseKey(std::string_view word) {
  if (word.size() == 1) {
    const auto character = static_cast<unsigned char>(word[0]);
    return character > ' ' && character < 127 ? Key(std::toupper(character)) : Key::none;
  }
  for (const auto& [name, key] : kNamedKeys) {
    if (sameWord(name, word)) return key;
  }
  if (const int n = numbered(word, "F", 12); n >= 1) return Key(int(Key::f1) + n - 1);
  if (const int n = numbered(word, "Keypad", 9); n >= 0) return Key(int(Key::keypad0) + n);
  return Key::none;
}

std::vector<std::string> words(std::string_view text) {
  std::istringstream stream{std::string(text)};
  std::vector<std::string> list;
  for (std::string word; stream >> word;) list.push_back(word);
  return list;
}

}  // namespace

std::optional<Shortcut> parseShortcut(std::string_view text) {
  Shortcut shortcut;
  for (;;) {
    const size_t plus = text.find('+');
    // The last word; a '+' at the end is the key itself.
    if (plus == std::string_view::npos || plus + 1 >= text.size()) break;
    const auto modifier = std::find_if(kModifiers.begin(), kModifiers.end(),
                                       [&](const auto& each) { return sameWord(each.first, text.substr(0, plus)); });
    if (modifier == kModifiers.end() || (shortcut.modifiers & modifier->second)) return std::nullopt;
    shortcut.modifiers |= modifier->second;
    text.remove_prefix(plus + 1);
  }
  shortcut.key = parseKey(text);
  if (shortcut.key == Key::none) return std::nullopt;
  return shortcut;
}

std::string format(const Shortcut& shortcut) {
  std::string text;
  for (size_t i = 0; i < 4; ++i) {
    if (shortcut.modifiers & kModifiers[i].second) text += std::string(kModifiers[i].first) + "+";
  }
  const int code = int(shortcut.key);
  for (const auto& [name, key] : kNamedKeys) {
    if (key == shortcut.key) return text + std::string(name);
  }
  if (shortcut.key >= Key::f1 && shortcut.key <= Key::f12) return text + "F" + std::to_string(code - int(Key::f1) + 1);
  if (shortcut.key >= Key::keypad0 && shortcut.key <= Key::keypad9)
    return text + "Keypad" + std::to_string(code - int(Key::keypad0));
  return code > ' ' && code < 127 ? text + static_cast<char>(code) : std::string();
}

std::string shortcutOf(const Action& action, const StudioState& state) {
  const auto own = state.keys.find(action.id);
  return own == state.keys.end() ? action.shortcut : own->second;
}

const Action* actionOf(const Shortcut& shortcut, const StudioState& state) {
  for (const Action& action : actions()) {
    for (const std::string& word : words(shortcutOf(action, state))) {
      if (parseShortcut(word) == shortcut) return &action;
    }
  }
  return nullptr;
}

void setShortcut(StudioState& state, const Action& action, std::string_view shortcuts) {
  std::string kept;
  for (const std::string& word : words(shortcuts)) {
    const std::optional<Shortcut> shortcut = parseShortcut(word);
    if (!shortcut)
      throw Error("'" + word + "' is no key: write a key with Ctrl, Alt or Shift before it, such as Ctrl+Shift+Z");
    const Action* holder = actionOf(*shortcut, state);
    if (holder && holder->id != action.id) {
      throw Error(format(*shortcut) + " is the key of \"" + holder->name +
                  "\" already: take it away there first, or choose another");
    }
    kept += (kept.empty() ? "" : " ") + format(*shortcut);
  }
  if (kept == action.shortcut)
    state.keys.erase(action.id);
  else
    state.keys[action.id] = kept;
}

void resetShortcut(StudioState& state, const Action& action) {
  setShortcut(state, action, action.shortcut);
}

bool runShortcut(Context& context, const Shortcut& shortcut) {
  const Action* action = actionOf(shortcut, context.state);
  if (!action && shortcut.key >= Key::keypad0 && shortcut.key <= Key::keypad9) {
    action = actionOf({Key('0' + int(shortcut.key) - int(Key::keypad0)), shortcut.modifiers}, context.state);
  }
  if (!action || (action->enabled && !action->enabled(context))) return false;
  action->run(context, action->argument);
  return true;
}

}  // namespace argil::studio
