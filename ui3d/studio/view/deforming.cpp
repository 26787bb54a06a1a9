#include "ui3d/studio/view/deforming.h"

#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/store/store.h"
#include "clay/whole/deform.h"

namespace argil::studio {

void Deforming::stop() {
  job_.reset();  // Cancels and waits: its threads look at the job with every brick.
  result_.reset();
  making_.reset();
}

bool Deforming::update(std::optional<DeformBox>& box, const engine::Document& document, bool held, const Edit& edit,
                       const std::function<void()>& endMerge) {
  if (!box) {
    const bool had = busy();
    stop();
    made_.reset();
    waits_ = false;
    return had;
  }
  if (!made_ || made_->piece != box->piece || made_->base != box->base) {  // A new box.
    stop();
    made_ = *box;
    made_->rest();
    shown_ = before_ = box->base;
    waits_ = false;
    ++boxes_;
  }
  const engine::Piece* piece = document.piece(box->piece);
  if (piece && piece->version == shown_) {
    before_ = shown_;
    waits_ = false;
  }
  if (!piece || piece->locked || (piece->version != shown_ && piece->version != before_)) {
    box.reset();
    return true;
  }
  if (box->pose.translation != piece->pose.translation || !box->pose.rotation.isApprox(piece->pose.rotation, 0))
    box->pose = piece->pose;

  if (box->cancel) {
    stop();
    if (shown_ != box->base) show(*box, box->base, edit);
    endMerge();
    box.reset();
    return true;
  }
  bool changed = false;
  if (job_ && job_->done()) {
    take(*box, edit);
    changed = true;
  }
  const DeformBox& followed = making_ ? *making_ : *made_;
  if (!held && !box->held && !box->sameShape(followed)) {
    stop();
    box->trouble.clear();
    if (box->warp()) {
      begin(*box);
    } else {
      made_ = *box;
      if (shown_ != box->base) show(*box, box->base, edit);
    }
    changed = true;
  }
  const double progress = job_ ? std::floor(100 * job_->job().fraction()) / 100 : -1;
  changed |= progress != box->progress;
  box->progress = progress;
  if (box->apply && !job_) {
    box->apply = false;
    if (box->trouble.empty()) {
      endMerge();
      box.reset();
      return true;
    }
  }
  return changed;
}

void Deforming::begin(const DeformBox& box) {
  making_ = box;
  result_ = std::make_shared<Result>();
  job_ = std::make_unique<engine::BackgroundJob>([base = box.base, warp = box.warp(), result = result_](Job& job) {
    result->version = clay::deform(base, *warp, clay::Store::make(base.store()->precision()), &job);
  });
}

void Deforming::take(DeformBox& box, const Edit& edit) {
  try {
    job_->wait();
    const clay::Version version = result_->version;
    show(box, version, edit);
  } catch (const Error& error) {
    box.trouble = error.what();
  }
  made_ = making_;  // What was refused is not tried again until it is another.
  stop();
}

void Deforming::show(const DeformBox& box, const clay::Version& version, const Edit& edit) {
  before_ = shown_;
  shown_ = version;
  waits_ = true;
  edit(
      "Deform",
      [id = box.piece, version](engine::Document& document) {
        if (engine::Piece* piece = document.piece(id)) piece->version = version;
      },
      fmt::format("deform box {}", boxes_));
}

}  // namespace argil::studio
