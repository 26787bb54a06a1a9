#include "engine/saving/document_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <exception>
#include <span>
#include <thread>

#include "clay/base/error.h"
#include "clay/store/store.h"
#include "haptics/scene/part_mesh.h"
#include "io/records/blob.h"

namespace argil::engine {
namespace {

constexpr size_t kMostState = size_t{64} << 20;
constexpr size_t kMostMesh = size_t{8} << 30;
constexpr size_t kCopied = 256;  // records at once

std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text));
}

std::string_view textOf(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Count of vertices, count of triangles, positions, corners: little endian, as in memory.
std::vector<std::byte> meshBytes(const clay::TriangleMesh& mesh) {
  static_assert(sizeof(Vec3d) == 24 && sizeof(mesh.triangles[0]) == 12);
  const uint64_t counts[2] = {mesh.positions.size(), mesh.triangles.size()};
  std::vector<std::byte> bytes(sizeof counts + mesh.positions.size() * 24 + mesh.triangles.size() * 12);
  std::byte* at = bytes.data();
  std::memcpy(at, counts, sizeof counts);
  at += sizeof counts;
  if (!mesh.positions.empty()) std::memcpy(at, mesh.positions.data(), mesh.positions.size() * 24);
  at += mesh.positions.size() * 24;
  if (!mesh.triangles.empty()) std::memcpy(at, mesh.triangles.data(), mesh.triangles.size() * 12);
  return bytes;
}

std::shared_ptr<const clay::TriangleMesh> meshFrom(const std::vector<std::byte>& bytes) {
  const auto damaged = [] { return Error("damaged: a part's mesh does not hold together", Error::Kind::work); };
  uint64_t counts[2];
  if (bytes.size() < sizeof counts) throw damaged();
  std::memcpy(counts, bytes.data(), sizeof counts);
  if (counts[0] > UINT32_MAX || counts[1] > UINT32_MAX ||
      bytes.size() != sizeof counts + counts[0] * 24 + counts[1] * 12)
    throw damaged();
  auto mesh = std::make_shared<clay::TriangleMesh>();
  mesh->positions.resize(counts[0]);
  mesh->triangles.resize(counts[1]);
  const std::byte* at = bytes.data() + sizeof counts;
  if (counts[0] > 0) std::memcpy(static_cast<void*>(mesh->positions.data()), at, counts[0] * 24);
  if (counts[1] > 0) std::memcpy(mesh->triangles.data(), at + counts[0] * 24, counts[1] * 12);
  for (const Vec3d& p : mesh->positions) {
    if (!p.allFinite()) throw damaged();
  }
  for (const auto& [a, b, c] : mesh->triangles) {
    if (std::max({a, b, c}) >= counts[0]) throw damaged();
  }
  return mesh;
}

DocumentText textOfState(io::RecordSource& source, io::RecordId state, std::vector<std::string>* unknown) {
  const std::vector<std::byte> bytes = io::getBlob(io::BlobKind::state, state, source, kMostState);
  try {
    return readDocumentText(textOf(bytes), "its state", unknown);
  } catch (const Error& e) {
    throw Error(fmt::format("damaged: {}", e.what()), Error::Kind::work);
  }
}

}  // namespace

DocumentRecords::Lock DocumentRecords::lock() {
  ++waiting_;
  Lock held(mutex_);
  --waiting_;
  return held;
}

DocumentRecords::Lock DocumentRecords::tryLock(std::chrono::milliseconds most) {
  ++waiting_;
  Lock held(mutex_, most);
  --waiting_;
  return held;
}

void DocumentRecords::Giving::put(const io::RecordHeader& header, std::span<const std::byte> body) {
  sink_.put(header, body);
  if (header.kind != io::RecordKind::brick || documentRecords_.waiting_.load(std::memory_order_relaxed) == 0) return;
  lock_.unlock();
  while (documentRecords_.waiting_.load() > 0) std::this_thread::sleep_for(std::chrono::microseconds(50));
  lock_.lock();
}

uint32_t DocumentRecords::ownerOf(const clay::Version& version) {
  const auto [at, fresh] = owners_.try_emplace(version.store(), nextOwner_);
  if (fresh) ++nextOwner_;
  return at->second;
}

// Pieces that were copies of each other share a store again: a copy costs nothing.
std::shared_ptr<clay::Store> DocumentRecords::storeOf(uint32_t owner, clay::Precision precision) {
  for (const auto& [weak, each] : owners_) {
    if (each != owner) continue;
    if (auto store = weak.lock()) return store;
  }
  auto store = clay::Store::make(precision);
  owners_[store] = owner;
  nextOwner_ = std::max(nextOwner_, owner + 1);
  return store;
}

