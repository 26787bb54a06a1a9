#include "ui3d/studio/panels/panels.h"

namespace argil::studio {

struct Panels::State {
  std::array<float, 4> free{};
};

Panels::Panels() : state_(std::make_unique<State>()) {}
Panels::~Panels() = default;
void Panels::draw(Context& context) { state_->free = {0, 0, context.width, context.height}; }
void Panels::dropped(Context&, const std::string&) {}
void Panels::applyTheme(Theme, float) {}
std::array<float, 4> Panels::free() const { return state_->free; }

}  // namespace argil::studio
