// From the document to the window: what the renderer is sent, and when.

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "ui3d/studio/kit/layout.h"
#include "ui3d/studio/session_window.h"
#include "ui3d/studio/view/cursor.h"
#include "ui3d/studio/view/fingerprint.h"

namespace argil::studio {
namespace {

constexpr engine::Id kPreview = UINT32_MAX, kGrown = UINT32_MAX - 1;
constexpr double kStillS = 0.2;     // The full picture comes when nothing has moved for so long.
constexpr double kSlowMs = 20;      // A full picture that takes less is drawn in motion too.
constexpr double kSluggishMs = 60;  // More than this is felt while typing.
constexpr double kAbove = 0.002;    // Of the way to the eye: a line over the clay is not hidden in it.
constexpr double kSameSize = 0.01;  // A view or a model that differs by less is as large: that is rounding.
// Beyond that zooming there and back would not bring all sizes back.
constexpr double kLeastViewMm = 1.2, kMostViewMm = 12000;
constexpr double kAgainS = 1;    // After a picture failed.
constexpr double kClearMm = 15;  // Above a model that is opened, of the tip of a simulated device.

bool same(const render::PieceLook& a, const render::PieceLook& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translationMm == b.translationMm && a.colour.r == b.colour.r &&
         a.colour.g == b.colour.g && a.colour.b == b.colour.b && a.visible == b.visible && a.dimmed == b.dimmed &&
         a.hideMasked == b.hideMasked && a.materials == b.materials && a.grownMm == b.grownMm && a.scale == b.scale;
}

template <class Thing>
render::PieceLook lookOf(const Thing& thing) {
  render::PieceLook look;
  look.rotation = thing.pose.rotation;
  look.translationMm = thing.pose.translation;
  look.colour = {thing.colour[0], thing.colour[1], thing.colour[2], 1};
  look.visible = thing.visible;
  look.dimmed = thing.locked;
  return look;
}

}  // namespace

// Takes over what the picture thread did. True when the renderer is free.
bool SessionWindow::collect() {
  if (!pictures_.busy()) return true;
  try {
    if (!pictures_.take()) return false;
  } catch (const Error& e) {
    lost(e);
    return true;
  }
  if (frame_.beganNs == 0) return true;  // It was a picture for a file.
  log_.add(frame_);
  if (frame_.uploads > 0) hoverStale_ = true;
  if (!frame_.shown) {
    shotShown_ = panelsShown_ = 0;
    return true;
  }
  cost_.add(frame_);
  state_.figures.uploadedBytes += frame_.uploadedBytes;
  // Of pictures of the clay alone: panels that show what drawing panels took would be drawn for ever.
  if (frame_.clay) {
    state_.figures.still = frame_.still;
    state_.figures.frameMs = double(frame_.endedNs - frame_.beganNs) * 1e-6;
    state_.figures.passes = frame_.passes;
    state_.figures.framesPerSecond = log_.framesPerSecond(frame_.endedNs);
    state_.figures.sampleToScreenMs = log_.lastSampleToScreenMs();
  }
  state_.figures.triangles = frame_.triangles;
  state_.figures.deviceBytes = frame_.deviceBytes;
  const bool loading =
      jobs_ > 0 || (now_->document->pieces.empty() && now_->document->parts.empty() && !options_.file.empty());
  const double soFarMs = double(frame_.endedNs - startNs_) * 1e-6;
  if (firstPictureMs_ == 0 && (frame_.triangles > 0 || options_.file.empty())) firstPictureMs_ = soFarMs;
  if (openedMs_ == 0 && !loading && (frame_.triangles > 0 || options_.file.empty())) openedMs_ = soFarMs;
  return true;
}

// A lost device comes back with all that it had; any other failure leaves the clay as it is.
void SessionWindow::lost(const Error& error) {
  const double now = window_.nowS();
  shotShown_ = panelsShown_ = 0;
  fileImage_.reset();
  if (!renderer_.deviceLost()) {
    if (now - failedS_ > 5 * kAgainS) bench_.tell(engine::Message::Level::error, error.what());
    failedS_ = now;
    bench_.resendSurfaces();
    parts_.clear();
    preview_.reset();
    return;
  }
  if (now - failedS_ < kAgainS) throw error;  // It does not come back.
  failedS_ = now;
  renderer_.recover();
  ++losses_;
  sendFont();
  panels_.forgetPictures();
  uiSteps_ = 2;
  bench_.resendSurfaces();
  waiting_ = {};
  partsWaiting_.clear();
  parts_.clear();
  preview_.reset();
  placed_.clear();
  placedFor_.reset();
  bench_.tell(engine::Message::Level::warning,
              "The graphics device was lost and has been started anew; the clay is untouched.");
  changed();
}

void SessionWindow::sendFont() {
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
  renderer_.setUiTexture(0, width, height, 1, pixels);
  ImGui::GetIO().Fonts->SetTexID(nullptr);
}

void SessionWindow::takeSurfaces() {
  engine::SurfaceChanges changes = bench_.takeSurfaces();
  if (!changes.pieces.empty()) changed();
  // Shows the new surface where and as it is.
  const auto settle = [this](engine::Id id, render::PieceLook& look) {
    look.grownMm = 0;
    const Vec3d factors = std::exchange(look.scale, Vec3d::Ones());
    const engine::Piece* piece = now_->document->piece(id);
    if (!piece) return;
    look.visible = piece->visible;
    // A stretch leaves the pose as it is.
    if (factors != Vec3d::Constant(factors.x())) look.translationMm = piece->pose.translation;
  };
  for (engine::SurfaceChange& change : changes.pieces) {
    if (state_.growing && state_.growing->piece == change.piece) {
      // Here is what was shown before it was there.
      if (state_.grown == state_.growing) state_.grown.reset();
      state_.growing.reset();
      if (const auto look = placed_.find(change.piece); change.whole && look != placed_.end() && !state_.grown)
        settle(change.piece, look->second);  // placed with that surface, in the same picture
    }
    waiting_.pieces.push_back(std::move(change));
  }
  if (changes.oldestSampleNs && !waiting_.oldestSampleNs) waiting_.oldestSampleNs = changes.oldestSampleNs;
}

// Where pieces and parts stand. Surfaces come on their own way.
void SessionWindow::follow() {
  takeSurfaces();
  followPreview();
  const std::optional<GrownPiece> grown = state_.scaled ? state_.scaled : state_.grown;
  const engine::Id worked = state_.planeCut ? state_.planeCut->arguments.pieces.front() : now_->document->active;
  if (placedFor_ == now_->document && placedGrown_ == grown && placedWorked_ == worked) return;
  placedWorked_ = worked;
  placedFor_ = now_->document;
  placedGrown_ = grown;
  shotShown_ = 0;  // Places and looks are no part of the shot.
  const engine::Document& document = *now_->document;
  std::map<engine::Id, render::PieceLook> wanted;
  const auto scale = [&grown](engine::Id id, render::PieceLook& look) {
    if (!grown || grown->piece != id) return;
    look.scale = grown->factors;
    look.translationMm = grown->aboutMm + grown->factors.cwiseProduct(look.translationMm - grown->aboutMm);
  };
  for (const engine::Piece& piece : document.pieces) {
    wanted[piece.id] = lookOf(piece);
    wanted[piece.id].hideMasked = piece.hideMasked;
    wanted[piece.id].materials = engine::materialColours(piece);
    wanted[piece.id].dimmed |= document.pieces.size() > 1 && piece.id != worked;
    if (grown && grown->piece == piece.id) wanted[piece.id].grownMm = grown->mm;
    scale(piece.id, wanted[piece.id]);
    if (!grown || grown->piece != piece.id || !grown->shape) continue;
    wanted[kGrown] = wanted[piece.id];
    wanted[piece.id].visible = false;
    if (parts_[kGrown] == grown->shape.get()) continue;
    parts_[kGrown] = grown->shape.get();
    std::erase_if(partsWaiting_, [](const auto& part) { return part.first == kGrown; });
    partsWaiting_.emplace_back(kGrown, grown->shape);
  }
  if (!wanted.contains(kGrown)) std::erase_if(partsWaiting_, [](const auto& part) { return part.first == kGrown; });
  for (const engine::Part& part : document.parts) {
    wanted[part.id] = lookOf(part);
    scale(part.id, wanted[part.id]);
    if (parts_[part.id] == part.mesh.get()) continue;
    parts_[part.id] = part.mesh.get();
    partsWaiting_.emplace_back(part.id, part.mesh);
  }
  const bool newWorld =
      std::none_of(wanted.begin(), wanted.end(), [this](const auto& w) { return seen_.count(w.first) != 0; });
  seen_.clear();
  for (const auto& [id, look] : wanted) seen_.insert(id);
  for (const auto& [id, look] : placed_)
    if (!wanted.count(id) && parts_.erase(id)) renderer_.remove(id);
  for (const auto& [id, look] : wanted) {
    const auto before = placed_.find(id);
    if (before == placed_.end() || !same(before->second, look)) renderer_.place(id, look);
  }
  placed_ = std::move(wanted);
  if (newWorld && !placed_.empty()) sizeDue_ = true;
  if (newWorld && !placed_.empty()) showAll_ = !std::exchange(viewGiven_, false);
  hoverStale_ = true;  // What is under the cursor may have gone.
  changed();
}

// Tools that were of use for one model are as large as another as a whole, or smaller than its voxels. Where the person
// wants it their sizes go with the model, once it is all there, or with what is seen.
void SessionWindow::followToolSizes() {
  if (hand_.active() || sizing_ || line_) return;
  const SizeBy by = state_.sizeBy;
  // As large as they are now.
  if (std::exchange(sizedBy_, by) != by && by == SizeBy::view) state_.sizedForMm = viewSizeMm();
  if (by == SizeBy::view) {
    if (const double seen = viewSizeMm(); std::abs(seen / state_.sizedForMm - 1) > kSameSize) state_.sizeTools(seen);
    sizeDue_ = false;
    return;
  }
  if (!sizeDue_ || placed_.empty()) return;
  render::Box all;
  for (const auto& [id, look] : placed_) {
    if (!look.visible) continue;
    const render::Box box = renderer_.bounds(id);
    if (box.empty()) {
      if (const engine::Piece* piece = now_->document->piece(id);
          piece && piece->version && piece->version.stats().bricks == 0)
        continue;
      return;  // Its surface is on its way.
    }
    all.add(box);
  }
  sizeDue_ = false;
  // Nobody holds a simulated device: what is opened must not appear around its tip.
  if (!all.empty() && bench_.usesSimulated())
    steerTo(Vec3d(all.centre().x(), all.centre().y(), all.max.z() + kClearMm + state_.tool().radiusMm), false);
  if (all.empty() || by != SizeBy::model) return;
  const double modelMm = all.size().maxCoeff();
  if (!(modelMm > 0) || std::abs(modelMm / state_.sizedForMm - 1) <= kSameSize) return;
  state_.sizeTools(modelMm);
  if (faceTool_) state_.tools[std::string(faceTool_->id)] = *faceTool_;  // It was saved as the document needs it.
}

double SessionWindow::viewSizeMm() const {
  return std::clamp(camera_.view().heightAtTarget(), kLeastViewMm, kMostViewMm);
}

// What a file holds, from the moment that it is read to the moment that it is clay.
void SessionWindow::followPreview() {
  std::shared_ptr<const clay::TriangleMesh> preview = bench_.preview();
  if (preview == preview_) return;
  shotShown_ = 0;
  if (preview_) renderer_.remove(kPreview);
  std::erase_if(partsWaiting_, [](const auto& part) { return part.first == kPreview; });
  preview_ = std::move(preview);
  if (preview_) {
    render::PieceLook look;
    look.dimmed = true;
    renderer_.place(kPreview, look);
    partsWaiting_.emplace_back(kPreview, preview_);
    if (placed_.empty()) showAll_ = true;
  }
  changed();
}

void SessionWindow::showWhole(bool glide) {
  render::Box box = renderer_.bounds();
  if (box.empty()) return;
  const auto [left, top, right, bottom] = panels_.free();
  const double aspect = freeAspect({left, top, right, bottom}, width_, height_);  // As wide as what no panel covers.
  if (glide) {
    camera_.focus(box, aspect);
  } else {
    camera_.set(render::View::named("iso", box, aspect, camera_.view().projection));
  }
  changed();
}

std::optional<render::Cursor> SessionWindow::cursor() {
  if (state_.drawnCurve || state_.planeCut) return std::nullopt;
  const engine::Tool tool = toolSent_.value_or(engine::Tool());
  CursorOptions options;
  options.heightUnits = height_;
  const auto surface = [this](const Vec3d& origin, const Vec3d& direction) -> std::optional<render::Cursor::Footprint> {
    const auto hit = renderer_.pick(origin, direction, state_.look.section);
    if (!hit) return std::nullopt;
    return render::Cursor::Footprint{origin + hit->distanceMm * direction, hit->normal};
  };
  if (bench_.usesPointer()) {
    if (hand_.active() || drag_ == Drag::line) {
      const Camera::Ray at = ray(mouse_);
      const auto under = surface(at.origin, at.direction);
      return under ? std::optional(pointerCursor(*under, tool, camera_.view(), options, hand_.pressed()))
                   : std::nullopt;
    }
    const bool free = drag_ == Drag::none || drag_ == Drag::size || (drag_ == Drag::ring && sizing_);
    if (!footprint_ || overWidget_ || !free || widgets_.placing()) return std::nullopt;
    engine::Tool shown = tool;
    if (sizing_) shown.radiusMm = state_.tool().radiusMm;
    return pointerCursor(*footprint_, shown, camera_.view(), options);
  }
  if (!bench_.usesPointer() && (stylus_.flags & haptics::kStale)) return std::nullopt;
  return makeCursor(stylus_, tool, camera_.view(), options, footprintOf(stylus_, tool, camera_.view(), surface));
}

render::Shot SessionWindow::shot() {
  render::Shot shot;
  shot.view = camera_.view();
  shot.look = state_.look;
  shot.look.scaleBar = false;  // picture_labels draws it where no panel covers it.
  shot.stereo = state_.stereo;
  shot.overlays.cursor = cursor();
  const Context c = context();
  widgets_.draw(c, shot.overlays);
  if (line_) {
    render::Polyline line;
    line.pointsMm = Hand::placesUnder(*line_, inEye(dragFrom_), inEye(mouse_), false);
    for (Vec3d& place : line.pointsMm) place += kAbove * (camera_.view().position - place);
    line.colour = tintOf(toolSent_.value_or(engine::Tool()));
    line.depth = render::Depth::xray;
    if (line.pointsMm.size() >= 2) shot.overlays.polylines.push_back(std::move(line));
  }
  return shot;
}

// Sends a picture to be drawn, if it would not be the one that is shown. The renderer is free.
bool SessionWindow::draw() {
  const double now = window_.nowS();
  if (window_.minimised() || now - failedS_ < kAgainS) return false;
  if (showAll_ && !renderer_.bounds().empty()) {
    showAll_ = false;
    showWhole(false);
  }
  if (showMade_ && !renderer_.bounds(now_->made).empty()) {
    showMade_ = false;
    showWhole(true);
  }
  const render::Shot shot = this->shot();
  // Compared at full quality: what is thinned is no motion.
  const uint64_t picture = fingerprint(shot, state_.quality), panels = fingerprint(panelsFrame_);
  const bool pending = !waiting_.pieces.empty() || !partsWaiting_.empty();
  // Panels that change under the person's hand must not wait for a slow picture.
  if (picture != shotShown_ || (panels != panelsShown_ && cost_.ms() > kSluggishMs && now - activeS_ < kStillS))
    changed();
  const bool moving = now - changedS_ < kStillS;
  const render::Quality quality = moving && cost_.ms() > kSlowMs ? state_.quality.moving() : state_.quality;
  const bool still = quality == state_.quality;
  // The picture that is shown serves as long as nothing in it changes, and it is as good as it is to be by now.
  const bool clay = picture != shotShown_ || pending || (still && !stillShown_) || !renderer_.holdsPicture();
  if (!clay && panels == panelsShown_) return false;
  shotShown_ = picture;
  panelsShown_ = panels;
  if (clay) stillShown_ = still;
  frame_ = {};
  frame_.still = stillShown_;
  frame_.moving = moving && clay;
  frame_.stroke = hand_.active() || now_->inStroke;
  frame_.clay = clay;
  nextFrameS_ = now + 1.0 / state_.framesPerSecond;
  if (clay) nextClayS_ = nextFrameS_;
  if (clay) takeSurfaces();  // What came since, while panels were laid out: as new as can be.
  pictures_.run([this, clay, shot, quality,
                 changes = std::make_shared<engine::SurfaceChanges>(std::exchange(waiting_, {})),
                 parts = std::exchange(partsWaiting_, {}), ui = panelsFrame_] {
    frame_.beganNs = haptics::nowNs();
    frame_.oldestSampleNs = changes->oldestSampleNs;
    for (const engine::SurfaceChange& change : changes->pieces) {  // None where only panels are drawn.
      if (change.whole || change.removed) renderer_.remove(change.piece);
      if (change.removed) continue;
      if (change.whole)
        if (const auto look = placed_.find(change.piece); look != placed_.end())
          renderer_.place(change.piece, look->second);
      const render::UploadStats sent = renderer_.update(change.piece, change.delta);
      frame_.uploadedBytes += sent.bytes;
      frame_.uploads += sent.writes;
    }
    for (const auto& [id, mesh] : parts) {
      const render::UploadStats sent = renderer_.updatePart(id, *mesh);
      frame_.uploadedBytes += sent.bytes;
      if (const auto look = placed_.find(id); look != placed_.end()) renderer_.place(id, look->second);
    }
    renderer_.setQuality(quality);
    frame_.shown = clay ? renderer_.present(shot, ui) : renderer_.presentPanels(ui);
    frame_.waitedNs = renderer_.waitedNs();
    frame_.endedNs = haptics::nowNs();
    frame_.deviceBytes = renderer_.deviceBytes();
    frame_.triangles = renderer_.drawStats().trianglesDrawn;
    frame_.passes = renderer_.passTimes();
  });
  return true;
}

}  // namespace argil::studio
