#include "ui3d/studio/files/keep_flow.h"

#include <utility>

namespace argil::studio {

bool KeepFlow::unkept(const engine::Snapshot& now) {
  return now.file.unsaved && (!now.file.path.empty() || (now.history && !now.history->empty()));
}

KeepFlow::Next KeepFlow::want(Departure departure, const engine::Snapshot& now) {
  departure_ = std::move(departure);
  if (stage_ != Stage::idle) return Next::nothing;
  if (!unkept(now)) return Next::go;
  stage_ = Stage::asking;
  return Next::nothing;
}

KeepFlow::Next KeepFlow::answer(Answer answer, const engine::FileState& file) {
  if (stage_ != Stage::asking) return Next::nothing;
  if (answer == Answer::save) {
    if (file.path.empty()) {
      stage_ = Stage::naming;
      return Next::chooseName;
    }
    stage_ = Stage::saving;
    refusedBefore_ = file.refused;
    restingSinceS_ = -1;
    return Next::save;
  }
  stage_ = Stage::idle;
  return answer == Answer::dontSave ? Next::go : Next::nothing;
}

void KeepFlow::named() {
  if (stage_ != Stage::naming) return;
  stage_ = Stage::saving;
  restingSinceS_ = -1;
}

void KeepFlow::notNamed() {
  if (stage_ == Stage::naming) stage_ = Stage::idle;
}

KeepFlow::Next KeepFlow::follow(const engine::FileState& file, bool underWay, double timeS) {
  if (stage_ != Stage::saving) return Next::nothing;
  if (underWay || file.saving) {
    restingSinceS_ = -1;
    return Next::nothing;
  }
  if (!file.unsaved) {
    stage_ = Stage::idle;
    return Next::go;
  }
  if (file.refused > refusedBefore_) {
    refusedBefore_ = file.refused;
    stage_ = Stage::naming;
    return Next::chooseName;
  }
  if (restingSinceS_ < 0) restingSinceS_ = timeS;
  if (timeS - restingSinceS_ >= kFailedS) stage_ = Stage::idle;
  return Next::nothing;
}

void KeepFlow::stay() {
  stage_ = Stage::idle;
}

}  // namespace argil::studio
