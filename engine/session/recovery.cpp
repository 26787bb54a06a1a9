#include "engine/session/recovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include "clay/base/error.h"
#include "engine/models/tool_file.h"
#include "engine/text/tool_text.h"
#include "io/bytes/input.h"
#include "io/records/blob.h"
#include "io/records/document_file.h"
#include "io/records/journal_file.h"
#include "io/records/recovered_records.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

std::string nameOf(const fs::path& file) {
  return file.empty() ? "an untitled document" : io::displayName(file);
}

std::string counted(uint64_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

// Undone and redone until it is what was saved: nothing is left to recover.
bool nothingNew(const JournalStory& story) {
  return story.strokes.empty() && story.states[story.done].second == story.begin.savedState;
}

bool isWhole(const JournalStory& story) {
  return story.unread == 0 && story.damaged == 0;
}

// Away from what was saved, or from the beginning: steps back that were undone, and steps that were done.
uint64_t stepsOf(const JournalStory& story) {
  std::vector<io::RecordId> first;  // The states that the journal began with, those that it has.
  size_t saved = SIZE_MAX, started = 0;
  for (size_t i = 0; i < story.begin.states.size(); ++i) {
    const io::RecordId id = story.begin.states[i].second;
    if (id == 0) continue;
    if (i == story.begin.done) started = first.size();
    if (id == story.begin.savedState) saved = first.size();
    first.push_back(id);
  }
  if (story.begin.savedState == 0) saved = 0;
  if (saved == SIZE_MAX) saved = started;
  // The saved state itself may have been undone and be no longer part of the story.
  size_t common = 0;
  while (common < first.size() && common < story.states.size() && first[common] == story.states[common].second)
    ++common;
  const size_t done = story.done + story.strokes.size();
  if (saved < common) return saved > done ? saved - done : done - saved;
  return (saved + 1 - common) + (done + 1 - common);
}

// A document in which nothing was made: it was begun and not used.
bool isEmpty(io::JournalReader& journal, const JournalStory& story) {
  if (!story.strokes.empty() || !story.begin.file.empty()) return false;
  try {
    const std::vector<std::byte> text =
        io::getBlob(io::BlobKind::state, story.states[story.done].second, journal, size_t{64} << 20);
    const Document document =
        readDocumentText({reinterpret_cast<const char*>(text.data()), text.size()}, "the journal").document;
    return document.pieces.empty() && document.parts.empty() && document.guides.empty();
  } catch (const Error&) {
    return false;
  }
}

// The file is the one that the journal counts on, as it was then or as the same work saved it later: equal ids mean the
// same in both.
bool belongs(const Base& base, const JournalBegin& begin) {
  if (begin.stamp == 0) return base.writer == begin.writer;  // written before saves had stamps
  if (base.stamp == begin.stamp) return true;
  return base.writer == begin.writer &&
         std::any_of(base.lineage.begin(), base.lineage.end(),
                     [&](const io::SavePoint& point) { return point.stamp == begin.stamp; });
}

// The last strokes, from the one on whose repetition ended a program. When the machine ended with it, that may have
// been a power cut: once more.
uint64_t leavesOut(const JournalStory& story, const std::string& boot) {
  return story.replay && (story.replay->boot == boot || story.replay->times > 1) ? story.replay->stroke : 0;
}

Recoverable tellOf(const fs::path& journal, const JournalStory& story) {
  Recoverable told;
  told.journal = journal;
  told.file = story.begin.file;
  told.from = story.begin.at;
  told.to = story.last;
  told.steps = nothingNew(story) ? 0 : std::max<uint64_t>(stepsOf(story), 1);
  told.midStroke = !story.strokes.empty() && !story.strokes.back().ended;
  told.strokes = story.strokes.size();
  told.leavesOut = leavesOut(story, bootId());
  told.damaged = !isWhole(story);
  told.sentence =
      fmt::format("{}: {} since it was {}{}", nameOf(story.begin.file), counted(stepsOf(story), "step"),
                  story.begin.file.empty() ? "begun" : "saved", told.midStroke ? ", cut off in mid-stroke" : "");
  if (told.damaged) told.sentence += fmt::format("; {} cannot be read", counted(story.unread + story.damaged, "thing"));
  if (told.leavesOut > 0)
    told.sentence += fmt::format("; repeating it ended Argil, so the last {} left out",
                                 told.leavesOut == 1 ? "stroke is" : fmt::format("{} strokes are", told.leavesOut));
  if (!told.file.empty()) {
    try {
      (void)readBase(told.file);
    } catch (const Error&) {
      told.fileMissing = true;
      told.sentence += "; the saved file is not there or cannot be read";
    }
  }
  told.sentence += ".";
  return told;
}

// Of a journal that tells no story: nothing can be said of it but that there are documents in it.
Recoverable tellOfDamaged(const fs::path& journal, const std::string& why) {
  Recoverable told;
  told.journal = journal;
  bool any = false;
  try {
    any = !io::RecoveredRecords(journal).states().empty();
  } catch (const Error&) {
  }
  told.damaged = any;
  told.sentence =
      any ? fmt::format("{}: is damaged ({}); what is whole in it can be repaired.", io::displayName(journal), why)
          : fmt::format("{}: nothing can be had from it ({}).", io::displayName(journal), why);
  return told;
}

struct Newest {
  DocumentPtr document;              // null: none can be read
  bool all = true;                   // the strokes lead to the end of the story
  std::string why;                   // what is wrong with a newer one
  std::vector<std::string> unknown;  // what of it a newer Argil wrote and this one does not understand
};

// The newest document of a story that can be read: the story then ends with it and the strokes that lead on from it.
Newest readNewest(DocumentRecords& documentRecords, io::RecordSource& sources, JournalStory& story, Job* job) {
  Newest newest;
  for (size_t at = story.done + 1; at-- > 0;) {
    try {
      DocumentRecords::Read read = documentRecords.get(sources, story.states[at].second, nullptr, job);
      newest.document = read.document;
      newest.unknown = std::move(read.unknown);
      if (at != story.done) {
        std::vector<JournalStroke> strokes;
        for (size_t i = at + 1; i <= story.done && newest.all; ++i) {
          auto& [led, all] = story.ledBy[i];
          newest.all = all;
          std::move(led.begin(), led.end(), std::back_inserter(strokes));
        }
        if (newest.all) std::move(story.strokes.begin(), story.strokes.end(), std::back_inserter(strokes));
        story.strokes = std::move(strokes);
        story.states.resize(at + 1);
        story.done = at;
      }
      return newest;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      if (newest.why.empty()) newest.why = e.what();
    }
  }
  return newest;
}

// The newest whole document of a journal that its story does not lead to, as a record that says so is damaged. No
// state: none.
HistoryState findLoose(DocumentRecords& documentRecords, io::RecordSource& sources, const fs::path& journal,
                       const JournalStory& story, Job* job) {
  const auto known = [&](io::RecordId id) {
    return std::any_of(story.states.begin(), story.states.end(), [&](const auto& each) { return each.second == id; });
  };
  const io::RecoveredRecords found(journal, job);
  for (const io::RecordId id : found.states()) {
    if (id <= story.states[story.done].second || known(id)) break;
    try {
      return {"Found in the journal", documentRecords.get(sources, id, nullptr, job).document, id};
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      // An older one may be whole.
    }
  }
  return {};
}

struct OpenJournal {
  fs::path path;
  std::unique_ptr<io::JournalReader> reader;
  JournalStory story;
};

// All that was done is in a saved file as well.
bool isSaved(const JournalStory& story) {
  if (!story.strokes.empty()) return false;
  const auto holds = [&](const fs::path& file, bool ours) {
    try {
      const auto base = readBase(file);
      return (ours ? base->writer == story.begin.writer : belongs(*base, story.begin)) &&
             base->state == story.states[story.done].second;
    } catch (const Error&) {
      return false;  // then there is all the more to recover
    }
  };
  return (!story.begin.file.empty() && holds(story.begin.file, false)) ||
         (!story.saving.empty() && holds(story.saving, true));
}

// All that it tells of can be read, the clay too: it stands for the journals before it.
bool isReadable(const OpenJournal& journal) {
  if (!isWhole(journal.story)) return false;
  std::vector<io::RecordSource*> places{journal.reader.get()};
  std::unique_ptr<io::DocumentFile> file;
  DocumentRecords documentRecords;
  const auto lock = documentRecords.lock();
  try {
    if (!journal.story.begin.file.empty()) {
      if (!belongs(*readBase(journal.story.begin.file), journal.story.begin)) return false;
      file = io::DocumentFile::open(journal.story.begin.file, false);
      places.push_back(file.get());
    }
    Sources sources(places);
    (void)documentRecords.get(sources, journal.story.states[journal.story.done].second, nullptr);
    return true;
  } catch (const Error&) {
    return false;
  }
}

// The number of the process that began it, as its name says.
std::string programOf(const fs::path& journal) {
  const std::string name = journal.stem().string();
  const size_t first = name.find('-'), second = name.find('-', first + 1);
  return first == std::string::npos || second == std::string::npos ? std::string() : name.substr(first, second - first);
}

}  // namespace

