// What is said of files, of moments and of what a crash left.

#include "ui3d/studio/files/save_words.h"

#include <gtest/gtest.h>

#include <ctime>

#include "ui3d/studio/files/file_kinds.h"

namespace argil::studio {
namespace {

Moment at(int year, int month, int day, int hour, int minute) {
  std::tm parts{};
  parts.tm_year = year - 1900;
  parts.tm_mon = month - 1;
  parts.tm_mday = day;
  parts.tm_hour = hour;
  parts.tm_min = minute;
  parts.tm_isdst = -1;
  return std::chrono::system_clock::from_time_t(std::mktime(&parts));
}

TEST(When, IsSaidInAPersonsWords) {
  const Moment now = at(2026, 3, 1, 15, 0);
  EXPECT_EQ(momentWords(at(2026, 3, 1, 9, 5), now), "9:05");
  EXPECT_EQ(momentWords(at(2026, 2, 28, 23, 59), now), "yesterday 23:59");
  EXPECT_EQ(momentWords(at(2026, 2, 27, 0, 0), now), "27 February 0:00");
  EXPECT_EQ(momentWords(at(2025, 3, 1, 12, 0), now), "1 March 2025 12:00");
  EXPECT_EQ(dayWords(at(2025, 12, 31, 12, 0), at(2026, 1, 1, 0, 1)), "yesterday");
  EXPECT_EQ(spanWords(at(2026, 3, 1, 12, 3), at(2026, 3, 1, 12, 31), now), "today, 12:03 to 12:31");
  EXPECT_EQ(spanWords(at(2026, 3, 1, 12, 3), at(2026, 3, 1, 12, 3), now), "today, 12:03");
  EXPECT_EQ(spanWords(at(2026, 2, 28, 23, 50), at(2026, 3, 1, 0, 10), now), "yesterday 23:50 to today 0:10");
}

TEST(KeepWords, TitleAndStatusSayWhereTheDocumentIs) {
  engine::FileState file;
  {
    engine::FileState newer;
    newer.path = "/x/newer.argil";
    newer.readOnly = "A newer Argil wrote it.";
    EXPECT_EQ(savingWords(newer, Moment()).words, "Opened for reading only");
    newer.unsaved = true;
    EXPECT_EQ(savingWords(newer, Moment()).words, "Changed; the journal keeps it");
  }
  {
    engine::FileState shared;
    shared.path = "/x/head.argil";
    shared.unsaved = shared.elsewhere = true;
    EXPECT_EQ(savingWords(shared, Moment()).words, "Changed; the journal keeps it; open in another window too");
    EXPECT_TRUE(savingWords(shared, Moment()).ails);
    engine::FileState recovered;
    recovered.name = "head.argil";
    recovered.unsaved = true;
    EXPECT_EQ(windowTitle(recovered), "head.argil* — Argil");
    EXPECT_EQ(documentName(recovered), "head.argil");
  }
  EXPECT_EQ(windowTitle(file), "Argil");
  EXPECT_EQ(savingWords(file, Moment()).words, "Nothing to save");
  file.unsaved = true;
  EXPECT_EQ(windowTitle(file), "Untitled* — Argil");
  EXPECT_EQ(savingWords(file, Moment()).words, "Not saved yet; the journal keeps it");
  EXPECT_FALSE(savingWords(file, Moment()).ails);
  file.journalTrouble = "the disk is full";
  EXPECT_TRUE(savingWords(file, Moment()).ails);
  file.path = "/x/head.argil";
  EXPECT_EQ(windowTitle(file), "head.argil* — Argil");
  file.saving = true;
  EXPECT_EQ(savingWords(file, Moment()).words, "Saving…");
  file.saving = file.unsaved = false;
  EXPECT_EQ(windowTitle(file), "head.argil — Argil");
  EXPECT_EQ(savingWords(file, Moment()).words.substr(0, 6), "Saved ");
}

TEST(FileKinds, PrintersGetThreeMfFirstAndUnitsAreAskedWhereNoneAre) {
  std::vector<std::string> written;
  for (const FileKind& kind : fileKinds()) {
    if (kind.writes.empty()) continue;
    written.emplace_back(kind.ending);
    EXPECT_TRUE(kind.writes.ends_with('.')) << kind.name;
  }
  EXPECT_EQ(written, (std::vector<std::string>{".3mf", ".stl", ".obj", ".ply", ".glb", ".gltf", ".drc", ".step",
                                               ".iges", ".vdb"}));
  for (const char* file : {"a.stl", "a.OBJ", "a.ply", "a.off", "a.drc", "a.vdb"})
    EXPECT_TRUE(asksForUnits(file)) << file;
  for (const char* file : {"a.3mf", "a.glb", "a.gltf", "a.argil", "a.json", "a.txt", "a", ""})
    EXPECT_FALSE(asksForUnits(file)) << file;
  EXPECT_EQ(kindOf("x.txt"), nullptr);
}

}  // namespace
}  // namespace argil::studio
