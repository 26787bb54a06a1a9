#include "engine/saving/undo_budget.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "clay/store/unshared.h"

namespace argil::engine {
namespace {

constexpr size_t kFewPieces = 8;

bool same(const std::weak_ptr<const Document>& a, const DocumentPtr& b) {
  return !a.owner_before(b) && !b.owner_before(a);
}

// It holds nothing that is worth a file.
bool isEmpty(const Document& document) {
  return document.pieces.empty() && document.parts.empty();
}

}  // namespace

uint64_t bytesAlone(const Document& document, const Document& beside) {
  uint64_t bytes = 0;
  // Most pieces are as they are beside it, at the same place of the list: a step of a document with a thousand pieces
  // looks at each once.
  std::vector<const Piece*> others;
  for (size_t i = 0; i < document.pieces.size(); ++i) {
    const Piece& piece = document.pieces[i];
    if (piece.version && !(i < beside.pieces.size() && beside.pieces[i].version == piece.version))
      others.push_back(&piece);
  }
  if (!others.empty()) {
    std::unordered_map<const clay::VersionRecord*, const Piece*> byVersion;
    std::unordered_map<Id, const Piece*> byId;
    std::unordered_map<const clay::Store*, const Piece*> byStore;
    // One or two are found sooner by looking.
    const bool few = others.size() <= kFewPieces;
    for (const Piece& each : beside.pieces) {
      if (few || !each.version) continue;
      byVersion.emplace(each.version.record(), &each);
      byId.emplace(each.id, &each);
      byStore.emplace(each.version.store().get(), &each);
    }
    const auto find = [&](const auto& map, const auto& key, const auto& fits) -> const Piece* {
      if (few) {
        const auto found = std::find_if(beside.pieces.begin(), beside.pieces.end(),
                                        [&](const Piece& each) { return each.version && fits(each); });
        return found == beside.pieces.end() ? nullptr : &*found;
      }
      const auto found = map.find(key);
      return found == map.end() ? nullptr : found->second;
    };
    std::unordered_set<const clay::VersionRecord*> counted;
    for (const Piece* piece : others) {
      const clay::Version& version = piece->version;
      const clay::Store* store = version.store().get();
      // Once, whether another piece has it too.
      if (find(byVersion, version.record(), [&](const Piece& each) { return each.version == version; }) ||
          !counted.insert(version.record()).second)
        continue;
      // Its own earlier or later clay, else that of a copy.
      const Piece* other = find(byId, piece->id, [&](const Piece& each) { return each.id == piece->id; });
      if (!other || other->version.store().get() != store)
        other = find(byStore, store, [&](const Piece& each) { return each.version.store().get() == store; });
      bytes += other ? clay::unshared(version, other->version).bytes() : version.stats().bytes();
    }
  }
  for (const Part& part : document.parts) {
    const auto has = [&](const Part& each) { return each.mesh == part.mesh; };
    if (!part.mesh || std::any_of(beside.parts.begin(), beside.parts.end(), has)) continue;
    bytes += part.mesh->positions.size() * sizeof(part.mesh->positions[0]) +
             part.mesh->triangles.size() * sizeof(part.mesh->triangles[0]);
  }
  return bytes;
}

UndoUse UndoBudget::keep(Session& session, const Kept& kept) {
  const std::vector<HistoryState>& states = session.states();
  const size_t done = session.undoSteps();
  std::vector<size_t> row;  // in memory
  for (size_t i = 0; i < states.size(); ++i) {
    if (states[i].document) row.push_back(i);
  }
  edges_.resize(states.size());
  UndoUse use;
  size_t fresh = 0;
  for (size_t k = 0; k + 1 < row.size(); ++k) {
    const DocumentPtr &of = states[row[k]].document, &next = states[row[k + 1]].document;
    Edge& edge = edges_[row[k]];
    if (!same(edge.of, of) || !same(edge.next, next)) {
      if (fresh++ >= kMostNew) continue;  // the next time
      edge = {of, next, bytesAlone(*of, *next), bytesAlone(*next, *of)};
    }
    use.bytes += row[k] < done ? edge.below : edge.above;
  }
  const auto letGo = [&](size_t state, uint64_t alone) {
    const uint64_t id = states[state].kept != 0 ? states[state].kept : kept(states[state].document);
    if (id == 0) return false;
    session.spill(state, id);
    use.bytes -= alone;
    return true;
  };
  size_t first = 0, last = row.size();
  const auto tooMuch = [&] { return bytes_ != 0 && use.bytes > bytes_ && fresh <= kMostNew; };
  while (tooMuch() && row[first] < done) {
    if (!isEmpty(*states[row[first]].document) && !letGo(row[first], edges_[row[first]].below)) break;
    ++first;
  }
  if (row[first] == done) {
    while (tooMuch() && row[last - 1] > done && letGo(row[last - 1], edges_[row[last - 2]].above)) --last;
  }
  for (const HistoryState& state : states) ++(state.document ? use.inMemory : use.onDisk);
  --use.inMemory;  // the newest
  use.over = bytes_ != 0 && use.bytes > bytes_;
  return use;
}

}  // namespace argil::engine
