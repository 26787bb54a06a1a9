#pragma once
// Tests that are done on screens of several sizes.

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/e2e/support/command.h"
#include "tests/e2e/support/person.h"
#include "tests/support/x_server.h"

namespace argil::tests {

struct Screen {
  int width, height;  ///< Of the window, pixels.
  double scale;
  const char* name;
};

/// Has a server of its own with a window manager, and a folder; skipped where there is none.
class OnScreen : public ::testing::TestWithParam<Screen> {
 protected:
  void SetUp() override {
    if (const std::string missing = support::XServer::missing({.windowManager = true}); !missing.empty())
      GTEST_SKIP() << missing;
    // Room for the manager's frame.
    server_ = std::make_unique<support::XServer>(support::XServer::Options{at().width + 60, at().height + 80, true});
  }
  static Screen at() { return GetParam(); }
  /// Interface units.
  static double middleX() { return at().width / at().scale / 2; }
  static double middleY() { return at().height / at().scale / 2; }
  /// The studio's command line: first a file, where there is one.
  static std::vector<std::string> arguments(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"studio"};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--size", std::to_string(at().width) + "x" + std::to_string(at().height), "--scale",
                               std::to_string(at().scale)});
    return words;
  }
  /// What the palette finds first under these words is done.
  static void byPalette(Person& person, const std::string& words) {
    person.key("ctrl+p");
    person.ready();
    person.type(words);
    person.ready();
    person.key("enter");
    person.ready();
  }
  /// A busy machine may take so long for a picture that the one before counts as settled: waits for a picture that is
  /// another one.
  static render::Image other(const Person& person, const render::Image& before, double least) {
    render::Image now = person.settled();
    for (int i = 0; i < 100 && difference(before, now) <= least; ++i) now = person.settled();
    EXPECT_GT(difference(before, now), least);
    return now;
  }
  /// The settled picture for which `holds` is true, or the last one looked at: messages fade and previews arrive after
  /// the first picture that differs.
  template <class Holds>
  static render::Image until(const Person& person, const Holds& holds) {
    render::Image now = person.settled();
    for (int i = 0; i < 100 && !holds(now); ++i) now = person.settled();
    return now;
  }
  /// A part of a picture, interface units.
  static render::Image part(const render::Image& whole, double left, double top, double right, double bottom) {
    render::Image cut;
    const int x = int(left * at().scale), y = int(top * at().scale);
    cut.width = int(right * at().scale) - x;
    cut.height = int(bottom * at().scale) - y;
    for (int i = 0; i < cut.height; ++i)
      cut.rgba.insert(cut.rgba.end(), whole.pixel(x, y + i), whole.pixel(x, y + i) + 4 * cut.width);
    return cut;
  }

  Scratch scratch_;
  std::unique_ptr<support::XServer> server_;
};

inline std::string nameOf(const ::testing::TestParamInfo<Screen>& screen) {
  return std::string("on") + screen.param.name;
}

inline constexpr Screen kSmallScreen{1280, 720, 1, "720"}, kDenseScreen{2560, 1440, 2, "1440"};

}  // namespace argil::tests
