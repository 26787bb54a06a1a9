#pragma once
// Between versions and OpenVDB, the library for work on the whole model.

#include <memory>

#include "clay/base/job.h"
#include "clay/store/version.h"

namespace argil::clay {

/// An openvdb::FloatGrid whose header stays out of sight: std::static_pointer_cast<openvdb::FloatGrid>(grid) gives it
/// back where <openvdb/openvdb.h> is included. Unit voxels: index coordinates are voxel coordinates, distances are in
/// voxels; the grid's place in the world travels apart, as a clay::Grid.
struct VdbGrid {
  std::shared_ptr<void> grid;
};

/// Readies OpenVDB; any number of times, any thread. Only code that uses the library by itself needs to call it.
void initializeVdb();

/// The version as a level set: leaf for brick, active where |phi| < band, background the band. O(model).
[[nodiscard]] VdbGrid toVdb(const Version& version, Job* job = nullptr);

/// A level set as a version: brick for leaf, values clamped to ±grid.band, tiles by their sign. The index origin is
/// voxel (0, 0, 0), so the way there and back keeps every bit of a version. The grid must be a narrow band of unit
/// voxels at least as wide as grid.band. Throws Error when it reaches farther than a version can, Cancelled when the
/// job was; the job's fraction runs from `jobFrom` to 1. O(model).
[[nodiscard]] Version fromVdb(std::shared_ptr<Store> store, const Grid& grid, const VdbGrid& level, Job* job = nullptr,
                              double jobFrom = 0);

}  // namespace argil::clay
