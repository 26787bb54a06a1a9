#pragma once
// Panels without a window: an ImGui context, a document in work, a hand on mouse and keys.

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "engine/session/workbench.h"
#include "render/renderer/renderer.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/actions.h"
#include "ui3d/studio/panels/panels.h"
#include "ui3d/studio/view/camera.h"
#include "ui3d/studio/view/context.h"

namespace argil::studio {

class PanelsRig {
 public:
  explicit PanelsRig(float width = 1280, float height = 720, float scale = 1, Theme theme = Theme::dark)
      : width_(width), height_(height), scale_(scale) {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {width, height};
    io.DisplayFramebufferScale = {scale, scale};
    for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key + 1;  // Codes of our own.
    state.theme = theme;
    state.foldPanels = false;  // Tests of what is in panels want all of them beside the clay.
    studio::applyTheme(theme, scale);
    panels = std::make_unique<Panels>();
    frame();
    frame();
  }
  ~PanelsRig() {
    panels.reset();
    ImGui::DestroyContext();
  }
  PanelsRig(const PanelsRig&) = delete;
  PanelsRig& operator=(const PanelsRig&) = delete;

  /// One frame, a sixtieth of a second.
  void frame() {
    timeS += 1 / 60.0;
    now = bench.snapshot();
    ImGui::GetIO().DeltaTime = 1 / 60.0f;
    Context c{bench, *now, state, camera, renderer(), timeS, 1 / 60.0, width_, height_, scale_};
    ImGui::NewFrame();
    panels->draw(c);
    ImGui::Render();
    if (state.wishes.save) {  // As the window does.
      if (state.wishes.save->empty())
        bench.save({});
      else
        bench.saveAs(*state.wishes.save, {});
      state.wishes.save.reset();
    }
    if (state.wishes.copy) bench.saveCopy(*std::exchange(state.wishes.copy, {}), {});
  }
  void frames(int count) {
    for (int i = 0; i < count; ++i) frame();
  }
  /// Frames until it is so. Throws after five minutes: the test ends there.
  template <class Condition>
  void until(const Condition& condition, const char* what) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);  // on a busy machine
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) throw std::runtime_error(std::string("never: ") + what);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      frame();
    }
  }
  /// Sends an edit and waits until it is done.
  void edit(const std::string& label, std::function<void(engine::Document&)> change) {
    const size_t before = bench.snapshot()->done;
    bench.edit(label, std::move(change));
    until([&] { return bench.snapshot()->done == before + 1; }, label.c_str());
    frame();
  }
  void run(const char* id) {
    now = bench.snapshot();
    Context c{bench, *now, state, camera, renderer(), timeS, 1 / 60.0, width_, height_, scale_};
    const Action* action = findAction(id);
    ASSERT_NE(action, nullptr) << id;
    action->run(c, action->argument);
    frames(3);
  }

  void moveTo(float x, float y) {
    ImGui::GetIO().MousePos = {x, y};
    frame();
  }
  void press() {
    ImGui::GetIO().MouseDown[0] = true;
    frame();
  }
  void release() {
    ImGui::GetIO().MouseDown[0] = false;
    frame();
  }
  void click(ImVec2 at) {
    moveTo(at.x, at.y);
    frame();
    press();
    release();
    frame();
  }
  void doubleClick(ImVec2 at) {
    moveTo(at.x, at.y);
    frames(30);  // Else it would be a third click.
    for (int i = 0; i < 2; ++i) {
      press();
      release();
    }
    frame();
  }
  void drag(ImVec2 from, ImVec2 to, int steps = 10) {
    moveTo(from.x, from.y);
    frame();
    press();
    for (int i = 1; i <= steps; ++i) {
      const float t = float(i) / float(steps);
      moveTo(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
    }
    release();
    frame();
  }
  void type(const std::string& text) {
    ImGui::GetIO().AddInputCharactersUTF8(text.c_str());
    frames(2);
  }
  void key(ImGuiKey key) {
    ImGui::GetIO().KeysDown[ImGui::GetIO().KeyMap[key]] = true;
    frame();
    ImGui::GetIO().KeysDown[ImGui::GetIO().KeyMap[key]] = false;
    frame();
  }

  /// Where an item stands in the frame that was drawn last: found by hovering a grid of places. `path`: the window's
  /// name and ids of the item, from outside to inside. NaN: nowhere.
  ImVec2 find(const char* window, std::initializer_list<const char*> path) {
    return findFrom(ImGui::FindWindowByName(window), path);
  }
  ImVec2 findFrom(ImGuiWindow* window, std::initializer_list<const char*> path) {
    return window ? findId(window, idOf(window, path)) : ImVec2(NAN, NAN);
  }
  /// Whether it is there, in the next picture.
  bool isAt(ImVec2 at, const char* window, std::initializer_list<const char*> path) {
    if (std::isnan(at.x)) return false;
    moveTo(at.x, at.y);
    frame();
    ImGuiWindow* in = ImGui::FindWindowByName(window);
    return in && GImGui->HoveredId == idOf(in, path);
  }
  ImVec2 findId(ImGuiWindow* window, ImGuiID id) {
    const ImVec2 kept = ImGui::GetIO().MousePos;
    ImVec2 found{NAN, NAN};
    for (float y = window->Pos.y + 5; y < window->Pos.y + window->Size.y && std::isnan(found.x); y += 7) {
      for (float x = window->Pos.x + 8; x < window->Pos.x + window->Size.x; x += 13) {
        moveTo(x, y);
        if (GImGui->HoveredId == id) {
          found = {x, y};
          break;
        }
      }
    }
    moveTo(kept.x, kept.y);
    return found;
  }
  static ImGuiWindow* child(const char* parent, const char* name) {
    for (ImGuiWindow* window : GImGui->Windows) {
      if (window->ParentWindow && std::string(window->ParentWindow->Name) == parent &&
          std::string(window->Name).find(std::string("/") + name + "_") != std::string::npos)
        return window;
    }
    return nullptr;
  }

  /// One for all tests: it is only asked for bounds.
  static render::Renderer& renderer() {
    static render::Renderer one;
    return one;
  }

  engine::Workbench bench;
  StudioState state;
  Camera camera;
  std::unique_ptr<Panels> panels;
  std::shared_ptr<const engine::Snapshot> now;
  double timeS = 0;

 private:
  static ImGuiID idOf(const ImGuiWindow* window, std::initializer_list<const char*> path) {
    ImGuiID id = window->ID;
    for (const char* part : path) id = ImHashStr(part, 0, id);
    return id;
  }

  float width_, height_, scale_;
};

