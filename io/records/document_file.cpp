#include "io/records/document_file.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include "clay/base/error.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/folder_flush.h"
#include "io/bytes/input.h"
#include "io/bytes/replaced_file.h"
#include "io/records/document_facts.h"
#include "io/records/open_documents.h"
#include "io/records/sqlite.h"

namespace argil::io {

namespace {

/// One record of the largest size fits in a leaf page: 8192 - 35 bytes of payload are kept local
/// (sqlite.org/fileformat2.html, "B-tree cell format").
constexpr int64_t kPageBytes = 8192;
/// What SQLite adds to a record in its page: cell pointer, sizes, id, kind.
constexpr int64_t kRowOverhead = 16;
/// Smaller files are not worth shrinking.
constexpr int64_t kLeastShrinkBytes = int64_t{1} << 20;
constexpr size_t kIdOffset = 16;  // Of the id in a record's header.

uint64_t randomStamp() {
  uint64_t stamp = 0;
  // Without chance two saves could not be told apart.
  if (::getrandom(&stamp, sizeof stamp, 0) != sizeof stamp)
    throw Error("the system gives no random numbers", Error::Kind::work);
  stamp >>= 1;  // SQLite's integers have a sign.
  return stamp == 0 ? 1 : stamp;
}

/// Saves that this process made into files whose structure was sound: what it goes on writing to needs no second look.
class SoundSaves {
 public:
  void add(uint64_t stamp) {
    const std::lock_guard lock(mutex_);
    stamps_[next_++ % stamps_.size()] = stamp;
  }
  bool contains(uint64_t stamp) {
    const std::lock_guard lock(mutex_);
    return std::find(stamps_.begin(), stamps_.end(), stamp) != stamps_.end();
  }

 private:
  std::mutex mutex_;
  std::array<uint64_t, 64> stamps_{};  ///< The last ones; a stamp of 0 is never asked for.
  size_t next_ = 0;
};
SoundSaves soundSaves;

/// The rollback journal or log of a file that is replaced would be taken for that of its successor.
void removeCompanions(const std::filesystem::path& path) {
  std::error_code ignored;
  for (const char* ending : {"-journal", "-wal", "-shm"}) std::filesystem::remove(path.string() + ending, ignored);
}

}  // namespace

struct DocumentFile::State {
  std::filesystem::path path;
  std::string name;  ///< As messages show it.
  bool toWrite = true;
  bool checked = false;  ///< Its structure is sound: else what is added may be laid over what is there.
  DocumentFacts facts;
  std::optional<OpenDocument> registered;  ///< As long as the database is open under its own name.
  std::unique_ptr<AtomicFile> fresh;       ///< Until the first commit.
  Replaced replaced;                       ///< By the first commit.
  std::unique_ptr<Database> database;
  std::optional<Query> insert, one, walk;

  ~State() { close(); }

  void close() {
    insert.reset();
    one.reset();
    walk.reset();
    database.reset();
    registered.reset();
  }

  /// A new database in a temporary file. If it fails, that is thrown away: no rollback journal is needed on the disk,
  /// and one flush at the end.
  void openFresh() {
    if (!fresh) fresh = std::make_unique<AtomicFile>(path);
    database = std::make_unique<Database>(fresh->temporary(), name);
    database->expectWriting();
    database->run(
        "PRAGMA page_size = 8192; PRAGMA journal_mode = MEMORY; PRAGMA synchronous = OFF; PRAGMA auto_vacuum = NONE");
    database->run("BEGIN IMMEDIATE");
    makeTables(*database);
    prepare();
  }

  void openSaved() {
    checkFile(path, name);
    registered.emplace(path);
    database = std::make_unique<Database>(path, name);
    database->run("BEGIN");
    checkTables(*database, name);
    facts = readFacts(*database, name);
    database->run("COMMIT");
    if (toWrite) {
      if (!database->mayWrite()) fail(name, "may not be written; change its permissions or save it under another name");
      // EXTRA flushes the folder too when the rollback journal has gone: a save that was reported stays.
      database->run("PRAGMA journal_mode = DELETE; PRAGMA synchronous = EXTRA");
      database->expectWriting();
    } else {
      database->run("PRAGMA query_only = ON");
    }
    prepare();
  }

