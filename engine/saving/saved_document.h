#pragma once
// A document in its file: opened with its history, saved with it.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "engine/saving/document_records.h"
#include "engine/saving/session.h"
#include "io/records/document_file.h"
#include "io/records/record.h"

namespace argil::engine {

/// A saved file as the documents in work know it: what it holds. It is known by the random stamp of its last save
/// alone: a path, a time or a count of saves may be those of a file in which the same ids mean other things.
struct Base {
  std::filesystem::path path;
  uint64_t stamp = 0;      ///< Of that save.
  io::Lineage lineage;     ///< The saves before it.
  std::string writer;      ///< Names the work that wrote it: ids of its journals and of this file agree.
  io::RecordId state = 0;  ///< The document that it opens with.
  io::RecordId next = 1;   ///< No record of it has this id or a higher one.
  io::RecordSet held;
  /// Of a save that is in place, but may be lost in a power cut, as the folder could not be flushed: the sentence. Else
  /// empty.
  std::string unflushed;
};

/// What a saved file holds, without its clay. Throws Error as openDocument() does, for damage too.
[[nodiscard]] std::shared_ptr<const Base> readBase(const std::filesystem::path& file);
[[nodiscard]] std::shared_ptr<const Base> readBase(io::DocumentFile& file);

/// True while the file at its path is what `base` says: nobody has saved into it, replaced or removed it. Throws Error
/// when that cannot be told now, since another program is just writing to it or it cannot be opened.
[[nodiscard]] bool isStill(const Base& base);

/// Records of the save that `base` is of, read from its file, whoever saved into that since. Reading throws Error when
/// there is a file now that did not grow from that save. It is opened for each call. With `hold` the file can be read
/// when it was removed or replaced by another, too; nobody is kept from reading or writing it. Null stays null.
[[nodiscard]] std::shared_ptr<io::RecordSource> recordsOf(std::shared_ptr<const Base> base, bool hold = false);

/// Saved beside the document.
struct FaceData {
  std::string face;                  ///< JSON of the face's own; empty: none.
  std::vector<std::byte> thumbnail;  ///< PNG; empty: none.
};

struct SaveLimits {
  size_t steps = 100;  ///< Of history that a file keeps, besides those that can be redone.
};

struct OpenedDocument {
  /// The one at `done` has its document, the others are read when they are gone to.
  std::vector<HistoryState> states;
  size_t done = 0;
  FaceData face;
  std::shared_ptr<DocumentRecords> documentRecords;
  std::shared_ptr<const Base> base;  ///< Null when it was repaired or must not be written to: it has to be saved anew.
  std::vector<std::string> notes;    ///< What was repaired, sentences.
  size_t steps = 0;                  ///< Of history that the file holds, those that can be redone included.
  /// Why it must not be saved into its file, a sentence: a newer Argil left more in it than is understood here; of its
  /// history only the newest document is read. Empty: it may be.
  std::string readOnly;
};

/// Opens a saved document. What is damaged is repaired from what else is in the file, and told in notes; nothing is
/// written. Throws Error: not there, no document, made by a newer Argil, nothing left that can be repaired; Cancelled.
/// Any thread.
[[nodiscard]] OpenedDocument openDocument(const std::filesystem::path& file, Job* job = nullptr);

/// What can be had of a damaged document or journal: the newest document in it, its clay filled from older records
/// where it has to be. `why` stands in its notes. Throws Error when there is nothing; Cancelled.
[[nodiscard]] OpenedDocument repairDocument(const std::filesystem::path& file, const std::string& why,
                                            Job* job = nullptr);

/// What is saved: states as the session has them.
struct SaveRequest {
  std::vector<HistoryState> states;
  size_t done = 0;
  FaceData face;  ///< Empty members: what the file at `base` has stays.
  std::shared_ptr<DocumentRecords> documentRecords;
  std::shared_ptr<const Base> base;  ///< Of the file that it was opened from or saved to last; null: none.
  /// Where states without a document are read, besides the base.
  std::vector<std::shared_ptr<io::RecordSource>> sources;
  std::string writer;
};

/// Writes to a file: to that of the base only what it has not seen, to another the whole, which appears under its name
/// when it is complete. A file of the base's name that somebody else wrote since is never written to, and none is
/// replaced that was written or made while this ran. A file with a second name (hard link) is replaced as a whole, so
/// that the other name keeps what it has. Durable when it returns. Throws Error (kind work), Cancelled; then the old
/// file stands. A save that is there and may still be lost says so in `unflushed`. Lets others at the records
/// between two bricks. Any thread.
[[nodiscard]] std::shared_ptr<const Base> saveDocument(const std::filesystem::path& file, const SaveRequest& request,
                                                       Job* job = nullptr, const SaveLimits& limits = {});

/// The document alone, in a file that was never any other's: nothing that was taken out or undone is in its bytes, no
/// name of a step, and it is of no lineage.
void saveDocument(const std::filesystem::path& file, const Document& document, Job* job = nullptr, FaceData face = {});

/// Reads one state near another document: for Session::setReader. Where the other one's clay is in no file yet, so that
/// nothing can be shared, the whole is read.
[[nodiscard]] DocumentPtr readState(DocumentRecords& documentRecords, const std::shared_ptr<const Base>& base,
                                    const std::vector<std::shared_ptr<io::RecordSource>>& sources, io::RecordId state,
                                    const Document& near);

/// A name for a work: no two are alike.
[[nodiscard]] std::string newWriter();

}  // namespace argil::engine
