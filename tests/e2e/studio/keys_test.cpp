// Every key of the table of actions, pressed once by real events where it is offered: the window shows that it did
// something.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "tests/e2e/support/screen.h"
#include "ui3d/studio/panels/actions.h"

namespace argil::tests {
namespace {

class Keys : public OnScreen {
 protected:
  /// What a press changes is at least as large as a letter.
  static constexpr double kChanged = 4e-5;

  /// A palette row is worth a few more pictures than a key: used to bring about the state that a key needs.
  void place(Person& person, const std::string& what, double x, double y) {
    byPalette(person, "add a " + what);
    person.click(middleX() + x, middleY() + y);
    (void)person.settled();
  }
};

std::vector<std::string> wordsOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> list;
  for (std::string word; stream >> word;) {
    // A capital would be pressed with Shift.
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    list.push_back(word);
  }
  return list;
}

TEST_P(Keys, EveryOneInTheTableDoesSomethingWhereItIsOffered) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  // The state that an action needs, beyond a block with two planes of which the second is selected.
  std::map<std::string, std::function<void()>> first;
  first["draw.apply"] = first["draw.side"] = [&] {
    person.key("shift+c");
    person.ready();
    person.drag({{middleX() - 60, middleY() - 150}, {middleX() - 40, middleY()}, {middleX() - 60, middleY() + 150}});
  };
  first["tool.carve"] = [&] { person.key("a"); };
  first["edit.redo"] = [&] { person.key("ctrl+z"); };
  first["edit.showAll"] = [&] { person.key("h"); };
  first["piece.mask-clear"] = first["piece.mask-hide"] = [&] {
    person.key("ctrl+h");
    person.key("alt+m");
    person.key("ctrl+m");
  };
  first["piece.mask-show"] = [&] {
    first["piece.mask-hide"]();
    person.key("shift+h");
  };
  first["view.all"] = [&] { person.key("f"); };
  first["view.front"] = [&] { person.key("0"); };
  std::set<std::string> dead, pressed;
  const auto begin = [&] {
    byPalette(person, "add a block");
    (void)person.settled();
    place(person, "plane", -40, -20);
    place(person, "plane", 40, 20);
  };
  // A message alone, such as what stands in the way, is no effect.
  const auto look = [&] {
    render::Image seen = part(person.settled(), 0, 0, 1280, 690);  // Without the status line, and
    for (int y = int(540 * at().scale); y < seen.height; ++y)      // right of the tools without messages.
      for (int x = int(145 * at().scale); x < seen.width; ++x)
        std::fill_n(seen.rgba.begin() + 4 * (size_t(y) * size_t(seen.width) + size_t(x)), 4, uint8_t(0));
    return seen;
  };
  const auto press = [&](const studio::Action& action, const std::string& keys) {
    const render::Image before = look();
    person.key(keys);
    render::Image after = look();
    for (int i = 0; i < 4 && difference(before, after) < kChanged; ++i) after = look();
    if (difference(before, after) < kChanged) {
      dead.insert(action.id + " (" + keys + ")");
      (void)person.shot("dead-" + action.id);
    }
    pressed.insert(action.id);
  };
  begin();
  // A key that stands for nothing changes nothing: what is seen below comes from the keys.
  const render::Image rest = person.settled();
  person.key("ctrl+f11");
  ASSERT_LT(difference(rest, person.settled()), kChanged) << "the window changes by itself";

  // Those that leave the document as it is come first; what deletes or cuts comes last.
  std::vector<const studio::Action*> rows;
  for (const studio::Action& action : studio::actions())
    // A mouse has no motors to be stopped; what is copied is seen when it is pasted.
    if (!action.shortcut.empty() && action.id != "file.quit" && action.group != "Touch" && action.id != "edit.copy")
      rows.push_back(&action);
  const auto order = [](const studio::Action* a) {
    const std::string& id = a->id;
    return id.starts_with("draw.") || id == "edit.delete" ? 3
           : id.starts_with("piece.")                     ? 2
           : id.starts_with("edit.")                      ? 1
                                                          : 0;
  };
  std::stable_sort(rows.begin(), rows.end(), [&](const auto* a, const auto* b) { return order(a) < order(b); });
  int stage = 0;
  for (const studio::Action* action : rows) {
    // Neither locked nor hidden by a key before.
    if (order(action) > stage && (stage = order(action)) >= 2) byPalette(person, "add a block");
    for (const std::string& keys : wordsOf(action->shortcut)) {
      ASSERT_TRUE(studio.running()) << action->id << ": " << studio.said();
      if (const auto it = first.find(action->id); it != first.end()) it->second();
      press(*action, keys);
      // Dialogs, palettes and drawn curves are put away; full screen is left as it was entered.
      if (action->id == "window.fullScreen") person.key(keys);
      person.key("escape");
      if (order(action) == 2) {
        byPalette(person, "put the drawn curve away");
        person.key("escape");  // Where there is none the palette stays.
      }
    }
  }
  press(*studio::findAction("file.quit"), "ctrl+q");  // There is work that nobody has saved: it is asked about.
  std::string text;
  for (const std::string& each : dead) text += "\n  " + each;
  EXPECT_TRUE(dead.empty()) << "keys without an effect:" << text;
  EXPECT_GT(pressed.size(), 40u);
}

// Some hundred pictures that have to settle: minutes.
INSTANTIATE_TEST_SUITE_P(LongSizes, Keys, ::testing::Values(kSmallScreen), nameOf);

}  // namespace
}  // namespace argil::tests
