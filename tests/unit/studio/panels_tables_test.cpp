// The tables of settings: what they call standard is what a new one has, and every row moves what it names.

#include "ui3d/studio/panels/settings_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "engine/document/guide_table.h"
#include "ui3d/studio/kit/icons.h"

namespace argil::studio {
namespace {

template <class Owner>
void expectRow(const engine::Parameter<Owner>& row, const Owner& fresh) {
  SCOPED_TRACE(row.id);
  EXPECT_LT(row.low, row.high);
  EXPECT_GE(row.standard, row.low);
  EXPECT_LE(row.standard, row.high);
  EXPECT_TRUE(!row.logarithmic || row.low > 0);
  EXPECT_TRUE(row.help.ends_with('.')) << row.help;
  EXPECT_NEAR(row.get(fresh), row.standard, 1e-5 * std::abs(row.standard)) << "a new one has another value";
  for (const double value : {row.low, row.high, row.standard}) {
    Owner owner = fresh;
    row.change(owner, value);
    EXPECT_NEAR(row.get(owner), value, 1e-5 * std::max(1.0, std::abs(value)));
  }
  Owner owner = fresh;
  row.change(owner, 1e300);
  EXPECT_NEAR(row.get(owner), row.high, 1e-5 * row.high);
}
template <class Owner>
void expectRow(const Switch<Owner>& row, const Owner&) {
  SCOPED_TRACE(row.id);
  EXPECT_NE(row.on, nullptr);
  EXPECT_FALSE(row.name.empty());
}
template <class Owner>
void expectRow(const Choice<Owner>& row, const Owner& fresh) {
  SCOPED_TRACE(row.id);
  ASSERT_GE(row.options.size(), 2u);
  for (int i = 0; i < int(row.options.size()); ++i) {
    Owner owner = fresh;
    row.set(owner, i);
    EXPECT_EQ(row.get(owner), i);
  }
}
template <class Owner>
void expectRows(std::span<const Row<Owner>> rows) {
  std::set<std::string_view> ids;
  for (const auto& row : rows) {
    std::visit(
        [&](const auto& each) {
          EXPECT_TRUE(ids.insert(each.id).second) << each.id;
          expectRow(each, Owner{});
        },
        row);
  }
  EXPECT_FALSE(ids.empty());
}

TEST(SettingsTables, StandardsAreWhatANewOneHas) {
  expectRows(lookRows());
  expectRows(stereoRows());
  expectRows(qualityRows());
  expectRows(pictureRows());
  for (const auto& row : touchQualityRows()) expectRow(row, engine::Quality{});
  for (const auto& row : strokeQualityRows()) expectRow(row, engine::Quality{});
  expectRows(workspaceRows());
  expectRows(wallRows());
  for (const auto& row : materialRows()) expectRow(row, haptics::Material{});
  for (const auto& row : wellRows()) expectRow(row, engine::Guide{});
  for (const engine::GuideRow& guide : engine::guideTable()) {
    EXPECT_EQ(sizeRows(guide.kind).empty(), guide.size == engine::GuideSize::none) << guide.id;
    for (const auto& row : sizeRows(guide.kind)) expectRow(row, engine::Guide{});
    EXPECT_TRUE(hasIcon(guide.icon)) << guide.id;
  }
  for (const auto& row : symmetryRows()) expectRow(row, engine::Symmetry{});
  for (const auto& row : handRows()) expectRow(row, StudioState{});
  for (const auto& row : handsRows()) expectRow(row, StudioState{});
  for (const auto& row : undoRows()) expectRow(row, StudioState{});
}

TEST(SettingsTables, SlidingFrictionNeverIsAboveTheStaticOne) {
  const auto rows = materialRows();
  const auto find = [&](std::string_view id) -> const engine::Parameter<haptics::Material>& {
    for (const auto& row : rows) {
      if (row.id == id) return row;
    }
    throw std::runtime_error("no such row");
  };
  haptics::Material m;
  find("dynamicFriction").change(m, 0.7);
  EXPECT_GE(m.staticFriction, 0.7);
  find("staticFriction").change(m, 0.3);
  EXPECT_LE(m.dynamicFriction, 0.3);
}

}  // namespace
}  // namespace argil::studio
