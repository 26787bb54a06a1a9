#pragma once
// What plugins' libraries do in the background: files in and out, operations on whole pieces.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "clay/import/height_image.h"
#include "clay/store/version.h"
#include "engine/plugins/plugin_brush.h"
#include "io/bytes/atomic_file.h"
#include "io/models/model_file.h"
#include "io/models/model_writer.h"

namespace argil::engine {

/// Of a sequence: which file of how many.
struct PluginFrame {
  uint32_t number = 0, count = 1;
};

/// Writes a model to a file, which the caller commits. Throws PluginError, Error (no space), Cancelled.
void exportByPlugin(PluginProcesses& processes, const std::string& exporter, io::AtomicFile& file,
                    const io::ModelView& model, const PluginFrame& frame, Job* job);

/// Reads a model from a file's bytes. What the plugin gives is checked as if a file had it: finite, in range, no more
/// than `most` bytes of it. Throws PluginError, Error, Cancelled.
[[nodiscard]] io::ModelFile importByPlugin(PluginProcesses& processes, const std::string& importer,
                                           std::span<const std::byte> bytes, Job* job,
                                           uint64_t most = uint64_t{4} << 30);

/// Works on a whole piece: a version of the same store, of what the plugin put, its distances renewed. Throws
/// PluginError, Cancelled; then nothing has changed.
[[nodiscard]] clay::Version operateByPlugin(PluginProcesses& processes, const std::string& operation,
                                            const std::vector<std::string>& numbers, std::span<const float> values,
                                            const clay::Version& version, Job* job);

/// Heights over a tip as a texture of a plugin has them. Throws PluginError.
[[nodiscard]] std::shared_ptr<const clay::HeightImage> imageByPlugin(PluginProcesses& processes,
                                                                     const std::string& texture,
                                                                     const std::vector<std::string>& numbers,
                                                                     std::span<const float> values);

}  // namespace argil::engine
