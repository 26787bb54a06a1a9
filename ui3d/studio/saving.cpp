// From the document to its file and to pictures in files, with what of the studio goes along.

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "ui3d/studio/files/save_words.h"
#include "ui3d/studio/files/settings.h"
#include "ui3d/studio/session_window.h"
#include "ui3d/studio/view/face.h"

namespace argil::studio {
namespace {

constexpr int kThumbnailPixels = 256;
constexpr int kLeastPixels = 16, kMostPixels = 8192;  // What the renderer takes.

// Of a picture as wide as the window for its height, its longer edge so long.
std::array<int, 2> pixelsOf(float width, float height, int longest) {
  const double factor = longest / double(std::max(width, height));
  const auto edge = [&](float units) {
    return std::clamp(int(std::lround(double(units) * factor)), kLeastPixels, kMostPixels);
  };
  return {edge(width), edge(height)};
}

}  // namespace

// Title, face, recent files: what follows the document's file.
void SessionWindow::followFile() {
  const engine::FileState& file = now_->file;
  if (file.opened != openedShown_) {
    openedShown_ = file.opened;
    const std::string idBefore = state_.toolId;
    const engine::Tool toolBefore = state_.tool();
    viewGiven_ = file.face && applyFace(*file.face, state_, camera_);
    faceTool_.reset();
    if (state_.toolId != idBefore || !(state_.tool() == toolBefore)) faceTool_ = state_.tool();
    changed();
  }
  if (now_->madeCount != madeShown_) {
    madeShown_ = now_->madeCount;
    // Beside what is there it may stand out of the view.
    const engine::Document& document = *now_->document;
    showMade_ = document.pieces.size() + document.parts.size() > 1 && !document.guide(now_->made);
  }
  if (std::string title = windowTitle(file); title != titleShown_) {
    window_.setTitle(title);
    titleShown_ = std::move(title);
  }
  if (file.path == pathShown_) return;
  pathShown_ = file.path;
  if (file.path.empty() || !options_.play.empty()) return;
  state_.remember(file.path);
  saveSettings(state_);  // A crash must not take the list along.
}

// As the view shows it, without panels and cursor.
render::Shot SessionWindow::pictureShot() {
  render::Shot shot = this->shot();
  shot.overlays.cursor.reset();
  shot.look.scaleBar = state_.look.scaleBar;
  return shot;
}

// Of a save the picture thread draws the picture for those who choose among files; then it is saved. True when that
// thread was given work. No picture is no reason not to save. The renderer is free.
bool SessionWindow::serveSave() {
  if (!state_.wishes.save && !state_.wishes.copy) return false;
  if (!thumbnail_ && !renderer_.bounds().empty()) {
    thumbnail_ = std::make_shared<std::vector<std::byte>>();
    render::Shot shot = pictureShot();
    shot.look.scaleBar = false;
    shot.stereo = {};
    const auto [width, height] = pixelsOf(width_, height_, kThumbnailPixels);
    frame_ = {};
    pictures_.run([this, shot, quality = state_.quality, w = width, h = height, png = thumbnail_] {
      try {
        renderer_.setQuality(quality);
        const std::vector<uint8_t> made = render::encodePng(renderer_.render(shot, w, h));
        const auto* bytes = reinterpret_cast<const std::byte*>(made.data());
        png->assign(bytes, bytes + made.size());
      } catch (const Error&) {
        if (renderer_.deviceLost()) throw;
      }
    });
    return true;
  }
  engine::SaveExtras extras;
  extras.face = faceText(state_, camera_);
  if (thumbnail_) extras.thumbnail = std::move(*std::exchange(thumbnail_, nullptr));
  if (state_.wishes.save && state_.wishes.save->empty())
    bench_.save(extras);
  else if (state_.wishes.save)
    bench_.saveAs(*state_.wishes.save, extras);
  if (state_.wishes.copy) bench_.saveCopy(*state_.wishes.copy, extras);
  state_.wishes.save.reset();
  state_.wishes.copy.reset();
  return false;
}

// A picture for a file is drawn by the picture thread and written beside it. True when that thread was given work.
bool SessionWindow::servePicture() {
  if (pictureJob_) {
    if (!pictureJob_->done()) return false;
    attempt([&] {
      const auto job = std::exchange(pictureJob_, nullptr);
      job->wait();
      bench_.tell(engine::Message::Level::done,
                  fmt::format("Saved {}: {} × {} pixels.", pictureFile_.filename().string(), fileImage_->width,
                              fileImage_->height));
    });
    fileImage_.reset();
  }
  if (fileImage_ && !fileImage_->rgba.empty()) {
    pictureJob_ = std::make_unique<engine::BackgroundJob>(
        [image = fileImage_, file = pictureFile_](Job&) { render::writePng(*image, file.string()); });
    return false;
  }
  if (!state_.wishes.picture || !waiting_.pieces.empty() || !partsWaiting_.empty()) return false;
  const PictureWish wish = *std::exchange(state_.wishes.picture, {});
  pictureFile_ = wish.file;
  fileImage_ = std::make_shared<render::Image>();
  const auto [width, height] =
      pixelsOf(width_, height_,
               wish.longestPixels > 0 ? wish.longestPixels : int(std::lround(std::max(width_, height_) * scale_)));
  frame_ = {};
  pictures_.run([this, shot = pictureShot(), quality = state_.quality, w = width, h = height, image = fileImage_] {
    renderer_.setQuality(quality);
    *image = renderer_.render(shot, w, h);
  });
  return true;
}

}  // namespace argil::studio
