// What a day of work does to the studio: sizes, documents, lost devices. Recordings and the window manager.

#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "tests/e2e/support/command.h"
#include "tests/e2e/support/person.h"
#include "tests/support/x_server.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kMebi = 1 << 20;

class StudioSession : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string missing = support::XServer::missing({.windowManager = true}); !missing.empty())
      GTEST_SKIP() << missing;
    server_ = std::make_unique<support::XServer>(support::XServer::Options{1400, 900, true});
  }
  [[nodiscard]] Json report() const { return Json::parse(slurp(scratch_ / "report.json"), nullptr, false); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(scratch_ / name) << text;
    return scratch_ / name;
  }
  // Lines of a recording: what the palette finds under these words is done.
  static std::string byPalette(double& t, const std::string& words) {
    std::string lines;
    const auto line = [&](const Json& more) {
      Json e = {{"t", std::round(t * 1000) / 1000}};
      e.update(more);
      lines += e.dump() + "\n";
      t += 0.02;
    };
    line({{"kind", "down"}, {"key", "P"}, {"modifiers", {"ctrl"}}});
    line({{"kind", "up"}, {"key", "P"}});
    for (const char c : words) line({{"kind", "text"}, {"character", int(c)}});
    line({{"kind", "down"}, {"key", "enter"}});
    line({{"kind", "up"}, {"key", "enter"}});
    line({{"kind", "check"}});
    return lines;
  }
  static void expectClean(const Json& report) {
    ASSERT_TRUE(report.is_object());
    if (!report["validating"].get<bool>()) return;
    EXPECT_EQ(report["validation_messages"].size(), 0u) << report["validation_messages"].dump(1);
  }
  // Until the file is there.
  static bool waitFor(RunningStudio& studio, const fs::path& file, double seconds) {
    for (int i = 0; i < int(seconds * 20) && studio.running(); ++i) {
      if (fs::exists(file)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return fs::exists(file);
  }

  Scratch scratch_;
  std::unique_ptr<support::XServer> server_;
};

using StudioCalls = StudioSession;
using LongStudio = StudioSession;

TEST_F(StudioCalls, ABadRecordingIsNamedByItsLine) {
  const Outcome o =
      argil({"studio", "--play",
             write("bad.jsonl", "{\"t\": 0, \"kind\": \"check\"}\n{\"t\": 1, \"kind\": \"jump\"}\n").string()});
  EXPECT_EQ(o.code, 2);
  EXPECT_NE(o.err.find("bad.jsonl:2: "), std::string::npos) << o.err;
  const Outcome none = argil({"studio", (scratch_ / "nothing.stl").string()});
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("nothing.stl"), std::string::npos) << none.err;
}

TEST_F(StudioCalls, WithoutADisplayOneLineSaysWhatToDo) {
  unsetenv("DISPLAY");
  const Outcome o = argil({"studio"});
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("argil sculpt"), std::string::npos) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}

TEST_F(StudioCalls, WithoutAWindowManagerKeysArriveAtTheWindowThatIsClicked) {
  server_ = nullptr;
  server_ = std::make_unique<support::XServer>(support::XServer::Options{1400, 900, false});
  RunningStudio studio({"studio", "--size", "1000x700"}, scratch_.path());
  Person person(studio);
  const render::Image before = person.settled();
  person.click(600, 300);
  person.ready();
  person.key("ctrl+p");
  EXPECT_GT(difference(before, person.settled()), 0.05) << "the palette";
  person.key("escape");
  person.close();
  EXPECT_EQ(studio.wait(30), 0) << studio.said();
}

