// Operations on whole pieces in scripts, as a person at the command line meets them: each row of the table over a small
// ball, what comes out checked by its properties.

#include "tests/e2e/support/command.h"

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

namespace argil::tests {
namespace {

using nlohmann::json;

constexpr double kPi = 3.141592653589793;
const double kBall = 4.0 / 3 * kPi * 512;  // of radius 8, as every script begins with
constexpr double kUntouched = -1;          // its surface's volume, as it is with no step at all
const std::string kSetup = R"("setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":8}}],)";

std::string scriptOf(const std::string& setup, const std::string& steps) {
  return R"({"argil":1,"units":"mm",)" + setup + "\"strokes\":[" + steps + "]}";
}

json sculpt(const Scratch& scratch, const std::string& text) {
  std::ofstream(scratch / "s.json") << text;
  const Outcome o =
      argil({"sculpt", (scratch / "s.json").string(), "--report", (scratch / "r.json").string(), "--overwrite"});
  EXPECT_EQ(o.code, 0) << text << "\n" << o.err;
  if (o.code != 0) return {};
  json report = json::parse(slurp(scratch / "r.json"));
  EXPECT_TRUE(report["surface"]["closed"]) << text;
  return report;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> all;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) all.push_back(line);
  return all;
}

double volume(const json& report) {
  return report["surface"]["volume_mm3"];
}
double low(const json& report, int axis) {
  return report["surface"]["low_mm"][size_t(axis)];
}
double high(const json& report, int axis) {
  return report["surface"]["high_mm"][size_t(axis)];
}

struct Case {
  std::string steps;
  double mm3 = kBall, part = 0.01;  // the volume of it all, and by what part it may differ
  int bodies = 1, pieces = 1;
  std::function<void(const json&)> more = {};
  std::string setup = kSetup;
};

std::string ball(const std::string& name, double radius, const std::string& centre) {
  const std::string r = std::to_string(radius);
  return R"({"operation":"ellipsoid","radius_x_mm":)" + r + R"(,"radius_y_mm":)" + r + R"(,"radius_z_mm":)" + r +
         R"(,"name":")" + name + R"(","centre_mm":)" + centre + "},";
}
const std::string kCarve = R"(,{"tool":"carve","radius_mm":3,"path":[[0,10,0,0],[1,10,2,0]]})";
const std::string kMaskAll = R"({"operation":"mask-invert"},)";

std::map<std::string, Case> cases() {
  const auto ballOf = [](double radius) { return 4.0 / 3 * kPi * radius * radius * radius; };
  std::string lattice;
  for (const char* x : {"-21", "21"})
    for (const char* y : {"-14", "14"})
      for (const char* z : {"-14", "14"})
        lattice += (lattice.empty() ? "[" : ",[") + std::string(x) + "," + y + "," + z + "]";
  const auto changed = [](double from, double to) {
    return [=](const json& r) {
      EXPECT_GT(volume(r), from);
      EXPECT_LT(volume(r), to);
    };
  };
  return {
      {"join",
       {ball("Ball", 6, "[20,0,0]") + R"({"operation":"join","pieces":["Clay","Ball"]})", kBall + ballOf(6), 0.01, 2, 1,
        [](const json& r) { EXPECT_NEAR(high(r, 0), 26, 0.3); }}},
      {"cut",
       {ball("Ball", 4, "[0,0,0]") + R"({"operation":"cut","pieces":["Clay","Ball"]})", kBall - ballOf(4), 0.01, 2}},
      {"intersect",
       {R"({"operation":"cylinder","radius_mm":4,"height_mm":50,"round_mm":0,"axis":[1,0,0],"name":"Rod"},{"operation":"intersect","pieces":["Clay","Rod"],"keep":true})",
        4.0 / 3 * kPi * (512 - std::pow(48, 1.5)) + kPi * 16 * 50, 0.01, 2, 2,
        [](const json& r) { EXPECT_NEAR(high(r, 0), 25, 0.3); }}},
      {"split",
       {ball("Ball", 6, "[20,0,0]") + R"({"operation":"join","pieces":["Clay","Ball"]},{"operation":"split"})",
        kBall + ballOf(6), 0.01, 2, 2, [](const json& r) { EXPECT_EQ(r["pieces"][1]["name"], "Clay 2"); }}},
      {"offset",
       {R"({"operation":"offset","distance_mm":2})", ballOf(10), 0.01, 1, 1,
        [](const json& r) { EXPECT_NEAR(high(r, 2), 10, 0.05); }}},
      {"shell", {R"({"operation":"shell","inner_mm":2})", kBall - ballOf(6), 0.01, 2}},
      {"smooth-all", {R"({"operation":"smooth-all","passes":5})", kBall, 0.005}},
      {"scale",
       {R"({"operation":"scale","size_percent":200})", 8 * kBall, 0.005, 1, 1,
        [](const json& r) {
          EXPECT_EQ(r["clay"]["voxel_mm"], 1.0);
          EXPECT_NEAR(low(r, 2), -8, 0.05);
          EXPECT_NEAR(high(r, 2), 24, 0.1);
        }}},
      {"resample",
       {R"({"operation":"resample","voxel_mm":0.25})", kBall, 0.005, 1, 1,
        [](const json& r) {
          EXPECT_EQ(r["clay"]["voxel_mm"], 0.25);
          EXPECT_EQ(r["notes"].size(), 1u);
        }}},
      {"precision",
       {R"({"operation":"precision","bits":"16"})", kUntouched, 1e-5, 1, 1,
        [](const json& r) { EXPECT_EQ(r["notes"].size(), 1u); }}},
      {"mirror",
       {R"({"tool":"carve","radius_mm":3,"path":[[0,8,0,0]]},{"operation":"mirror","plane":[0,0,0,1,0,0]})", kBall, 0.1,
        1, 1,
        [](const json& r) {
          EXPECT_NEAR(low(r, 0), -high(r, 0), 0.05);
          EXPECT_LT(high(r, 0), 7.5);
        }}},
      {"fill-voids", {R"({"operation":"shell","inner_mm":2},{"operation":"fill-voids"})"}},
      {"remove-crumbs",
       {ball("Crumb", 2, "[20,0,0]") +
        R"({"operation":"join","pieces":["Clay","Crumb"]},{"operation":"remove-crumbs","below_mm3":100})"}},
      {"infill",
       {R"({"operation":"shell","inner_mm":2},{"operation":"infill","kind":"struts","density_percent":20,"wall_mm":1})",
        kBall - 0.8 * ballOf(6), 0.02, 2, 1, [](const json& r) { EXPECT_EQ(r["notes"].size(), 1u); }}},
      {"drain",
       {R"({"operation":"shell","inner_mm":2},{"operation":"drain","diameter_mm":3,"plugs":true})", kBall - ballOf(6),
        0.03, 3, 3, [](const json& r) { EXPECT_EQ(r["pieces"][1]["name"], "Clay, plug 1"); }}},
      {"cut-pegs",
       {R"({"operation":"cut-pegs","plane":[0,0,0,0,0,1],"pegs":1})", kBall, 0.05, 2, 2,
        [](const json& r) {
          EXPECT_EQ(r["pieces"][1]["name"], "Clay, other side");
          EXPECT_NEAR(r["pieces"][0]["surface"]["low_mm"][2].get<double>(), 0, 0.1);
          EXPECT_GT(r["pieces"][1]["surface"]["high_mm"][2].get<double>(), 1.5);
        }}},
      {"lay-flat",
       {R"({"operation":"cut-plane","plane":[2,0,0,1,0,0],"keep":-1},{"operation":"lay-flat"})",
        kBall - kPi * 36 * (24 - 6) / 3, 0.01, 1, 1,
        [](const json& r) {
          // On the cut, where its lowest place was.
          EXPECT_NEAR(low(r, 2), -8, 0.1);
          EXPECT_NEAR(high(r, 2) - low(r, 2), 10, 0.1);
        }}},
      {"base",
       {R"({"operation":"base","height_mm":5,"margin_mm":3,"sunk_mm":1,"dots":2})",
        kBall + kPi * 121 * 5 - kPi * (24 - 1) / 3 - 2 * 2.0 / 3 * kPi * 3.375, 0.01, 1, 1,
        [](const json& r) {
          EXPECT_NEAR(low(r, 2), -12, 0.1);
          EXPECT_NEAR(high(r, 0), 11, 0.1);
        }}},
      {"nest",
       {ball("Other", 3, "[200,0,7]") + R"({"operation":"nest","gap_mm":2})", kBall + ballOf(3), 0.01, 2, 2,
        [](const json& r) {
          EXPECT_EQ(r["notes"][0], "2 pieces on 1 bed.");
          EXPECT_LT(high(r, 0) - low(r, 0), 26);
          EXPECT_LT(high(r, 1) - low(r, 1), 26);
          EXPECT_NEAR(low(r, 2), -8, 0.1);
        }}},
      {"mould",
       {R"({"operation":"mould","pull":"z","wall_mm":8})", 32.5 * 32.5 * 32.5, 0.06, 3, 3,
        [](const json& r) {
          EXPECT_EQ(r["pieces"][1]["name"], "Clay, mould below");
          EXPECT_EQ(r["pieces"][2]["name"], "Clay, mould above");
          EXPECT_EQ(r["notes"].size(), 1u);
        }}},
      {"cut-plane",
       {R"({"operation":"cut-plane","plane":[0,0,2,0,0,1],"keep":0})", kBall, 0.01, 2, 2,
        [](const json& r) { EXPECT_NEAR(r["pieces"][0]["surface"]["low_mm"][2].get<double>(), 2, 0.1); }}},
      {"cut-curve",
       {R"({"operation":"cut-curve","points":[[-20,0,0],[20,0,0]],"direction":[0,0,1]})", kBall / 2, 0.02}},
      {"bend",
       {R"({"operation":"bend","angle_deg":90})", kBall, 0.1, 1, 1,
        [](const json& r) { EXPECT_GT(std::abs(high(r, 0) + low(r, 0)), 0.5); }}},
      {"twist", {R"({"operation":"twist","angle_deg":90,"from_percent":10})"}},
      {"taper", {R"({"operation":"taper","width_percent":50})", kBall * 0.6, 0.2}},
      {"stretch",
       {R"({"operation":"stretch","plane":[0,0,0,0,0,1],"length_percent":150})", kBall * 1.5, 0.01, 1, 1,
        [](const json& r) {
          EXPECT_NEAR(high(r, 2), 1.5 * high(r, 0), 0.1);
          EXPECT_NEAR(low(r, 2), 1.5 * low(r, 0), 0.1);
        }}},
      {"lattice",
       {R"({"operation":"lattice","points_x":2,"points_y":2,"points_z":2,"box":[-14,-14,-14,14,14,14],"points":[)" +
            lattice + "]}",
        kBall * 1.5, 0.01, 1, 1,
        [](const json& r) {
          EXPECT_NEAR(high(r, 0), 12, 0.1);
          EXPECT_NEAR(high(r, 1), 8, 0.1);
        }}},
      {"cylinder",
       {R"({"operation":"cylinder","radius_mm":5,"height_mm":20,"round_mm":0,"centre_mm":[100,0,0],"axis":[0,1,0]})",
        kPi * 500, 0.01, 1, 1,
        [](const json& r) {
          EXPECT_NEAR(high(r, 1), 10, 0.1);
          EXPECT_NEAR(low(r, 0), 95, 0.1);
          EXPECT_EQ(r["pieces"][0]["name"], "Cylinder");
        },
        ""}},
      {"cone", {R"({"operation":"cone","radius_mm":10,"height_mm":20})", kPi * 2000 / 3, 0.01, 1, 1, {}, ""}},
      {"ring",
       {R"({"operation":"ring","radius_mm":10,"tube_mm":3},{"operation":"ring","radius_mm":10,"tube_mm":3,"centre_mm":[40,0,0]})",
        4 * kPi * kPi * 90, 0.02, 2, 2, [](const json& r) { EXPECT_EQ(r["pieces"][1]["name"], "Ring 2"); }, ""}},
      {"ellipsoid",
       {R"({"operation":"ellipsoid","radius_x_mm":10,"radius_y_mm":6,"radius_z_mm":4,"voxel_mm":0.25})",
        4.0 / 3 * kPi * 240,
        0.01,
        1,
        1,
        {},
        ""}},
      {"mask-invert", {R"({"operation":"mask-invert"})" + kCarve, kUntouched, 1e-9}},
      {"mask-clear",
       {kMaskAll + R"({"operation":"mask-clear"})" + kCarve, kBall, 0.1, 1, 1, changed(0.985 * kBall, 0.994 * kBall)}},
      {"mask-soften",
       {R"({"tool":"mask","radius_mm":6,"path":[[0,8,0,0]]},{"operation":"mask-soften","passes":20})" + kCarve, kBall,
        0.1, 1, 1, changed(0.985 * kBall, 0.995 * kBall)}},
      {"mask-cavity",
       {R"({"tool":"carve","radius_mm":3,"path":[[0,8,0,0]]},{"operation":"mask-cavity","radius_mm":3,"ridges":true})",
        kBall, 0.1}},
      {"mask-lasso",
       {R"({"operation":"mask-lasso","points":[[-20,-20,0],[20,-20,0],[20,20,0],[-20,20,0]],"direction":[0,0,-1],"closed":true,"front":false})" +
            kCarve,
        kUntouched, 1e-9}},
      {"mask-hide", {kMaskAll + R"({"operation":"mask-hide"})" + kCarve, kUntouched, 1e-9}},
      {"mask-show", {kMaskAll + R"({"operation":"mask-hide"},{"operation":"mask-show"})" + kCarve, kUntouched, 1e-9}},
  };
}

// A row that has no script here fails: it says what a person gets of it.
TEST(Operations, EachRowDoesInAScriptWhatItSays) {
  const Scratch scratch;
  const std::map<std::string, Case> all = cases();
  const std::vector<std::string> ids = lines(argil({"tools", "--operations", "--ids"}).out);
  ASSERT_GE(ids.size(), 28u);
  const double untouched = volume(sculpt(scratch, scriptOf(kSetup, "")));
  for (const std::string& id : ids) {
    SCOPED_TRACE(id);
    const auto found = all.find(id);
    ASSERT_NE(found, all.end());
    const Case& each = found->second;
    const json report = sculpt(scratch, scriptOf(each.setup, each.steps));
    if (report.is_null()) continue;
    EXPECT_NEAR(volume(report) / (each.mm3 == kUntouched ? untouched : each.mm3), 1, each.part);
    EXPECT_EQ(report["surface"]["bodies"], each.bodies);
    EXPECT_EQ(report["pieces"].size(), size_t(each.pieces));
    if (each.more) each.more(report);
  }
}

TEST(Operations, AreListedWithWhatCanBeSet) {
  const Outcome table = argil({"tools", "--operations", "--json"}), text = argil({"tools", "--operations"});
  ASSERT_EQ(table.code, 0) << table.err;
  for (const json& row : json::parse(table.out)) {
    EXPECT_NE(text.out.find(row["id"].get<std::string>()), std::string::npos);
    EXPECT_EQ(row["takes"].empty(), row["id"] == "nest");  // of which all pieces are part
    for (const json& parameter : row["parameters"])
      EXPECT_NE(text.out.find(parameter["key"].get<std::string>()), std::string::npos) << row["id"];
  }
}

TEST(Operations, StrokesGoOnOnThePieceThatIsNamed) {
  const Scratch scratch;
  const std::string steps =
      ball("Ball", 6, "[30,0,0]") + R"({"tool":"carve","radius_mm":2,"piece":"Ball","path":[[0,36,0,0]]},
    {"tool":"carve","radius_mm":2,"drive":"hand","path":[[0,30,0,9],[0.3,30,0,5],[0.6,31,0,5]]},
    {"operation":"offset","piece":"Clay","distance_mm":1},
    {"tool":"add","radius_mm":2,"drive":"hand","onto":[0,0,-1],"press_mm":1,"piece":"Clay","path":[[0,0,0,20],[0.5,2,0,20]]})";
  const json report = sculpt(scratch, scriptOf(kSetup, steps));
  ASSERT_EQ(report["pieces"].size(), 2u);
  EXPECT_LT(report["pieces"][1]["surface"]["high_mm"][0].get<double>(), 35.7);  // the rim of the hole
  EXPECT_GT(report["pieces"][0]["surface"]["high_mm"][2].get<double>(), 9.3);
  EXPECT_EQ(report["strokes"], 3);
  EXPECT_GT(report["servo"]["cutting"], 0);
}

