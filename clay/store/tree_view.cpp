#include "clay/store/tree_view.h"

#include "clay/store/tree.h"

namespace argil::clay {

Coord treeFirst() {
  return {-kBrickOrigin, -kBrickOrigin, -kBrickOrigin};
}

TreePlace TreePlace::root(const Version& version) {
  return rootOfTree(version, kDistanceTree);
}
TreePlace TreePlace::root(const Version& version, Channel channel) {
  return rootOfTree(version, treeOf(channel));
}

TreePlace TreePlace::rootOfTree(const Version& version, int tree) {
  TreePlace place;
  place.link_ = version.record()->roots[static_cast<size_t>(tree)];
  place.first_ = treeFirst();
  place.level_ = kTreeLevels;
  return place;
}

TreePlace::Identity TreePlace::identity() const {
  return {link_, reinterpret_cast<const Node*>(link_)->birth};
}

TreePlace TreePlace::child(int index) const {
  TreePlace place;
  place.link_ = isTile() ? link_ : reinterpret_cast<const Node*>(link_)->child[index];
  place.first_ = childFirst(first_, level_, index);
  place.level_ = level_ - 1;
  return place;
}

}  // namespace argil::clay