// A recording drives the window, loses the device on the way, and the picture is the same again.
TEST_F(StudioCalls, ALostDeviceComesBackWithTheSamePicture) {
  double t = 0.2;
  std::string lines = byPalette(t, "add a block");
  const auto add = [&](const std::string& kind, const std::string& more = "") {
    lines += "{\"t\": " + std::to_string(t) + ", \"kind\": \"" + kind + "\"" + more + "}\n";
    t += 0.05;
  };
  add("move", ", \"x\": 560, \"y\": 330");
  add("press", ", \"x\": 560, \"y\": 330");
  for (int i = 0; i < 40; ++i) {
    t -= 0.04;
    add("move", ", \"x\": " + std::to_string(560 + 3 * i) + ", \"y\": 330");
  }
  add("release", ", \"x\": 677, \"y\": 330");
  add("move", ", \"x\": 400, \"y\": 640");
  add("check");
  add("screenshot", ", \"text\": \"before.png\"");
  add("lose");
  add("move", ", \"x\": 401, \"y\": 640");
  add("check");
  add("screenshot", ", \"text\": \"after.png\"");
  const fs::path recording = write("lose.jsonl", lines);
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1", "--play", recording.string(), "--report",
                        "report.json", "--validate"},
                       scratch_.path());
  ASSERT_EQ(studio.wait(200), 0) << studio.said();
  const Json r = report();
  EXPECT_EQ(r["device_losses"], 1);
  EXPECT_EQ(r["strokes"], 1);
  expectClean(r);
  // The middle, where no message stands.
  const auto middle = [](const render::Image& whole) {
    render::Image part;
    part.width = 600;
    part.height = 500;
    for (int y = 0; y < part.height; ++y)
      part.rgba.insert(part.rgba.end(), whole.pixel(320, 90 + y), whole.pixel(320, 90 + y) + 4 * part.width);
    return part;
  };
  EXPECT_LT(difference(middle(readPng(scratch_ / "before.png")), middle(readPng(scratch_ / "after.png"))), 0.001);
}

TEST_F(StudioCalls, LeavingWithWorkThatIsNotKeptAsks) {
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1"}, scratch_.path());
  Person person(studio);
  for (int i = 0; i < 2; ++i) {
    person.key("ctrl+p");
    person.ready();
    person.type("add a ball");
    person.key("enter");
    (void)person.settled();
  }
  const render::Image before = person.settled();
  person.close();
  render::Image asked = person.shot("leave-asked");
  for (int i = 0; i < 20 && difference(before, asked) <= 0.3; ++i) asked = person.settled();
  EXPECT_GT(difference(before, asked), 0.3) << "everything behind the question is dimmed";
  person.key("escape");
  // A busy machine may take so long for a picture that the old one counts as settled.
  double away = 1;
  for (int i = 0; i < 20 && away >= 0.02; ++i) away = difference(before, person.settled());
  EXPECT_LT(away, 0.02);
  EXPECT_TRUE(studio.running());
  kill(studio.pid(), SIGTERM);  // Ctrl-C on the terminal: a decision already.
  EXPECT_EQ(studio.wait(30), 0) << studio.said();
}

TEST_F(StudioCalls, AtRestNothingIsDrawn) {
  fs::create_directories(scratch_ / "argil");
  write("argil/studio.json", R"({"quality":{"supersample":1,"key_shadow":false,"cavity":false}})");  // 60 a second
  double t = 0.2;
  std::string lines = byPalette(t, "add a ball");
  lines += "{\"t\": " + std::to_string(t + 8) + ", \"kind\": \"check\"}\n";
  RunningStudio studio(
      {"studio", "--size", "800x600", "--play", write("rest.jsonl", lines).string(), "--report", "report.json"},
      scratch_.path());
  ASSERT_EQ(studio.wait(150), 0) << studio.said();
  // Of 8 s, 480 could have been drawn. What is drawn: the palette's letters, the ball's coming, numbers that settle.
  EXPECT_LT(report()["frames"], 40) << report().dump(1);
  // What a picture took is told with the next one of the clay: panels that follow it are drawn once.
  EXPECT_LE(report()["frames_since_clay"], 3) << report().dump(1);
}

