#pragma once
// Runs a piece of work once per SIMD target that this machine can run.

#include <hwy/targets.h>

#include <string>
#include <utility>
#include <vector>

namespace argil::tests {

/// Calls work(name) with each target in turn chosen for every kernel, then puts the best one back.
template <class Work>
void forEachSimdTarget(const Work& work) {
  const std::vector<int64_t> targets = [] {
    std::vector<int64_t> found;
    for (int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) found.push_back(left & -left);
    return found;
  }();
  for (const int64_t target : targets) {
    // A target that no kernel was compiled for would fall through to another: it shows nothing.
    if (!(target & HWY_TARGETS)) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    work(std::string(hwy::TargetName(target)));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

}  // namespace argil::tests
