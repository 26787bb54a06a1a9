#include "io/reader/sandbox.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>

#include "clay/base/error.h"
#include "io/reader/descriptor.h"

namespace argil::io::reader {

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

[[noreturn]] void failConfining() {
  throw Error("the reader could not confine itself", Error::Kind::work);
}

void limit(__rlimit_resource what, uint64_t value) {
  rlimit limits{};
  if (::getrlimit(what, &limits) != 0) return;
  limits.rlim_cur = limits.rlim_max = std::min<rlim_t>(limits.rlim_max, value);
  if (::setrlimit(what, &limits) != 0)
    throw Error("the reader's limits could not be set; look at ulimit -a", Error::Kind::work);
}

/// No file but what may be read; false where the kernel has no Landlock (before 5.13, or not switched on).
bool confineFiles(const std::filesystem::path& file, Readable readable) {
  const auto version = int(::syscall(SYS_landlock_create_ruleset, nullptr, size_t{0}, LANDLOCK_CREATE_RULESET_VERSION));
  if (version < 1) return false;
  // All rights of the first version, and those of later ones that both the kernel and our headers know.
  uint64_t rights = (uint64_t{LANDLOCK_ACCESS_FS_MAKE_SYM} << 1) - 1;
#ifdef LANDLOCK_ACCESS_FS_REFER
  if (version >= 2) rights |= LANDLOCK_ACCESS_FS_REFER;
#endif
#ifdef LANDLOCK_ACCESS_FS_TRUNCATE
  if (version >= 3) rights |= LANDLOCK_ACCESS_FS_TRUNCATE;
#endif
  landlock_ruleset_attr attributes{};
  attributes.handled_access_fs = rights;
  const Descriptor rules(int(::syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes, 0)));
  if (rules.get() < 0) failConfining();
  const std::filesystem::path place = readable == Readable::file ? file : file.parent_path();
  const Descriptor allowed(::open(place.c_str(), O_PATH | O_CLOEXEC));
  if (allowed.get() >= 0) {  // Else it is not there, which is told when it is opened.
    landlock_path_beneath_attr beneath{};
    beneath.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE;
    beneath.parent_fd = allowed.get();
    if (::syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &beneath, 0) != 0) failConfining();
  }
  if (::syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0) failConfining();
  return true;
}