/// A document of everything: two pieces, a part, a guide of each kind, one hidden, one locked.
inline void fill(PanelsRig& rig) {
  rig.bench.addBlock(Vec3d(12, 12, 8), 1, {.voxelMm = 1});
  rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1; }, "a block");
  rig.bench.addSphere(5, {.voxelMm = 1, .centreMm = Vec3d(20, 0, 0)});
  rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 2; }, "a ball");
  rig.edit("Everything", [](engine::Document& d) {
    d.pieces[0].name = "Head";
    d.pieces[1].name = "A piece with a name that is much longer than any list is wide";
    engine::Part part;
    part.name = "Skull";
    part.mesh = std::make_shared<clay::TriangleMesh>(
        clay::TriangleMesh{{Vec3d(0, 0, 0), Vec3d(5, 0, 0), Vec3d(0, 5, 0), Vec3d(0, 0, 5)},
                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}});
    d.add(part);
    for (const auto kind :
         {engine::Guide::Kind::plane, engine::Guide::Kind::line, engine::Guide::Kind::point, engine::Guide::Kind::curve,
          engine::Guide::Kind::keepOutBox, engine::Guide::Kind::ruler, engine::Guide::Kind::angle}) {
      engine::Guide guide;
      guide.kind = kind;
      if (kind == engine::Guide::Kind::curve || kind == engine::Guide::Kind::angle)
        guide.pointsMm = {Vec3d(0, 0, 30), Vec3d(10, 0, 30), Vec3d(10, 10, 30)};
      if (kind == engine::Guide::Kind::ruler) guide.pointsMm = {Vec3d(0, 0, 30), Vec3d(3, 4, 30)};
      if (kind == engine::Guide::Kind::plane) guide.feel = engine::Guide::Feel::well;
      d.add(guide);
    }
    d.guides[1].visible = false;
    d.guides[2].locked = true;
  });
  rig.state.shown.firstStart = false;
  rig.frames(2);
}

}  // namespace argil::studio
