// Names, keys and the search of what can be done.

#include "ui3d/studio/panels/actions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <sstream>

#include "clay/base/error.h"
#include "ui3d/studio/files/file_kinds.h"
#include "ui3d/studio/panels/settings_tables.h"
#include "ui3d/studio/panels/synonyms.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

TEST(Shortcuts, AreReadAndWrittenTheSame) {
  const std::vector<std::string> texts = {"Ctrl+Z",
                                          "Ctrl+Shift+Z",
                                          "[",
                                          "]",
                                          "F1",
                                          "F12",
                                          "Keypad0",
                                          "Keypad9",
                                          "Ctrl++",
                                          "+",
                                          "Ctrl+.",
                                          "Space",
                                          "Escape",
                                          "Delete",
                                          "PageUp",
                                          "Home",
                                          "Ctrl+Alt+Shift+Super+A",
                                          "7",
                                          "Alt+H",
                                          ","};
  for (const std::string& text : texts) {
    const auto shortcut = parseShortcut(text);
    ASSERT_TRUE(shortcut) << text;
    EXPECT_EQ(format(*shortcut), text);
  }
  EXPECT_EQ(parseShortcut("shift+ctrl+z"), parseShortcut("Ctrl+Shift+Z"));
  EXPECT_EQ(parseShortcut("Ctrl+Z")->key, Key('Z'));
  EXPECT_EQ(parseShortcut("Ctrl+Z")->modifiers, kControl);
  EXPECT_EQ(parseShortcut("f11")->key, Key::f11);
}

TEST(Shortcuts, EveryKeyOfTheTableComesBack) {
  for (int code = 1; code < 400; ++code) {
    const std::string text = format({Key(code), kShift});
    if (text.empty() || text == "Shift+") continue;
    const auto back = parseShortcut(text);
    // Small letters are no keys of their own.
    if (code >= 'a' && code <= 'z') continue;
    ASSERT_TRUE(back) << text;
    EXPECT_EQ(int(back->key), code) << text;
  }
}

TEST(Shortcuts, OtherTextsAreNone) {
  for (const char* text : {"", "+", "Ctrl", "Ctrl+", "Ctrl+Ctrl+Z", "Hyper+Z", "F0", "F13", "F1x", "Keypad10", "Zz",
                           "Ctrl Z", " ", "\x80"}) {
    if (std::string(text) == "+") continue;  // A key.
    EXPECT_FALSE(parseShortcut(text)) << "'" << text << "'";
  }
}

TEST(Actions, HaveNamesHelpAndUniqueIds) {
  const std::set<std::string> groups = {"File",   "Edit", "Clay",  "Piece",  "Tool",
                                        "Guides", "View", "Touch", "Window", "Help"};
  std::set<std::string> ids;
  for (const Action& action : actions()) {
    EXPECT_TRUE(ids.insert(action.id).second) << action.id;
    EXPECT_FALSE(action.name.empty()) << action.id;
    EXPECT_TRUE(action.help.ends_with('.')) << action.id << ": " << action.help;
    EXPECT_TRUE(groups.contains(action.group)) << action.id << ": " << action.group;
    EXPECT_NE(action.run, nullptr) << action.id;
  }
  for (const engine::ToolRow& tool : engine::toolTable())
    EXPECT_TRUE(findAction("tool." + std::string(tool.id))) << tool.id;
  for (const engine::PieceJob& job : engine::pieceJobs())
    EXPECT_EQ(findAction("piece." + std::string(job.id)) == nullptr, job.id == "lattice") << job.id;
  EXPECT_EQ(findAction("nothing"), nullptr);
}

TEST(Actions, ShipWithoutConflicts) {
  std::map<std::string, std::string> holders;
  for (const Action& action : actions()) {
    std::istringstream words(action.shortcut);
    for (std::string word; words >> word;) {
      const auto shortcut = parseShortcut(word);
      ASSERT_TRUE(shortcut) << action.id << ": " << word;
      EXPECT_EQ(format(*shortcut), word) << action.id;
      const auto [holder, first] = holders.emplace(word, action.id);
      EXPECT_TRUE(first) << word << ": " << holder->second << " and " << action.id;
    }
  }
}

