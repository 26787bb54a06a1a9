// A person's way through the studio, in a real window, by real mouse and keys.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "../cli/command.h"
#include "person.h"
#include "tests/support/x_server.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

struct Screen {
  int width, height;
  double scale;
  const char* name;
};

class Studio : public ::testing::TestWithParam<Screen> {
 protected:
  void SetUp() override {
    if (const std::string missing = testing::XServer::missing({.windowManager = true}); !missing.empty()) GTEST_SKIP() << missing;
  }
  // Room for the manager's frame.
  void screen(int width, int height) { server_ = std::make_unique<testing::XServer>(testing::XServer::Options{width + 60, height + 80, true}); }
  static std::string size(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }
  Json report() const { return Json::parse(slurp(scratch_ / "report.json"), nullptr, false); }

  Scratch scratch_;
  std::unique_ptr<testing::XServer> server_;
};

// Volume and topology of a file that was exported, as `argil inspect` sees them.
Json inspected(const fs::path& file) {
  const Outcome o = argil({"inspect", file.string(), "--json"});
  EXPECT_EQ(o.code, 0) << o.err;
  return Json::parse(o.out, nullptr, false);
}

std::vector<std::array<double, 2>> wave(double x, double y, double width, double height) {
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i <= 24; ++i) points.push_back({x + width * i / 24, y + height * std::sin(i / 4.0)});
  return points;
}

TEST_P(Studio, fromAnEmptyWindowToThreeFiles) {
  const Screen s = GetParam();
  screen(s.width, s.height);
  RunningStudio studio({"studio", "--size", size(s.width, s.height), "--scale", std::to_string(s.scale), "--validate", "--report", "report.json", "--record", "events.jsonl"},
                       scratch_.path());
  Person person(studio, s.scale);
  const auto shot = [&](const std::string& step) { return person.shot(std::string(s.name) + "-" + step); };
  const double x = s.width / s.scale / 2, y = s.height / s.scale / 2;  // The middle of the block's upper face is a little above.
  shot("01-start");

  // A block, by the palette.
  person.key("ctrl+p");
  person.pause(0.5);
  person.type("add a block");
  person.pause(0.5);
  person.key("enter");
  const render::Image block = shot("02-block");

  person.key("c");
  person.drag(wave(x - 110, y - 60, 190, 14));
  const render::Image carved = shot("03-carve");
  EXPECT_GT(difference(block, carved), 0.002);
  person.key("a");
  person.drag(wave(x - 60, y - 110, 130, 8));
  const render::Image added = shot("04-add");
  EXPECT_GT(difference(carved, added), 0.002);
  person.key("s");
  person.drag(wave(x - 110, y - 55, 190, 14));
  const render::Image smoothed = shot("05-smooth");
  EXPECT_GT(difference(added, smoothed), 0.0005);

  person.key("x");
  person.key("c");
  person.drag({{x + 60, y + 40}, {x + 20, y + 90}});
  const render::Image mirrored = shot("06-symmetry");
  person.key("x");
  EXPECT_GT(difference(smoothed, mirrored), 0.001);

  for (int i = 0; i < 3; ++i) person.key("ctrl+z");
  shot("07-undone");
  for (int i = 0; i < 3; ++i) person.key("ctrl+shift+z");
  shot("08-redone");

  // A plane where the clay is clicked; a stroke along it.
  person.key("ctrl+p");
  person.pause(0.5);
  person.type("add a plane");
  person.pause(0.5);
  person.key("enter");
  person.pause(0.5);
  shot("09-placing");
  person.click(x - 40, y - 40);
  shot("10-plane");
  person.drag(wave(x - 90, y - 20, 150, 6));
  shot("11-along-the-plane");

  // A second piece, and the first hidden.
  person.key("ctrl+e");
  person.pause(0.5);
  shot("12-export");
  person.key("escape");
  person.pause(0.3);

  person.key("ctrl+q");
  person.pause(0.5);
  shot("13-leave");
  person.key("escape");
  person.close();
  person.pause(0.5);
  shot("14-leave-again");
}

INSTANTIATE_TEST_SUITE_P(Sizes, Studio, ::testing::Values(Screen{1280, 720, 1, "720"}, Screen{2560, 1440, 2, "1440"}),
                         [](const auto& screen) { return std::string("on") + screen.param.name; });

}  // namespace
}  // namespace argil::tests
