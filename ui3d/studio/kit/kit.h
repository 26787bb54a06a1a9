#pragma once
// What panels are made of: docks, buttons, switches, sliders, facts. All sizes in interface units. Between NewFrame()
// and Render().

#include <imgui.h>

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace argil::studio::kit {

struct Rect {
  float left = 0, top = 0, right = 0, bottom = 0;
  [[nodiscard]] float width() const { return right - left; }
  [[nodiscard]] float height() const { return bottom - top; }
  [[nodiscard]] bool empty() const { return width() <= 0 || height() <= 0; }
};

/// Before everything else in a frame.
void beginFrame();
/// Escape is used up in this frame: no dialog closes by it.
void takeEscape();
[[nodiscard]] bool escapeIsTaken();
/// Before ImGui::NewFrame(): while a menu is on top its rows take arrows, Enter and Space.
void steerMenus();
/// Within a menu that is being drawn, before its rows.
void beginMenuRows();
/// ImGui::BeginMenu() of a row within a menu.
[[nodiscard]] bool beginMenuInMenu(const char* name);
/// Opens a menu of the bar that is being drawn instead of the open one, with its first row marked.
void openMenu(const char* name);
/// 1: Right asks for the next menu of the bar in this frame; -1: Left for the one before; 0: neither.
[[nodiscard]] int menuStepAcross();

/// A window that fills a rectangle, without title and without moving. Always end() it.
bool begin(const char* name, const Rect& rect, ImU32 ground, ImVec2 padding, ImGuiWindowFlags flags = 0);
/// A card over the picture that grows with what is in it, as wide as given, its middle at (x, y) at the place told by
/// `pivot`.
bool beginCard(const char* name, ImVec2 at, ImVec2 pivot, float width, float mostHeight = 0);
/// A window in the middle with everything behind it out of reach, `*open` becoming false by Escape or its cross. Call
/// it in every frame, open or not; endDialog() only when it returns true. Height 0: as what is in it needs. Without a
/// title a click outside closes it too. Enter presses its mainButton(), unless a text is being typed or a
/// list is open. `right` above 0: its right edge is there and the picture is not dimmed, so that what it shows is seen.
bool beginDialog(const char* name, const char* title, float width, float height, bool* open, float right = 0);
void end();
void endCard();
void endDialog(bool open);

/// A heading in a panel, with a line before it unless it is the first.
void heading(std::string_view text);
/// A row that unfolds what comes after it: draw that while it returns true, which is `open`.
bool fold(std::string_view name, bool& open, std::string_view help = {});
/// A row of a line and space.
void gap(float height);
void text(std::string_view text);
void dimText(std::string_view text);
/// Broken into lines.
void wrapped(std::string_view text, ImU32 colour);
/// In one line within `width`; what is too long ends in "…" and stands in a tooltip.
void elided(std::string_view text, float width, ImU32 colour);
void tooltip(std::string_view text, std::string_view shortcut = {});

/// Of buttons that can be on: a switch that is on is lit softly, the one thing that is in hand fully.
enum class Lit : uint8_t { off, soft, full };
/// Square. Shows the first two of `letters` where there is no icon of that name. Not `quiet`: with a ground of its own.
bool iconButton(const char* id, std::string_view icon, float size, Lit lit, std::string_view tip,
                std::string_view shortcut = {}, std::string_view letters = {}, bool quiet = true);
enum class Weight : uint8_t { plain, chief, danger };
/// Width 0: as its text needs; negative: all there is.
bool button(std::string_view text, Weight weight = Weight::plain, float width = 0, std::string_view icon = {});
/// The button of a dialog that Enter presses; one a dialog. While it is disabled Enter does nothing.
bool mainButton(std::string_view text, float width = 0, Weight weight = Weight::chief);
[[nodiscard]] float buttonWidth(std::string_view text, std::string_view icon = {});

/// Rows of a name and a switch at the right edge; true when it was turned.
bool toggle(std::string_view name, bool& on, std::string_view help = {});
/// Buttons side by side of which one is chosen; true when another one was.
bool segmented(const char* id, std::span<const std::string_view> names, int& chosen);
/// Returns 1 where the arrow down is pressed in this frame, −1 for the arrow up, else 0; repeats while it is held.
[[nodiscard]] int arrowStep();
/// A name and a list that folds out; arrows move within it, Enter chooses.
bool choice(std::string_view name, std::span<const std::string_view> names, int& chosen, std::string_view help = {});

struct Change {
  bool changed = false;  ///< The value is another one now.
  bool ended = false;    ///< The drag, or the typing, is over.
};
/// A name and a patch of colour (0xRRGGBB) that opens a picker.
Change colour(std::string_view name, double& value, std::string_view help = {});

struct Number {
  std::string_view id, name, help, unit;
  double low = 0, high = 1, standard = 0;
  bool logarithmic = false;
  std::string_view zero = {};  ///< Shown in place of the number 0.
  bool open = false;           ///< What is typed may lie beyond low and high.
};
/// A bar that is dragged (Shift: finely), typed into by a double click or Ctrl-click, and set back by the right button.
Change number(const Number& row, double& value, float width = 0);
/// One of them is being typed into.
[[nodiscard]] bool numberIsTyped();
/// Three or four digits that matter, without zeros at the end and without an exponent: "0.05", "12.5", "200".
[[nodiscard]] std::string written(double value);
/// "12.5", "12,5 mm", "1e-3". NaN for what is no number.
[[nodiscard]] double readNumber(const std::string& text);
/// "1 234 567".
[[nodiscard]] std::string counted(uint64_t count);
/// "1.2 MB".
[[nodiscard]] std::string bytes(uint64_t bytes);

/// A name on the left and a value on the right.
void fact(std::string_view name, std::string_view value, ImU32 colour = 0);
/// A line of text to be typed; true when Enter was pressed or it was left after a change.
bool textField(const char* id, std::string& text, float width, std::string_view hint = {}, bool focus = false);
/// A part of a whole, 0 to 1.
void bar(double part, float width, float height = 6);

/// "the device is felt" → "The device is felt."
[[nodiscard]] std::string sentence(std::string_view words);
/// A line in the border of the window, where its content does not reach.
void frameLine(ImVec2 from, ImVec2 to);
/// Sharp and smooth lines at any scale: for a draw list that is begun.
void sharpen(ImDrawList& list);

}  // namespace argil::studio::kit
