#include "ui3d/studio/files/save_flow.h"

#include <utility>

namespace argil::studio {

bool SaveFlow::unkept(const engine::Snapshot& now) {
  return now.file.unsaved && (!now.file.path.empty() || (now.history && !now.history->empty()));
}

SaveFlow::Next SaveFlow::want(Departure departure, const engine::Snapshot& now) {
  departure_ = std::move(departure);
  if (stage_ != Stage::idle) return Next::nothing;
  if (!unkept(now)) return Next::go;
  stage_ = Stage::asking;
  return Next::nothing;
}

SaveFlow::Next SaveFlow::answer(Answer answer, const engine::FileState& file) {
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

void SaveFlow::named() {
  if (stage_ != Stage::naming) return;
  stage_ = Stage::saving;
  restingSinceS_ = -1;
}

void SaveFlow::notNamed() {
  if (stage_ == Stage::naming) stage_ = Stage::idle;
}

SaveFlow::Next SaveFlow::follow(const engine::FileState& file, bool underWay, double timeS) {
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

void SaveFlow::stay() {
  stage_ = Stage::idle;
}

}  // namespace argil::studio