  void prepare() {
    if (toWrite) insert.emplace(*database, "INSERT OR REPLACE INTO record(id, kind, body) VALUES(?1, ?2, ?3)");
    one.emplace(*database, "SELECT body FROM record WHERE id = ?1");
    walk.emplace(*database, "SELECT id, body FROM record WHERE id >= ?1 ORDER BY id");
  }

  [[nodiscard]] std::string changed() const {
    return name + ": was changed by another program since it was opened; save it under another name";
  }

  /// Null before the first transaction of a new file.
  Database* reader() {
    if (!database && facts.save > 0) {
      const DocumentFacts mine = facts;
      try {
        openSaved();
        if (facts.stamp != mine.stamp) throw Error(changed(), Error::Kind::work);
      } catch (...) {
        facts = mine;
        close();
        throw;
      }
    }
    return database.get();
  }

  void abandon() noexcept {
    if (fresh) {
      close();
      fresh.reset();
    } else if (database) {
      database->rollBack();
    }
  }

  [[nodiscard]] Error writtenMeanwhile() const {
    return Error(name + ": was written by another program while it was being saved; save it under another name",
                 Error::Kind::work);
  }

  /// Renames over the target while nobody else writes to what is replaced: who waits for its lock finds then that it
  /// was replaced.
  void putInPlace(AtomicFile& file) {
    const std::filesystem::path target = file.target();
    if (!replaced.isStill(Replaced::at(target))) throw writtenMeanwhile();
    std::optional<OpenDocument> keeps;
    std::unique_ptr<Database> old;
    if (isDocument(target)) {
      try {
        keeps.emplace(target);
        old = std::make_unique<Database>(target, name);
        old->run("BEGIN EXCLUSIVE");
        // It may have been written to, or replaced, while this waited.
        if (!keeps->isStill(target) || (replaced.stamp != 0 && readFacts(*old, name).stamp != replaced.stamp))
          throw writtenMeanwhile();
      } catch (const Error& error) {
        if (error.kind() == Error::Kind::work) throw;
        old.reset();  // Damaged: nobody can write to it.
      }
    }
    removeCompanions(target);
    // A rollback journal of the old file that comes back after a power cut would be rolled back into the new one: its
    // end must be on the disk before the new name is.
    if (const int error = keeps ? flushFolder(target.parent_path()) : 0; error != 0) {
      throw Error(name + ": cannot be saved, as its folder cannot be flushed to the disk (" +
                      std::generic_category().message(error) + "); save it elsewhere",
                  Error::Kind::work);
    }
    file.commit(replaced.there);
  }

  /// Remembers what the first commit may replace.
  void lookAtTarget() {
    const std::filesystem::path target = fresh->target();
    if (isDocument(target)) {
      try {
        const OpenDocument keeps(target);
        Database old(target, name);
        replaced.stamp = readFacts(old, name).stamp;
      } catch (const Error&) {
        // Damaged, or written by a program that is not ours: it has no stamp, and is told by what its folder says of
        // it.
      }
    }
    const uint64_t stamp = replaced.stamp;
    replaced = Replaced::at(target);
    replaced.stamp = stamp;
  }

  /// Once in a program: reads the whole file, 0.1 s of work for 200 MB.
  void checkStructure() {
    if (checked || soundSaves.contains(facts.stamp)) return;
    Query check(*database, "PRAGMA quick_check(1)");
    if (!check.step() || check.text(0) != "ok")
      throw Error(name + ": is damaged, so that a save could destroy what is whole in it; save it under another name",
                  Error::Kind::work);
    checked = true;
  }

  void commitFresh(const DocumentFacts& next) {
    database->run("COMMIT");
    close();
    try {
      putInPlace(*fresh);
    } catch (const Error&) {
      if (fresh->inPlace()) facts = next;
      throw;
    }
    fresh.reset();
  }

