#include "engine/tools/felt_pieces.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace argil::engine {
namespace {

// A piece that is felt counts as nearer by so much: a hand between two pieces does not change them at every step.
constexpr double kStayingMm = 2, kStayingShare = 0.1;

Eigen::AlignedBox3d boundsOf(const clay::Version& version) {
  Coord low{INT32_MAX, INT32_MAX, INT32_MAX}, high{INT32_MIN, INT32_MIN, INT32_MIN};
  version.forEachBrick([&](const clay::Brick& brick) {
    const Coord at = brick.coord;
    low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
  });
  if (low.x > high.x) return {};
  const clay::Grid& grid = version.grid();
  return {grid.toWorld((low * clay::kBrickEdge).toVec3d()),
          grid.toWorld(((high + Coord{1, 1, 1}) * clay::kBrickEdge).toVec3d())};
}

}  // namespace

bool FeltPieces::choose(const Document& document, const Vec3d& handMm) {
  const Piece* worked = document.workedOn();
  bool same = seen_.size() == document.pieces.size() && worked_ == (worked ? worked->id : 0);
  const bool looked = std::exchange(stroke_, document.stroke) == document.stroke && document.stroke != 0;
  for (size_t i = 0; same && !looked && i < seen_.size(); ++i)
    same = seen_[i].id == document.pieces[i].id && seen_[i].visible == document.pieces[i].visible;
  const bool moved = !((handMm - chosenAt_).norm() < kMovedMm);
  if (same && (!moved || visible_ <= haptics::kMaxPieces)) return false;
  chosenAt_ = handMm;
  worked_ = worked ? worked->id : 0;
  if (!same) look(document);
  const std::vector<Id> before = ids_;
  if (visible_ > haptics::kMaxPieces) {
    chooseNearest(document, handMm);
  } else {
    places_.clear();
    for (size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i].id == worked_)
        places_.insert(places_.begin(), i);
      else if (seen_[i].visible)
        places_.push_back(i);
    }
  }
  for (Seen& each : seen_) each.felt = false;
  ids_.clear();
  for (const size_t place : places_) {
    seen_[place].felt = true;
    ids_.push_back(seen_[place].id);
  }
  return ids_ != before;
}

// What was known of a piece goes with it to its new place.
void FeltPieces::look(const Document& document) {
  std::unordered_map<Id, Seen> known;
  for (Seen& each : seen_) known.emplace(each.id, std::move(each));
  seen_.clear();
  visible_ = 0;
  for (const Piece& piece : document.pieces) {
    const auto found = known.find(piece.id);
    seen_.push_back(found == known.end() ? Seen{} : std::move(found->second));
    seen_.back().id = piece.id;
    seen_.back().visible = piece.visible;
    visible_ += piece.visible;
  }
}

void FeltPieces::chooseNearest(const Document& document, const Vec3d& handMm) {
  constexpr size_t kNone = SIZE_MAX;
  size_t first = 0, worked = kNone;
  std::vector<std::pair<double, size_t>> near;
  near.reserve(seen_.size());
  for (size_t i = 0; i < seen_.size(); ++i) {
    Seen& each = seen_[i];
    const Piece& piece = document.pieces[i];
    if (each.id == worked_) {
      worked = i;
      first = 1;
    }
    if (!each.visible || each.id == worked_) continue;
    if (each.measured != piece.version) {
      each.measured = piece.version;
      each.bounds = boundsOf(piece.version);
    }
    const double away = each.bounds.isEmpty() ? 1e300 : each.bounds.exteriorDistance(piece.pose.applyInverse(handMm));
    near.emplace_back(each.felt ? away * (1 - kStayingShare) - kStayingMm : away, i);
  }
  const size_t room = haptics::kMaxPieces - first;  // less than there are
  std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(room), near.end());
  near.resize(room);
  std::unordered_map<Id, size_t> chosen;
  for (const auto& [away, place] : near) chosen.emplace(seen_[place].id, place);
  // Those that stay keep their places in the scene; others fill what is free, in order.
  places_.assign(haptics::kMaxPieces, kNone);
  if (worked != kNone) places_[0] = worked;
  for (size_t i = first; i < ids_.size(); ++i) {
    const auto found = chosen.find(ids_[i]);
    if (found == chosen.end()) continue;
    places_[i] = found->second;
    chosen.erase(found);
  }
  std::vector<size_t> fresh;
  for (const auto& [id, place] : chosen) fresh.push_back(place);
  std::sort(fresh.begin(), fresh.end());
  size_t next = 0;
  for (size_t& place : places_) {
    if (place == kNone && next < fresh.size()) place = fresh[next++];
  }
  std::erase(places_, kNone);
}

}  // namespace argil::engine