TEST(Actions, KeysOfSculptorsAreThere) {
  const StudioState state;
  const std::map<std::string, std::string> keys = {
      {"Ctrl+Z", "edit.undo"},     {"Ctrl+Shift+Z", "edit.redo"}, {"[", "tool.smaller"},
      {"]", "tool.larger"},        {"X", "symmetry.x"},           {"1", "view.front"},
      {"Ctrl+1", "view.back"},     {"3", "view.right"},           {"Ctrl+3", "view.left"},
      {"7", "view.top"},           {"Ctrl+7", "view.bottom"},     {"5", "view.projection"},
      {"F", "view.focus"},         {"Home", "view.all"},          {"Ctrl+N", "file.new"},
      {"Ctrl+O", "file.open"},     {"Ctrl+S", "file.save"},       {"Ctrl+Shift+S", "file.saveAs"},
      {"Ctrl+P", "panel.palette"}, {"Space", "panel.palette"},    {"G", "gizmo.move"},
      {"R", "gizmo.rotate"},       {"T", "gizmo.scale"},          {"F11", "window.fullScreen"},
      {"Ctrl+.", "touch.stop"}};
  for (const auto& [key, id] : keys) {
    const Action* action = actionOf(*parseShortcut(key), state);
    ASSERT_NE(action, nullptr) << key;
    EXPECT_EQ(action->id, id) << key;
  }
}

TEST(Actions, KeysCanBeChangedButNotTwiceGiven) {
  StudioState state;
  const Action& undo = *findAction("edit.undo");
  const Action& redo = *findAction("edit.redo");
  setShortcut(state, undo, "ctrl+f12 ctrl+alt+u");
  EXPECT_EQ(shortcutOf(undo, state), "Ctrl+F12 Ctrl+Alt+U");
  EXPECT_EQ(actionOf(*parseShortcut("Ctrl+F12"), state), &undo);
  EXPECT_EQ(actionOf(*parseShortcut("Ctrl+Z"), state), nullptr);
  try {
    setShortcut(state, redo, "Ctrl+F12");
    FAIL() << "given twice";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("Undo"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("Ctrl+F12"), std::string::npos) << error.what();
  }
  EXPECT_EQ(shortcutOf(redo, state), "Ctrl+Shift+Z Ctrl+Y");
  EXPECT_THROW(setShortcut(state, redo, "Hyper+Q"), Error);
  setShortcut(state, redo, "Ctrl+Z");
  EXPECT_THROW(resetShortcut(state, undo), Error);  // Redo has it now.
  setShortcut(state, redo, "");
  EXPECT_EQ(shortcutOf(redo, state), "");
  resetShortcut(state, undo);
  resetShortcut(state, redo);
  EXPECT_TRUE(state.keys.empty());
}

// Whatever has a name in a menu or a key is found by that name, first of all; what the View panel switches is among it.
TEST(Actions, EachIsFoundInThePaletteByItsName) {
  for (const Action& action : actions()) {
    const auto found = searchActions(action.name);
    ASSERT_FALSE(found.empty()) << action.name;
    EXPECT_EQ(found.front()->name, action.name);
  }
  for (const auto& row : lookRows())
    if (const auto* look = std::get_if<Switch<render::Look>>(&row)) {
      EXPECT_NE(findAction("look." + std::string(look->id)), nullptr) << look->id;
    }
  for (const auto& [typed, id] : std::map<std::string, std::string>{{"zoom in", "view.zoomIn"},
                                                                    {"zoom out", "view.zoomOut"},
                                                                    {"x-ray", "look.xray"},
                                                                    {"thickness", "guides.thickness"},
                                                                    {"duplicate", "edit.duplicate"},
                                                                    {"copy", "edit.copy"},
                                                                    {"paste", "edit.paste"},
                                                                    {"grid", "look.grid"}}) {
    const auto found = searchActions(typed);
    ASSERT_FALSE(found.empty()) << typed;
    EXPECT_EQ(found.front()->id, id) << typed;
  }
}

