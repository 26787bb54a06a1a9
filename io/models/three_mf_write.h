#pragma once
// 3MF packages written. For this module's files.

#include "io/bytes/atomic_file.h"
#include "io/models/model_writer.h"

namespace argil::io {

/// One object and one item of the build for each object that has triangles, in millimetres. Coordinates are the
/// shortest decimals of 32-bit numbers: the specification lets readers keep no more. An object's colour is a base
/// material; colours of triangles or vertices are a colour group. Text is made and packed block by block on the threads
/// that TBB gives; equal models give equal bytes, however many. Memory: about 2 MB for each block on its way, three a
/// thread, and 4 bytes a distinct colour. Throws Error (kind work): colours that do not fit the mesh; Cancelled.
void writeThreeMf(AtomicFile& file, const ModelView& model, const WriteOptions& options, WriteReport& report, Job* job);

}  // namespace argil::io
