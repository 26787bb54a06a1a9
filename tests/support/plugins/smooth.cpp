// A brush in C++: towards the mean of the next six voxels, until it is told to fail.

#include <stdexcept>

#include "plugins/sdk/argil_plugin.hpp"

namespace {

struct Smooth {
  explicit Smooth(const argil_stroke& stroke) : amount(stroke.amount), fails(stroke.parameters[0] > 0.5f) {}
  void operator()(const argil_batch&, const argil_plugin_cpp::Brick& brick) const {
    if (fails) throw std::runtime_error("the wind has turned");
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (int z = 0; z < 8; ++z) {
          const float mean = (brick.phi(x - 1, y, z) + brick.phi(x + 1, y, z) + brick.phi(x, y - 1, z) +
                              brick.phi(x, y + 1, z) + brick.phi(x, y, z - 1) + brick.phi(x, y, z + 1)) /
                             6;
          const float here = brick.phi(x, y, z);
          brick.out(x, y, z) = here + brick.weight(x, y, z) * amount * (mean - here);
        }
  }
  float amount;
  bool fails;
};

constexpr const char* kNumbers[] = {"fails"};
const argil_brush kBrushes[] = {
    argil_plugin_cpp::brush<Smooth>("test.smooth.smooth", 1, ARGIL_LEAVES_VALUES, kNumbers, 1)};

}  // namespace

ARGIL_PLUGIN_BRUSHES("test.smooth", "1.0.0", kBrushes)
