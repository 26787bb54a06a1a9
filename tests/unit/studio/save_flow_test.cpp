// Nothing is put away unasked, nothing is done that was cancelled, and a save that fails stops what was asked for.

#include "ui3d/studio/files/save_flow.h"

#include <gtest/gtest.h>

namespace argil::studio {
namespace {

using Answer = SaveFlow::Answer;
using Next = SaveFlow::Next;
using Stage = SaveFlow::Stage;
using To = Departure::To;

engine::Snapshot snapshot(const char* path, bool unsaved, size_t steps = 1) {
  engine::Snapshot now;
  now.file.path = path;
  now.file.unsaved = unsaved;
  now.history = std::make_shared<const std::vector<std::string>>(steps, "Carve");
  return now;
}
Departure to(To where) {
  Departure departure;
  departure.to = where;
  return departure;
}

TEST(SaveFlow, WhatIsSavedIsLeftWithoutAQuestion) {
  for (const auto& now : {snapshot("/a.argil", false), snapshot("", false, 0), snapshot("", true, 0)}) {
    SaveFlow flow;
    EXPECT_EQ(flow.want(to(To::quit), now), Next::go);
    EXPECT_EQ(flow.stage(), Stage::idle);
  }
}

TEST(SaveFlow, WhatIsNotSavedIsAskedAbout) {
  for (const auto& now : {snapshot("/a.argil", true), snapshot("", true), snapshot("/a.argil", true, 0)}) {
    for (const To where : {To::quit, To::newDocument, To::file, To::recovered}) {
      SaveFlow flow;
      EXPECT_EQ(flow.want(to(where), now), Next::nothing);
      EXPECT_EQ(flow.stage(), Stage::asking);
      EXPECT_EQ(flow.answer(Answer::cancel, now.file), Next::nothing);
      EXPECT_EQ(flow.stage(), Stage::idle);
      EXPECT_EQ(flow.follow(snapshot("/a.argil", false).file, false, 10), Next::nothing)
          << "went on after it was cancelled";
      flow.want(to(where), now);
      EXPECT_EQ(flow.answer(Answer::dontSave, now.file), Next::go);
      EXPECT_EQ(flow.departure().to, where);
    }
  }
}

TEST(SaveFlow, ASaveIsWaitedFor) {
  SaveFlow flow;
  auto now = snapshot("/a.argil", true);
  flow.want(to(To::newDocument), now);
  ASSERT_EQ(flow.answer(Answer::save, now.file), Next::save);
  EXPECT_EQ(flow.follow(now.file, true, 1), Next::nothing);
  now.file.saving = true;
  EXPECT_EQ(flow.follow(now.file, false, 60), Next::nothing) << "a save may take long";
  now.file.saving = now.file.unsaved = false;
  EXPECT_EQ(flow.follow(now.file, true, 61), Next::nothing) << "something is still under way";
  EXPECT_EQ(flow.follow(now.file, false, 61), Next::go);
  EXPECT_EQ(flow.follow(now.file, false, 62), Next::nothing) << "once";
}

TEST(SaveFlow, ASaveThatFailsStopsIt) {
  SaveFlow flow;
  const auto now = snapshot("/a.argil", true);
  flow.want(to(To::quit), now);
  flow.answer(Answer::save, now.file);
  EXPECT_EQ(flow.follow(now.file, false, 1), Next::nothing);
  EXPECT_EQ(flow.stage(), Stage::saving) << "it may just be about to begin";
  EXPECT_EQ(flow.follow(now.file, true, 1.2), Next::nothing);
  EXPECT_EQ(flow.follow(now.file, false, 1.4), Next::nothing);
  EXPECT_EQ(flow.stage(), Stage::saving) << "the time counts from when it rests";
  EXPECT_EQ(flow.follow(now.file, false, 1.4 + SaveFlow::kFailedS + 0.01), Next::nothing);
  EXPECT_EQ(flow.stage(), Stage::idle);
}

TEST(SaveFlow, WhereItsFileIsNotItsOwnAnyMoreItGetsAnotherName) {
  SaveFlow flow;
  auto now = snapshot("/a.argil", true);
  now.file.refused = 3;  // of before
  flow.want(to(To::quit), now);
  ASSERT_EQ(flow.answer(Answer::save, now.file), Next::save);
  EXPECT_EQ(flow.follow(now.file, true, 1), Next::nothing);
  now.file.refused = 4;
  EXPECT_EQ(flow.follow(now.file, false, 2), Next::chooseName);
  EXPECT_EQ(flow.stage(), Stage::naming);
  flow.named();
  EXPECT_EQ(flow.follow(now.file, false, 3), Next::nothing) << "asks once";
  now.file.unsaved = false;
  EXPECT_EQ(flow.follow(now.file, false, 3.1), Next::go);
}

TEST(SaveFlow, UntitledWorkGetsANameFirst) {
  SaveFlow flow;
  const auto now = snapshot("", true);
  flow.want(to(To::quit), now);
  EXPECT_EQ(flow.answer(Answer::save, now.file), Next::chooseName);
  EXPECT_EQ(flow.follow(now.file, false, 100), Next::nothing) << "the name is still being chosen";
  flow.named();
  EXPECT_EQ(flow.stage(), Stage::saving);
  EXPECT_EQ(flow.follow(snapshot("/b.argil", false).file, false, 101), Next::go);

  flow.want(to(To::quit), now);
  flow.answer(Answer::save, now.file);
  flow.notNamed();
  EXPECT_EQ(flow.stage(), Stage::idle);
}

TEST(SaveFlow, ANamedSaveOnItsOwnLeadsNowhere) {
  SaveFlow flow;
  flow.named();
  flow.notNamed();
  EXPECT_EQ(flow.stage(), Stage::idle);
  EXPECT_EQ(flow.answer(Answer::dontSave, {}), Next::nothing) << "nobody asked";
}

TEST(SaveFlow, ANewerWishTakesTheOlderOnesPlace) {
  SaveFlow flow;
  const auto now = snapshot("/a.argil", true);
  flow.want(to(To::newDocument), now);
  EXPECT_EQ(flow.want(to(To::quit), now), Next::nothing);
  EXPECT_EQ(flow.stage(), Stage::asking);
  EXPECT_EQ(flow.answer(Answer::dontSave, now.file), Next::go);
  EXPECT_EQ(flow.departure().to, To::quit);
}

TEST(SaveFlow, OnesMindCanBeChangedWhileItSaves) {
  SaveFlow flow;
  const auto now = snapshot("/a.argil", true);
  flow.want(to(To::quit), now);
  flow.answer(Answer::save, now.file);
  flow.stay();
  EXPECT_EQ(flow.follow(snapshot("/a.argil", false).file, false, 5), Next::nothing);
}

}  // namespace
}  // namespace argil::studio