io::RecordId DocumentRecords::putMesh(const std::shared_ptr<const clay::TriangleMesh>& mesh, io::RecordSet& held,
                                      io::RecordSink& sink) {
  const auto known = meshes_.find(mesh);
  if (known != meshes_.end() && held.contains(known->second)) return known->second;
  const io::RecordId id =
      io::putBlob(io::BlobKind::mesh, meshBytes(*mesh), ids_, held, sink, known != meshes_.end() ? known->second : 0);
  meshes_[mesh] = id;
  return id;
}

io::RecordId DocumentRecords::known(const DocumentPtr& document) const {
  const auto found = states_.find(document);
  return found == states_.end() ? 0 : found->second;
}

bool DocumentRecords::knowsClay(const Document& document) {
  return std::all_of(document.pieces.begin(), document.pieces.end(), [this](const Piece& piece) {
    return !piece.version || clay_.rootOf(piece.version, ownerOf(piece.version)) != 0;
  });
}

io::RecordId DocumentRecords::put(const DocumentPtr& document, io::RecordSet& held, io::RecordSink& sink,
                                  io::RecordCodec codec, Job* job) {
  const io::RecordId before = known(document);
  if (before != 0 && held.contains(before)) return before;
  std::vector<ClayKey> clay;
  for (const Piece& piece : document->pieces) {
    ClayKey key;
    if (piece.version) {
      key.owner = ownerOf(piece.version);
      key.root = clay_.write(piece.version, key.owner, held, sink, codec, job);
    }
    clay.push_back(key);
  }
  std::vector<io::RecordId> meshes;
  for (const Part& part : document->parts) meshes.push_back(putMesh(part.mesh, held, sink));
  const std::string text = documentText(*document, clay, meshes);
  // The same text whatever file it goes to, as all ids in it are the records' own: so it may keep its own.
  // Meanwhile another file may have got it.
  const io::RecordId id = io::putBlob(io::BlobKind::state, bytesOf(text), ids_, held, sink, known(document));
  states_[document] = id;
  return id;
}

Part DocumentRecords::readPart(Part part, io::RecordSource& source, io::RecordId mesh, const Document* near, Job* job) {
  for (const auto& [weak, id] : meshes_) {
    if (id != mesh) continue;
    part.mesh = weak.lock();
    if (part.mesh && near) {
      for (const Part& other : near->parts) {
        if (other.mesh == part.mesh) part.felt = other.felt;
      }
    }
    break;
  }
  if (!part.mesh) {
    part.mesh = meshFrom(io::getBlob(io::BlobKind::mesh, mesh, source, kMostMesh));
    meshes_[part.mesh] = mesh;
  }
  if (!part.felt) part.felt = std::make_shared<const haptics::PartMesh>(*part.mesh, job);
  return part;
}

DocumentRecords::Read DocumentRecords::get(io::RecordSource& source, io::RecordId state, const Document* near, Job* job,
                                           const io::OlderBricks* repair) {
  Read read;
  DocumentText text = textOfState(source, state, allowsUnknown_ ? &read.unknown : nullptr);
  auto document = std::make_shared<Document>(std::move(text.document));
  for (size_t i = 0; i < document->pieces.size(); ++i) {
    Piece& piece = document->pieces[i];
    const ClayKey& key = text.clay[i];
    if (key.root == 0) throw Error("damaged: a piece without clay", Error::Kind::work);
    const clay::Version* relative = nullptr;
    if (near) {
      for (const Piece& other : near->pieces) {
        if (other.version && ownerOf(other.version) == key.owner && other.version.grid() == text.grids[i])
          relative = &other.version;
      }
    }
    io::ReadClay clay;
    const io::RecordId nearRoot = relative ? clay_.rootOf(*relative, key.owner) : 0;
    if (nearRoot != 0 && repair == nullptr) {
      clay = clay_.readNear(source, key.root, *relative, nearRoot, job);
    } else {
      clay = clay_.read(source, key.root, text.grids[i], storeOf(key.owner, text.precisions[i]), job, 2, repair,
                        key.owner);
    }
    piece.version = clay.version;
    for (const std::string& note : clay.notes) read.notes.push_back(fmt::format("{}: {}", piece.name, note));
  }
  std::vector<Part> parts;
  for (size_t i = 0; i < document->parts.size(); ++i) {
    const std::string name = document->parts[i].name;
    try {
      parts.push_back(readPart(std::move(document->parts[i]), source, text.meshes[i], near, job));
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      if (!repair) throw;
      read.notes.push_back(fmt::format("{}: the part is lost ({})", name, e.what()));
    }
  }
  document->parts = std::move(parts);
  // What was left out makes it another document, which is put anew.
  if (read.notes.empty() && read.unknown.empty()) states_[document] = state;
  read.document = std::move(document);
  return read;
}

