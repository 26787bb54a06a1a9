#include "clay/unshared.h"

#include "clay/tree.h"

namespace argil::clay {
namespace {

void count(Link own, Link other, int level, VersionStats& alone) {
  if (isTile(own) || own == other) return;
  if (level == 0) {
    ++alone.bricks;
    return;
  }
  ++alone.nodes;
  const auto* node = reinterpret_cast<const Node*>(own);
  const auto* beside = isTile(other) ? nullptr : reinterpret_cast<const Node*>(other);
  for (int i = 0; i < 512; ++i) count(node->child[i], beside ? beside->child[i] : other, level - 1, alone);
}

}  // namespace

VersionStats unshared(const Version& version, const Version& other) {
  if (version.store() != other.store()) return version.stats();
  VersionStats alone;
  count(version.record()->root, other.record()->root, kTreeLevels, alone);
  return alone;
}

}  // namespace argil::clay
