// Events to Dear ImGui and its triangles back.

#include "ui3d/studio/ui_input.h"

#include <gtest/gtest.h>
#include <imgui.h>

namespace argil::studio {
namespace {

using Kind = Event::Kind;

class UiInputTest : public ::testing::Test {
 protected:
  UiInputTest() {
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
  }
  static Event of(Kind kind, float x = 0, float y = 0) {
    Event e;
    e.kind = kind;
    e.x = x;
    e.y = y;
    return e;
  }
  static Event keyOf(Kind kind, Key key, uint8_t modifiers = 0) {
    Event e = of(kind);
    e.key = key;
    e.modifiers = modifiers;
    return e;
  }
  // A panel with a button and a text field, as wide as it.
  render::UiFrame frame() {
    ui_.beginFrame(0.02, 400, 300, 2);
    ImGui::SetNextWindowPos(ImVec2(20, 20));
    ImGui::SetNextWindowSize(ImVec2(200, 120));
    ImGui::Begin("Panel", nullptr, ImGuiWindowFlags_NoDecoration);
    clicks_ += ImGui::Button("Press", ImVec2(100, 30)) ? 1 : 0;
    ImGui::InputText("##text", text_, sizeof text_);
    field_ = ImGui::GetItemRectMin();
    ImGui::End();
    ImGui::Render();
    return ui_.frame();
  }
  UiInput ui_;
  int clicks_ = 0;
  char text_[64] = "";
  ImVec2 field_;
};

TEST_F(UiInputTest, KnowsWhetherThePanelsWantTheMouse) {
  frame();
  ui_.feed(of(Kind::move, 60, 40));
  frame();
  frame();
  EXPECT_TRUE(ui_.wantsMouse());
  ui_.feed(of(Kind::move, 350, 250));
  frame();
  EXPECT_FALSE(ui_.wantsMouse());
  ui_.feed(of(Kind::move, 60, 40));
  frame();
  ui_.feed(of(Kind::leave));
  frame();
  EXPECT_FALSE(ui_.wantsMouse());
}

TEST_F(UiInputTest, ClicksAndTextArrive) {
  frame();
  ui_.feed(of(Kind::move, 60, 40));
  frame();
  ui_.feed(of(Kind::press, 60, 40));
  frame();
  ui_.feed(of(Kind::release, 60, 40));
  frame();
  EXPECT_EQ(clicks_, 1);
  EXPECT_FALSE(ui_.wantsText());
  ui_.feed(of(Kind::move, field_.x + 20, field_.y + 8));
  frame();
  ui_.feed(of(Kind::press, field_.x + 20, field_.y + 8));
  frame();
  ui_.feed(of(Kind::release, field_.x + 20, field_.y + 8));
  frame();
  frame();
  EXPECT_TRUE(ui_.wantsText());
  for (const char c : {'c', 'l', 'a', 'y'}) {
    Event e = of(Kind::text);
    e.character = uint32_t(c);
    ui_.feed(e);
  }
  frame();
  EXPECT_STREQ(text_, "clay");
  // All of it, cut, and back again twice: modifiers and the clipboard.
  for (const char letter : {'A', 'X', 'V', 'V'}) {
    ui_.feed(keyOf(Kind::keyDown, Key(letter), kControl));
    frame();
    ui_.feed(keyOf(Kind::keyUp, Key(letter), kControl));
    frame();
  }
  EXPECT_STREQ(text_, "clayclay");
}

TEST_F(UiInputTest, ALostFocusLetsAllKeysGo) {
  frame();
  ui_.feed(keyOf(Kind::keyDown, Key('A'), kControl));
  frame();
  EXPECT_TRUE(ImGui::GetIO().KeysDown['A']);
  ui_.feed(of(Kind::focus));
  frame();
  EXPECT_FALSE(ImGui::GetIO().KeysDown['A']);
  EXPECT_FALSE(ImGui::GetIO().KeyCtrl);
}

TEST_F(UiInputTest, TrianglesStandWithinTheirBuffersAndTheWindow) {
  frame();
  const render::UiFrame f = frame();
  EXPECT_EQ(f.width, 400);
  EXPECT_EQ(f.height, 300);
  ASSERT_FALSE(f.empty());
  for (const render::UiCommand& command : f.commands) {
    ASSERT_LE(size_t(command.firstIndex) + command.indexCount, f.indices.size());
    EXPECT_EQ(command.indexCount % 3, 0u);
    EXPECT_LT(command.clip[0], command.clip[2]);
    for (uint32_t i = 0; i < command.indexCount; ++i) {
      const size_t v = size_t(command.firstVertex) + f.indices[command.firstIndex + i];
      ASSERT_LT(v, f.vertices.size());
      EXPECT_GE(f.vertices[v].x, 10);
      EXPECT_LE(f.vertices[v].x, 230) << "interface units, whatever the scale";
    }
  }
}

}  // namespace
}  // namespace argil::studio