  void commitInPlace(const DocumentFacts& next) {
    try {
      database->run("COMMIT");
    } catch (const Error&) {
      // When all was written but the folder could not be flushed, SQLite reports a failure and the file is the new one.
      database->rollBack();
      try {
        const DocumentFacts now = readFacts(*database, name);
        if (now.stamp == next.stamp) facts = now;
      } catch (const Error&) {
      }
      if (facts.stamp != next.stamp) throw;
      if (const int error = flushFolder(path.parent_path()); error != 0) {
        throw Error(name + ": is written, but its folder cannot be flushed to the disk (" +
                        std::generic_category().message(error) +
                        "), so a power cut may undo the save; save it elsewhere too",
                    Error::Kind::work);
      }
    }
  }

  /// A copy without holes replaces the file. What fails here is no loss: the file is whole, only larger.
  void shrink() {
    std::optional<AtomicFile> file;
    try {
      file.emplace(path);
      const std::string copy = file->temporary().string();
      try {
        Query(*database, "VACUUM INTO ?1").bind(0, copy).step();
      } catch (const Error&) {
        removeCompanions(copy);
        throw;
      }
      database->run("BEGIN IMMEDIATE");
      const bool mine = registered->isStill(path) && readFacts(*database, name).stamp == facts.stamp;
      if (mine) file->commit();
      database->rollBack();
      if (mine) close();
    } catch (const Error&) {
      database->rollBack();
      // The copy has the name already, only its folder could not be flushed: after a power cut either file may stand
      // there, and both are whole.
      if (file && file->inPlace()) close();
    }
  }
};

DocumentFile::DocumentFile(std::unique_ptr<State> state) : state_(std::move(state)) {}

DocumentFile::~DocumentFile() = default;

std::unique_ptr<DocumentFile> DocumentFile::create(const std::filesystem::path& path, Lineage lineage) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->name = displayName(path);
  state->fresh = std::make_unique<AtomicFile>(path);
  if (state->fresh->temporary().empty()) fail(state->name, "is not a regular file; name a file to write");
  state->lookAtTarget();
  state->facts.lineage = std::move(lineage);
  state->checked = true;
  return std::unique_ptr<DocumentFile>(new DocumentFile(std::move(state)));
}

std::unique_ptr<DocumentFile> DocumentFile::open(const std::filesystem::path& path, bool toWrite) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->name = displayName(path);
  state->toWrite = toWrite;
  state->openSaved();
  return std::unique_ptr<DocumentFile>(new DocumentFile(std::move(state)));
}

const std::filesystem::path& DocumentFile::path() const {
  return state_->path;
}

uint64_t DocumentFile::save() const {
  return state_->facts.save;
}

uint64_t DocumentFile::stamp() const {
  return state_->facts.stamp;
}

const Lineage& DocumentFile::lineage() const {
  return state_->facts.lineage;
}

int DocumentFile::schema() const {
  return state_->facts.schema;
}

const std::string& DocumentFile::writtenBy() const {
  return state_->facts.writtenBy;
}

RecordId DocumentFile::sharedWith(uint64_t stamp) const {
  return io::sharedWith(state_->facts, stamp);
}

RecordId DocumentFile::sharedNow(uint64_t stamp) {
  Database* database = state_->reader();
  return database == nullptr ? 0 : io::sharedWith(readFacts(*database, state_->name), stamp);
}

RecordId DocumentFile::head() const {
  return state_->facts.head;
}

RecordId DocumentFile::nextId() const {
  return state_->facts.nextId;
}

RecordSet DocumentFile::held() {
  RecordSet set;
  Database* database = state_->reader();
  if (database == nullptr) return set;
  Query all(*database, "SELECT id FROM record WHERE id < ?1");
  all.bind(0, static_cast<int64_t>(state_->facts.nextId));
  while (all.step()) {
    const auto id = static_cast<RecordId>(all.number(0));
    if (id == 0 || id > kMostIds) failDamaged(state_->name, "its ids are out of range");
    set.add(id);
  }
  return set;
}