// What pictures cost is the machine's affair; all else of a recording begins as a first day does, and nothing is kept.
TEST_F(StudioCalls, ARecordingIsPlayedInThePicturesOfTheMachine) {
  const std::string settings =
      R"({"quality":{"supersample":1,"key_shadow":false,"cavity":false,"frames_per_second":5},"theme":"light"})";
  fs::create_directories(scratch_ / "argil");
  write("argil/studio.json", settings);
  double t = 0.2;
  std::string lines = byPalette(t, "add a ball");
  const auto line = [&](Json e) {
    e["t"] = t += 0.02;
    lines += e.dump() + "\n";
  };
  line({{"kind", "press"}, {"x", 400}, {"y", 300}, {"button", "right"}});
  for (int i = 1; i <= 150; ++i) line({{"kind", "move"}, {"x", 400 + i}, {"y", 300}});
  line({{"kind", "release"}, {"x", 550}, {"y", 300}, {"button", "right"}});
  line({{"kind", "screenshot"}, {"text", (scratch_ / "turned.png").string()}});
  RunningStudio studio(
      {"studio", "--size", "800x600", "--play", write("turn.jsonl", lines).string(), "--report", "report.json"},
      scratch_.path());
  ASSERT_EQ(studio.wait(100), 0) << studio.said();
  EXPECT_GT(report()["clay_frames"], 5) << "the view turned";
  EXPECT_LT(report()["frames"], 40) << "60 a second would be 180";
  const render::Image turned = readPng(scratch_ / "turned.png");
  ASSERT_GT(turned.width, 30);
  EXPECT_LT(turned.pixel(turned.width - 20, turned.height - 20)[0], 100) << "dark, as on a first day";
  EXPECT_EQ(slurp(scratch_ / "argil" / "studio.json"), settings);
}

// A quick hand, or a slow machine: all of it comes between two pictures. Letters go where the keys before them say.
TEST_F(StudioCalls, WhatIsTypedAtOnceArrivesWhole) {
  double t = 0.2;
  std::string lines;
  for (int i = 0; i < 3; ++i) {
    std::istringstream typed(byPalette(t, i == 1 ? "add a block" : "add a ball"));
    for (std::string each; std::getline(typed, each);) {
      Json e = Json::parse(each);
      e["t"] = 1.0 + i;
      lines += e.dump() + "\n";
    }
  }
  RunningStudio studio({"studio", "--size", "800x600", "--scale", "1", "--play", write("typed.jsonl", lines).string(),
                        "--report", "report.json"},
                       scratch_.path());
  ASSERT_EQ(studio.wait(100), 0) << studio.said();
  EXPECT_EQ(report()["steps"], 3) << "a block and two balls";
}

TEST_F(LongStudio, AThousandSizesAndFiftyTimesMinimised) {
  RunningStudio studio({"studio", "--size", "1000x700", "--scale", "1", "--report", "report.json", "--validate"},
                       scratch_.path());
  Person person(studio);
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  const auto sizes = [&](int count) {
    for (int i = 0; i < count; ++i) {
      person.resize(int(640 + random() % 700), int(400 + random() % 440));
      person.pause(0.02);
    }
    person.resize(1000, 700);
    (void)person.settled();
  };
  const auto minimised = [&](int count) {
    for (int i = 0; i < count; ++i) {
      person.minimise();
      person.pause(0.05);
      person.restore();
      person.pause(0.05);
    }
    (void)person.settled();
  };
  // The driver's heap takes its time to settle: the second half is judged.
  std::vector<uint64_t> resident;
  for (int i = 0; i < 4; ++i) {
    sizes(250);
    minimised(13);
    resident.push_back(studio.residentBytes());
    std::printf("after %d sizes: %lu MiB\n", 250 * (i + 1), static_cast<unsigned long>(resident.back() / kMebi));
  }
  person.close();
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
  EXPECT_LT(resident[3], resident[1] + 32 * kMebi) << "seed " << kSeed;
  expectClean(report());
}

TEST_F(LongStudio, AHundredDocumentsLeaveNothingBehind) {
  double t = 0.2;
  std::string lines;
  for (int i = 0; i < 100; ++i) {
    lines += "{\"t\": " + std::to_string(t) + ", \"kind\": \"down\", \"key\": \"N\", \"modifiers\": [\"ctrl\"]}\n";
    lines += "{\"t\": " + std::to_string(t += 0.05) + ", \"kind\": \"up\", \"key\": \"N\"}\n";
    // D: don't save.
    if (i > 0) lines += "{\"t\": " + std::to_string(t += 0.2) + ", \"kind\": \"text\", \"character\": 100}\n";
    lines += "{\"t\": " + std::to_string(t += 0.05) + ", \"kind\": \"check\"}\n";
    lines += byPalette(t, i % 2 ? "add a block" : "add a ball");
    if (i == 19 || i == 99)
      lines += "{\"t\": " + std::to_string(t) + ", \"kind\": \"screenshot\", \"text\": \"at" + std::to_string(i + 1) +
               ".png\"}\n";
  }
  lines += "{\"t\": " + std::to_string(t + 3) + ", \"kind\": \"check\"}\n";
  RunningStudio studio({"studio", "--size", "800x600", "--scale", "1", "--play",
                        write("documents.jsonl", lines).string(), "--report", "report.json", "--validate"},
                       scratch_.path());
  ASSERT_TRUE(waitFor(studio, scratch_ / "at20.png", 300)) << studio.said();
  const uint64_t before = studio.residentBytes();
  ASSERT_TRUE(waitFor(studio, scratch_ / "at100.png", 600)) << studio.said();
  const uint64_t after = studio.residentBytes();
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
  EXPECT_LT(after, before + 96 * kMebi) << before / kMebi << " MiB after 20 documents";
  expectClean(report());
}

