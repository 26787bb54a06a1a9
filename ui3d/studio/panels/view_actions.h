#pragma once
// Commands that turn, zoom, cut open and shade the picture. For actions.cpp.

#include <vector>

#include "ui3d/studio/panels/actions.h"

namespace argil::studio {

void addViewRows(std::vector<Action>& rows);

}  // namespace argil::studio
