#include "ui3d/studio/ui_input.h"

#include <imgui.h>

#include <algorithm>

#include "ui3d/studio/kit/kit.h"
#include "ui3d/studio/window.h"

namespace argil::studio {
namespace {

using Kind = Event::Kind;

constexpr double kLongestFrameS = 0.1;  // After a rest animations go on, they do not jump.

}  // namespace

UiInput::UiInput() {
  context_ = ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // Panels are docked: there is nothing to remember.
  io.LogFilename = nullptr;
  io.BackendFlags |= ImGuiBackendFlags_HasMouseCursors | ImGuiBackendFlags_RendererHasVtxOffset;
  const auto map = [&io](ImGuiKey key, int ours) { io.KeyMap[key] = ours; };
  map(ImGuiKey_Tab, int(Key::tab));
  map(ImGuiKey_LeftArrow, int(Key::left));
  map(ImGuiKey_RightArrow, int(Key::right));
  map(ImGuiKey_UpArrow, int(Key::up));
  map(ImGuiKey_DownArrow, int(Key::down));
  map(ImGuiKey_PageUp, int(Key::pageUp));
  map(ImGuiKey_PageDown, int(Key::pageDown));
  map(ImGuiKey_Home, int(Key::home));
  map(ImGuiKey_End, int(Key::end));
  map(ImGuiKey_Insert, int(Key::insert));
  map(ImGuiKey_Delete, int(Key::remove));
  map(ImGuiKey_Backspace, int(Key::backspace));
  map(ImGuiKey_Space, ' ');
  map(ImGuiKey_Enter, int(Key::enter));
  map(ImGuiKey_Escape, int(Key::escape));
  for (const auto& [key, letter] : {std::pair{ImGuiKey_A, 'A'},
                                    {ImGuiKey_C, 'C'},
                                    {ImGuiKey_V, 'V'},
                                    {ImGuiKey_X, 'X'},
                                    {ImGuiKey_Y, 'Y'},
                                    {ImGuiKey_Z, 'Z'}})
    map(key, letter);
  io.ClipboardUserData = this;
  io.GetClipboardTextFn = readClipboard;
  io.SetClipboardTextFn = writeClipboard;
}

UiInput::~UiInput() {
  ImGui::DestroyContext(context_);
}

void UiInput::useClipboardOf(Window* window) {
  window_ = window;
}

const char* UiInput::readClipboard(void* self) {
  UiInput& me = *static_cast<UiInput*>(self);
  if (me.window_) me.clipboard_ = me.window_->clipboard();
  return me.clipboard_.c_str();
}

void UiInput::writeClipboard(void* self, const char* text) {
  UiInput& me = *static_cast<UiInput*>(self);
  me.clipboard_ = text;
  if (me.window_) me.window_->setClipboard(me.clipboard_);
}

void UiInput::feed(const Event& event) {
  ImGuiIO& io = ImGui::GetIO();
  const auto place = [&] { io.MousePos = ImVec2(event.x, event.y); };
  const auto modifiers = [&] {
    io.KeyShift = (event.modifiers & kShift) != 0;
    io.KeyCtrl = (event.modifiers & kControl) != 0;
    io.KeyAlt = (event.modifiers & kAlt) != 0;
    io.KeySuper = (event.modifiers & kSuper) != 0;
  };
  switch (event.kind) {
    case Kind::move:
    case Kind::enter:
      place();
      break;
    case Kind::press:
    case Kind::release:
      place();
      modifiers();
      io.MouseDown[int(event.button)] = event.kind == Kind::press;
      break;
    case Kind::wheel:
      io.MouseWheel += event.dy;
      io.MouseWheelH -= event.dx;
      break;
    case Kind::keyDown:
    case Kind::keyUp:
      modifiers();
      if (size_t(event.key) < IM_ARRAYSIZE(io.KeysDown)) io.KeysDown[size_t(event.key)] = event.kind == Kind::keyDown;
      break;
    case Kind::text:
      io.AddInputCharacter(event.character);
      break;
    case Kind::leave:
      if (!ImGui::IsAnyMouseDown()) io.MousePos = ImVec2(-FLT_MAX, -FLT_MAX);
      break;
    case Kind::focus:
      if (!event.on) {
        std::fill(std::begin(io.KeysDown), std::end(io.KeysDown), false);
        modifiers();
      }
      io.AddFocusEvent(event.on);
      break;
    default:
      break;
  }
}

void UiInput::beginFrame(double seconds, float width, float height, float scale) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = ImVec2(width, height);
  io.DisplayFramebufferScale = ImVec2(scale, scale);
  io.DeltaTime = float(std::clamp(seconds, 1e-4, kLongestFrameS));
  kit::steerMenus();
  ImGui::NewFrame();
}

render::UiFrame UiInput::frame() const {
  static_assert(sizeof(ImDrawVert) == sizeof(render::UiVertex) && sizeof(ImDrawIdx) == sizeof(uint16_t));
  render::UiFrame frame;
  const ImDrawData* data = ImGui::GetDrawData();
  if (!data || !data->Valid) return frame;
  frame.width = data->DisplaySize.x;
  frame.height = data->DisplaySize.y;
  frame.vertices.reserve(size_t(data->TotalVtxCount));
  frame.indices.reserve(size_t(data->TotalIdxCount));
  for (int i = 0; i < data->CmdListsCount; ++i) {
    const ImDrawList& list = *data->CmdLists[i];
    const auto firstVertex = uint32_t(frame.vertices.size()), firstIndex = uint32_t(frame.indices.size());
    for (const ImDrawVert& v : list.VtxBuffer) frame.vertices.push_back({v.pos.x, v.pos.y, v.uv.x, v.uv.y, v.col});
    frame.indices.insert(frame.indices.end(), list.IdxBuffer.begin(), list.IdxBuffer.end());
    for (const ImDrawCmd& command : list.CmdBuffer) {
      if (command.UserCallback || command.ElemCount == 0) continue;
      const ImVec4& clip = command.ClipRect;
      frame.commands.push_back({{clip.x - data->DisplayPos.x, clip.y - data->DisplayPos.y, clip.z - data->DisplayPos.x,
                                 clip.w - data->DisplayPos.y},
                                uint32_t(reinterpret_cast<uintptr_t>(command.GetTexID())),
                                firstIndex + command.IdxOffset,
                                command.ElemCount,
                                firstVertex + command.VtxOffset});
    }
  }
  return frame;
}

bool UiInput::wantsMouse() const {
  return ImGui::GetIO().WantCaptureMouse;
}
bool UiInput::wantsText() const {
  return ImGui::GetIO().WantTextInput;
}

}  // namespace argil::studio