Recoverable examine(const fs::path& journal) {
  io::JournalReader reader(journal, false);
  return tellOf(journal, readStory(reader));
}

Recovered recover(const fs::path& journal, Job* job, const RecoverChoice& choice) {
  const auto reader = std::make_shared<io::JournalReader>(journal, true);
  Recovered recovered;
  recovered.journal = reader;
  recovered.boot = choice.boot;
  const auto repair = [&](const std::string& damage) {
    recovered.document = repairDocument(journal, damage, job);
    recovered.sources.clear();
    recovered.writer = newWriter();
    recovered.continued = Autosave::Continued{journal, reader};
    recovered.sentence = fmt::format("Recovered what {} still holds.", io::displayName(journal));
    return std::move(recovered);
  };
  JournalStory story;
  try {
    story = readStory(*reader);
  } catch (const Error& e) {
    return repair(e.what());
  }
  recovered.file = story.begin.file;
  recovered.writer = story.begin.writer;
  recovered.sources = {reader};

  // The saved file under it: as the journal knew it, or another by now. Records of a file that did not grow from the
  // one that the journal builds on are never read: their ids mean other things.
  const fs::path path = choice.base.empty() || story.begin.file.empty() ? story.begin.file : fs::absolute(choice.base);
  std::shared_ptr<const Base> base;
  std::shared_ptr<io::RecordSource> file;
  io::RecordId shared = 0;
  std::string trouble;
  if (!path.empty()) {
    try {
      const std::shared_ptr<io::DocumentFile> now = io::DocumentFile::open(path, false);
      base = readBase(*now);
      shared = now->sharedWith(story.begin.stamp);
      if (belongs(*base, story.begin)) {
        file = now;
      } else if (choice.base.empty()) {
        auto under = std::make_shared<Base>(*base);
        under->stamp = story.begin.stamp;
        under->next = shared;
        if (shared != 0) file = recordsOf(std::move(under));
        base.reset();
      }
    } catch (const Error& e) {
      if (!choice.base.empty()) throw;
      trouble = e.what();
      base.reset();
    }
  }
  if (base && !choice.base.empty() && !belongs(*base, story.begin)) {
    throw Error(fmt::format(
        "{} is not the document that the journal was kept for, or was saved by other work since: choose another file",
        io::displayName(path)));
  }
  OpenedDocument& document = recovered.document;
  document.documentRecords = std::make_shared<DocumentRecords>();
  DocumentRecords& documentRecords = *document.documentRecords;
  DocumentRecords::Lock lock = documentRecords.lock();
  documentRecords.ids().atLeast(reader->highestId() + 1);
  if (story.begin.schema > uint64_t{io::kDocumentSchema}) documentRecords.allowUnknown();
  document.base = base;
  documentRecords.ids().atLeast(base ? base->next : shared);
  // What others saved later is not ours, but what they grew from is.
  if (!base && file) recovered.sources.push_back(file);
  std::vector<io::RecordSource*> places{reader.get()};
  if (file) places.push_back(file.get());
  Sources sources(places);

  const size_t done = story.done;
  const Newest newest = readNewest(documentRecords, sources, story, job);
  if (!newest.document && (story.begin.file.empty() || choice.repair)) {
    lock.unlock();  // the records go
    return repair(newest.why);
  }
  if (!newest.document) {
    if (trouble.empty() && !document.base && !story.begin.file.empty())
      throw Error(
          fmt::format("{}: nothing can be recovered: {}; {} was replaced since: put the file back that was there "
                      "when it was opened, say where it lies now, or have what the journal alone holds repaired",
                      io::displayName(journal), newest.why, nameOf(story.begin.file)),
          Error::Kind::work);
    if (trouble.empty())
      throw Error(fmt::format("{}: nothing can be recovered: {}", io::displayName(journal), newest.why),
                  Error::Kind::work);
    throw Error(fmt::format("{}: nothing can be recovered without the saved file ({}); plug in its disk, say where it "
                            "lies now, or have what the journal alone holds repaired",
                            io::displayName(journal), trouble),
                Error::Kind::work);
  }
  for (const auto& [label, id] : story.states) document.states.push_back({label, nullptr, id});
  document.states[story.done].document = newest.document;
  document.done = story.done;
  if (story.done != done) {
    document.notes.push_back(fmt::format("The newest {} could not be read ({}): {}.",
                                         counted(done - story.done, "step"), newest.why,
                                         newest.all ? "the strokes are repeated" : "what came last is missing"));
  }
  if (!isWhole(story))
    document.notes.push_back(
        fmt::format("{} of the journal could not be read.", counted(story.unread + story.damaged, "thing")));
  if (!newest.unknown.empty()) {
    // As openDocument() has it: the steps before it stay with the Argil that understands them.
    document.notes.push_back(
        fmt::format("A newer Argil wrote it: {} is not understood here and was left out, and its history too; save "
                    "it under another name.",
                    newest.unknown[0]));
    document.states = {{document.states[document.done].label, newest.document}};
    document.done = 0;
    document.base = nullptr;
  }
  // It is put behind the document that is known to have been in work: what came of it nobody knows.
  if (!isWhole(story) && story.strokes.empty()) {
    if (HistoryState loose = findLoose(documentRecords, sources, journal, story, job); loose.document) {
      document.states.resize(document.done + 1);
      document.states.push_back(std::move(loose));
      document.notes.push_back("The journal holds a later document that no step leads to: redo brings it back.");
    }
  }
  if (!story.begin.file.empty() && !base) {
    document.notes.push_back(
        trouble.empty()
            ? fmt::format("{} has changed since: save what was recovered under another name.", nameOf(story.begin.file))
            : fmt::format("The saved file cannot be read ({}): save what was recovered under another name.", trouble));
  }
  const uint64_t ended = leavesOut(story, choice.boot);
  if (newest.all)
    recovered.leftOut = std::min<uint64_t>(ended > 0 ? ended : choice.withoutLast ? 1 : 0, story.strokes.size());
  recovered.ended = ended > 0 && recovered.leftOut > 0;
  if (recovered.leftOut > 0) {
    document.notes.push_back(
        fmt::format("{}he last {} left out.", ended > 0 ? "Repeating a stroke ended Argil the last time: t" : "T",
                    recovered.leftOut == 1 ? "stroke is" : fmt::format("{} strokes are", recovered.leftOut)));
    story.strokes.resize(story.strokes.size() - recovered.leftOut);
  }
  recovered.sentence = fmt::format(
      "Recovered {}: {}{}.", nameOf(story.begin.file), counted(stepsOf(story), "step"),
      !story.strokes.empty() && !story.strokes.back().ended ? ", the last stroke ended where its samples end" : "");
  recovered.strokes = std::move(story.strokes);
  recovered.before = std::move(story.replay);
  recovered.continued = Autosave::Continued{journal, reader, story.begin.sequence};
  return recovered;
}