TEST(Operations, RecordingsAndDocumentsHoldThem) {
  const Scratch scratch;
  const std::string steps =
      R"({"tool":"carve","radius_mm":2,"path":[[0,8,0,0],[1,8,3,0]]},{"operation":"shell","inner_mm":2.5},)" +
      ball("Ball", 5, "[10,0,0]") +
      R"({"operation":"join","pieces":["Clay","Ball"],"blend_mm":1},{"tool":"smooth","radius_mm":4,"path":[[0,8,0,0]]})";
  std::ofstream(scratch / "a.json") << scriptOf(kSetup, steps);
  const auto hash = [&](const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"sculpt", (scratch / (name + ".json")).string(), "--report",
                                          (scratch / "r.json").string(), "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = argil(arguments);
    EXPECT_EQ(o.code, 0) << o.err;
    return json::parse(slurp(scratch / "r.json"))["clay"]["hash"].get<std::string>();
  };
  const std::string first = hash("a", {"--record", (scratch / "b.json").string(), "-o", (scratch / "a.argil").string(),
                                       "-o", (scratch / "a.stl").string()});
  EXPECT_EQ(hash("b", {"--record", (scratch / "c.json").string()}), first);
  EXPECT_EQ(slurp(scratch / "b.json"), slurp(scratch / "c.json"));
  const Outcome seen = argil({"inspect", (scratch / "a.argil").string()});
  EXPECT_NE(seen.out.find("5 steps of history"), std::string::npos) << seen.out;
  // All pieces of a document come in, under their names, where they are.
  std::ofstream(scratch / "two.json") << scriptOf(
      kSetup, ball("Ball", 5, "[20,0,0]") + R"({"operation":"offset","distance_mm":1})");
  std::ofstream(scratch / "on.json") << scriptOf("", R"({"operation":"join","pieces":["Clay","Ball"]})");
  ASSERT_EQ(argil({"sculpt", (scratch / "two.json").string(), "-o", (scratch / "two.argil").string()}).code, 0);
  const Outcome on = argil({"sculpt", (scratch / "on.json").string(), "-i", (scratch / "two.argil").string(),
                            "--report", (scratch / "r.json").string(), "--overwrite"});
  ASSERT_EQ(on.code, 0) << on.err;
  const json joined = json::parse(slurp(scratch / "r.json"));
  EXPECT_EQ(joined["surface"]["bodies"], 2);
  EXPECT_NEAR(high(joined, 0), 25, 0.2);
}

