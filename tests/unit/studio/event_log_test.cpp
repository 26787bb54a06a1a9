// Recordings: what is written is read again; what is no recording is refused by line.

#include "ui3d/studio/input/event_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "clay/base/error.h"
#include "ui3d/studio/input/player.h"

namespace argil::studio {
namespace {

namespace fs = std::filesystem;
using Kind = Event::Kind;

class EventLog : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = fs::temp_directory_path() / ("argil-events-" + std::to_string(getpid()) + "-" +
                                         ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove(file_);
  }
  void TearDown() override { fs::remove(file_); }
  void write(const std::string& text) const { std::ofstream(file_) << text; }
  std::string refusal() const {
    try {
      (void)readEvents(file_);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), Error::Kind::input);
      return e.what();
    }
    return {};
  }
  fs::path file_;
};

Event ofKind(Kind kind) {
  Event e;
  e.kind = kind;
  e.timeS = 1.25;
  return e;
}

TEST_F(EventLog, EveryKindComesBackAsItWas) {
  for (int k = 0; k <= int(Kind::lose); ++k) {
    Event e = ofKind(Kind(k));
    const bool placed = e.kind == Kind::move || e.kind == Kind::press || e.kind == Kind::release ||
                        e.kind == Kind::wheel || e.kind == Kind::enter;
    if (placed) {
      e.x = 640.5f;
      e.y = -3.25f;
      e.pressure = 0.5f;
      e.tiltX = 0.25f;
      e.tiltY = -0.125f;
    }
    if (e.kind == Kind::press || e.kind == Kind::release) e.button = Button::middle;
    if (e.kind == Kind::wheel) e.dy = -2;
    if (e.kind == Kind::keyDown || e.kind == Kind::keyUp) {
      e.key = Key('Z');
      e.repeat = true;
      e.modifiers = kControl | kShift;
    }
    if (e.kind == Kind::text) e.character = 0x00B5;
    if (e.kind == Kind::resize) {
      e.width = 800;
      e.height = 600;
      e.scale = 1.5f;
    }
    if (e.kind == Kind::focus) e.on = true;
    if (e.kind == Kind::motion6) e.axes = {0.5f, 0, 0, -0.25f, 0, 1};
    if (e.kind == Kind::drop || e.kind == Kind::screenshot) e.text = "a \"folder\"/µ.stl";
    const Event back = fromLine(toLine(e));
    EXPECT_EQ(back.kind, e.kind);
    EXPECT_EQ(back.timeS, e.timeS);
    EXPECT_EQ(back.x, e.x) << toLine(e);
    EXPECT_EQ(back.y, e.y);
    EXPECT_EQ(back.dy, e.dy);
    EXPECT_EQ(back.pressure, e.pressure);
    EXPECT_EQ(back.tiltX, e.tiltX);
    EXPECT_EQ(back.tiltY, e.tiltY);
    EXPECT_EQ(back.button, e.button);
    EXPECT_EQ(back.modifiers, e.modifiers);
    EXPECT_EQ(back.key, e.key);
    EXPECT_EQ(back.repeat, e.repeat);
    EXPECT_EQ(back.on, e.on);
    EXPECT_EQ(back.character, e.character);
    EXPECT_EQ(back.width, e.width);
    EXPECT_EQ(back.height, e.height);
    EXPECT_EQ(back.scale, e.scale);
    EXPECT_EQ(back.axes, e.axes);
    EXPECT_EQ(back.text, e.text);
  }
}

TEST_F(EventLog, EveryKeyHasANameOfItsOwn) {
  for (int k = 33; k <= int(Key::super); ++k) {
    const bool named = k < 127 || (k >= int(Key::escape) && k <= int(Key::end)) ||
                       (k >= int(Key::f1) && k <= int(Key::f12)) ||
                       (k >= int(Key::keypad0) && k <= int(Key::keypad9)) || k >= int(Key::shift);
    if (!named) continue;
    Event e = ofKind(Kind::keyDown);
    e.key = Key(k);
    EXPECT_EQ(fromLine(toLine(e)).key, Key(k)) << toLine(e);
  }
}

