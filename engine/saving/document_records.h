#pragma once
// Documents to records and back: what saved files and journals have in common.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "clay/base/job.h"
#include "engine/document/document.h"
#include "engine/document/timed_mutex.h"
#include "engine/text/document_text.h"
#include "io/records/clay_records.h"
#include "io/records/record.h"

namespace argil::engine {

/// What a document in work is called in its files: which record holds what. All files of one document in work share
/// these, so that what was written to the journal is known when the document is saved, and the other way
/// round. Members may be called from any thread but the servo's; one at a time reads or writes (`lock`).
class DocumentRecords {
 public:
  DocumentRecords() : clay_(ids_) {}
  DocumentRecords(const DocumentRecords&) = delete;
  DocumentRecords& operator=(const DocumentRecords&) = delete;

  /// Held while something is put or read. Waits for a save at most until its next brick (see Giving).
  using Lock = std::unique_lock<TimedMutex>;
  [[nodiscard]] Lock lock();
  /// The same, but no longer than that, as whoever holds it may wait for a disk: look whether it is owned.
  [[nodiscard]] Lock tryLock(std::chrono::milliseconds most);

  /// A sink of who holds the lock for long: lets those pass who wait for it, between two bricks.
  class Giving : public io::RecordSink {
   public:
    Giving(io::RecordSink& sink, DocumentRecords& documentRecords, Lock& lock)
        : sink_(sink), documentRecords_(documentRecords), lock_(lock) {}
    void put(const io::RecordHeader& header, std::span<const std::byte> body) override;

   private:
    io::RecordSink& sink_;
    DocumentRecords& documentRecords_;
    Lock& lock_;
  };

  // With the lock held:

  /// Puts what of the document is not in `held` yet; the state's id, the same for the same document whatever file it
  /// goes to. Throws what the sink throws, Cancelled.
  io::RecordId put(const DocumentPtr& document, io::RecordSet& held, io::RecordSink& sink, io::RecordCodec codec,
                   Job* job = nullptr);
  /// The id that put() gave a document, 0 if it never did.
  [[nodiscard]] io::RecordId known(const DocumentPtr& document) const;
  /// All its clay has been put: what is read near it shares with it.
  [[nodiscard]] bool knowsClay(const Document& document);

  struct Read {
    DocumentPtr document;
    std::vector<std::string> notes;    ///< What was lost, with `repair`.
    std::vector<std::string> unknown;  ///< Keys of its text that are not known, where they are allowed.
  };
  /// The document of a state. With `near`, clay and meshes that both have are shared and the cost follows the
  /// difference. Parts come as they can be felt. Throws Error (kind work) for what is missing or damaged, Cancelled.
  Read get(io::RecordSource& source, io::RecordId state, const Document* near, Job* job = nullptr,
           const io::OlderBricks* repair = nullptr);
  /// From now on keys of texts that are not known are left out, and told by get(): what is read was written by a newer
  /// Argil.
  void allowUnknown() { allowsUnknown_ = true; }
  /// Keys of a state's text that are not known. Throws as get() does.
  [[nodiscard]] std::vector<std::string> unknownIn(io::RecordSource& source, io::RecordId state) const;
  /// Ids of all that a state consists of.
  void mark(io::RecordSource& source, io::RecordId state, io::RecordSet& live);
  /// Copies what of a state is not in `held`, from one file to another.
  void copy(io::RecordSource& source, io::RecordId state, io::RecordSet& held, io::RecordSink& sink);

  [[nodiscard]] io::RecordIds& ids() { return ids_; }
  /// Forgets what belongs to clay that none of these documents has, when there is much of it.
  void tidy(const std::vector<DocumentPtr>& inUse);

 private:
  template <class T>
  using Weak = std::map<std::weak_ptr<const T>, io::RecordId, std::owner_less<>>;

  uint32_t ownerOf(const clay::Version& version);
  std::shared_ptr<clay::Store> storeOf(uint32_t owner, clay::Precision precision);
  io::RecordId putMesh(const std::shared_ptr<const clay::TriangleMesh>& mesh, io::RecordSet& held,
                       io::RecordSink& sink);
  Part readPart(Part part, io::RecordSource& source, io::RecordId mesh, const Document* near, Job* job);

  TimedMutex mutex_;
  std::atomic<int> waiting_{0};
  io::RecordIds ids_;
  io::ClayRecords clay_;
  std::map<std::weak_ptr<clay::Store>, uint32_t, std::owner_less<>> owners_;
  uint32_t nextOwner_ = 1;
  bool allowsUnknown_ = false;
  Weak<clay::TriangleMesh> meshes_;
  Weak<Document> states_;
  size_t tidyAt_ = 1 << 20;
};

/// Several sources as one: the first that has a record gives it. What one of them throws is thrown on when no other has
/// what was asked for.
class Sources : public io::RecordSource {
 public:
  explicit Sources(std::vector<io::RecordSource*> sources) : sources_(std::move(sources)) {}
  bool get(io::RecordId id, std::vector<std::byte>& record) override;
  void getMany(std::span<const io::RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override;

 private:
  std::vector<io::RecordSource*> sources_;
};

}  // namespace argil::engine
