#include "clay/brush/quality.h"

#include <fmt/format.h>

#include "clay/base/error.h"

namespace argil::clay {

void Quality::check() const {
  const auto within = [](const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high))
      throw Error(fmt::format("a quality's {} of {:g} is out of range; choose {:g} to {:g}", name, value, low, high));
  };
  within("tolerance", tolerance, 0.01, 1);
  within("passes", passes, 0, 16);
  within("drift", drift, 0.25, 2);
  within("trail", trail, 1, 32);
  within("together", together, 0, 48);
  within("flow step", flowStep, 0.02, 1);
  within("level rounds", levelRounds, 1, 8);
}

}  // namespace argil::clay
