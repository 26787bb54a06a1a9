#pragma once
// OpenVDB's usual grids, which libopenvdb has compiled already: whoever includes this too does not compile them again
// (a fifth to two thirds of the time that such a source takes). Not for clang: it would call short members, which GCC
// puts in line and libopenvdb keeps to itself.

#ifndef OPENVDB_OPENVDB_HAS_BEEN_INCLUDED
#error "include <openvdb/openvdb.h> before: headers of this tree do not bring it along"
#endif

#ifndef __clang__
namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {

extern template class tree::Tree<FloatTree::RootNodeType>;
extern template class tree::Tree<DoubleTree::RootNodeType>;
extern template class tree::Tree<Int32Tree::RootNodeType>;
extern template class tree::Tree<Vec3STree::RootNodeType>;
extern template class Grid<FloatTree>;
extern template class Grid<DoubleTree>;
extern template class Grid<Int32Tree>;
extern template class Grid<Vec3STree>;

}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb
#endif