// Texts stand whole in tables. Where they were glued from parts, an ending came twice, a word or a blank did, or "a"
// stood before a vowel.
TEST(Texts, OfAllTablesReadAsEnglish) {
  std::vector<std::string> texts;
  const auto add = [&](std::string_view text) { texts.emplace_back(text); };
  for (const Action& action : actions()) add(action.name), add(action.help);
  for (const PanelRow& row : panelTable()) add(row.name), add(row.help);
  const auto parameters = [&](const auto& rows) {
    for (const auto& row : rows) add(row.name), add(row.help);
  };
  for (const engine::ToolRow& row : engine::toolTable()) add(row.name), add(row.help), parameters(row.parameters);
  for (const engine::PieceJob& row : engine::pieceJobs()) {
    add(row.name), add(row.help), add(row.doing), add(row.brief), parameters(row.parameters);
    // What stands on a small button is part of what it is called.
    for (std::istringstream words{std::string(row.brief)}; words;) {
      std::string word;
      if (!(words >> word)) break;
      std::string name(row.name);
      for (std::string* text : {&word, &name})
        std::transform(text->begin(), text->end(), text->begin(),
                       [](unsigned char c) { return char(std::tolower(c)); });
      EXPECT_TRUE((" " + name + " ").find(" " + word + " ") != std::string::npos) << row.brief << " of " << row.name;
    }
  }
  const auto rows = [&](const auto& table) {
    for (const auto& row : table) std::visit([&](const auto& each) { add(each.name), add(each.help); }, row);
  };
  rows(lookRows()), rows(stereoRows()), rows(qualityRows()), rows(pictureRows()), rows(workspaceRows()),
      rows(wallRows());
  parameters(touchQualityRows()), parameters(strokeQualityRows());
  for (const engine::QualityPreset& preset : engine::qualityPresets()) add(preset.name), add(preset.help);
  parameters(materialRows()), parameters(wellRows()), parameters(symmetryRows()), parameters(handRows()),
      parameters(undoRows());
  for (const FileKind& kind : fileKinds()) add(kind.name), add(kind.writes), add(kind.units);
  EXPECT_GT(texts.size(), 400u);
  const std::set<std::string> right = {"need", "needed", "needs",  "speed", "feed",   "freed",
                                       "seed", "indeed", "exceed", "bring", "brings", "singing"};
  for (const std::string& text : texts) {
    std::istringstream words(text);
    std::string before;
    for (std::string word; words >> word;) {
      bool pauses = false;
      while (!word.empty() && std::string_view(".,:;!?)").find(word.back()) != std::string_view::npos) {
        word.pop_back();
        pauses = true;
      }
      std::string small = word;
      std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return char(std::tolower(c)); });
      const auto ends = [&](std::string_view ending) { return small.ends_with(ending) && !right.contains(small); };
      EXPECT_FALSE(ends("eed") || ends("eded") || ends("inging") || ends("sss") || ends("lyly"))
          << word << ": " << text;
      EXPECT_NE(small, before) << text;
      if (before == "a") {
        EXPECT_EQ(std::string_view("aeio").find(small.empty() ? 'x' : small[0]), std::string_view::npos) << text;
      }
      if (before == "an") {
        EXPECT_NE(std::string_view("aeiouhx8").find(small.empty() ? 'x' : small[0]), std::string_view::npos) << text;
      }
      before = pauses ? std::string() : small;
    }
    EXPECT_EQ(text.find("  "), std::string::npos) << text;
    EXPECT_TRUE(text.empty() || (text.front() != ' ' && text.back() != ' ')) << "'" << text << "'";
  }
}

// What sculptors, modellers and people who print type when they look for it.
TEST(Actions, AreFoundByTheWordsOfOtherPrograms) {
  const std::multimap<std::string, std::string> wanted = {
      {"boolean", "piece.join"},
      {"boolean", "piece.cut"},
      {"boolean", "piece.intersect"},
      {"union", "piece.join"},
      {"merge", "piece.join"},
      {"weld", "piece.join"},
      {"subtract", "piece.cut"},
      {"difference", "piece.cut"},
      {"move", "gizmo.move"},
      {"translate", "gizmo.move"},
      {"move", "tool.tug"},
      {"grab", "tool.tug"},
      {"snake hook", "tool.tug"},
      {"camera", "panel.view"},
      {"lens", "panel.view"},
      {"resolution", "piece.resample"},
      {"remesh", "piece.resample"},
      {"dynamesh", "piece.resample"},
      {"detail", "piece.resample"},
      {"trim", "piece.cut-plane"},
      {"trim", "piece.cut-curve"},
      {"knife", "piece.cut-plane"},
      {"decimate", "file.export"},
      {"matcap", "shading.matcap"},
      {"perspective", "view.projection"},
      {"turntable", "view.iso"},
      {"screenshot", "file.picture"},
      {"extrude", "piece.offset"},
      {"thicken", "piece.offset"},
      {"hollow", "piece.shell"},
      {"group", "panel.things"},
      {"outliner", "panel.things"},
      {"isolate", "edit.isolate"},
      {"solo", "edit.isolate"},
      {"alpha", "tool.emboss"},
      {"hide", "edit.hide"},
      {"visibility", "edit.hide"},
      {"clone", "edit.duplicate"},
      {"hotkeys", "panel.shortcuts"},
      {"keymap", "panel.shortcuts"},
      {"options", "panel.preferences"},
      {"dark mode", "window.theme"},
      {"cross section", "view.section"},
      {"measure distance", "guides.ruler"},
      {"caliper", "guides.thickness"},
      {"gizmo", "gizmo.rotate"},
      {"dam standard", "tool.crease"},
      {"mold", "piece.mould"},
      {"primitive", "clay.block"},
      {"Boolean", "piece.join"},
      {"DECIM", "file.export"},
      // Brushes of ZBrush, Blender and Nomad, and what moulders say.
      {"move brush", "tool.tug"},
      {"mallet", "tool.flatten"},
      {"claytubes", "tool.clay"},
      {"trim dynamic", "tool.flatten"},
      {"draw sharp", "tool.crease"},
      {"selmask", "tool.mask"},
      {"zremesher", "file.export"},
      {"retopo", "file.export"},
      {"bake", "file.export"},
      {"stl", "file.export.stl"},
      {"live boolean", "piece.join"},
      {"lazy mouse", "tool.straight"},
      {"box trim", "piece.cut-curve"},
      {"line project", "piece.cut-plane"},
      {"falloff", "panel.settings"},
      {"opacity", "panel.settings"},
      {"round edges", "piece.smooth-all"},
      {"hole", "piece.fill-voids"},
      {"wall", "piece.shell"},
      {"volume", "panel.facts"},
      {"mesh info", "panel.facts"},
      {"drop to floor", "piece.lay-flat"},
      {"zoom to fit", "view.all"},
      {"undercut", "panel.print"},
      {"draft angle", "panel.print"},
      {"parting line", "piece.mould"},
      {"core", "piece.mould"},
  };
  constexpr size_t kSeen = 5;  // Without scrolling or reading far.
  for (const auto& [typed, id] : wanted) {
    const auto found = searchActions(typed);
    const auto at = std::find_if(found.begin(), found.end(), [&](const Action* each) { return each->id == id; });
    EXPECT_LT(size_t(at - found.begin()), kSeen) << typed << ": " << id;
    EXPECT_NE(at, found.end()) << typed << ": " << id;
  }
}

