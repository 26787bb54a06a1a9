#include "engine/document/jobs.h"

#include <sys/resource.h>

namespace argil::engine {

BackgroundJob::BackgroundJob(std::function<void(Job&)> work)
    : thread_([this, work = std::move(work)] {
        // Threads that the work begins inherit this. (Linux keeps it by thread; where it is refused nothing is lost.)
        (void)setpriority(PRIO_PROCESS, 0, kNice);
        try {
          work(job_);
        } catch (...) {
          failure_ = std::current_exception();
        }
        done_.store(true, std::memory_order_release);
      }) {}

BackgroundJob::~BackgroundJob() {
  job_.cancel();
  if (thread_.joinable()) thread_.join();
}

void BackgroundJob::wait() {
  if (thread_.joinable()) thread_.join();
  if (failure_) std::rethrow_exception(failure_);
}

}  // namespace argil::engine
