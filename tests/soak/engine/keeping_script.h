#pragma once
// What a session under test does, the same in the program that is killed and in the one that looks at what is left.

#include <fcntl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "clay/base/hash.h"
#include "engine/document/document.h"
#include "engine/document/random.h"
#include "engine/document/tool.h"

namespace argil::soak {

inline int64_t nowNs() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1'000'000'000LL + t.tv_nsec;
}

/// In a file that both programs map: it outlives the one that is killed.
struct Progress {
  static constexpr size_t kActions = 200'000, kOps = 5'000;
  std::atomic<int64_t> readyNs;   ///< The session works from here on.
  std::atomic<uint64_t> actions;  ///< Points, and ops that are no strokes, in the order of the script.
  std::atomic<uint64_t> ops;      ///< Finished.
  std::atomic<uint64_t> savedOp;  ///< Ops that were in the newest document that saveDocument() returned for.
  std::atomic<uint64_t> saves, saveErrors;
  std::atomic<uint64_t> journalErrors;  ///< Sentences that a person would have got.
  std::atomic<int64_t> troubledNs;      ///< When the first of them came; 0: none.
  std::atomic<double> autosaveCpuS, autosaveSteps;
  std::atomic<uint64_t> autosaveBytes;
  std::atomic<int64_t> at[kActions];     ///< When each was done.
  std::atomic<uint64_t> hash[kOps + 1];  ///< Of the document after so many ops.
};

inline Progress* mapProgress(const std::filesystem::path& file, bool make) {
  const int fd = open(file.c_str(), make ? O_RDWR | O_CREAT | O_TRUNC : O_RDWR, 0600);
  if (fd < 0 || (make && ftruncate(fd, sizeof(Progress)) != 0)) throw std::runtime_error("no progress file");
  void* at = mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  if (at == MAP_FAILED) throw std::runtime_error("no progress map");
  return static_cast<Progress*>(at);
}

struct Op {
  enum class Kind { stroke, undo, redo, move } kind = Kind::stroke;
  engine::Tool tool;
  std::vector<Vec3d> points;  ///< Of a stroke, mm, one a millisecond.
  bool save = false;          ///< A save is asked for when it is done.
};

/// Endless, by number: strokes on a sphere of this radius about zero.
inline Op opOf(uint64_t seed, uint64_t number, double radiusMm, double voxelMm) {
  engine::Random random(seed * 1'000'003 + number);
  Op op;
  const size_t kind = random.below(12);
  if (kind == 0 && number > 2) op.kind = Op::Kind::undo;
  if (kind == 1 && number > 2) op.kind = Op::Kind::redo;
  if (kind == 2) op.kind = Op::Kind::move;
  op.save = random.below(6) == 0;
  if (op.kind != Op::Kind::stroke) return op;
  op.tool.id = std::array{"carve", "add", "smooth"}[random.below(3)];
  op.tool.radiusMm = voxelMm * random.between(4, 12);
  op.tool.strength = 0.5f;
  Vec3d at = random.inBall();
  at = radiusMm * at / std::max(0.01, at.norm());
  const size_t count = 20 + random.below(400);
  for (size_t i = 0; i < count; ++i) {
    op.points.push_back(at);
    at += 0.4 * voxelMm * random.inBall();
    at *= radiusMm / at.norm();
  }
  return op;
}

inline uint64_t hashOf(const engine::Document& document) {
  clay::Hasher hasher;
  for (const engine::Piece& piece : document.pieces) {
    hasher.add(piece.version.hash());
    hasher.add(piece.pose.translation.data(), 24);
  }
  return hasher.value();
}

}  // namespace argil::soak
