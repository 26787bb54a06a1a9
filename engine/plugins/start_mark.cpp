#include "engine/plugins/start_mark.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace argil::engine {

StartMark::StartMark(const std::filesystem::path& file)
    : file_(file.empty() ? -1 : ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
  // The lock goes with its process, however that ends.
  if (file_.get() < 0 || ::flock(file_.get(), LOCK_EX | LOCK_NB) != 0) return;
  holds_ = true;
  struct stat facts {};
  lastDied_ = ::fstat(file_.get(), &facts) == 0 && facts.st_size > 0;
  if (::ftruncate(file_.get(), 1) != 0) lastDied_ = false;
}

void StartMark::good() {
  if (!holds_) return;
  holds_ = false;
  (void)!::ftruncate(file_.get(), 0);
  (void)::flock(file_.get(), LOCK_UN);
}

}  // namespace argil::engine
