#include "engine/recovery.h"
#include "engine/tool_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "clay/error.h"
#include "io/blob.h"
#include "io/document_file.h"
#include "io/input.h"
#include "io/journal_file.h"

namespace argil::engine {
namespace {

std::string nameOf(const std::filesystem::path& file) { return file.empty() ? "an untitled document" : io::displayName(file); }

std::string counted(uint64_t count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); }

// Undone and redone until it is what was saved: nothing is left to recover.
bool nothingNew(const JournalStory& story) { return story.strokes.empty() && story.states[story.done].second == story.begin.savedState; }

// Away from what was saved, or from the beginning.
uint64_t stepsOf(const JournalStory& story) {
  size_t saved = 0;
  for (size_t i = 0; i < story.states.size(); ++i) {
    if (story.begin.savedState != 0 && story.states[i].second == story.begin.savedState) saved = i;
  }
  return (saved > story.done ? saved - story.done : story.done - saved) + story.strokes.size();
}

// The program ended while it was being begun: what it was to hold is in the one before it.
bool isUnborn(const io::JournalReader& journal) {
  bool begun = false;
  journal.forEachEvent([&](const io::RecordView& record) { begun = begun || record.header.kind == io::RecordKind::journalBegin; });
  return !begun && journal.damagedPlaces() == 0;
}

// A document in which nothing was made: it was begun and not used.
bool isEmpty(io::JournalReader& journal, const JournalStory& story) {
  if (!story.strokes.empty() || !story.begin.file.empty()) return false;
  const std::vector<std::byte> text = io::getBlob(io::BlobKind::state, story.states[story.done].second, journal, size_t{64} << 20);
  const Document document = readDocumentText({reinterpret_cast<const char*>(text.data()), text.size()}, "the journal").document;
  return document.pieces.empty() && document.parts.empty() && document.guides.empty();
}

Recoverable tellOf(const std::filesystem::path& journal, const JournalStory& story) {
  Recoverable told;
  told.journal = journal;
  told.file = story.begin.file;
  told.from = story.begin.at;
  told.to = story.last;
  told.steps = nothingNew(story) ? 0 : std::max<uint64_t>(stepsOf(story), 1);
  told.midStroke = !story.strokes.empty() && !story.strokes.back().ended;
  told.sentence = fmt::format("{}: {} since it was {}{}{}.", nameOf(story.begin.file), counted(stepsOf(story), "step"), story.begin.file.empty() ? "begun" : "saved",
                              told.midStroke ? ", cut off in mid-stroke" : "", story.unread > 0 ? fmt::format("; {} cannot be read", counted(story.unread, "thing")) : "");
  return told;
}

}  // namespace

Recoverable examine(const std::filesystem::path& journal) {
  io::JournalReader reader(journal, false);
  return tellOf(journal, readStory(reader));
}

