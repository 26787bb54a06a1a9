#pragma once
// Tests of what hands do to the clay of a document.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/e2e/support/screen.h"

namespace argil::tests {

using Json = nlohmann::json;
using Way = std::vector<std::array<double, 2>>;

/// A document in a window; the clay is judged by what is saved of it.
class ClayOnScreen : public OnScreen {
 protected:
  /// A document of this clay, opened by the studio as its file.
  std::string document(const std::string& setup) {
    std::ofstream(scratch_ / "script.json")
        << R"({"argil": 1, "units": "mm", "setup": [)" + setup + R"(], "strokes": []})";
    const fs::path file = scratch_ / "clay.argil";
    const Outcome o = argil({"sculpt", (scratch_ / "script.json").string(), "-o", file.string(), "--overwrite"});
    EXPECT_EQ(o.code, 0) << o.err;
    return file.string();
  }
  std::string block() { return document(R"({"voxel_mm": 0.5}, {"block": {"size_mm": [60, 60, 40], "round_mm": 4}})"); }
  struct Saved {
    double volume = 0;
    std::string hash;  ///< Of all pieces.
    int steps = 0;
    friend bool operator==(const Saved& a, const Saved& b) { return a.hash == b.hash; }
  };
  Saved saved() const {
    const Outcome o = argil({"inspect", (scratch_ / "clay.argil").string(), "--json"});
    EXPECT_EQ(o.code, 0) << o.err;
    const Json json = Json::parse(o.out, nullptr, false);
    Saved result;
    result.steps = json["history_steps"];
    for (const Json& piece : json["pieces"]) {
      result.hash += piece["hash"].get<std::string>();
      result.volume += piece["surface"]["volume_mm3"].get<double>();
    }
    return result;
  }
  /// Saves until the clay is another than it was.
  Saved otherClay(Person& person, const Saved& before) const {
    Saved now = before;
    for (int i = 0; i < 30 && now == before; ++i) {
      (void)person.settled();
      person.key("ctrl+s");
      (void)person.settled();
      now = saved();
    }
    EXPECT_FALSE(now == before) << "nothing happened to the clay";
    return now;
  }
  /// A busy machine shows an empty window for long before the file is clay.
  static void seesClay(const Person& person) {
    for (int i = 0; i < 40; ++i) {
      const render::Image image = person.settled();
      size_t orange = 0;
      for (int y = 100; y < 600; y += 4)
        for (int x = 390; x < 940; x += 4) {
          const uint8_t* p = image.pixel(x * image.width / 1280, y * image.height / 720);
          orange += p[0] > 150 && p[0] > p[2] + 30;
        }
      if (orange > 300) return;
    }
    ADD_FAILURE() << "no clay is seen";
  }
  static void offTheClay(Person& person) { person.move(middleX() - 230, middleY() + 250); }
};

}  // namespace argil::tests