// An hour of strokes, turns, undo, menus, the palette, operations and saves, played twenty times as fast. The clay
// comes behind the hand; the window's thread answers all the while.
TEST_F(LongStudio, AnHourOfMixedWorkNeverHoldsUpTheWindow) {
  constexpr unsigned kSeed = 16;
  constexpr double kHourS = 3600, kX = 640, kY = 360;
  std::mt19937 random(kSeed);
  const auto between = [&](double low, double high) { return low + (high - low) * double(random() % 10001) / 10000; };
  double t = 0.2;
  std::string lines = byPalette(t, "add a block");
  const auto line = [&](const char* kind, const Json& more = Json::object(), double seconds = 0.02) {
    Json e = {{"t", std::round(t * 1000) / 1000}, {"kind", kind}};
    e.update(more);
    lines += e.dump() + "\n";
    t += seconds;
  };
  const auto at = [&](const char* kind, double x, double y, const Json& more = Json::object()) {
    Json place = {{"x", std::round(x * 10) / 10}, {"y", std::round(y * 10) / 10}};
    place.update(more);
    line(kind, place, 1.0 / 60);
  };
  const auto key = [&](const char* name, const std::vector<std::string>& held = {}) {
    Json more = {{"key", name}};
    if (!held.empty()) more["modifiers"] = held;
    line("down", more);
    line("up", {{"key", name}});  // Nothing is held any more: letters after it are letters.
  };
  const auto drag = [&](double seconds, const char* button, const std::vector<std::string>& held = {}) {
    double x = kX + between(-80, 80), y = kY + between(-60, 60), heading = between(0, 6.28);
    const double speed = between(1, 5);
    Json more = {{"button", button}};
    if (!held.empty()) more["modifiers"] = held;
    at("move", x, y);
    at("press", x, y, more);
    for (int i = 0; i < int(60 * seconds); ++i) {
      heading += between(-0.3, 0.3);
      if (std::hypot(x - kX, y - kY) > 110) heading = std::atan2(kY - y, kX - x);
      x += speed * std::cos(heading), y += speed * std::sin(heading);
      at("move", x, y);
    }
    at("release", x, y, more);
  };
  int strokes = 0;
  double savedS = 0, jobS = 0, checkedS = 0;
  while (t < kHourS) {
    const double dice = between(0, 1);
    if (dice < 0.5) {
      constexpr std::array kTools = {"C", "A", "W", "S", "P"};
      key(kTools[random() % kTools.size()]);
      const double turn = between(0, 1);
      drag(between(0.5, 4), "left",
           turn < 0.15  ? std::vector<std::string>{"shift"}
           : turn < 0.3 ? std::vector<std::string>{"ctrl"}
                        : std::vector<std::string>{});
      ++strokes;
    } else if (dice < 0.65) {
      drag(between(0.3, 1.5), "right");
    } else if (dice < 0.7) {
      for (int i = 0; i < 4; ++i) line("wheel", {{"x", kX}, {"y", kY}, {"dx", 0}, {"dy", i < 2 ? 1 : -1}}, 0.1);
    } else if (dice < 0.8) {
      for (unsigned i = 1 + random() % 3; i > 0; --i)
        key("Z", between(0, 1) < 0.6 ? std::vector<std::string>{"ctrl"} : std::vector<std::string>{"ctrl", "shift"});
    } else if (dice < 0.9) {
      for (int i = 0; i < 30; ++i) at("move", between(10, 340), between(80, 680));
    } else if (dice < 0.95) {
      at("move", 23, 14);
      at("press", 23, 14, {{"button", "left"}});
      at("release", 23, 14, {{"button", "left"}});
      t += 0.5;
      key("escape");
    } else {
      key("P", {"ctrl"});
      for (const char c : std::string("mirror")) line("text", {{"character", int(c)}}, 0.1);
      t += 0.5;
      key("escape");
    }
    t += between(0.2, 2);
    if (t - jobS > 400) {
      key("home");
      lines += byPalette(t, random() % 2 ? "add a ball" : "duplicate");
      jobS = t;
    }
    if (t - savedS > 600) {
      key("S", {"ctrl"});
      line("check");  // The dialog is there, however slow the machine is.
      if (savedS == 0) {
        for (const char c : (scratch_ / "hour").string()) line("text", {{"character", int(c)}});
        line("check");
        key("enter");
        line("check");
      }
      savedS = t;
    }
    if (t - checkedS > 60) {
      key("home");  // The view has turned away from the clay now and then.
      line("check");
      checkedS = t;
    }
  }
  line("check");
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1", "--play", write("hour.jsonl", lines).string(),
                        "--speed", "20", "--report", "report.json"},
                       scratch_.path());
  ASSERT_EQ(studio.wait(3600), 0) << studio.said();
  const Json r = report();
  std::printf("%d strokes drawn, %s done; the window's thread, ms: by the clock %s, of its own work %s\n", strokes,
              r["strokes"].dump().c_str(), r["turn_ms"].dump().c_str(), r["turn_core_ms"].dump().c_str());
  EXPECT_GT(r["strokes"], strokes / 4) << "most strokes found clay";
  EXPECT_TRUE(fs::exists(scratch_ / "hour.argil"));
  EXPECT_EQ(r["turn_core_ms"]["over_100_ms"], 0) << "seed " << kSeed << ": " << r["turn_core_ms"].dump();
}