TEST(Actions, SynonymsAreWordsOfRowsThatThereAre) {
  std::set<std::string_view> ids;
  for (const Synonyms& row : synonyms()) {
    EXPECT_NE(findAction(row.id), nullptr) << row.id;
    EXPECT_TRUE(ids.insert(row.id).second) << row.id << " comes twice";
    EXPECT_FALSE(row.words.empty()) << row.id;
    EXPECT_TRUE(std::none_of(row.words.begin(), row.words.end(), [](char c) { return c >= 'A' && c <= 'Z'; }))
        << row.words;
    std::istringstream words{std::string(row.words)};
    for (std::string word; words >> word;) {
      const auto found = searchActions(word);
      EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const Action* each) { return each->id == row.id; }))
          << word << ": " << row.id;
    }
  }
  // Formats are found by their names; what plugins bring has none.
  for (const Action& action : actions())
    EXPECT_TRUE(!action.synonyms.empty() || action.id.starts_with("file.export.")) << action.id;
}

TEST(Actions, WhatIsMistypedIsOfferedByTheNearestNames) {
  const auto offered = [](const char* typed, const char* id) {
    const auto near = nearestActions(typed);
    EXPECT_LE(near.size(), 5u);
    return std::any_of(near.begin(), near.end(), [&](const Action* each) { return each->id == id; });
  };
  EXPECT_TRUE(searchActions("smoth brsh").empty());
  EXPECT_TRUE(offered("smotth", "tool.smooth"));
  EXPECT_TRUE(offered("bolean", "piece.join"));
  EXPECT_TRUE(offered("boleen", "piece.join"));
  EXPECT_TRUE(offered("remseh", "piece.resample"));
  EXPECT_TRUE(offered("exprot", "file.export"));
  EXPECT_TRUE(offered("simmetry", "symmetry.x"));
  EXPECT_TRUE(offered("decimat", "file.export"));
  EXPECT_FALSE(nearestActions("qqqq").empty());
}

TEST(Actions, AreFoundByWhatIsTyped) {
  const auto first = [](const char* typed) {
    const auto found = searchActions(typed);
    return found.empty() ? std::string() : found.front()->id;
  };
  EXPECT_EQ(searchActions("").size(), actions().size());
  EXPECT_EQ(first("undo"), "edit.undo");
  EXPECT_EQ(first("carve"), "tool.carve");
  EXPECT_EQ(first("exp stl"), "file.export.stl");
  EXPECT_EQ(first("export 3mf"), "file.export.3mf");
  EXPECT_EQ(first("save"), "file.save");
  EXPECT_EQ(first("open recent"), "file.recent");
  EXPECT_EQ(first("symx"), "symmetry.x");
  EXPECT_EQ(first("front"), "view.front");
  EXPECT_EQ(first("add plane"), "guides.plane");
  EXPECT_EQ(first("STOP"), "touch.stop");
  EXPECT_EQ(first("join"), "piece.join");
  EXPECT_EQ(first("cut by plane"), "piece.cut-plane");
  EXPECT_EQ(first("straight"), "tool.straight");
  EXPECT_EQ(first("side by side"), "stereo.sideBySide");
  EXPECT_EQ(first("top and bottom"), "stereo.topBottom");
  EXPECT_TRUE(searchActions("qqqq").empty());
}

}  // namespace
}  // namespace argil::studio