namespace {

void repeat(Session& session, const JournalStroke& stroke, Job* job, double done, double share) {
  constexpr size_t kPointsAStep = 64;
  Tool tool = stroke.tool;
  loadToolFile(tool);
  session.beginStroke(tool, stroke.images);
  for (size_t i = 0; i < stroke.points.size(); ++i) {
    if (job && i % kPointsAStep == 0) job->step(done + share * double(i) / double(stroke.points.size()));
    const JournalPoint& point = stroke.points[i];
    if (point.lift)
      session.liftTool();
    else
      session.addPoint(point.point);
  }
  session.endStroke();
}

// Whether it could be done.
bool tryToRepeat(Session& session, const JournalStroke& stroke, Job* job, double done, double share) {
  try {
    repeat(session, stroke, job, done, share);
    return true;
  } catch (const Cancelled&) {
    throw;
  } catch (const Error&) {
    if (session.inStroke()) session.endStroke();
    return false;
  }
}

}  // namespace

size_t replay(Session& session, const std::vector<JournalStroke>& strokes) {
  return size_t(std::count_if(strokes.begin(), strokes.end(), [&](const JournalStroke& stroke) {
    return !tryToRepeat(session, stroke, nullptr, 0, 0);
  }));
}

size_t replay(Recovered& recovered, Job* job, SessionWatch* watch) {
  if (recovered.strokes.empty()) return 0;
  OpenedDocument& document = recovered.document;
  Session session(document.states, document.done);
  session.setReader([&](uint64_t kept, const Document& near) {
    return readState(*document.documentRecords, document.base, recovered.sources, kept, near);
  });
  session.setWatch(watch);
  std::string trouble;
  const auto note = [&](const JournalReplay& replay) {
    if (!recovered.journal) return;
    try {
      putReplay(*recovered.journal, replay);
    } catch (const Error& e) {
      trouble = e.what();
    }
  };
  // What ended a program once is left out of every recovery of this journal.
  const auto noteEnd = [&] {
    note(recovered.ended ? JournalReplay{recovered.leftOut, recovered.boot, 2} : JournalReplay{});
  };
  size_t leftOut = 0;
  try {
    const double share = 1 / double(recovered.strokes.size());
    for (size_t i = 0; i < recovered.strokes.size(); ++i) {
      const uint64_t stroke = recovered.leftOut + recovered.strokes.size() - i;
      const bool again = recovered.before && recovered.before->stroke == stroke;
      note({stroke, recovered.boot, again ? recovered.before->times + 1 : 1});
      if (!tryToRepeat(session, recovered.strokes[i], job, double(i) * share, share)) ++leftOut;
    }
  } catch (const Cancelled&) {
    noteEnd();
    throw;
  }
  noteEnd();
  document.states = session.states();
  document.done = session.undoSteps();
  recovered.strokes.clear();
  if (!trouble.empty())
    document.notes.push_back(
        fmt::format("{} Should Argil end while this is recovered again, leave out the last stroke.", trouble));
  return leftOut;
}

