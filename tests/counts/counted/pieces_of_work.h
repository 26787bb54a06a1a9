#pragma once
// What is counted.

#include <functional>
#include <string>
#include <vector>

namespace argil::tests {

struct PieceOfWork {
  std::string name;
  int times;                                              ///< Of what is counted.
  std::function<std::function<void(int times)>()> begin;  ///< Makes what is needed; what it gives does the work.
};

[[nodiscard]] std::vector<PieceOfWork> piecesOfWork();

}  // namespace argil::tests