/// System calls of computing and reading; false where the kernel has no filters.
bool confineCalls() {
  // What libraries call to compute, to start threads (TBB) and to read. A call that the machine does not have is passed
  // over.
  constexpr int kAllowed[] = {SCMP_SYS(read),
                              SCMP_SYS(write),
                              SCMP_SYS(readv),
                              SCMP_SYS(writev),
                              SCMP_SYS(pread64),
                              SCMP_SYS(close),
                              SCMP_SYS(fstat),
                              SCMP_SYS(stat),
                              SCMP_SYS(lstat),
                              SCMP_SYS(newfstatat),
                              SCMP_SYS(statx),
                              SCMP_SYS(lseek),
                              SCMP_SYS(access),
                              SCMP_SYS(faccessat),
                              SCMP_SYS(readlink),
                              SCMP_SYS(readlinkat),
                              SCMP_SYS(getdents64),
                              SCMP_SYS(getcwd),
                              SCMP_SYS(fcntl),
                              SCMP_SYS(poll),
                              SCMP_SYS(ppoll),
                              SCMP_SYS(mmap),
                              SCMP_SYS(mprotect),
                              SCMP_SYS(munmap),
                              SCMP_SYS(mremap),
                              SCMP_SYS(madvise),
                              SCMP_SYS(brk),
                              SCMP_SYS(futex),
                              SCMP_SYS(set_robust_list),
                              SCMP_SYS(rseq),
                              SCMP_SYS(set_tid_address),
                              SCMP_SYS(arch_prctl),
                              SCMP_SYS(membarrier),
                              SCMP_SYS(sched_yield),
                              SCMP_SYS(sched_getaffinity),
                              SCMP_SYS(getcpu),
                              SCMP_SYS(get_mempolicy),
                              SCMP_SYS(getpid),
                              SCMP_SYS(gettid),
                              SCMP_SYS(rt_sigaction),
                              SCMP_SYS(rt_sigprocmask),
                              SCMP_SYS(rt_sigreturn),
                              SCMP_SYS(sigaltstack),
                              SCMP_SYS(restart_syscall),
                              SCMP_SYS(exit),
                              SCMP_SYS(exit_group),
                              SCMP_SYS(clock_gettime),
                              SCMP_SYS(clock_nanosleep),
                              SCMP_SYS(nanosleep),
                              SCMP_SYS(gettimeofday),
                              SCMP_SYS(times),
                              SCMP_SYS(getrusage),
                              SCMP_SYS(getrandom),
                              SCMP_SYS(uname),
                              SCMP_SYS(sysinfo),
                              SCMP_SYS(getuid),
                              SCMP_SYS(geteuid),
                              SCMP_SYS(getgid),
                              SCMP_SYS(getegid)};
  constexpr scmp_datum_t kWriting = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;
  if (::prctl(PR_GET_SECCOMP, 0, 0, 0, 0) < 0 && errno == EINVAL) return false;
  const std::unique_ptr<void, void (*)(void*)> filter(::seccomp_init(SCMP_ACT_ERRNO(EPERM)), ::seccomp_release);
  if (filter == nullptr) failConfining();
  const auto rule = [&](int call, uint32_t action, auto... conditions) {
    if (call >= 0 &&
        ::seccomp_rule_add(filter.get(), action, call, unsigned(sizeof...(conditions)), conditions...) != 0)
      failConfining();
  };
  // The library's macros for this are C, which clang refuses in C++.
  const auto masked = [](unsigned argument, scmp_datum_t mask, scmp_datum_t value) {
    return scmp_arg_cmp{argument, SCMP_CMP_MASKED_EQ, mask, value};
  };
  for (const int call : kAllowed) rule(call, SCMP_ACT_ALLOW);
  rule(SCMP_SYS(openat), SCMP_ACT_ALLOW, masked(2, kWriting, 0));
  rule(SCMP_SYS(open), SCMP_ACT_ALLOW, masked(1, kWriting, 0));
  // abort() sends itself a signal; nobody else gets one.
  rule(SCMP_SYS(tgkill), SCMP_ACT_ALLOW, scmp_arg_cmp{0, SCMP_CMP_EQ, scmp_datum_t(::getpid()), 0});
  // Threads, not processes. The C library falls back to clone when the kernel knows no clone3, whose flags lie in
  // memory.
  rule(SCMP_SYS(clone3), SCMP_ACT_ERRNO(ENOSYS));
  rule(SCMP_SYS(clone), SCMP_ACT_ALLOW, masked(0, scmp_datum_t(CLONE_THREAD), scmp_datum_t(CLONE_THREAD)));
  const int loaded = ::seccomp_load(filter.get());
  if (loaded == -EINVAL || loaded == -ENOSYS || loaded == -EOPNOTSUPP) return false;
  if (loaded != 0) failConfining();
  return true;
}

}  // namespace

void limitResources(uint64_t memoryBytes, uint64_t seconds) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (!kSanitized) limit(RLIMIT_AS, memoryBytes);
  limit(RLIMIT_CPU, seconds);
  limit(RLIMIT_NOFILE, 64);
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_CORE, 0);
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
    throw Error("the reader could not give up its privileges", Error::Kind::work);
}

std::string confine(const std::filesystem::path& file, Readable readable) {
  if (kSanitized) return {};
  const bool files = confineFiles(file, readable), calls = confineCalls();
  if (files && calls) return {};
  const std::string cannot = "this system cannot confine the program that reads such files";
  if (calls)
    return cannot + " to this one (it has no Landlock): it could read others of yours if a damaged file misled it";
  if (files) return cannot + " fully (it has no seccomp): open only files that you trust";
  return cannot + " (it has neither seccomp nor Landlock): open only files that you trust";
}

}  // namespace argil::io::reader