std::vector<Recoverable> recoverable(const fs::path& folder) {
  // All are read before any goes: what one of them lacks another may hold.
  std::vector<Recoverable> found, last;
  std::map<std::string, std::vector<OpenJournal>> byWriter;
  std::vector<std::pair<fs::path, std::string>> without;  // a story, and why
  for (const fs::path& path : io::abandonedJournals(folder)) {
    try {
      OpenJournal journal{path, std::make_unique<io::JournalReader>(path, true), {}};
      try {
        journal.story = readStory(*journal.reader);
      } catch (const Error& e) {
        without.emplace_back(path, e.what());
        continue;
      }
      byWriter[journal.story.begin.writer].push_back(std::move(journal));
    } catch (const io::JournalTaken&) {
      // Another Argil offers it, or has thrown it away.
    } catch (const Error& e) {
      last.push_back(tellOfDamaged(path, e.what()));
    }
  }
  const auto anyBy = [&](const std::string& program) {
    return std::any_of(byWriter.begin(), byWriter.end(), [&](const auto& each) {
      return std::any_of(each.second.begin(), each.second.end(),
                         [&](const OpenJournal& journal) { return programOf(journal.path) == program; });
    });
  };
  for (const auto& [path, why] : without) {
    try {
      io::JournalReader reader(path, true);
      bool begun = false;
      reader.forEachEvent([&](const io::RecordView& record, uint64_t) {
        begun = begun || record.header.kind == io::RecordKind::journalBegin;
      });
      Recoverable told = tellOfDamaged(path, why);
      // The program ended while it was being begun: what it was to hold is in the one before it, which goes only when
      // the new one is on the disk. Before the first one nothing was promised.
      const bool unborn = !begun && reader.damagedPlaces() == 0 && (!told.damaged || anyBy(programOf(path)));
      if (unborn)
        reader.remove();
      else
        last.push_back(std::move(told));
    } catch (const Error&) {
    }
  }
  for (auto& [writer, journals] : byWriter) {
    std::stable_sort(journals.begin(), journals.end(), [](const OpenJournal& a, const OpenJournal& b) {
      return std::tuple(a.story.begin.sequence, a.path.filename()) >
             std::tuple(b.story.begin.sequence, b.path.filename());
    });
    OpenJournal& newest = journals.front();
    const JournalStory& story = newest.story;
    // What the file holds by now may be newer than what the journal knew.
    const bool saved = isWhole(story) && isSaved(story);
    // One that was begun anew holds all that the one before it held, which a crash may have left beside it.
    if (journals.size() > 1 && (saved || isReadable(newest))) {
      for (size_t i = 1; i < journals.size(); ++i) journals[i].reader->remove();
      journals.erase(journals.begin() + 1, journals.end());
    }
    // Nothing in it that the saved file has not, wherever that is; but where something is damaged nobody knows.
    if (journals.size() == 1 && isWhole(story) && (saved || nothingNew(story) || isEmpty(*newest.reader, story))) {
      newest.reader->remove();
      continue;
    }
    for (const OpenJournal& journal : journals) {
      Recoverable told = tellOf(journal.path, journal.story);
      if (&journal != &journals.front())
        told.sentence = "An older journal, as the newer one cannot be read to its end: " + told.sentence;
      if (told.some()) found.push_back(std::move(told));
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Recoverable& a, const Recoverable& b) { return a.to > b.to; });
  std::move(last.begin(), last.end(), std::back_inserter(found));
  return found;
}

}  // namespace argil::engine