std::vector<std::string> DocumentRecords::unknownIn(io::RecordSource& source, io::RecordId state) const {
  std::vector<std::string> unknown;
  (void)textOfState(source, state, &unknown);
  return unknown;
}

void DocumentRecords::mark(io::RecordSource& source, io::RecordId state, io::RecordSet& live) {
  if (live.contains(state)) return;
  std::vector<std::string> unknown;
  const DocumentText text = textOfState(source, state, allowsUnknown_ ? &unknown : nullptr);
  for (const ClayKey& key : text.clay) io::markLive(source, key.root, live);
  for (const io::RecordId mesh : text.meshes) io::markBlob(source, mesh, live);
  io::markBlob(source, state, live);
}

void DocumentRecords::copy(io::RecordSource& source, io::RecordId state, io::RecordSet& held, io::RecordSink& sink) {
  if (held.contains(state)) return;
  io::RecordSet live = held;  // what is there already is not walked
  mark(source, state, live);
  const std::vector<io::RecordId> wanted = live.without(held);
  // The sink may let others pass, who may read from the same source: it is not in a call then.
  std::vector<std::byte> batch;
  for (size_t at = 0; at < wanted.size(); at += kCopied) {
    batch.clear();
    const auto part = std::span(wanted).subspan(at, std::min(kCopied, wanted.size() - at));
    size_t found = 0;
    source.getMany(part, [&](size_t, std::span<const std::byte> bytes) {
      batch.insert(batch.end(), bytes.begin(), bytes.end());
      ++found;
    });
    if (found != part.size()) throw Error("damaged: a record of the history is missing", Error::Kind::work);
    for (size_t begin = 0; begin < batch.size();) {
      const auto record = io::parseRecord(std::span(batch).subspan(begin));
      if (!record) throw Error("damaged: a record of the history", Error::Kind::work);
      begin += record->whole.size();
      if (held.contains(record->header.id)) continue;
      sink.put(record->header, record->body);
      held.add(record->header.id);
    }
  }
}

void DocumentRecords::tidy(const std::vector<DocumentPtr>& inUse) {
  std::erase_if(states_, [](const auto& each) { return each.first.expired(); });
  std::erase_if(owners_, [](const auto& each) { return each.first.expired(); });
  std::erase_if(meshes_, [](const auto& each) { return each.first.expired(); });
  if (clay_.entries() < tidyAt_) return;
  std::vector<clay::Version> versions;
  for (const DocumentPtr& document : inUse) {
    if (!document) continue;
    for (const Piece& piece : document->pieces) versions.push_back(piece.version);
  }
  clay_.forgetUnused(versions);
  tidyAt_ = std::max<size_t>(1 << 20, 2 * clay_.entries());
}

bool Sources::get(io::RecordId id, std::vector<std::byte>& record) {
  bool found = false;
  getMany({&id, 1}, [&](size_t, std::span<const std::byte> bytes) {
    record.assign(bytes.begin(), bytes.end());
    found = true;
  });
  return found;
}

void Sources::getMany(std::span<const io::RecordId> ids,
                      const std::function<void(size_t, std::span<const std::byte>)>& each) {
  if (sources_.size() == 1) {
    sources_[0]->getMany(ids, each);
    return;
  }
  // Each source gives what those before it do not have; what comes out is in rising order within a source only, so it
  // is put back into order.
  std::vector<size_t> left(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) left[i] = i;
  std::vector<std::vector<std::byte>> found(ids.size());
  std::exception_ptr trouble;
  for (io::RecordSource* source : sources_) {
    if (left.empty()) break;
    std::vector<io::RecordId> wanted;
    for (const size_t i : left) wanted.push_back(ids[i]);
    try {
      source->getMany(wanted, [&](size_t i, std::span<const std::byte> bytes) {
        found[left[i]].assign(bytes.begin(), bytes.end());
      });
    } catch (const Error&) {
      trouble = std::current_exception();
    }
    std::erase_if(left, [&](size_t i) { return !found[i].empty(); });
  }
  if (!left.empty() && trouble) std::rethrow_exception(trouble);
  for (size_t i = 0; i < ids.size(); ++i) {
    if (!found[i].empty()) each(i, found[i]);
  }
}

}  // namespace argil::engine
