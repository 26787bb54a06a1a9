#include "ui3d/studio/view/frame_log.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

namespace argil::studio {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kPause = 250;  // ms: frames farther apart than this are not of one motion.

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto at = values.begin() + std::ptrdiff_t(std::min(double(values.size()) - 1, part * double(values.size())));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Json spread(const std::vector<double>& values) {
  return {{"n", values.size()},
          {"median", quantile(values, 0.5)},
          {"p99", quantile(values, 0.99)},
          {"max", quantile(values, 1)}};
}

Json spread(const haptics::Histogram& times, uint64_t stalls) {
  return {{"n", times.count()},
          {"median", times.quantileUs(0.5) * 1e-3},
          {"p99", times.quantileUs(0.99) * 1e-3},
          {"max", times.maxUs() * 1e-3},
          {"over_100_ms", stalls}};
}

double perSecond(double ms) {
  return ms > 0 ? 1000 / ms : 0;
}

Json histogram(const std::vector<double>& counts) {
  Json bins = Json::object();
  for (const double count : counts) {
    Json& bin = bins[std::to_string(int(count))];
    bin = bin.is_null() ? 1 : bin.get<int>() + 1;
  }
  return bins;
}

}  // namespace

void PictureCost::add(const FrameDone& f) {
  if (!f.shown || !f.still || !f.clay) return;
  double passes = 0;
  for (const render::PassTime& pass : f.passes) passes += pass.us;
  ms_ = std::max(double(f.endedNs - f.beganNs - f.waitedNs) * 1e-6, passes / 1000);
}

void FrameLog::add(const FrameDone& f) {
  uploadedBytes_ += f.uploadedBytes;
  largestUpload_ = std::max(largestUpload_, f.uploadedBytes);
  if (!f.shown) return;
  ++frames_;
  stillFrames_ += f.still ? 1 : 0;
  clayFrames_ += f.clay ? 1 : 0;
  sinceClay_ = f.clay ? 0 : sinceClay_ + 1;
  ends_.push_back(f.endedNs);
  begins_.push_back(f.beganNs);
  const double ms = double(f.endedNs - f.beganNs) * 1e-6;
  frameMs_.push_back(ms);
  if (f.moving) {
    movingMs_.push_back(ms);
    const double since = double(f.endedNs - lastMovingNs_) * 1e-6;
    if (since < kPause) intervalMs_.push_back(since);
    if (wasMoving_) gapMs_.push_back(since);
    if (wasMoving_ && wasStroke_ && f.stroke) strokeGapMs_.push_back(since);
    lastMovingNs_ = f.endedNs;
  }
  wasMoving_ = f.moving;
  wasStroke_ = f.stroke;
  if (f.oldestSampleNs > 0) {
    sampleMs_.push_back(double(f.endedNs - f.oldestSampleNs) * 1e-6);
    sampleFrames_.push_back(double(ends_.end() - std::upper_bound(ends_.begin(), ends_.end(), f.oldestSampleNs)));
    sampleBegun_.push_back(double(begins_.end() - std::upper_bound(begins_.begin(), begins_.end(), f.oldestSampleNs)));
  }
}

void FrameLog::turned(int64_t ns, int64_t coreNs) {
  turns_.add(ns);
  coreTurns_.add(coreNs);
  stalls_ += ns > kStallNs ? 1 : 0;
  coreStalls_ += coreNs > kStallNs ? 1 : 0;
}

double FrameLog::framesPerSecond(int64_t nowNs) const {
  return double(ends_.end() - std::lower_bound(ends_.begin(), ends_.end(), nowNs - 1'000'000'000));
}

std::string FrameLog::report(const Facts& facts, const engine::Snapshot& now) const {
  Json json;
  json["frames"] = frames_;
  json["still_frames"] = stillFrames_;
  json["clay_frames"] = clayFrames_;
  json["frames_since_clay"] = sinceClay_;
  json["first_picture_ms"] = facts.firstPictureMs;
  json["opened_ms"] = facts.openedMs;
  json["fps_moving"] = {{"n", intervalMs_.size()},
                        {"p50", perSecond(quantile(intervalMs_, 0.5))},
                        {"p99", perSecond(quantile(intervalMs_, 0.99))}};
  json["frame_ms"] = spread(frameMs_);
  json["moving_frame_ms"] = spread(movingMs_);
  json["moving_gap_ms"] = spread(gapMs_);
  json["stroke_gap_ms"] = spread(strokeGapMs_);
  json["turn_ms"] = spread(turns_, stalls_);
  json["turn_core_ms"] = spread(coreTurns_, coreStalls_);
  json["uploaded_bytes"] = uploadedBytes_;
  json["largest_upload_bytes"] = largestUpload_;
  json["sample_to_screen_ms"] = spread(sampleMs_);
  json["sample_to_screen_frames"] = spread(sampleFrames_);
  json["sample_to_screen_histogram"] = histogram(sampleFrames_);
  json["sample_to_screen_begun_histogram"] = histogram(sampleBegun_);
  json["edit_us"] = {{"p50", now.editP50Us}, {"p99", now.editP99Us}};
  json["strokes"] = now.strokes;
  json["points"] = now.points;
  json["steps"] = now.done;
  json["clay_bytes"] = now.clayBytes;
  json["dropped_samples"] = facts.droppedSamples;
  json["device"] = facts.device;
  json["device_bytes"] = facts.deviceBytes;
  json["device_losses"] = facts.losses;
  json["rss_bytes"] = facts.rssBytes;
  json["validating"] = facts.validating;
  json["validation_messages"] = facts.validation;
  return json.dump(2) + "\n";
}

uint64_t residentBytes() {
  std::ifstream in("/proc/self/statm");
  uint64_t total = 0, resident = 0;
  in >> total >> resident;
  return resident * uint64_t(sysconf(_SC_PAGESIZE));
}

}  // namespace argil::studio
