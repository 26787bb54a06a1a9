#include "engine/saving/saved_document.h"

#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "clay/base/error.h"
#include "engine/saving/thumbnail.h"
#include "engine/text/json_text.h"
#include "engine/text/script_place.h"
#include "io/bytes/input.h"
#include "io/records/blob.h"
#include "io/records/document_file.h"
#include "io/records/recovered_records.h"

namespace argil::engine {
namespace {

using nlohmann::ordered_json;

constexpr size_t kMostHead = size_t{64} << 20;
constexpr size_t kMostPicture = size_t{4} << 20;
constexpr size_t kMostAttempts = 64;  // states of a file without a head
constexpr double kMostRecord = 9007199254740992.0;

// What a saved document consists of, beside its states.
struct Head {
  std::string writer;
  std::vector<std::pair<std::string, io::RecordId>> states;  // label, id
  size_t done = 0;
  std::string face;
  io::RecordId thumbnail = 0;
  uint64_t records = 0;  // that are needed, when they were last counted
};

std::string headText(const Head& head) {
  ordered_json root;
  root["writer"] = head.writer;
  root["states"] = ordered_json::array();
  for (const auto& [label, id] : head.states) root["states"].push_back({{"label", label}, {"id", id}});
  root["done"] = head.done;
  if (!head.face.empty()) root["face"] = head.face;
  if (head.thumbnail != 0) root["thumbnail"] = head.thumbnail;
  root["records"] = head.records;
  return root.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

uint64_t readWhole(const Place& place) {
  if (!place.value().is_number_unsigned()) place.fail("must be a whole number");
  (void)place.number(0, kMostRecord);
  return place.value().get<uint64_t>();
}

Head readHead(io::RecordSource& source, io::RecordId id, const std::string& name,
              std::vector<std::string>* unknown = nullptr) {
  const std::vector<std::byte> bytes = io::getBlob(io::BlobKind::head, id, source, kMostHead);
  const nlohmann::json root =
      parseJson({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name, "a document's head");
  const Place place(root, name, "", unknown);
  place.keys({"writer", "states", "done", "face", "thumbnail", "records"});
  Head head;
  head.writer = place.at("writer").text();
  for (const Place& each : place.at("states").items()) {
    each.keys({"label", "id"});
    head.states.emplace_back(each.at("label").text(), readWhole(each.at("id")));
  }
  head.done = readWhole(place.at("done"));
  if (head.done >= head.states.size()) place.at("done").fail("is beyond the steps");
  if (const auto face = place.maybe("face")) head.face = face->text();
  if (const auto thumbnail = place.maybe("thumbnail")) head.thumbnail = readWhole(*thumbnail);
  head.records = readWhole(place.at("records"));
  return head;
}

FaceData faceOf(const Head& head, io::RecordSource& source) {
  FaceData face;
  face.face = head.face;
  if (head.thumbnail == 0) return face;
  try {
    face.thumbnail = io::getBlob(io::BlobKind::picture, head.thumbnail, source, kMostPicture);
  } catch (const Error&) {
    // A picture that is lost is made anew with the next save.
  }
  return face;
}

std::vector<HistoryState> statesOf(const Head& head) {
  std::vector<HistoryState> states;
  for (const auto& [label, id] : head.states) states.push_back({label, nullptr, id});
  return states;
}

// "pieces[0].glaze and 2 more"
std::string listed(const std::vector<std::string>& unknown) {
  return unknown.size() == 1 ? unknown[0] : fmt::format("{} and {} more", unknown[0], unknown.size() - 1);
}

// From any head that holds together, the newest first, else from any state. `newer`: a newer Argil wrote it.
OpenedDocument repaired(const std::filesystem::path& file, const std::string& why, bool newer, Job* job) {
  io::RecoveredRecords found(file, job);
  std::string reason = why;
  const auto attempt =
      [&](const std::function<io::RecordId(OpenedDocument&)>& choose) -> std::optional<OpenedDocument> {
    try {
      OpenedDocument opened;
      opened.documentRecords = std::make_shared<DocumentRecords>();
      opened.documentRecords->ids().atLeast(found.highestId() + 1);
      const auto lock = opened.documentRecords->lock();
      if (newer) opened.documentRecords->allowUnknown();
      DocumentRecords::Read read = opened.documentRecords->get(found, choose(opened), nullptr, job, &found);
      opened.states = {{.label = {}, .document = read.document}};
      opened.notes.push_back(
          fmt::format("{} is damaged ({}) and was repaired from {} sound records; save it under another name.",
                      io::displayName(file), why, found.records()));
      for (std::string& note : read.notes) opened.notes.push_back(std::move(note));
      if (!read.unknown.empty())
        opened.notes.push_back(
            fmt::format("A newer Argil wrote it: {} is not understood and was left out.", listed(read.unknown)));
      return opened;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      reason = e.what();
      return std::nullopt;
    }
  };
  for (const io::RecordId id : found.heads()) {
    auto opened = attempt([&](OpenedDocument& document) {
      std::vector<std::string> unknown;
      const Head head = readHead(found, id, io::displayName(file), newer ? &unknown : nullptr);
      document.face = faceOf(head, found);
      return head.states[head.done].second;
    });
    if (opened) return std::move(*opened);
  }
  for (size_t i = 0; i < found.states().size() && i < kMostAttempts; ++i) {
    auto opened = attempt([&](OpenedDocument&) { return found.states()[i]; });
    if (opened) return std::move(*opened);
  }
  throw Error(
      fmt::format("{}: is damaged ({}), and nothing can be repaired: {} sound records, none of them tells what the "
                  "document was; open a copy of it",
                  io::displayName(file), reason, found.records()));
}

Base baseOf(const std::filesystem::path& file, io::DocumentFile& document, const Head& head) {
  Base base;
  base.path = file;
  base.stamp = document.stamp();
  base.lineage = document.lineage();
  base.writer = head.writer;
  base.state = head.states[head.done].second;
  base.next = document.nextId();
  base.held = document.held();
  return base;
}

class BaseRecords : public io::RecordSource {
 public:
  BaseRecords(std::shared_ptr<const Base> base, bool hold) : base_(std::move(base)) {
    if (!hold) return;
    try {
      inode_ = inodeNow();
      held_ = open();
    } catch (const Error&) {
      // Then it is told when something is read.
    }
  }
  bool get(io::RecordId id, std::vector<std::byte>& record) override {
    return id < base_->next && now()->get(id, record);
  }
  void getMany(std::span<const io::RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override {
    // They rise; those from `next` on belong to whoever saved later.
    ids = ids.first(size_t(std::lower_bound(ids.begin(), ids.end(), base_->next) - ids.begin()));
    if (!ids.empty()) now()->getMany(ids, each);
  }

 private:
  [[nodiscard]] std::shared_ptr<io::DocumentFile> open() const {
    std::shared_ptr<io::DocumentFile> file = io::DocumentFile::open(base_->path, false);
    // A save that grew from this one keeps its ids.
    if (file->sharedWith(base_->stamp) == 0) throw changed();
    return file;
  }
  [[nodiscard]] std::shared_ptr<io::DocumentFile> now() const {
    if (!held_ || inodeNow() == inode_) return open();
    // Somebody may have written into it before it lost its name.
    if (held_->sharedNow(base_->stamp) == 0) throw changed();
    return held_;
  }
  [[nodiscard]] Error changed() const {
    return Error(fmt::format("{} was changed by another program: steps that it kept cannot be gone back to",
                             io::displayName(base_->path)),
                 Error::Kind::work);
  }
  [[nodiscard]] ino_t inodeNow() const {
    struct stat facts {};
    return ::stat(base_->path.c_str(), &facts) == 0 ? facts.st_ino : 0;
  }
  std::shared_ptr<const Base> base_;
  std::shared_ptr<io::DocumentFile> held_;
  ino_t inode_ = 0;
};

bool isSave(const std::filesystem::path& file, uint64_t stamp) {
  try {
    return io::DocumentFile::open(file, false)->stamp() == stamp;
  } catch (const Error&) {
    return true;  // nobody's newer one
  }
}

OpenedDocument openAttempt(const std::filesystem::path& file, Job* job, int attempts);

}  // namespace

std::shared_ptr<const Base> readBase(const std::filesystem::path& file) {
  return readBase(*io::DocumentFile::open(file, false));
}

std::shared_ptr<const Base> readBase(io::DocumentFile& file) {
  return std::make_shared<const Base>(
      baseOf(file.path(), file, readHead(file, file.head(), io::displayName(file.path()))));
}

std::vector<std::byte> thumbnailOf(const std::filesystem::path& file) {
  const auto opened = io::DocumentFile::open(file, false);
  return faceOf(readHead(*opened, opened->head(), io::displayName(file)), *opened).thumbnail;
}

bool isStill(const Base& base) {
  std::error_code ignored;
  if (!std::filesystem::exists(base.path, ignored) || !io::isDocument(base.path)) return false;
  return io::DocumentFile::open(base.path, false)->stamp() == base.stamp;
}

OpenedDocument repairDocument(const std::filesystem::path& file, const std::string& why, Job* job) {
  return repaired(file, why, false, job);
}

std::string newWriter() {
  uint64_t words[2] = {};
  if (getrandom(words, sizeof words, 0) != sizeof words)
    throw Error("the system gives no random numbers", Error::Kind::work);
  return fmt::format("{:016x}{:016x}", words[0], words[1]);
}

OpenedDocument openDocument(const std::filesystem::path& file, Job* job) {
  return openAttempt(file, job, 3);
}

namespace {

OpenedDocument openAttempt(const std::filesystem::path& file, Job* job, int attempts) {
  if (!io::isDocument(file)) {
    // Not there, a folder, ...: said as for every file. What had our mark and lost it may still be repaired.
    (void)io::DocumentFile::open(file, false);
  }
  std::unique_ptr<io::DocumentFile> document;
  bool newer = false;
  try {
    document = io::DocumentFile::open(file, false);
    newer = document->schema() > io::kDocumentSchema;
    std::vector<std::string> unknown;
    const Head head = readHead(*document, document->head(), io::displayName(file), newer ? &unknown : nullptr);
    OpenedDocument opened;
    opened.documentRecords = std::make_shared<DocumentRecords>();
    opened.documentRecords->ids().atLeast(document->nextId());
    {
      const auto lock = opened.documentRecords->lock();
      opened.states = statesOf(head);
      opened.done = head.done;
      opened.steps = opened.states.size() - 1;
      if (newer) opened.documentRecords->allowUnknown();
      HistoryState& now = opened.states[head.done];
      DocumentRecords::Read read = opened.documentRecords->get(*document, now.kept, nullptr, job);
      now.document = std::move(read.document);
      unknown.insert(unknown.end(), read.unknown.begin(), read.unknown.end());
      // A step of the past that is not understood either: a save would keep it under this Argil's name.
      for (size_t i = 0; newer && i < opened.states.size(); ++i) {
        if (i == head.done) continue;
        try {
          const auto more = opened.documentRecords->unknownIn(*document, opened.states[i].kept);
          unknown.insert(unknown.end(), more.begin(), more.end());
        } catch (const Error&) {
          // A step that cannot be read is told when it is gone to.
        }
      }
    }
    opened.face = faceOf(head, *document);
    if (!unknown.empty()) {
      opened.readOnly = fmt::format(
          "{} holds what only a newer Argil understands ({}; it was last saved by Argil {}): it is opened for reading "
          "only. Save it under another name to go on without that, or open it with the newer "
          "Argil.",
          io::displayName(file), listed(unknown), document->writtenBy());
      opened.states = {std::move(opened.states[head.done])};
      opened.states[0].kept = 0;
      opened.done = 0;
      return opened;
    }
    opened.base = std::make_shared<const Base>(baseOf(file, *document, head));
    return opened;
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    if (e.kind() != Error::Kind::work) throw;
    // A save that came meanwhile may have taken away what was being read: then it is opened as it is by now.
    if (document && attempts > 1 && !isSave(file, document->stamp())) return openAttempt(file, job, attempts - 1);
    return repaired(file, e.what(), newer, job);
  }
}

}  // namespace

std::shared_ptr<const Base> saveDocument(const std::filesystem::path& file, const SaveRequest& request, Job* job,
                                         const SaveLimits& limits) {
  auto lock = request.documentRecords->lock();
  DocumentRecords& documentRecords = *request.documentRecords;
  // A base that was deleted, damaged or written by somebody else is no reason to lose what is in memory: it is done
  // without, in a new file.
  const bool gone = request.base && !std::filesystem::exists(request.base->path);
  const bool same = request.base && request.base->path == file && !gone;
  // A rollback journal is found by the file's name: after a crash in the middle of a save the other name of a file
  // would lead to half of it.
  const bool inPlace = same && std::filesystem::hard_link_count(file) == 1;
  io::Lineage lineage;
  if (request.base) {
    lineage = request.base->lineage;
    lineage.push_back({request.base->stamp, request.base->next});
    if (lineage.size() > io::kMostLineage) lineage.erase(lineage.begin());
  }
  // First what it would replace is remembered, then it is looked whose that is: what comes in between is noticed either
  // way.
  std::shared_ptr<io::DocumentFile> to;
  if (!inPlace) to = io::DocumentFile::create(file, std::move(lineage));
  std::shared_ptr<io::DocumentFile> from;
  if (request.base && !gone) {
    try {
      from = io::DocumentFile::open(request.base->path, inPlace);
      if (from->stamp() != request.base->stamp) from.reset();
    } catch (const Error&) {
      if (same) throw;
    }
  }
  if (same && !from) {
    throw Error(
        fmt::format(
            "{} was changed by another program or in another window since it was opened: save under another name",
            io::displayName(file)),
        Error::Kind::work);
  }
  if (inPlace) to = from;
  auto base = std::make_shared<Base>();
  base->path = file;
  base->writer = request.writer;
  if (inPlace) base->held = request.base->held;

  std::vector<io::RecordSource*> places;
  if (from) places.push_back(from.get());
  for (const auto& source : request.sources) places.push_back(source.get());
  Sources sources(places);

  const auto transaction = to->begin();
  DocumentRecords::Giving sink(*transaction, documentRecords, lock);
  Head head;
  head.writer = request.writer;
  const size_t first = request.done > limits.steps ? request.done - limits.steps : 0;
  // The newest state first: its records lie together, and it is what is opened.
  std::vector<io::RecordId> ids(request.states.size());
  const auto keep = [&](size_t i, Job* watch) {
    const HistoryState& state = request.states[i];
    if (state.document) {
      ids[i] = documentRecords.put(state.document, base->held, sink, io::RecordCodec::zstd, watch);
    } else {
      documentRecords.copy(sources, state.kept, base->held, sink);
      ids[i] = state.kept;
    }
  };
  keep(request.done, job);
  for (size_t i = first; i < request.states.size(); ++i) {
    if (i == request.done) continue;
    try {
      keep(i, nullptr);
    } catch (const Error& e) {
      // A step of the past that cannot be read any more must not keep the present from being saved.
      if (request.states[i].document) throw;
      ids[i] = 0;
    }
    if (job && job->cancelled()) throw Cancelled();
  }
  for (size_t i = first; i < request.states.size(); ++i) {
    if (ids[i] == 0) continue;
    if (i == request.done) head.done = head.states.size();
    head.states.emplace_back(request.states[i].label, ids[i]);
  }
  Head before;
  if (from) {
    try {
      before = readHead(*from, from->head(), io::displayName(request.base->path));
    } catch (const Error&) {
      // Then there is nothing to take over from it.
    }
  }
  FaceData face = request.face;
  if (from && face.face.empty()) face.face = before.face;
  if (from && face.thumbnail.empty()) face.thumbnail = faceOf(before, *from).thumbnail;
  head.face = face.face;
  if (!face.thumbnail.empty())
    head.thumbnail =
        io::putBlob(io::BlobKind::picture, face.thumbnail, documentRecords.ids(), base->held, *transaction);
  head.records = before.records;
  const auto put = [&] {
    return io::putBlob(io::BlobKind::head, std::as_bytes(std::span<const char>(headText(head))), documentRecords.ids(),
                       base->held, *transaction);
  };

  // What no state needs goes when there is much of it.
  uint64_t held = 0;
  for (io::RecordId id = 1; id < documentRecords.ids().next(); ++id) held += base->held.contains(id);
  if (head.records == 0) head.records = held;
  io::RecordId id = 0;
  if (held > 2 * head.records + 1000) {
    io::RecordSet live;
    for (const auto& [label, state] : head.states) documentRecords.mark(*to, state, live);
    // Steps before those that the file keeps can still be gone back to while this program runs.
    for (size_t i = 0; inPlace && i < first; ++i) {
      const HistoryState& state = request.states[i];
      const io::RecordId kept = state.document ? documentRecords.known(state.document) : state.kept;
      if (kept == 0) continue;
      try {
        documentRecords.mark(sources, kept, live);
      } catch (const Error&) {
        // What cannot be read is lost already.
      }
    }
    live.intersect(base->held);
    if (head.thumbnail != 0) io::markBlob(*to, head.thumbnail, live);
    head.records = 0;
    for (io::RecordId each = 1; each < documentRecords.ids().next(); ++each) head.records += live.contains(each);
    id = put();
    io::markBlob(*to, id, live);
    transaction->removeAllBut(live);
    base->held = live;
  } else {
    id = put();
  }
  const io::RecordId next = documentRecords.ids().next();
  // From here on only the disk is waited for: others may go on.
  lock.unlock();
  const uint64_t saves = to->save();
  try {
    transaction->commit(id, next);
  } catch (const Error& e) {
    // The file may have it although the folder could not be flushed: later saves go on from there, but nobody may be
    // told that it is safe.
    if (to->save() <= saves) throw;
    base->unflushed = e.what();
  }
  base->stamp = to->stamp();
  base->lineage = to->lineage();
  base->state = head.states[head.done].second;
  base->next = next;
  return base;
}

void saveDocument(const std::filesystem::path& file, const Document& document, Job* job, FaceData face) {
  SaveRequest request;
  request.face = std::move(face);
  request.states = {{.label = {}, .document = std::make_shared<const Document>(document)}};
  request.documentRecords = std::make_shared<DocumentRecords>();
  request.writer = newWriter();
  if (const auto base = saveDocument(file, request, job); !base->unflushed.empty())
    throw Error(base->unflushed, Error::Kind::work);
}

std::shared_ptr<io::RecordSource> recordsOf(std::shared_ptr<const Base> base, bool hold) {
  if (!base) return nullptr;
  return std::make_shared<BaseRecords>(std::move(base), hold);
}

DocumentPtr readState(DocumentRecords& documentRecords, const std::shared_ptr<const Base>& base,
                      const std::vector<std::shared_ptr<io::RecordSource>>& sources, io::RecordId state,
                      const Document& near) {
  std::vector<io::RecordSource*> places;
  for (const auto& source : sources) places.push_back(source.get());
  const auto file = recordsOf(base);
  if (file) places.push_back(file.get());
  Sources all(places);
  const auto lock = documentRecords.lock();
  return documentRecords.get(all, state, &near).document;
}

}  // namespace argil::engine
