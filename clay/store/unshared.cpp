#include "clay/store/unshared.h"

#include "clay/store/tree.h"

namespace argil::clay {
namespace {

void count(Link own, Link other, int level, uint64_t& leaves, uint64_t& nodes) {
  if (isTile(own) || own == other) return;
  if (level == 0) {
    ++leaves;
    return;
  }
  ++nodes;
  const auto* node = reinterpret_cast<const Node*>(own);
  const auto* beside = isTile(other) ? nullptr : reinterpret_cast<const Node*>(other);
  for (int i = 0; i < 512; ++i) count(node->child[i], beside ? beside->child[i] : other, level - 1, leaves, nodes);
}

void countDiffering(Link a, Link b, int level, uint64_t most, uint64_t& count) {
  if (a == b || (isTile(a) && isTile(b)) || count > most) return;
  if (level == 0) {
    ++count;
    return;
  }
  const auto childOf = [](Link link, int i) {
    return isTile(link) ? link : reinterpret_cast<const Node*>(link)->child[i];
  };
  for (int i = 0; i < 512; ++i) countDiffering(childOf(a, i), childOf(b, i), level - 1, most, count);
}

}  // namespace

uint64_t differingLeaves(const Version& a, const Version& b, uint64_t most) {
  uint64_t count = 0;
  for (size_t i = 0; i < kTrees; ++i)
    countDiffering(a.record()->roots[i], b.record()->roots[i], kTreeLevels, most, count);
  return count;
}

VersionStats unshared(const Version& version, const Version& other) {
  if (version.store() != other.store()) return version.stats();
  VersionStats alone;
  alone.precision = version.stats().precision;
  for (size_t i = 0; i < kTrees; ++i)
    count(version.record()->roots[i], other.record()->roots[i], kTreeLevels,
          i == kDistanceTree ? alone.bricks : alone.channelBricks, alone.nodes);
  return alone;
}

}  // namespace argil::clay
