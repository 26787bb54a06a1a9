#pragma once
// Work on many items by threads that need large rooms. This module's own.

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "clay/base/parallel.h"
#include "clay/base/work_part.h"

namespace argil::clay {

/// Calls work(item, room) for each item below `count` on so many threads, in no set order; tells `part` how far it is
/// after each. A room is used again for item after item, since fresh pages would cost more than what is done in them,
/// and by one thread at a time.
template <class Room, class Work>
void forEachWithRoom(size_t count, int threads, const WorkPart& part, const Work& work) {
  part.step(0);
  std::mutex mutex;
  std::vector<std::unique_ptr<Room>> spare;
  size_t done = 0;
  parallelBlocks(
      count, threads,
      [&](size_t begin, size_t end) {
        std::unique_ptr<Room> room;
        {
          const std::lock_guard lock(mutex);
          if (!spare.empty()) {
            room = std::move(spare.back());
            spare.pop_back();
          }
        }
        if (!room) room = std::make_unique<Room>();
        for (size_t i = begin; i < end; ++i) {
          work(i, *room);
          const std::lock_guard lock(mutex);
          part.step(static_cast<double>(++done) / static_cast<double>(count));
        }
        const std::lock_guard lock(mutex);
        spare.push_back(std::move(room));
      },
      1);
}

}  // namespace argil::clay
