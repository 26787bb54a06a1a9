#include "io/reader/sandbox.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include <cerrno>
#include <cstddef>
#include <vector>

#include "clay/error.h"

namespace argil::io::reader {

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

void limit(__rlimit_resource what, uint64_t value) {
  rlimit limits{};
  if (::getrlimit(what, &limits) != 0) return;
  limits.rlim_cur = limits.rlim_max = std::min<rlim_t>(limits.rlim_max, value);
  if (::setrlimit(what, &limits) != 0)
    throw Error("the reader's limits could not be set; look at ulimit -a", Error::Kind::work);
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

void confine() {
#if defined(__x86_64__)
  if (kSanitized) return;
  // What libraries call to compute, to start threads (TBB) and to read.
  constexpr unsigned kAllowed[] = {SYS_read,
                                   SYS_write,
                                   SYS_readv,
                                   SYS_writev,
                                   SYS_pread64,
                                   SYS_close,
                                   SYS_fstat,
                                   SYS_stat,
                                   SYS_lstat,
                                   SYS_newfstatat,
                                   SYS_statx,
                                   SYS_lseek,
                                   SYS_access,
                                   SYS_faccessat,
                                   SYS_readlink,
                                   SYS_readlinkat,
                                   SYS_getdents64,
                                   SYS_getcwd,
                                   SYS_fcntl,
                                   SYS_poll,
                                   SYS_ppoll,
                                   SYS_mmap,
                                   SYS_mprotect,
                                   SYS_munmap,
                                   SYS_mremap,
                                   SYS_madvise,
                                   SYS_brk,
                                   SYS_futex,
                                   SYS_set_robust_list,
                                   SYS_rseq,
                                   SYS_set_tid_address,
                                   SYS_arch_prctl,
                                   SYS_membarrier,
                                   SYS_sched_yield,
                                   SYS_sched_getaffinity,
                                   SYS_getcpu,
                                   SYS_get_mempolicy,
                                   SYS_getpid,
                                   SYS_gettid,
                                   SYS_tgkill,
                                   SYS_rt_sigaction,
                                   SYS_rt_sigprocmask,
                                   SYS_rt_sigreturn,
                                   SYS_sigaltstack,
                                   SYS_restart_syscall,
                                   SYS_exit,
                                   SYS_exit_group,
                                   SYS_clock_gettime,
                                   SYS_clock_nanosleep,
                                   SYS_nanosleep,
                                   SYS_gettimeofday,
                                   SYS_times,
                                   SYS_getrusage,
                                   SYS_getrandom,
                                   SYS_uname,
                                   SYS_sysinfo,
                                   SYS_getuid,
                                   SYS_geteuid,
                                   SYS_getgid,
                                   SYS_getegid};
  constexpr unsigned kWriting = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;
  constexpr unsigned kRefuse = SECCOMP_RET_ERRNO | EPERM;
  const auto argument = [](int i) { return unsigned(offsetof(seccomp_data, args) + 8 * size_t(i)); };  // its lower half

  std::vector<sock_filter> code;
  const auto load = [&](unsigned offset) { code.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offset)); };
  const auto answer = [&](unsigned what) { code.push_back(BPF_STMT(BPF_RET | BPF_K, what)); };
  const auto skipUnless = [&](unsigned value, uint8_t count) {
    code.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, count));
  };
  const auto skipUnlessAny = [&](unsigned bits, uint8_t count) {
    code.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, 0, count));
  };
  load(offsetof(seccomp_data, arch));
  code.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0));
  answer(SECCOMP_RET_KILL_PROCESS);
  load(offsetof(seccomp_data, nr));
  for (const unsigned call : kAllowed) {
    skipUnless(call, 1);
    answer(SECCOMP_RET_ALLOW);
  }
  const auto openFlags = [&](unsigned call, int flags) {
    skipUnless(call, 4);
    load(argument(flags));
    skipUnlessAny(kWriting, 1);
    answer(kRefuse);
    answer(SECCOMP_RET_ALLOW);
  };
  openFlags(SYS_openat, 2);
  openFlags(SYS_open, 1);
  // Threads, not processes. The C library falls back to clone when the kernel knows no clone3, whose flags lie in
  // memory.
  skipUnless(SYS_clone3, 1);
  answer(SECCOMP_RET_ERRNO | ENOSYS);
  skipUnless(SYS_clone, 3);
  load(argument(0));
  skipUnlessAny(CLONE_THREAD, 1);
  answer(SECCOMP_RET_ALLOW);
  answer(kRefuse);

  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0 && errno != EINVAL && errno != ENOSYS) {
    throw Error("the reader could not confine itself", Error::Kind::work);  // EINVAL, ENOSYS: a kernel without filters
  }
#endif
}

}  // namespace argil::io::reader