// A minute's scribble of the slowest kind: the picture follows, nothing is dropped, and it is done soon after the hand.
TEST_F(LongStudio, AMinuteOfInflateIsFollowed) {
  double t = 0.2;
  std::string lines = byPalette(t, "add a ball");
  lines += byPalette(t, "inflate");
  const auto at = [&](const char* kind, double x, double y, const Json& more = Json::object()) {
    Json e = {{"t", std::round(t * 1000) / 1000},
              {"kind", kind},
              {"x", std::round(x * 10) / 10},
              {"y", std::round(y * 10) / 10}};
    e.update(more);
    lines += e.dump() + "\n";
    t += 1.0 / 60;
  };
  for (int i = 0; i < 12; ++i) {  // A tip of 15 mm and more.
    lines += "{\"t\": " + std::to_string(t) +
             ", \"kind\": \"down\", \"key\": \"]\"}\n{\"t\": " + std::to_string(t + 0.01) +
             ", \"kind\": \"up\", \"key\": \"]\"}\n";
    t += 0.05;
  }
  at("move", 640, 360);
  at("press", 640, 360, {{"button", "left"}});
  for (int i = 0; i < 3600; ++i) at("move", 640 + 80 * std::sin(0.0437 * i), 360 + 70 * std::sin(0.0291 * i));
  at("release", 640, 360, {{"button", "left"}});
  at("move", 400, 640);
  lines += "{\"t\": " + std::to_string(t) + ", \"kind\": \"check\"}\n";
  lines += "{\"t\": " + std::to_string(t) + ", \"kind\": \"screenshot\", \"text\": \"swollen.png\"}\n";
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1", "--play",
                        write("inflate.jsonl", lines).string(), "--report", "report.json"},
                       scratch_.path());
  ASSERT_EQ(studio.wait(400), 0) << studio.said();  // A check waits a minute at most.
  if (const char* folder = std::getenv("ARGIL_SHOTS"))
    fs::copy_file(scratch_ / "swollen.png", fs::path(folder) / "swollen.png", fs::copy_options::overwrite_existing);
  const Json r = report();
  std::printf("from sample to screen, ms: %s\n", r["sample_to_screen_ms"].dump().c_str());
  EXPECT_EQ(r["strokes"], 1);
  EXPECT_EQ(r["dropped_samples"], 0);
  EXPECT_GT(r["clay_frames"], 60) << "the clay is shown while it swells";
}

}  // namespace
}  // namespace argil::tests