TEST_F(EventLog, ABadLineIsNamedByItsNumber) {
  for (const char* line :
       {"{\"t\": 2, \"kind\": \"jump\"}", "{\"t\": 2}", "nonsense", "[]",
        "{\"t\": 2, \"kind\": \"move\", \"x\": \"left\"}", "{\"t\": 2, \"kind\": \"move\", \"x\": 1e300}",
        "{\"t\": 2, \"kind\": \"down\", \"key\": \"any\"}", "{\"t\": 2, \"kind\": \"press\", \"button\": \"fourth\"}",
        "{\"t\": 2, \"kind\": \"motion6\", \"axes\": [1, 2]}",
        "{\"t\": 2, \"kind\": \"press\", \"modifiers\": [\"hyper\"]}", "{\"t\": 0.5, \"kind\": \"check\"}",
        "{\"t\": 2, \"kind\": \"resize\", \"width\": 99999}", "{\"t\": 2, \"kind\": \"move\", \"pressure\": 2}",
        "{\"t\": 2, \"kind\": \"text\", \"character\": -1}"}) {
    write(std::string("# A recording\n{\"t\": 1, \"kind\": \"move\", \"x\": 1, \"y\": 2}\n\n") + line + "\n");
    EXPECT_THAT(refusal(), ::testing::HasSubstr(file_.string() + ":4: ")) << line;
  }
  write("{\"t\": 1, \"kind\": \"move\"}\n");
  EXPECT_EQ(refusal(), "");
  fs::remove(file_);
  EXPECT_THAT(refusal(), ::testing::HasSubstr("cannot be read"));
}

TEST_F(EventLog, IsReadAtEveryLengthWithoutHarm) {
  const std::string whole = toLine(ofKind(Kind::motion6)) + "\n" + toLine(ofKind(Kind::press)) + "\n";
  for (size_t length = 0; length <= whole.size(); ++length) {
    write(whole.substr(0, length));
    try {
      EXPECT_LE(readEvents(file_).size(), 2u);
    } catch (const Error&) {
    }
  }
}

TEST_F(EventLog, ARecordingIsNotWrittenOver) {
  { EventWriter(file_).write(ofKind(Kind::check)); }
  EXPECT_EQ(readEvents(file_).size(), 1u);
  EXPECT_THROW(EventWriter{file_}, Error);
}

TEST_F(EventLog, PlaysAtItsTimesAndStopsAtChecks) {
  write(R"({"t": 0, "kind": "move", "x": 1}
{"t": 1, "kind": "move", "x": 2}
{"t": 1, "kind": "check"}
{"t": 1.5, "kind": "move", "x": 3}
)");
  Player player(file_);
  std::vector<Event> events;
  player.poll(0.5, events);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(player.nextS(), 1);
  player.poll(1.1, events);
  ASSERT_EQ(events.size(), 2u);
  ASSERT_NE(player.waiting(), nullptr);
  EXPECT_EQ(player.waiting()->kind, Kind::check);
  player.poll(30, events);
  EXPECT_EQ(events.size(), 2u) << "nothing passes a check";
  EXPECT_FALSE(player.stuck(30));
  EXPECT_TRUE(player.stuck(1.2 + Player::kCheckSeconds));
  player.passed(31);
  EXPECT_EQ(player.waiting(), nullptr);
  EXPECT_EQ(player.nextS(), 31.5) << "the recording's clock stood still meanwhile";
  player.poll(32, events);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events.back().timeS, 31.5);
  EXPECT_TRUE(player.over());
}

TEST_F(EventLog, PlaysSoManyTimesAsFast) {
  write(R"({"t": 1, "kind": "move", "x": 1}
{"t": 20, "kind": "check"}
{"t": 60, "kind": "move", "x": 2}
)");
  Player player(file_, 20);
  std::vector<Event> events;
  EXPECT_EQ(player.nextS(), 0.05);
  player.poll(1, events);
  ASSERT_EQ(events.size(), 1u);
  ASSERT_NE(player.waiting(), nullptr);
  player.passed(5);
  EXPECT_EQ(player.nextS(), 7) << "two seconds after the check, which took four";
}

}  // namespace
}  // namespace argil::studio
