#include "haptics/part_builder.h"

#include <sys/resource.h>

#include <exception>
#include <utility>

namespace argil::haptics {

PartBuilder::PartBuilder() : thread_([this] { run(); }) {}

PartBuilder::~PartBuilder() {
  {
    const std::lock_guard lock(mutex_);
    drop();
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void PartBuilder::drop() {
  if (job_) job_->cancel();
  job_.reset();
  wanted_.reset();
  done_.reset();
}

uint64_t PartBuilder::request(std::shared_ptr<const clay::TriangleMesh> mesh) {
  const std::lock_guard lock(mutex_);
  drop();
  wanted_ = std::move(mesh);
  job_ = std::make_shared<Job>();
  wake_.notify_one();
  return ++last_;
}

void PartBuilder::cancel() {
  const std::lock_guard lock(mutex_);
  drop();
}

std::optional<PartBuilder::Result> PartBuilder::poll() {
  const std::lock_guard lock(mutex_);
  return std::exchange(done_, std::nullopt);
}

double PartBuilder::fraction() const {
  const std::lock_guard lock(mutex_);
  return job_ ? job_->fraction() : 1.0;
}

void PartBuilder::run() {
  // Of this thread alone, on Linux: whole-mesh work comes last.
  setpriority(PRIO_PROCESS, 0, 10);
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stop_ || wanted_; });
    if (stop_) return;
    std::shared_ptr<const clay::TriangleMesh> mesh = std::exchange(wanted_, nullptr);
    const std::shared_ptr<Job> job = job_;
    Result result;
    result.request = last_;
    lock.unlock();
    try {
      result.mesh = std::make_shared<const PartMesh>(*mesh, job.get());
    } catch (const std::exception& e) {
      result.error = e.what();
    }
    mesh.reset();
    lock.lock();
    if (job_ != job) {
      // A newer request, or none: nobody asks for this any more. Freeing it takes time that the publisher must not wait for.
      lock.unlock();
      result = {};
      lock.lock();
      continue;
    }
    job_.reset();
    done_ = std::move(result);
  }
}

}  // namespace argil::haptics