namespace {

/// A record under a wrong id would be another one's content with a valid checksum.
bool isRecord(std::span<const std::byte> body, RecordId id) {
  return body.size() >= kRecordHeaderBytes && body.size() <= kMostRecordBytes &&
         std::memcmp(body.data() + kIdOffset, &id, sizeof id) == 0;
}

/// Ends a read transaction whatever happens.
struct Reading {
  Database& database;
  bool own;
  explicit Reading(Database& in) : database(in), own(!in.inTransaction()) {
    if (own) database.run("BEGIN");
  }
  ~Reading() {
    if (own) database.rollBack();
  }
};

struct Resetting {
  Query& query;
  ~Resetting() { query.reset(); }
};

}  // namespace

bool DocumentFile::get(RecordId id, std::vector<std::byte>& record) {
  if (state_->reader() == nullptr) return false;
  Query& one = *state_->one;
  const Resetting resetting{one};
  bool bad = false;
  one.bind(0, static_cast<int64_t>(id));
  if (!one.step(bad)) return false;
  const auto body = one.bytes(0);
  if (!isRecord(body, id)) return false;
  record.assign(body.begin(), body.end());
  return true;
}

void DocumentFile::getMany(std::span<const RecordId> ids,
                           const std::function<void(size_t, std::span<const std::byte>)>& each) {
  Database* database = state_->reader();
  if (database == nullptr || ids.empty()) return;
  const Reading reading(*database);
  const Resetting resettingWalk{*state_->walk}, resettingOne{*state_->one};
  Query& walk = *state_->walk;
  bool bad = false, onRow = false;
  RecordId at = 0;
  const auto advance = [&] {
    onRow = walk.step(bad);
    if (onRow) at = static_cast<RecordId>(walk.number(0));
  };
  // Walking over a row is several times cheaper than a search; how far that pays depends on how many rows are not
  // wanted.
  constexpr int kMostSteps = 64;
  int steps = 4;
  size_t i = 0;
  for (bool ended = false; i < ids.size() && !bad && !ended; ++i) {
    const RecordId wanted = ids[i];
    if (onRow) {
      int left = steps;
      while (onRow && at < wanted && left-- > 0) advance();
      steps = std::clamp(at < wanted && onRow ? steps / 2 : steps * 2, 1, kMostSteps);
      ended = !onRow && !bad;
    }
    if (!bad && !ended && (!onRow || at < wanted)) {
      walk.reset();
      walk.bind(0, static_cast<int64_t>(wanted));
      advance();
      ended = !onRow && !bad;
    }
    if (bad) break;
    if (onRow && at == wanted) {
      const auto body = walk.bytes(1);
      if (isRecord(body, wanted)) each(i, body);
    }
  }
  // A damaged page ends the walk, not the reading: each of the others is searched for.
  if (!bad) return;
  walk.reset();
  for (; i < ids.size(); ++i) {
    Query& one = *state_->one;
    one.reset();
    one.bind(0, static_cast<int64_t>(ids[i]));
    bool lost = false;
    if (!one.step(lost)) continue;
    const auto body = one.bytes(0);
    if (isRecord(body, ids[i])) each(i, body);
  }
}

struct DocumentFile::Transaction::State {
  DocumentFile::State* file = nullptr;
  std::vector<std::byte> record;
  bool done = false;
  bool compacts = false;
  int needs = 1;          ///< Of what was put.
  int64_t liveBytes = 0;  ///< Of records kept and put since removeAllBut().
};

DocumentFile::Transaction::Transaction(std::unique_ptr<State> state) : state_(std::move(state)) {}

DocumentFile::Transaction::~Transaction() {
  if (!state_->done) state_->file->abandon();
}

