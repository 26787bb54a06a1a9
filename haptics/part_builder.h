#pragma once
// Parts built in the background while the ones before them are still touched.

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "clay/job.h"
#include "clay/triangle_mesh.h"
#include "haptics/part_mesh.h"

namespace argil::haptics {

/// Builds one PartMesh at a time on a thread of its own; a newer request cancels the one before it. The publisher polls, puts the
/// mesh into the next scene and publishes that: until then, and until no reader can see it any more, the old one serves.
/// One thread calls it, not the servo's.
class PartBuilder {
 public:
  struct Result {
    uint64_t request = 0;                  ///< What request() returned.
    std::shared_ptr<const PartMesh> mesh;  ///< Null: `error` says why.
    std::string error;
  };

  PartBuilder();
  /// Cancels what is under way and waits until the builder has noticed: a third of a second for 10^6 triangles.
  ~PartBuilder();
  PartBuilder(const PartBuilder&) = delete;
  PartBuilder& operator=(const PartBuilder&) = delete;

  /// Begins to build `mesh` (not null, not changed meanwhile). Results of earlier requests that were not polled are dropped.
  /// Returns 1 for the first request, then 2, and so on. Does not wait.
  uint64_t request(std::shared_ptr<const clay::TriangleMesh> mesh);
  /// Drops the last request and its result, if it has one.
  void cancel();

  /// The result of the last request, once: an earlier one is never given. Does not wait for the build.
  [[nodiscard]] std::optional<Result> poll();
  /// How much of the last request is done, 0 to 1; 1 when there is none.
  [[nodiscard]] double fraction() const;

 private:
  void run();
  void drop();

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::shared_ptr<const clay::TriangleMesh> wanted_;  // Not yet begun.
  std::shared_ptr<Job> job_;                          // Of what is wanted or under way.
  std::optional<Result> done_;
  uint64_t last_ = 0;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace argil::haptics
