#pragma once
// A session at work in virtual time, what it did and what it promised by then: for power_cuts.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/hash.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/saving/undo_budget.h"
#include "engine/session/recovery.h"
#include "tests/support/write_trace.h"

namespace argil::engine {

namespace fs = std::filesystem;
using failing::TraceOp;

// Virtual time. The autosave writes what came within its syncS of 0.25 s together.
inline constexpr double kPointMs = 20, kOpMs = 100, kFlushMs = 250;
inline constexpr double kMostLostMs = 1000;
inline constexpr double kRadiusMm = 4;

inline uint64_t hashOf(const Document& document) {
  clay::Hasher hasher;
  for (const Piece& piece : document.pieces) {
    hasher.add(piece.version.hash());
    hasher.add(piece.pose.translation.data(), 24);
  }
  return hasher.value();
}

inline std::string hex(uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

// What the trace is told between the writes: what was done and promised by then.
enum class Said : uint64_t { acted = 1, flushed, saving, saved, repeating, repeated };
inline void say(Said what, uint64_t value, uint64_t file = 0) {
  failing::note(uint64_t(what) << 56 | file << 48 | value);
}

// All that was done, in actions: a point of a stroke, or another step.
class Truth {
 public:
  struct Moment {
    uint64_t actions = 0;  // done by then
    uint64_t hash = 0;
    std::vector<uint64_t> history;
    size_t done = 0;
    DocumentPtr document;
    // A stroke that began then.
    Tool tool;
    std::vector<Vec3d> points;
  };
  std::vector<Moment> moments;
  std::vector<double> actedMs;  // when each was

  void add(const Session& session, std::vector<uint64_t> history) {
    Moment moment;
    moment.actions = actedMs.size();
    moment.document = session.document();
    moment.hash = hashOf(*moment.document);
    moment.history = std::move(history);
    moment.done = session.undoSteps();
    moments.push_back(std::move(moment));
  }

  struct Place {
    size_t moment = 0, points = 0;
  };
  [[nodiscard]] uint64_t actionsOf(const Place& place) const { return moments[place.moment].actions + place.points; }

  // Where a document with these strokes on top stands; the latest such place of the first `acted` actions.
  [[nodiscard]] std::optional<Place> find(uint64_t hash, const std::vector<JournalStroke>& strokes, uint64_t acted,
                                          size_t* from) const {
    for (size_t m = moments.size(); m-- > 0;) {
      if (moments[m].hash != hash) continue;
      Place place{m, 0};
      bool all = true;
      for (size_t i = 0; i < strokes.size() && all; ++i) {
        const std::vector<Vec3d>& points = moments[place.moment].points;
        std::vector<Vec3d> given;
        for (const JournalPoint& point : strokes[i].points) {
          if (!point.lift) given.push_back(point.point.mm);
        }
        all = !given.empty() && given.size() <= points.size() &&
              std::equal(given.begin(), given.end(), points.begin()) &&
              strokes[i].tool.id == moments[place.moment].tool.id;
        if (strokes[i].ended) {
          all = all && given.size() == points.size() && place.moment + 1 < moments.size();
          ++place.moment;
        } else {
          all = all && i + 1 == strokes.size();
          place.points = given.size();
        }
      }
      if (!all || actionsOf(place) > acted) continue;
      *from = m;
      return place;
    }
    return std::nullopt;
  }

  // Of the document in which the stroke was ended after so many points.
  uint64_t hashAt(const Place& place) {
    if (place.points == 0) return moments[place.moment].hash;
    const auto [known, fresh] = partial_.try_emplace({place.moment, place.points}, 0);
    if (fresh) {
      const Moment& moment = moments[place.moment];
      Session session({{.label = {}, .document = moment.document}}, 0);
      session.beginStroke(moment.tool);
      for (size_t i = 0; i < place.points; ++i) session.addPoint(1e-3 * kPointMs * double(i), moment.points[i]);
      session.endStroke();
      known->second = hashOf(*session.document());
    }
    return known->second;
  }

 private:
  std::map<std::pair<size_t, size_t>, uint64_t> partial_;
};

// What a cut disk has to hold.
struct Promise {
  uint64_t acted = 0, flushed = 0;
  struct File {
    std::optional<size_t> saved, saving;  // moments
    std::optional<uint64_t> before;       // hash of what somebody else had there
  };
  std::map<uint64_t, File> files;
  bool repeating = false;

  void hear(const TraceOp& op) {
    const uint64_t file = op.at >> 48 & 0xff, value = op.at & 0xffffffffffff;
    switch (Said(op.at >> 56)) {
      case Said::acted:
        acted = std::max(acted, value);
        break;
      case Said::flushed:
        flushed = std::max(flushed, value);
        break;
      case Said::saving:
        files[file].saving = value;
        break;
      case Said::saved:
        files[file].saved = value, files[file].saving.reset();
        break;
      case Said::repeating:
        repeating = true;
        break;
      case Said::repeated:
        repeating = false;
        break;
    }
  }
};

inline constexpr std::array kFiles{"docs/a.argil", "docs/other.argil"};
inline constexpr const char* kJournals = "state/argil/journal";

// A session at work, its journal flushed four times in a virtual second.
class Desk {
 public:
  Desk(fs::path root, Truth& truth, uint64_t rollBytes = uint64_t{512} << 20) : root_(std::move(root)), truth_(truth) {
    AutosaveOptions options;
    options.folder = root_ / kJournals;
    options.syncS = 1e6;  // by flush() alone
    options.rollBytes = rollBytes;
    autosave_ = std::make_unique<Autosave>(options, [](const std::string& trouble) { EXPECT_EQ(trouble, ""); });
  }
  ~Desk() {
    if (session) session->setWatch(nullptr);
  }

  void begin(std::vector<HistoryState> states, size_t done, std::shared_ptr<DocumentRecords> documentRecords,
             std::shared_ptr<const Base> base, std::string writer, std::optional<Autosave::Continued> continued = {},
             const std::vector<std::shared_ptr<io::RecordSource>>& sources = {}) {
    documentRecords_ = std::move(documentRecords);
    base_ = std::move(base);
    writer_ = std::move(writer);
    records_ = autosave_->begin(states, done, documentRecords_, base_, writer_, std::move(continued), sources);
    session = std::make_unique<Session>(std::move(states), done);
    session->setReader([this](uint64_t kept, const Document& near) {
      return readStep(*autosave_, *documentRecords_, records_, kept, near);
    });
    session->setWatch(autosave_.get());
    // What is in no memory was seen before.
    for (size_t i = 0;
         i < session->states().size() && !truth_.moments.empty() && i < truth_.moments.back().history.size(); ++i)
      spilled_[i] = truth_.moments.back().history[i];
    seen();
    flush();
  }
  void beginUntitled() {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    auto first = std::make_shared<const Document>(
        Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), kRadiusMm)));
    begin({{.label = {}, .document = first}}, 0, std::make_shared<DocumentRecords>(), nullptr, newWriter());
  }

  void beginStroke(uint64_t seed) {
    random_ = Random(seed);
    Tool tool;
    tool.radiusMm = 1;
    tool.id = std::array{"carve", "add", "smooth"}[seed % 3];
    truth_.moments.back().tool = tool;
    session->beginStroke(tool);
    at_ = kRadiusMm * random_.inBall().normalized();
  }
  void points(size_t count) {
    for (size_t i = 0; i < count; ++i) {
      auto& points = truth_.moments.back().points;
      session->addPoint(1e-3 * kPointMs * double(points.size()), at_);
      points.push_back(at_);
      at_ = kRadiusMm * (at_ + 0.3 * random_.inBall()).normalized();
      acted(kPointMs);
    }
  }
  void endStroke() {
    session->endStroke();
    seen();
  }
  void stroke(uint64_t seed, size_t count) {
    beginStroke(seed);
    points(count);
    endStroke();
  }
  void move() {
    session->change("Move", [](Document& d) { d.pieces[0].pose.translation.x() += 0.125; });
    step();
  }
  void undo() {
    session->undo();
    step();
  }
  void redo() {
    session->redo();
    step();
  }
  void goTo(size_t steps) {
    session->goTo(steps);
    step();
  }

  struct Saving {
    uint64_t file;
    size_t moment;
    SaveRequest request;
    std::shared_ptr<const Base> base;
  };
  Saving beginSave(uint64_t file) {
    Saving saving{file,
                  truth_.moments.size() - 1,
                  {session->states(), session->undoSteps(), {}, documentRecords_, base_, {records_}, writer_},
                  nullptr};
    say(Said::saving, saving.moment, file);
    autosave_->saving(root_ / kFiles[file]);
    return saving;
  }
  void save(Saving& saving) const {
    saving.base = saveDocument(root_ / kFiles[saving.file], saving.request);
    say(Said::saved, saving.moment, saving.file);
  }
  void endSave(const Saving& saving) {
    base_ = saving.base;
    autosave_->saved(base_);
  }
  void save(uint64_t file) {
    Saving saving = beginSave(file);
    save(saving);
    endSave(saving);
    flush();
  }
  UndoUse keepBudget(UndoBudget& budget) {
    return budget.keep(*session, [this](const DocumentPtr& document) { return autosave_->kept(document); });
  }
  void flush() {
    const uint64_t done = truth_.actedMs.size();
    autosave_->flush();
    say(Said::flushed, done);
    flushedMs_ = nowMs_;
  }

  std::unique_ptr<Session> session;

 private:
  void acted(double ms) {
    nowMs_ += ms;
    truth_.actedMs.push_back(nowMs_);
    say(Said::acted, truth_.actedMs.size());
    if (nowMs_ - flushedMs_ >= kFlushMs) flush();
  }
  void step() {
    acted(kOpMs);
    seen();
  }
  // The history's documents are hashed once: they stay what they are.
  void seen() {
    std::vector<uint64_t> history;
    for (const HistoryState& state : session->states()) {
      uint64_t& was = spilled_[history.size()];
      if (state.document) {
        uint64_t& known = known_[state.document];
        if (known == 0) known = hashOf(*state.document);
        was = known;
      }
      history.push_back(was);
    }
    truth_.add(*session, std::move(history));
  }

  fs::path root_;
  Truth& truth_;
  std::unique_ptr<Autosave> autosave_;
  std::shared_ptr<DocumentRecords> documentRecords_;
  std::shared_ptr<const Base> base_;
  std::shared_ptr<SavedHistory> records_;
  std::string writer_;
  Random random_{0};
  Vec3d at_ = Vec3d::Zero();
  double nowMs_ = 0, flushedMs_ = 0;
  std::map<DocumentPtr, uint64_t> known_;
  std::map<size_t, uint64_t> spilled_;  // by step: what was there when it left memory
};

}  // namespace argil::engine