Recovered recover(const std::filesystem::path& journal, Job* job) {
  const auto reader = std::make_shared<io::JournalReader>(journal, true);
  Recovered recovered;
  const auto mend = [&](const std::string& damage) {
    recovered.document = mendDocument(journal, damage, job);
    recovered.writer = newWriter();
    recovered.continued = Keeper::Continued{journal, reader};
    recovered.sentence = fmt::format("Recovered what {} still holds.", io::displayName(journal));
    return std::move(recovered);
  };
  JournalStory story;
  try {
    story = readStory(*reader);
  } catch (const Error& e) {
    return mend(e.what());
  }
  recovered.file = story.begin.file;
  recovered.writer = story.begin.writer;
  recovered.sources = {reader};

  // The saved file under it: as the journal knew it, or another by now. Records of a file that did not grow from the
  // one that the journal builds on are never read: their ids mean other things.
  std::shared_ptr<const Base> base;
  std::shared_ptr<io::RecordSource> file;
  io::RecordId shared = 0;
  std::string trouble;
  if (!story.begin.file.empty()) {
    try {
      const std::shared_ptr<io::DocumentFile> now = io::DocumentFile::open(story.begin.file, false);
      base = readBase(*now);
      shared = now->sharedWith(story.begin.stamp);
      if (base->stamp == story.begin.stamp || (shared != 0 && base->writer == story.begin.writer)) {
        file = now;  // or it is a later save of the same work, of which the journal has not heard any more
      } else {
        auto under = std::make_shared<Base>(*base);
        under->stamp = story.begin.stamp;
        under->next = shared;
        if (shared != 0) file = recordsOf(std::move(under));
        base.reset();
      }
    } catch (const Error& e) {
      trouble = e.what();
      base.reset();
    }
  }
  OpenedDocument& document = recovered.document;
  document.archive = std::make_shared<Archive>();
  Archive& archive = *document.archive;
  Archive::Lock lock = archive.lock();
  archive.ids().atLeast(reader->highestId() + 1);
  if (story.begin.schema > uint64_t{io::kDocumentSchema}) archive.allowUnknown();
  document.base = base;
  archive.ids().atLeast(base ? base->next : shared);
  if (!base && file)
    recovered.sources.push_back(file);  // what others saved later is not ours, but what they grew from is
  std::vector<io::RecordSource*> places{reader.get()};
  if (file) places.push_back(file.get());
  Sources sources(places);

  // The newest document that can be read; strokes lead on from the last one only.
  std::string why;
  for (size_t at = story.done + 1; at-- > 0;) {
    try {
      const Archive::Read whole = archive.get(sources, story.states[at].second, nullptr, job);
      const DocumentPtr read = whole.document;
      if (at != story.done) {
        document.notes.push_back(fmt::format("The newest {} could not be read ({}).", counted(story.done - at + story.strokes.size(), "step"), why));
        story.strokes.clear();
        story.states.resize(at + 1);
      }
      story.done = at;
      for (const auto& [label, id] : story.states) document.states.push_back({label, nullptr, id});
      document.states[at].document = read;
      document.done = at;
      if (!whole.unknown.empty()) {
        // As openDocument() has it: the steps before it stay with the Argil that understands them.
        document.notes.push_back(
            fmt::format("A newer Argil wrote it: {} is not understood here and was left out, and its history too; save "
                        "it under another name.",
                        whole.unknown[0]));
        document.states = {{document.states[at].label, read}};
        document.done = 0;
        document.base = nullptr;
      }
      break;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      if (why.empty()) why = e.what();
    }
  }
  if (document.states.empty() && story.begin.file.empty()) {
    lock.unlock();  // the archive goes
    return mend(why);
  }
  if (document.states.empty()) {
    const std::string blame =
        !trouble.empty() ? fmt::format("; it builds on a file that cannot be read: {}", trouble)
        : document.base  ? std::string()
                         : fmt::format("; {} was replaced since: put the file back that was there when it was opened",
                                       nameOf(story.begin.file));
    throw Error(fmt::format("{}: nothing can be recovered: {}{}", io::displayName(journal), why, blame),
                Error::Kind::work);
  }
  if (story.unread > 0) document.notes.push_back(fmt::format("{} of the journal could not be read.", counted(story.unread, "thing")));
  if (!story.begin.file.empty() && !base) {
    document.notes.push_back(trouble.empty() ? fmt::format("{} has changed since: save what was recovered under another name.", nameOf(story.begin.file))
                                             : fmt::format("The saved file cannot be read ({}): save what was recovered under another name.", trouble));
  }
  recovered.strokes = std::move(story.strokes);
  recovered.continued = Keeper::Continued{journal, reader};
  recovered.sentence = fmt::format("Recovered {}: {}{}.", nameOf(story.begin.file), counted(stepsOf(story), "step"),
                                   !recovered.strokes.empty() && !recovered.strokes.back().ended ? ", the last stroke ended where its samples end" : "");
  return recovered;
}

size_t replay(Session& session, const std::vector<JournalStroke>& strokes) {
  size_t leftOut = 0;
  for (const JournalStroke& stroke : strokes) {
    try {
      Tool tool = stroke.tool;
      loadToolFile(tool);
      session.beginStroke(tool, stroke.images);
      for (const JournalPoint& point : stroke.points) {
        if (point.lift) session.liftTool();
        else session.addPoint(point.point);
      }
      session.endStroke();
    } catch (const Error&) {
      ++leftOut;
      if (session.inStroke()) session.endStroke();
    }
  }
  return leftOut;
}

std::vector<Recoverable> recoverable(const std::filesystem::path& folder) {
  std::vector<Recoverable> found;
  std::set<std::string> writers;
  for (const std::filesystem::path& journal : io::abandonedJournals(folder)) {
    try {
      io::JournalReader reader(journal, true);
      if (isUnborn(reader)) {
        reader.remove();
        continue;
      }
      const JournalStory story = readStory(reader);
      // A journal that was begun anew holds all that the one before it held, which a crash may have left beside it.
      if (!writers.insert(story.begin.writer).second) {
        reader.remove();
        continue;
      }
      // What the file holds by now may be newer than what the journal knew.
      bool saved = nothingNew(story) || isEmpty(reader, story);
      for (const std::filesystem::path& file : {story.begin.file, story.saving}) {
        if (saved || !story.strokes.empty() || file.empty()) continue;
        try {
          const auto base = readBase(file);
          saved = base->writer == story.begin.writer && base->state == story.states[story.done].second;
        } catch (const Error&) {
          // Then there is all the more to recover.
        }
      }
      if (saved) {
        reader.remove();
      } else {
        found.push_back(tellOf(journal, story));
      }
    } catch (const Error& e) {
      if (e.kind() == Error::Kind::work) {
        Recoverable lost;
        lost.journal = journal;
        lost.sentence = fmt::format("{}: nothing can be had from it ({}).", io::displayName(journal), e.what());
        found.push_back(std::move(lost));
      }
    }
  }
  return found;
}

}  // namespace argil::engine
