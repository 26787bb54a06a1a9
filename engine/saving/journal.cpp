#include "engine/saving/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "clay/base/error.h"
#include "engine/text/json_text.h"
#include "engine/text/script_place.h"
#include "engine/text/tool_text.h"
#include "io/records/blob.h"
#include "io/records/document_file.h"

namespace argil::engine {
namespace {

using io::RecordKind;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr size_t kMostLabel = 500, kMostPath = 4096;
constexpr size_t kMostBegin = size_t{64} << 20;
constexpr double kMostRecord = 9007199254740992.0;

double seconds(WallTime at) {
  return std::chrono::duration<double>(at.time_since_epoch()).count();
}
WallTime wallTime(double s) {
  return WallTime(std::chrono::duration_cast<WallTime::duration>(std::chrono::duration<double>(s)));
}

std::string textOf(const ordered_json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void put(io::RecordSink& sink, RecordKind kind, const ordered_json& value) {
  const std::string text = textOf(value);
  sink.put({kind, io::RecordCodec::raw, 0, 0, 0}, std::as_bytes(std::span(text)));
}

std::string shortened(const std::string& label) {
  return label.size() <= kMostLabel ? label : label.substr(0, kMostLabel);
}

uint64_t whole(const Place& place) {
  if (!place.value().is_number_unsigned()) place.fail("must be a whole number");
  (void)place.number(0, kMostRecord);
  return place.value().get<uint64_t>();
}

WallTime timeAt(const Place& place) {
  return wallTime(place.at("at").number(0, 1e11));
}

// A JSON number would lose bits of it.
std::string stampText(uint64_t stamp) {
  return fmt::format("{:016x}", stamp);
}

uint64_t readStamp(const Place& place) {
  const std::string text = place.text();
  uint64_t stamp = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), stamp, 16);
  if (error != std::errc() || end != text.data() + text.size()) place.fail("is no stamp");
  return stamp;
}

JournalBegin readBegin(io::JournalReader& journal, const Place& place) {
  place.keys({"state", "at"});
  const std::vector<std::byte> bytes = io::getBlob(io::BlobKind::state, whole(place.at("state")), journal, kMostBegin);
  const json root =
      parseJson({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "the journal", "a journal's begin");
  std::vector<std::string> unknown;
  JournalBegin begin;
  if (const auto schema = Place(root, "the journal", "").maybe("schema")) begin.schema = whole(*schema);
  const Place at(root, "the journal", "", begin.schema > uint64_t{io::kDocumentSchema} ? &unknown : nullptr);
  // "save" is what journals had that knew no stamps.
  at.keys({"schema", "writer", "sequence", "file", "save", "stamp", "states", "done", "saved"});
  begin.writer = at.at("writer").text();
  if (const auto sequence = at.maybe("sequence")) begin.sequence = whole(*sequence);
  begin.file = at.at("file").text();
  if (const auto stamp = at.maybe("stamp")) begin.stamp = readStamp(*stamp);
  for (const Place& each : at.at("states").items()) {
    each.keys({"label", "id"});
    begin.states.emplace_back(each.at("label").text(), whole(each.at("id")));
  }
  begin.done = whole(at.at("done"));
  if (begin.done >= begin.states.size()) at.at("done").fail("is beyond the steps");
  begin.savedState = whole(at.at("saved"));
  begin.at = timeAt(place);
  return begin;
}

JournalStroke readStroke(const Place& place) {
  checkToolKeys(place, {"mirrors", "radial", "at"});
  JournalStroke stroke;
  stroke.tool = readTool(place);
  stroke.images = readImages(place, "mirrors");
  return stroke;
}

// Time, place, pressure and quaternion (zero: none).
constexpr size_t kSampleNumbers = 9;
constexpr size_t kSamplesARecord = io::kMostRecordBody / (kSampleNumbers * sizeof(double));

PathPoint pointOf(const double* numbers, bool whole) {
  PathPoint point{numbers[0], {numbers[1], numbers[2], numbers[3]}};
  if (whole) {
    point.pressure = numbers[4];
    const Eigen::Vector4d q(numbers[5], numbers[6], numbers[7], numbers[8]);
    if (!q.allFinite() || !(point.pressure >= 0 && point.pressure <= 1))
      throw Error("damaged: a sample is not finite", Error::Kind::work);
    if (!q.isZero()) point.rotation = Eigen::Quaterniond(q);
  }
  if (!std::isfinite(point.timeS) || !point.mm.allFinite())
    throw Error("damaged: a point is not finite", Error::Kind::work);
  return point;
}

// Follows the events. What cannot be read stops the story for what depends on it: after a hole nobody knows which
// document was in work (an undo may be lost) nor which samples a stroke had, until a step is told whose document is
// there.
class Teller {
 public:
  explicit Teller(io::JournalReader& journal) : journal_(journal) {}

  void take(const io::RecordView& record, uint64_t damaged) {
    if (std::exchange(story_.damaged, damaged) != damaged) ++holes_;
    try {
      follow(record);
    } catch (const Error&) {
      ++story_.unread;
      ++holes_;
    }
  }

  JournalStory finish() {
    if (!begun_) throw Error("damaged: the journal's begin is not there", Error::Kind::work);
    // The newest document that is there, and the strokes that lead on from it.
    size_t from = done_;
    while (from > 0 && steps_[from].state == 0) --from;
    if (steps_[from].state == 0) throw Error("damaged: no document of the journal is whole", Error::Kind::work);
    bool all = true;
    for (size_t i = from + 1; i <= done_ && all; ++i) {
      if (steps_[i].stroke) story_.strokes.push_back(*steps_[i].stroke);
      all = steps_[i].stroke && steps_[i].stroke->ended;
      if (!all) story_.unread += done_ - i + 1;
    }
    if (all && open_ && !open_->points.empty()) story_.strokes.push_back(*open_);
    JournalStory::Led led{{}, true};
    for (size_t i = 0; i < steps_.size(); ++i) {
      if (led.all && steps_[i].stroke) led.strokes.push_back(std::move(*steps_[i].stroke));
      led.all = led.all && steps_[i].stroke && led.strokes.back().ended;
      if (steps_[i].state == 0 || (i > from && !story_.strokes.empty())) continue;
      if (i == from) story_.done = story_.states.size();
      story_.states.emplace_back(steps_[i].label, steps_[i].state);
      story_.ledBy.push_back(std::exchange(led, {{}, true}));
    }
    return std::move(story_);
  }

 private:
  struct Step {
    std::string label;
    io::RecordId state = 0;
    uint64_t number = 0;
    std::optional<JournalStroke> stroke;  // that led to it; not `ended` where its samples go on behind a hole
  };

  // Samples of the open stroke that follow the ones that are known.
  [[nodiscard]] bool goesOn() const { return open_ && openHoles_ == holes_; }

  void follow(const io::RecordView& record) {
    if (record.header.kind == RecordKind::strokePoints || record.header.kind == RecordKind::strokeSamples) {
      if (!goesOn()) return;
      const bool whole = record.header.kind == RecordKind::strokeSamples;
      const size_t bytes = (whole ? kSampleNumbers : 4) * sizeof(double);
      for (size_t at = 0; at + bytes <= record.body.size(); at += bytes) {
        double numbers[kSampleNumbers];
        std::memcpy(numbers, record.body.data() + at, bytes);
        open_->points.push_back({pointOf(numbers, whole), false});
      }
      return;
    }
    const std::string_view text(reinterpret_cast<const char*>(record.body.data()), record.body.size());
    const json value = parseJson(text, "the journal", "an event of a journal");
    const Place place(value, "the journal", "");
    switch (record.header.kind) {
      case RecordKind::journalBegin:
        if (begun_) break;
        story_.begin = readBegin(journal_, place);
        for (const auto& [label, id] : story_.begin.states) steps_.push_back({label, id, 0, std::nullopt});
        done_ = story_.begin.done;
        story_.last = story_.begin.at;
        begun_ = true;
        break;
      case RecordKind::step: {
        if (!begun_) break;
        Step step{place.at("label").text(), 0, whole(place.at("number")), std::nullopt};
        if (step.number != lastNumber_ + 1) {
          ++holes_;
          ++story_.unread;
        }
        lastNumber_ = step.number;
        if (open_ && !open_->points.empty()) {
          step.stroke = *open_;
          step.stroke->ended = goesOn();
        }
        open_.reset();  // what is known of it belongs to this step
        sureHoles_ = holes_;
        if (place.at("merged").truth() && done_ > 0) {
          steps_.resize(done_ + 1);
          steps_.back() = std::move(step);
        } else {
          steps_.resize(done_ + 1);
          steps_.push_back(std::move(step));
          ++done_;
        }
        story_.last = timeAt(place);
        break;
      }
      case RecordKind::state: {
        const uint64_t number = whole(place.at("number"));
        for (Step& step : steps_) {
          if (step.number == number && number != 0) step.state = whole(place.at("state"));
        }
        break;
      }
      case RecordKind::went: {
        open_.reset();  // its end is missing: what it became was left behind
        const size_t done = whole(place.at("done"));
        if (!begun_ || done >= steps_.size())
          throw Error("damaged: it went to a step that is not there", Error::Kind::work);
        done_ = done;
        // It counts steps from the first one, of which some may be missing.
        if (holes_ > 0) ++holes_;
        story_.last = timeAt(place);
        break;
      }
      case RecordKind::strokeBegin:
        // Else nobody knows what it was done to; what is known of the one before it stays.
        if (sureHoles_ != holes_) throw Error("damaged: the step before a stroke is missing", Error::Kind::work);
        open_.reset();
        open_ = readStroke(place);
        openHoles_ = holes_;
        story_.last = timeAt(place);
        break;
      case RecordKind::strokeLift:
        if (goesOn()) open_->points.push_back({{}, true});
        break;
      case RecordKind::replaying: {
        JournalReplay replay{whole(place.at("stroke")), place.at("boot").text(), whole(place.at("times"))};
        story_.replay.reset();
        if (replay.stroke != 0) story_.replay = std::move(replay);
        break;
      }
      case RecordKind::saving:
        story_.saving = place.at("file").text();
        break;
      case RecordKind::strokeEnd:
        if (goesOn()) open_.reset();  // it changed nothing; behind a hole its step may be missing
        break;
      default:
        break;  // of a later Argil
    }
  }

  io::JournalReader& journal_;
  JournalStory story_;
  std::vector<Step> steps_;
  size_t done_ = 0;
  bool begun_ = false;
  std::optional<JournalStroke> open_;
  uint64_t holes_ = 0;       // places where events may be missing, so far
  uint64_t openHoles_ = 0;   // when the open stroke began
  uint64_t sureHoles_ = 0;   // when it was last known which document was in work
  uint64_t lastNumber_ = 0;  // of a step
};

}  // namespace

void putBegin(io::RecordSink& sink, const JournalBegin& begin, io::RecordIds& ids, io::RecordSet& held) {
  ordered_json root;
  root["schema"] = io::kDocumentSchema;
  root["writer"] = begin.writer;
  root["sequence"] = begin.sequence;
  root["file"] = begin.file.string();
  root["stamp"] = stampText(begin.stamp);
  root["states"] = ordered_json::array();
  for (const auto& [label, id] : begin.states) root["states"].push_back({{"label", label}, {"id", id}});
  root["done"] = begin.done;
  root["saved"] = begin.savedState;
  const std::string text = textOf(root);
  const io::RecordId id = io::putBlob(io::BlobKind::state, std::as_bytes(std::span(text)), ids, held, sink);
  put(sink, RecordKind::journalBegin, {{"state", id}, {"at", seconds(begin.at)}});
}

void putStep(io::RecordSink& sink, uint64_t number, const std::string& label, bool merged, WallTime at) {
  put(sink, RecordKind::step,
      {{"number", number}, {"label", shortened(label)}, {"merged", merged}, {"at", seconds(at)}});
}

void putState(io::RecordSink& sink, uint64_t number, io::RecordId state) {
  put(sink, RecordKind::state, {{"number", number}, {"state", state}});
}

void putWent(io::RecordSink& sink, size_t done, WallTime at) {
  put(sink, RecordKind::went, {{"done", done}, {"at", seconds(at)}});
}

void putSaving(io::RecordSink& sink, const std::filesystem::path& file) {
  if (file.string().size() <= kMostPath) put(sink, RecordKind::saving, {{"file", file.string()}});
}

void putStrokeBegin(io::RecordSink& sink, const Tool& tool, const StrokeImages& images, WallTime at) {
  ordered_json root;
  putTool(root, tool);
  putImages(root, images, "mirrors");
  root["at"] = seconds(at);
  put(sink, RecordKind::strokeBegin, root);
}

void putStrokePoints(io::RecordSink& sink, const std::vector<JournalPoint>& points) {
  std::vector<double> numbers;
  const auto flush = [&] {
    if (!numbers.empty())
      sink.put({RecordKind::strokeSamples, io::RecordCodec::raw, 0, 0, 0}, std::as_bytes(std::span(numbers)));
    numbers.clear();
  };
  for (const JournalPoint& point : points) {
    if (point.lift) {
      flush();
      put(sink, RecordKind::strokeLift, ordered_json::object());
      continue;
    }
    const auto& [timeS, mm, pressure, rotation] = point.point;
    const Eigen::Vector4d q = rotation ? rotation->coeffs() : Eigen::Vector4d(Eigen::Vector4d::Zero());
    numbers.insert(numbers.end(), {timeS, mm.x(), mm.y(), mm.z(), pressure, q[0], q[1], q[2], q[3]});
    if (numbers.size() == kSampleNumbers * kSamplesARecord) flush();
  }
  flush();
}

void putStrokeEnd(io::RecordSink& sink) {
  put(sink, RecordKind::strokeEnd, ordered_json::object());
}

void putReplay(io::JournalReader& journal, const JournalReplay& replay) {
  const std::string text = textOf({{"stroke", replay.stroke}, {"boot", replay.boot}, {"times", replay.times}});
  journal.append(RecordKind::replaying, std::as_bytes(std::span(text)));
}

std::string bootId() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(file, id);
  return id;
}

JournalStory readStory(io::JournalReader& journal) {
  Teller teller(journal);
  journal.forEachEvent([&](const io::RecordView& record, uint64_t damaged) { teller.take(record, damaged); });
  return teller.finish();
}

}  // namespace argil::engine