TEST(Operations, WhatIsWrongIsOneLineThatNamesTheStep) {
  const Scratch scratch;
  const std::pair<std::string, std::string> faults[] = {
      {R"({"operation":"melt-down"})", "strokes[1].operation: unknown \"melt-down\"; known are join, cut"},
      {R"({"operation":3})", "strokes[1].operation: must be a text"},
      {R"({"operation":"offset","distance":2})",
       "strokes[1]: unknown key \"distance\"; known are operation, distance_mm, piece"},
      {R"({"operation":"offset","distance_mm":1e9})",
       "strokes[1].distance_mm: 1000000000 is out of range; use -100 to 100"},
      {R"({"operation":"offset","distance_mm":"2"})", "strokes[1].distance_mm: must be a number"},
      {R"({"operation":"offset","piece":"Rod"})", "strokes[1]: there is no piece \"Rod\"; there are Clay"},
      {R"({"operation":"offset","piece":""})", "strokes[1].piece: names no piece"},
      {R"({"operation":"offset","pieces":["Clay"]})", "strokes[1]: unknown key \"pieces\""},
      {R"({"operation":"join"})", "strokes[1]: \"pieces\" is missing"},
      {R"({"operation":"join","pieces":["Clay"]})", "strokes[1].pieces: must name 2 pieces, and names 1"},
      {R"({"operation":"join","pieces":["Clay","Clay"]})", "strokes[1]: Join: choose two different pieces"},
      {R"({"operation":"join","pieces":["Clay",7]})", "strokes[1].pieces[1]: must be a text"},
      {R"({"operation":"join","pieces":["Clay","Clay"],"keep":1})", "strokes[1].keep: must be true or false"},
      {R"({"operation":"mirror"})", "strokes[1]: \"plane\" is missing"},
      {R"({"operation":"mirror","plane":[0,0,0,0,0,0]})", "strokes[1].plane: its normal is no direction"},
      {R"({"operation":"mirror","plane":[0,0,0,1]})", "strokes[1].plane: must be 6 numbers"},
      {R"({"operation":"cut-curve","points":[]})", "strokes[1].points: is empty"},
      {R"({"operation":"cut-curve","points":[[0,0]]})", "strokes[1].points[0]: must be 3 numbers"},
      {R"({"operation":"cut-curve","points":[[0,0,0],[1,0,0]],"direction":[0,0,0]})",
       "strokes[1].direction: is no direction"},
      {R"({"operation":"lattice","points":[[0,0,0]]})", "strokes[1]: lattice of 4 × 4 × 4 with 1 points"},
      {R"({"operation":"bend","from_percent":90,"to_percent":20})", "strokes[1]: from 90 % to 20 %"},
      {R"({"operation":"ring","name":"Clay"})", "strokes[1]: there is a piece \"Clay\" already"},
      {R"({"operation":"ring","radius_mm":2,"tube_mm":8})", "strokes[1]: "},
      {R"({"tool":"add","radius_mm":1,"piece":"Rod","path":[[0,0,0,0]]})", "strokes[1]: there is no piece \"Rod\""},
  };
  for (const auto& [step, expected] : faults) {
    std::ofstream(scratch / "w.json") << scriptOf(kSetup, R"({"tool":"add","radius_mm":1,"path":[[0,8,0,0]]},)" + step);
    const Outcome o = argil({"sculpt", (scratch / "w.json").string(), "-o", (scratch / "w.stl").string(), "-o",
                             (scratch / "w.argil").string(), "--report", (scratch / "w-report.json").string()});
    EXPECT_EQ(o.code, 2) << step << "\n" << o.err;
    EXPECT_EQ(lines(o.err).size(), 1u) << o.err;
    EXPECT_NE(o.err.find("w.json"), std::string::npos) << o.err;
    EXPECT_NE(o.err.find(expected), std::string::npos) << step << "\n" << o.err;
    for (const char* file : {"w.stl", "w.argil", "w-report.json"}) EXPECT_FALSE(fs::exists(scratch / file)) << step;
  }
  // Nothing left is no fault of the call.
  std::ofstream(scratch / "w.json") << scriptOf(kSetup, R"({"operation":"offset","distance_mm":-50})");
  const Outcome gone = argil({"sculpt", (scratch / "w.json").string(), "-o", (scratch / "w.stl").string()});
  EXPECT_EQ(gone.code, 1);
  EXPECT_NE(gone.err.find("strokes[0]: nothing is left"), std::string::npos) << gone.err;
  EXPECT_FALSE(fs::exists(scratch / "w.stl"));
  // A script without clay that does not begin with a new piece.
  std::ofstream(scratch / "w.json") << scriptOf("", R"({"operation":"offset"})");
  EXPECT_EQ(argil({"sculpt", (scratch / "w.json").string()}).code, 2);
}

}  // namespace
}  // namespace argil::tests
