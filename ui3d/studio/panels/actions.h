#pragma once
// Everything that can be asked of the studio by name: menus, shortcuts and the palette are made from this table.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ui3d/studio/view/context.h"
#include "ui3d/studio/view/event.h"

namespace argil::studio {

struct Shortcut {
  Key key = Key::none;
  uint8_t modifiers = 0;
  friend bool operator==(const Shortcut&, const Shortcut&) = default;
};
/// "Ctrl+Shift+Z", "[", "F1". Any case and order of modifiers. Nothing for a text that is none.
[[nodiscard]] std::optional<Shortcut> parseShortcut(std::string_view text);
[[nodiscard]] std::string format(const Shortcut& shortcut);

struct Action {
  std::string id, name, help;  ///< "edit.undo", "Undo", one sentence.
  std::string group;           ///< Menu: File, Edit, Clay, Tool, Guides, View, Touch, Window, Help.
  std::string shortcut;  ///< As it ships, one or more parted by blanks; the person's own are in StudioState::keys.
  void (*run)(Context&, std::string_view argument) = nullptr;
  std::string argument = {};                  ///< Given to run: one function serves several rows.
  bool (*enabled)(const Context&) = nullptr;  ///< Null: always.
  bool (*checked)(const Context&, std::string_view argument) = nullptr;  ///< Null: not a switch.
  std::string synonyms = {};  ///< Search words, separated by blanks (synonyms.h).
};

/// One row for each tool of engine::toolTable(), each named view, each panel among them. Made anew when a plugin has
/// added tools; its rows are others then.
[[nodiscard]] const std::vector<Action>& actions();
[[nodiscard]] const Action* findAction(std::string_view id);
/// The shortcuts in force, after the person's changes; empty: none.
[[nodiscard]] std::string shortcutOf(const Action& action, const StudioState& state);
/// What a key stands for; null: nothing.
[[nodiscard]] const Action* actionOf(const Shortcut& shortcut, const StudioState& state);
/// Gives an action other shortcuts, kept in StudioState::keys; empty: none. Throws Error that says which word is no
/// key, or which action has that key already; then nothing changed.
void setShortcut(StudioState& state, const Action& action, std::string_view shortcuts);
/// As it shipped. Throws Error when another action has taken its key meanwhile.
void resetShortcut(StudioState& state, const Action& action);
/// Runs what the key stands for; false when nothing does or it cannot be done now. Not called while a text field has
/// the keyboard. F ("view.focus") is meant for the key's release without a drag: F and a drag is the tool's size.
/// Keypad digits count as digits.
bool runShortcut(Context& context, const Shortcut& shortcut);
/// A row of its own colour to the piece's materials, as one step.
void addMaterial(Context& context, const engine::Piece& piece);
/// Returns rows whose name, group, synonyms or help match what was typed, best first: letters in order, beginnings of
/// words count more.
[[nodiscard]] std::vector<const Action*> searchActions(std::string_view typed);
/// Returns the rows whose name or synonyms are spelt most like what was typed, best first, five at most: what is
/// offered where nothing matches.
[[nodiscard]] std::vector<const Action*> nearestActions(std::string_view typed);

}  // namespace argil::studio
