#pragma once
// A saved document: an SQLite database of records.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/records/record.h"

namespace argil::io {

/// Schema of what this Argil writes; it reads this one and all before. A file that needs a newer one names who wrote it
/// and is not opened. A file needs only what is in it: without colours, materials and masks Argils of schema 1 read it,
/// and without clay of 16-bit distances those of schema 2.
inline constexpr int kDocumentSchema = 3;

/// One save of a document. The stamp is random and names this save alone: a count of saves or a time does not, since
/// two programs that write to one file or to copies of it count alike.
struct SavePoint {
  uint64_t stamp = 0;   ///< Never 0.
  RecordId nextId = 1;  ///< All records of that save have lower ids.
  friend bool operator==(const SavePoint&, const SavePoint&) = default;
};
/// The saves that a file grew from, oldest first; at most kMostLineage, older ones are forgotten.
using Lineage = std::vector<SavePoint>;
inline constexpr size_t kMostLineage = 100;

/// One `.argil` file. Tables: meta (key, value), record (id, kind, body: header and body of io/records/record.h, whole
/// in one page). What a commit wrote is there after any crash, what had no commit is not. Nothing stays open between
/// two calls that could keep another program from reading. One thread at a time.
class DocumentFile : public RecordSource {
 public:
  /// A new file that does not appear before its first commit; a file of that name is replaced then, as a whole, unless
  /// somebody wrote or made it since this call: then the commit throws. `lineage`: of the saves whose records it takes
  /// over under their ids. Throws Error for a place that cannot be written.
  static std::unique_ptr<DocumentFile> create(const std::filesystem::path& path, Lineage lineage = {});
  /// Throws Error, one sentence: not there, no document, made by a newer Argil (says which), damaged so that SQLite
  /// cannot read it (then see recovered_records.h). `toWrite` false: for reading, never changes the file (but rolls
  /// back what a crashed Argil left half-written).
  static std::unique_ptr<DocumentFile> open(const std::filesystem::path& path, bool toWrite);
  ~DocumentFile() override;

  [[nodiscard]] const std::filesystem::path& path() const;
  /// Of the last commit: counts up from 1; 0 before the first. Says nothing about whose save it is: see stamp().
  [[nodiscard]] uint64_t save() const;
  /// Names the last commit; 0 before the first.
  [[nodiscard]] uint64_t stamp() const;
  /// Records with lower ids are, where both have them, the same here as in the save of this stamp. 0: this file did not
  /// grow from that save, and equal ids mean different things.
  [[nodiscard]] RecordId sharedWith(uint64_t stamp) const;
  /// The same of the file as it is now, where sharedWith() and the others tell of it as it was opened or written by
  /// this object.
  [[nodiscard]] RecordId sharedNow(uint64_t stamp);
  [[nodiscard]] const Lineage& lineage() const;
  /// The highest schema of the programs that wrote to it. Above kDocumentSchema: a newer Argil may have left texts in
  /// it with more in them than this one knows, though it can be read.
  [[nodiscard]] int schema() const;
  /// The version of the program that wrote it last, at most 40 characters that can be shown.
  [[nodiscard]] const std::string& writtenBy() const;
  /// Blob (BlobKind::head) of the last commit.
  [[nodiscard]] RecordId head() const;
  /// The id that the next record may have: above all in the file and all that its journals may have used.
  [[nodiscard]] RecordId nextId() const;
  /// The ids of all records below nextId(): what others add meanwhile is not among them. O(records).
  [[nodiscard]] RecordSet held();

  bool get(RecordId id, std::vector<std::byte>& record) override;
  void getMany(std::span<const RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override;

  /// One transaction. Destroyed without commit: nothing has changed.
  class Transaction : public RecordSink {
   public:
    ~Transaction() override;
    void put(const RecordHeader& header, std::span<const std::byte> body) override;
    /// Removes all records that are not in `live`; gives pages back to the file system when more than half of the file
    /// would be empty.
    void removeAllBut(const RecordSet& live);
    /// Durable when it returns: fsync of the file and, for a new one, of its folder. `nextId`: no record has it or a
    /// higher id. Throws Error (kind work): no space, I/O error; then nothing has changed, unless save() has gone up:
    /// all is there, but the folder could not be flushed.
    void commit(RecordId head, RecordId nextId);

   private:
    friend class DocumentFile;
    struct State;
    explicit Transaction(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
  };
  /// Throws Error (kind work) when the file was changed by another program since it was opened, is in use by one for
  /// two seconds, or is damaged: save under another name. For that the whole file is read once (0.1 s of work for 200
  /// MB), not again behind a save of this program.
  [[nodiscard]] std::unique_ptr<Transaction> begin();

 private:
  struct State;
  explicit DocumentFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// True when the first bytes are those of an SQLite database with our application id.
[[nodiscard]] bool isDocument(const std::filesystem::path& path);

}  // namespace argil::io
