// Work is kept: saved by name, asked about before it goes, recovered after a crash. By mouse and keys, in a real
// window.

#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/e2e/support/screen.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

class Keeping : public OnScreen {
 protected:
  std::unique_ptr<RunningStudio> studio(const std::vector<std::string>& more = {}) {
    return std::make_unique<RunningStudio>(arguments(more), scratch_.path());
  }
  render::Image shot(Person& person, const std::string& step) {
    return person.shot(std::string("keep-") + at().name + "-" + step);
  }

  static render::Image addBlock(Person& person) {
    const render::Image before = person.settled();
    byPalette(person, "add a block");
    return other(person, before, 0.05);
  }
  static void question(Person& person) {
    const render::Image before = person.settled();
    person.close();
    (void)other(person, before, 0.3);  // Everything behind it is dimmed.
  }
  // No cursor in the picture.
  static void offTheClay(Person& person) { person.move(middleX() - 250, middleY() + 240); }
  void carve(Person& person, double y) {
    const render::Image before = person.settled();
    person.key("c");
    std::vector<std::array<double, 2>> points;
    for (int i = 0; i <= 24; ++i)
      points.push_back({middleX() - 110 + 190.0 * i / 24, middleY() + y + 14 * std::sin(i / 4.0)});
    person.drag(points);
    offTheClay(person);
    EXPECT_GT(difference(clay(before), clay(other(person, before, 0.0002))), 0.0002);
  }
  // The clay, without panels and messages.
  static render::Image clay(const render::Image& whole) { return part(whole, 385, 110, 920, 570); }
  // A busy machine may take so long for a picture that the one before counts as settled.
  static void expectSame(const Person& person, const render::Image& wanted, const std::string& what) {
    double away = 1;
    for (int i = 0; i < 20 && away >= 0.01; ++i) away = difference(clay(wanted), clay(person.settled()));
    EXPECT_LT(away, 0.01) << what;
  }
  static constexpr std::array<uint8_t, 3> kAccent{0x74, 0xb6, 0xe2};  // Of the dark theme.
  // The middle of the dialog's chief button; `left`: of the one so many places to the left of it, all 96 wide.
  static std::array<double, 2> button(const Person& person, int left) {
    const render::Image image = person.settled();
    const int least = int(80 * at().scale);
    for (int y = 0; y < image.height; ++y) {
      for (int x = image.width / 3, run = 0; x < image.width; ++x) {
        const uint8_t* p = image.pixel(x, y);
        run = p[0] == kAccent[0] && p[1] == kAccent[1] && p[2] == kAccent[2] ? run + 1 : 0;
        if (run >= least) return {(x - run / 2) / at().scale - 102.0 * left, y / at().scale + 12};
      }
    }
    ADD_FAILURE() << "no chief button";
    return {0, 0};
  }
  static bool appears(const fs::path& file) {
    for (int i = 0; i < 600; ++i) {
      if (fs::exists(file)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  std::set<std::string> journals() const {
    std::set<std::string> found;
    std::error_code none;
    for (const auto& entry : fs::recursive_directory_iterator(scratch_ / "state", none))
      if (entry.is_regular_file()) found.insert(entry.path().string());
    return found;
  }
  // Until nothing more is written for a second: half a second after a step it is kept.
  void journalRests(const Person& person) const {
    const auto bytes = [&] {
      uintmax_t sum = 0;
      for (const std::string& file : journals()) {
        std::error_code gone;
        const uintmax_t size = fs::file_size(file, gone);
        sum += gone ? 0 : size;
      }
      return sum;
    };
    uintmax_t last = bytes();
    for (int still = 0, looks = 0; (still < 20 || last == 0) && looks < 1000; ++looks) {
      person.pause(0.05);
      const uintmax_t now = bytes();
      still = now == last ? still + 1 : 0;
      last = now;
    }
  }
};

TEST_P(Keeping, SavedAskedAboutAndOpenedAgain) {
  const fs::path file = scratch_ / "head.argil";
  render::Image carvedTwice;
  {
    const auto running = studio();
    Person person(*running, at().scale);
    shot(person, "01-start");
    (void)addBlock(person);
    carve(person, -60);
    shot(person, "02-not-saved");
    person.key("ctrl+s");
    person.ready();
    shot(person, "03-save-as");
    person.type(file.string());
    person.key("enter");
    ASSERT_TRUE(appears(file)) << running->said();
    shot(person, "04-saved");
    EXPECT_TRUE(running->running());
    carve(person, -10);
    carvedTwice = shot(person, "05-changed");
    // Cancel, then Save.
    question(person);
    shot(person, "06-question");
    person.key("escape");
    expectSame(person, carvedTwice, "cancelled");
    ASSERT_TRUE(running->running());
    question(person);
    person.key("enter");
    EXPECT_EQ(running->wait(60), 0) << running->said();
  }
  EXPECT_TRUE(journals().empty()) << "a journal was left by a document that was saved: " << *journals().begin();
  {
    const auto running = studio({file.string()});
    Person person(*running, at().scale);
    const render::Image again = shot(person, "07-opened-again");
    expectSame(person, carvedTwice, "opened again");
    // Nothing was done: nothing is asked.
    person.close();
    EXPECT_EQ(running->wait(60), 0) << running->said();
  }
  {
    const auto running = studio();
    Person person(*running, at().scale);
    const render::Image before = person.settled();
    person.key("ctrl+shift+o");
    (void)other(person, before, 0.3);
    shot(person, "08-recent");
    person.click(middleX() - 100, middleY() - 4);
    offTheClay(person);
    shot(person, "09-opened-by-the-list");
    expectSame(person, carvedTwice, "opened by the list");
    person.close();
    EXPECT_EQ(running->wait(60), 0) << running->said();
  }
}

TEST_P(Keeping, ACrashIsRecoveredOrThrownAway) {
  render::Image carved;
  const auto crash = [&](const std::string& step) {
    const auto running = studio();
    Person person(*running, at().scale);
    (void)addBlock(person);
    carve(person, -60);
    carved = shot(person, step);
    journalRests(person);
    ::kill(running->pid(), SIGKILL);
    EXPECT_EQ(running->wait(10), 128 + SIGKILL);
  };
  crash("11-before-the-crash");
  EXPECT_FALSE(journals().empty());
  {
    const auto running = studio();
    Person person(*running, at().scale);
    shot(person, "12-recovery");
    const auto [x, y] = button(person, 0);
    person.click(x, y);
    person.ready();
    shot(person, "13-recovered");
    expectSame(person, carved, "recovered");
    // It is not saved: that is asked about. This time it is left.
    question(person);
    shot(person, "14-question");
    person.type("d");
    EXPECT_EQ(running->wait(60), 0) << running->said();
  }
  EXPECT_TRUE(journals().empty()) << "left unsaved by choice, so nothing is to be recovered: " << *journals().begin();
  crash("15-before-the-second-crash");
  {
    const auto running = studio();
    Person person(*running, at().scale);
    (void)person.settled();
    const auto [x, y] = button(person, 1);
    person.click(x, y);
    person.ready();
    shot(person, "16-discard-asked");
    EXPECT_FALSE(journals().empty()) << "thrown away by one click";
    person.click(x, y);
    for (int i = 0; i < 100 && journals().size() > 1; ++i) person.pause(0.1);
    shot(person, "17-discarded");
    person.key("escape");
    person.close();
    EXPECT_EQ(running->wait(60), 0) << running->said();
  }
  EXPECT_TRUE(journals().empty());
}

TEST_P(Keeping, PicturesAndModelsGoToFiles) {
  const auto running = studio();
  Person person(*running, at().scale);
  offTheClay(person);
  (void)addBlock(person);
  byPalette(person, "save picture");
  person.ready();
  shot(person, "21-picture");
  person.type((scratch_ / "view").string());
  person.key("enter");
  ASSERT_TRUE(appears(scratch_ / "view.png"));
  const render::Image picture = readPng(scratch_ / "view.png");
  EXPECT_EQ(picture.width, at().width);
  EXPECT_EQ(picture.height, at().height);
  double away = 1;
  for (int i = 0; i < 20 && away >= 0.05; ++i) away = difference(clay(picture), clay(person.settled()));
  EXPECT_LT(away, 0.05) << "the same without panels";
  byPalette(person, "export 3mf");
  person.key("ctrl+a");
  person.type("block");
  shot(person, "22-export");
  person.key("enter");
  ASSERT_TRUE(appears(scratch_ / "block.3mf"));
  shot(person, "23-exported");
  const Outcome o = argil({"inspect", (scratch_ / "block.3mf").string(), "--json"});
  EXPECT_EQ(o.code, 0) << o.err;
  const Json mesh = Json::parse(o.out, nullptr, false);
  ASSERT_TRUE(mesh.is_object()) << o.out;
  EXPECT_TRUE(mesh["mesh"]["closed"].get<bool>()) << mesh.dump();
  EXPECT_NEAR(mesh["mesh"]["volume_mm3"].get<double>(), 60 * 60 * 40 - 2200, 400)
      << "rounding the edges by 4 mm takes 2200";
  question(person);
  person.type("d");
  EXPECT_EQ(running->wait(60), 0) << running->said();
}

INSTANTIATE_TEST_SUITE_P(Sizes, Keeping, ::testing::Values(kSmallScreen), nameOf);
INSTANTIATE_TEST_SUITE_P(LongSizes, Keeping, ::testing::Values(kDenseScreen), nameOf);

}  // namespace
}  // namespace argil::tests