std::unique_ptr<DocumentFile::Transaction> DocumentFile::begin() {
  State& file = *state_;
  auto state = std::make_unique<Transaction::State>();
  if (!file.toWrite)
    throw Error(file.name + ": was opened for reading only; save it under another name", Error::Kind::work);
  Database* database = file.reader();
  if (file.facts.save == 0) {
    try {
      file.openFresh();
    } catch (...) {
      file.abandon();
      throw;
    }
  } else {
    assert(!database->inTransaction());
    // Before and behind the lock: a missing file is no reason to wait, and it may be replaced while this waits.
    if (!file.registered->isStill(file.path)) throw Error(file.changed(), Error::Kind::work);
    database->run("BEGIN IMMEDIATE");
    try {
      if (!file.registered->isStill(file.path) || readFacts(*database, file.name).stamp != file.facts.stamp)
        throw Error(file.changed(), Error::Kind::work);
      file.checkStructure();
    } catch (...) {
      database->rollBack();
      throw;
    }
  }
  state->file = &file;
  return std::unique_ptr<Transaction>(new Transaction(std::move(state)));
}

void DocumentFile::Transaction::put(const RecordHeader& header, std::span<const std::byte> body) {
  assert(header.id != 0 && header.id < kMostIds && body.size() <= kMostRecordBody);
  auto& record = state_->record;
  record.clear();
  appendRecord(record, header, body);
  Query& insert = *state_->file->insert;
  insert.bind(0, static_cast<int64_t>(header.id)).bind(1, static_cast<int64_t>(header.kind)).bind(2, record);
  insert.step();
  insert.reset();
  state_->needs = std::max(state_->needs, schemaOf(header.kind, header.codec));
  state_->liveBytes += static_cast<int64_t>(record.size()) + kRowOverhead;
}

void DocumentFile::Transaction::removeAllBut(const RecordSet& live) {
  Database& database = *state_->file->database;
  // Kinds of later Argils are theirs to remove.
  struct Range {
    int64_t first, last;
  };
  std::vector<Range> dead;
  state_->liveBytes = 0;
  {
    static_assert(kLastStoredKind == RecordKind::clay);
    Query all(database, "SELECT id, length(body), kind BETWEEN 1 AND 5 FROM record ORDER BY id");
    bool open = false;
    while (all.step()) {
      const int64_t id = all.number(0);
      if (all.number(2) == 0 || (id > 0 && live.contains(static_cast<RecordId>(id)))) {
        state_->liveBytes += all.number(1) + kRowOverhead;
        open = false;
      } else if (open) {
        dead.back().last = id;
      } else {
        dead.push_back({id, id});
        open = true;
      }
    }
  }
  Query erase(database, "DELETE FROM record WHERE id BETWEEN ?1 AND ?2");
  for (const Range& range : dead) {
    erase.bind(0, range.first).bind(1, range.last).step();
    erase.reset();
  }
  state_->compacts = true;
}

void DocumentFile::Transaction::commit(RecordId head, RecordId nextId) {
  DocumentFile::State& file = *state_->file;
  DocumentFacts next = file.facts;
  if (next.save > 0) next.lineage.push_back({next.stamp, next.nextId});
  if (next.lineage.size() > kMostLineage) next.lineage.erase(next.lineage.begin(), next.lineage.end() - kMostLineage);
  ++next.save;
  next.schema = std::max(next.schema, kDocumentSchema);
  next.stamp = randomStamp();
  next.head = head;
  next.nextId = std::max(next.nextId, nextId);
  next.needs = std::max(next.needs, state_->needs);
  if (next.nextId > kMostIds)
    throw Error(file.name + ": has used up its record numbers; save under another name", Error::Kind::work);
  writeFacts(*file.database, next, file.name);
  const int64_t fileBytes = state_->compacts ? file.database->number("PRAGMA page_count") * kPageBytes : 0;
  try {
    if (file.fresh) {
      file.commitFresh(next);
    } else {
      file.commitInPlace(next);
    }
  } catch (const Error&) {
    if (file.facts.stamp == next.stamp) {
      // All is there, but for the folder that could not be flushed: this object goes on with what the file is now.
      state_->done = true;
      file.fresh.reset();
      soundSaves.add(next.stamp);
    }
    throw;
  }
  file.facts = next;
  state_->done = true;
  soundSaves.add(next.stamp);
  if (state_->compacts && fileBytes >= kLeastShrinkBytes && fileBytes > 2 * state_->liveBytes && file.database)
    file.shrink();
}

}  // namespace argil::io
