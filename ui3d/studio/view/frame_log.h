#pragma once
// What the window measured, frame by frame, and the report of it.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/workbench.h"
#include "haptics/base/histogram.h"
#include "render/renderer/renderer.h"

namespace argil::studio {

/// What the picture thread tells of a frame.
struct FrameDone {
  bool shown = false;                ///< False: minimised.
  bool still = true;                 ///< The full picture.
  bool moving = false;               ///< A camera, a stroke or an animation was going on.
  bool stroke = false;               ///< The hand worked, or what it did was still worked on.
  bool clay = true;                  ///< The clay was drawn; else the panels alone, over the picture that was there.
  int64_t beganNs = 0, endedNs = 0;  ///< CLOCK_MONOTONIC: from its first upload until it was handed to the window.
  int64_t waitedNs = 0;              ///< Of that time: until the screen took the picture.
  int64_t oldestSampleNs = 0;        ///< SurfaceChanges::oldestSampleNs; 0: none.
  uint64_t uploadedBytes = 0, uploads = 0, deviceBytes = 0, triangles = 0;
  std::vector<render::PassTime> passes;
};

/// What the full picture costs, without waits for the screen: whether it can be drawn in motion too. One thread.
class PictureCost {
 public:
  void add(const FrameDone& frame);
  /// Of the last full picture; a second before there was one.
  [[nodiscard]] double ms() const { return ms_; }

 private:
  double ms_ = 1000;
};

/// One thread. Kept: 8 bytes a frame and figure.
class FrameLog {
 public:
  static constexpr int64_t kStallNs = 100'000'000;  ///< What a person notices.

  void add(const FrameDone& frame);
  /// The window's thread answered for so long, between two waits: by the clock, and of its own work.
  void turned(int64_t ns, int64_t coreNs);
  /// For the panel: of the last second.
  [[nodiscard]] double framesPerSecond(int64_t nowNs) const;
  [[nodiscard]] double lastSampleToScreenMs() const { return sampleMs_.empty() ? 0 : sampleMs_.back(); }
  [[nodiscard]] uint64_t frames() const { return frames_; }

  struct Facts {
    std::string device;
    uint64_t deviceBytes = 0;
    bool validating = false;
    std::vector<std::string> validation;
    /// Since the program began: the first picture that shows something of the file that it was started with;
    double firstPictureMs = 0;
    double openedMs = 0;  ///< and the first of all of it as it is to be: clay, where the file held a mesh.
    uint64_t rssBytes = 0;
    uint64_t droppedSamples = 0;
    size_t losses = 0;  ///< Of the device.
  };
  /// As JSON: frames, rates while moving, times of a frame and of a turn of the window's thread, bytes uploaded, from
  /// sample to screen, edits, device.
  [[nodiscard]] std::string report(const Facts& facts, const engine::Snapshot& now) const;

 private:
  uint64_t frames_ = 0, clayFrames_ = 0, sinceClay_ = 0, stillFrames_ = 0, uploadedBytes_ = 0, largestUpload_ = 0;
  std::vector<int64_t> ends_, begins_;  // Of every frame, to count between sample and screen.
  std::vector<double> sampleBegun_;     // Frames begun after a sample until the one that shows it.
  std::vector<double> frameMs_, movingMs_, intervalMs_, sampleMs_, sampleFrames_;
  std::vector<double> gapMs_;        // From one picture in motion to the next, however long it took.
  std::vector<double> strokeGapMs_;  // The same within strokes.
  bool wasMoving_ = false, wasStroke_ = false;
  haptics::Histogram turns_, coreTurns_;
  uint64_t stalls_ = 0, coreStalls_ = 0;
  int64_t lastMovingNs_ = 0;
};

/// The resident memory of this process, bytes.
[[nodiscard]] uint64_t residentBytes();

}  // namespace argil::studio
