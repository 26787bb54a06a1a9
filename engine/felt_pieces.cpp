#include "engine/felt_pieces.h"

#include <algorithm>
#include <unordered_set>
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
  return {grid.toWorld((low * clay::kBrickEdge).toVec3d()), grid.toWorld(((high + Coord{1, 1, 1}) * clay::kBrickEdge).toVec3d())};
}

}  // namespace

double FeltPieces::distance(const Piece& piece, const Vec3d& handMm) {
  Bounds& bounds = bounds_[piece.id];
  if (bounds.of != piece.version.record()) bounds = {piece.version.record(), piece.version, boundsOf(piece.version)};
  return bounds.mm.isEmpty() ? 1e300 : bounds.mm.exteriorDistance(piece.pose.applyInverse(handMm));
}

bool FeltPieces::choose(const Document& document, const Vec3d& handMm) {
  const Piece* worked = document.workedOn();
  bool same = seen_.size() == document.pieces.size() && worked_ == (worked ? worked->id : 0);
  const bool looked = std::exchange(stroke_, document.stroke) == document.stroke && document.stroke != 0;
  for (size_t i = 0; same && !looked && i < seen_.size(); ++i) same = seen_[i] == Seen{document.pieces[i].id, document.pieces[i].visible};
  const bool moved = !((handMm - chosenAt_).norm() < kMovedMm);
  if (same && (!moved || visible_ <= haptics::kMaxPieces)) return false;
  chosenAt_ = handMm;
  worked_ = worked ? worked->id : 0;
  seen_.clear();
  visible_ = 0;
  std::unordered_map<Id, size_t> placeOf;
  for (const Piece& piece : document.pieces) {
    placeOf.emplace(piece.id, seen_.size());
    seen_.push_back({piece.id, piece.visible});
    visible_ += piece.visible;
  }
  const std::vector<Id> before = std::exchange(ids_, {});
  if (worked) ids_.push_back(worked->id);
  const size_t first = ids_.size();
  if (visible_ <= haptics::kMaxPieces) {
    bounds_.clear();
    for (const Piece& piece : document.pieces) {
      if (piece.visible && &piece != worked) ids_.push_back(piece.id);
    }
  } else {
    std::erase_if(bounds_, [&](const auto& each) { return !placeOf.contains(each.first); });
    const std::unordered_set<Id> felt(before.begin(), before.end());
    std::vector<std::pair<double, Id>> near;
    for (const Piece& piece : document.pieces) {
      if (!piece.visible || &piece == worked) continue;
      const double away = distance(piece, handMm);
      near.emplace_back(felt.contains(piece.id) ? away * (1 - kStayingShare) - kStayingMm : away, piece.id);
    }
    const size_t room = haptics::kMaxPieces - first;  // less than there are
    std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(room), near.end());
    near.resize(room);
    std::unordered_set<Id> chosen;
    for (const auto& [away, id] : near) chosen.insert(id);
    // Those that stay keep their places; others fill what is free, in order.
    ids_.resize(haptics::kMaxPieces, 0);
    for (size_t i = first; i < before.size(); ++i) {
      if (chosen.erase(before[i]) > 0) ids_[i] = before[i];
    }
    std::vector<Id> fresh(chosen.begin(), chosen.end());
    std::sort(fresh.begin(), fresh.end());
    size_t next = 0;
    for (Id& id : ids_) {
      if (id == 0 && next < fresh.size()) id = fresh[next++];
    }
    std::erase(ids_, 0u);
  }
  places_.clear();
  for (const Id id : ids_) places_.push_back(placeOf.at(id));
  return ids_ != before;
}

}  // namespace argil::engine
