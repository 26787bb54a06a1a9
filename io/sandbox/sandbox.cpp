#include "io/sandbox/sandbox.h"

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
#include <cstdlib>
#include <memory>

#include "clay/base/error.h"
#include "io/sandbox/descriptor.h"

namespace argil::io {

namespace {

[[noreturn]] void failConfining() {
  throw Error("the process could not confine itself", Error::Kind::work);
}

void limit(__rlimit_resource what, uint64_t value) {
  rlimit limits{};
  if (::getrlimit(what, &limits) != 0) return;
  limits.rlim_cur = limits.rlim_max = std::min<rlim_t>(limits.rlim_max, value);
  if (::setrlimit(what, &limits) != 0)
    throw Error("the limits of the process could not be set; look at ulimit -a", Error::Kind::work);
}

}  // namespace

bool confineFiles(std::span<const std::filesystem::path> readable, std::span<const std::filesystem::path> nodes) {
  if (kConfinesNothing) return false;
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
  const auto allow = [&](const std::filesystem::path& place, uint64_t access) {
    const Descriptor allowed(::open(place.c_str(), O_PATH | O_CLOEXEC));
    if (allowed.get() < 0) return;  // It is not there, which is told when it is opened.
    landlock_path_beneath_attr beneath{};
    beneath.allowed_access = access;
    beneath.parent_fd = allowed.get();
    if (::syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &beneath, 0) != 0) failConfining();
  };
  for (const std::filesystem::path& place : readable) allow(place, LANDLOCK_ACCESS_FS_READ_FILE);
  for (const std::filesystem::path& node : nodes)
    allow(node, LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE);
  if (::syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0) failConfining();
  return true;
}

bool confineCalls(Calls calls) {
  if (kConfinesNothing) return false;
  // What libraries call to compute, to start threads (TBB), to read, and to confine the process further. A call that
  // the machine does not have is passed over.
  constexpr int kComputing[] = {
      SCMP_SYS(read),           SCMP_SYS(write),           SCMP_SYS(readv),         SCMP_SYS(writev),
      SCMP_SYS(pread64),        SCMP_SYS(close),           SCMP_SYS(fstat),         SCMP_SYS(lseek),
      SCMP_SYS(poll),           SCMP_SYS(ppoll),           SCMP_SYS(mmap),          SCMP_SYS(mprotect),
      SCMP_SYS(munmap),         SCMP_SYS(mremap),          SCMP_SYS(madvise),       SCMP_SYS(brk),
      SCMP_SYS(futex),          SCMP_SYS(set_robust_list), SCMP_SYS(rseq),          SCMP_SYS(set_tid_address),
      SCMP_SYS(arch_prctl),     SCMP_SYS(membarrier),      SCMP_SYS(sched_yield),   SCMP_SYS(sched_getaffinity),
      SCMP_SYS(getcpu),         SCMP_SYS(get_mempolicy),   SCMP_SYS(getpid),        SCMP_SYS(gettid),
      SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn),    SCMP_SYS(sigaltstack),   SCMP_SYS(restart_syscall),
      SCMP_SYS(exit),           SCMP_SYS(exit_group),      SCMP_SYS(clock_gettime), SCMP_SYS(clock_nanosleep),
      SCMP_SYS(nanosleep),      SCMP_SYS(gettimeofday),    SCMP_SYS(times),         SCMP_SYS(getrusage),
      SCMP_SYS(getrandom),      SCMP_SYS(uname),           SCMP_SYS(sysinfo),       SCMP_SYS(getuid),
      SCMP_SYS(geteuid),        SCMP_SYS(getgid),          SCMP_SYS(getegid)};
  constexpr int kReading[] = {SCMP_SYS(stat),   SCMP_SYS(lstat),      SCMP_SYS(newfstatat), SCMP_SYS(statx),
                              SCMP_SYS(access), SCMP_SYS(faccessat),  SCMP_SYS(readlink),   SCMP_SYS(readlinkat),
                              SCMP_SYS(getcwd), SCMP_SYS(getdents64), SCMP_SYS(fcntl)};
  constexpr int kConfining[] = {SCMP_SYS(seccomp), SCMP_SYS(prctl)};
  const bool device = calls == Calls::loadingDevice || calls == Calls::driving;
  if (device) calls = calls == Calls::driving ? Calls::computing : Calls::loading;
  const scmp_datum_t writing = device ? O_CREAT | O_TRUNC : O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;
  if (::prctl(PR_GET_SECCOMP, 0, 0, 0, 0) < 0 && errno == EINVAL) return false;
  const std::unique_ptr<void, void (*)(void*)> filter(
      ::seccomp_init(calls == Calls::reading ? SCMP_ACT_ERRNO(EPERM) : SCMP_ACT_TRAP), ::seccomp_release);
  if (filter == nullptr) failConfining();
  if (::seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_TSYNC, 1) != 0) failConfining();
  const auto rule = [&](int call, uint32_t action, auto... conditions) {
    if (call >= 0 &&
        ::seccomp_rule_add(filter.get(), action, call, unsigned(sizeof...(conditions)), conditions...) != 0)
      failConfining();
  };
  // The library's macros for this are C, which clang refuses in C++.
  const auto masked = [](unsigned argument, scmp_datum_t mask, scmp_datum_t value) {
    return scmp_arg_cmp{argument, SCMP_CMP_MASKED_EQ, mask, value};
  };
  for (const int call : kComputing) rule(call, SCMP_ACT_ALLOW);
  if (device) rule(SCMP_SYS(ioctl), SCMP_ACT_ALLOW);
  if (calls != Calls::computing) {
    for (const int call : kReading) rule(call, SCMP_ACT_ALLOW);
    rule(SCMP_SYS(openat), SCMP_ACT_ALLOW, masked(2, writing, 0));
    rule(SCMP_SYS(open), SCMP_ACT_ALLOW, masked(1, writing, 0));
  }
  if (calls == Calls::loading)
    for (const int call : kConfining) rule(call, SCMP_ACT_ALLOW);
  // Whoever hears of refused calls goes on hearing of them.
  rule(SCMP_SYS(rt_sigaction), SCMP_ACT_ALLOW, scmp_arg_cmp{0, SCMP_CMP_NE, SIGSYS, 0});
  if (calls != Calls::reading)
    rule(SCMP_SYS(rt_sigaction), SCMP_ACT_ERRNO(EPERM), scmp_arg_cmp{0, SCMP_CMP_EQ, SIGSYS, 0});
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

std::string callName(int number) {
  const std::unique_ptr<char, void (*)(void*)> name(::seccomp_syscall_resolve_num_arch(SCMP_ARCH_NATIVE, number),
                                                    ::free);
  return name ? name.get() : std::to_string(number);
}

void limitResources(const ProcessLimits& limits) {
  if (limits.endsWithParentThread) ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (limits.cpuSeconds > 0) limit(RLIMIT_CPU, limits.cpuSeconds);
  limit(RLIMIT_NOFILE, 64);
  if (!kConfinesNothing) {
    limit(RLIMIT_AS, limits.memoryBytes);
    limit(RLIMIT_FSIZE, 0);
  }
  limit(RLIMIT_CORE, 0);
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
    throw Error("the process could not give up its privileges", Error::Kind::work);
}

}  // namespace argil::io
