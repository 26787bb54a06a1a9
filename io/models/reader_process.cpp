#include "io/models/reader_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include "io/bytes/child_process.h"
#include "io/bytes/input.h"
#include "io/sandbox/descriptor.h"

namespace argil::io {

namespace {

constexpr int kLookMs = 50;  // between two looks at the job
constexpr size_t kPipeBytes = size_t{1} << 20;
constexpr const char* kGarbage =
    "could not be read, as the reader sent what it should not; export it again, or install argil again";

/// The process and the end of its pipe that is ours: gone with this.
class Process {
 public:
  /// `input`: what it gets as its standard input; -1: nothing.
  Process(const std::filesystem::path& program, const std::vector<std::string>& arguments, int input) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
      throw Error(std::string("no pipe to the reader could be made (") + std::strerror(errno) + ")", Error::Kind::work);
    const Descriptor theirs(ends[1]);
    pipe_.emplace(ends[0]);
    ::fcntl(pipe(), F_SETPIPE_SZ, int(kPipeBytes));
    ::fcntl(pipe(), F_SETFL, O_NONBLOCK);
    const std::array<ChildProcess::File, 2> files{{{input, STDIN_FILENO}, {theirs.get(), STDOUT_FILENO}}};
    process_.emplace(program, arguments, files);
  }
  [[nodiscard]] int pipe() const { return pipe_->get(); }
  /// How it ended, as waitpid says it. Waits.
  int wait() { return process_->wait(); }

 private:
  std::optional<Descriptor> pipe_;
  std::optional<ChildProcess> process_;
};

[[noreturn]] void failMemory(const std::string& name, const ReaderLimits& limits) {
  fail(name, "needs more than the " + std::to_string(limits.memoryBytes >> 20) +
                 " MiB of memory that reading it may take; reduce it first, or it is damaged");
}

[[noreturn]] void failTime(const std::string& name, const ReaderLimits& limits) {
  fail(name, "takes more than the " + std::to_string(std::lround(limits.seconds)) +
                 " s that reading it may take; reduce it first, or it is damaged");
}

[[noreturn]] void failEnd(const std::string& name, int status, const ReaderLimits& limits) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU) failTime(name, limits);
    // The CPU limit's hard end, or the system's when memory is short: which one cannot be told.
    if (signal == SIGKILL)
      fail(name, "made the reader take too much time or memory; reduce it first, or it is damaged");
    fail(name, "made the reader crash (" + std::string(::strsignal(signal)) +
                   "), so it is damaged or unusual; export it again");
  }
  constexpr int kNotStarted = 127;  // what the system's loader ends with when a library is missing
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotStarted)
    fail(name, "could not be read, as a library that its reader needs is missing; install argil again");
  fail(name, "could not be read, as the reader ended too early; export it again");
}

/// What came and is not whole yet.
class Messages {
 public:
  explicit Messages(const std::string& name) : name_(name) {}
  void add(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  /// Hands out all that are whole; true when the last one was there.
  bool hand(const std::function<void(wire::Kind, std::span<const std::byte>)>& take, const ReaderLimits& limits) {
    size_t at = 0;
    const auto left = [&] { return std::span<const std::byte>(bytes_).subspan(at); };
    if (!begun_) {
      if (bytes_.size() < sizeof wire::kMagic) return false;
      if (std::memcmp(bytes_.data(), wire::kMagic, sizeof wire::kMagic) != 0) fail(name_, kGarbage);
      begun_ = true;
      at = sizeof wire::kMagic;
    }
    while (left().size() >= sizeof(wire::Head)) {
      wire::Head head;
      std::memcpy(&head, left().data(), sizeof head);
      if (head.bytes > wire::kMostBytes) fail(name_, kGarbage);
      if (left().size() < sizeof head + head.bytes) break;
      const auto payload = left().subspan(sizeof head, head.bytes);
      at += sizeof head + head.bytes;
      if (!counted(head.kind)) fail(name_, kGarbage);
      if (head.kind == wire::Kind::error) fail(name_, wireText(payload));
      if (head.kind == wire::Kind::memory) failMemory(name_, limits);
      try {
        take(head.kind, payload);
      } catch (const Cancelled&) {
        throw;
      } catch (const Error& error) {
        fail(name_, error.what());
      }
      if (head.kind == wire::Kind::end) return true;
    }
    bytes_.erase(bytes_.begin(), bytes_.begin() + std::ptrdiff_t(at));
    return false;
  }

 private:
  /// False when there are too many: a note without a word costs the reader eight bytes, and us a string.
  bool counted(wire::Kind kind) {
    switch (kind) {
      case wire::Kind::note:
      case wire::Kind::metadata:
        return ++texts_ <= wire::kMostTexts;
      case wire::Kind::object:
        return ++objects_ <= wire::kMostObjects;
      case wire::Kind::surface:
        return ++surfaces_ <= wire::kMostSurfaces;
      case wire::Kind::picture:
        return ++pictures_ <= wire::kMostSurfaces;
      case wire::Kind::grid:
        return ++grids_ <= wire::kMostGrids;
      default:
        return true;
    }
  }

  const std::string& name_;
  std::vector<std::byte> bytes_;
  bool begun_ = false;
  uint32_t texts_ = 0, objects_ = 0, grids_ = 0, surfaces_ = 0, pictures_ = 0;
};

/// A file without a name that holds the bytes.
class SharedBytes {
 public:
  SharedBytes(std::span<const std::byte> bytes, const std::string& name) : fd_(::memfd_create("argil", MFD_CLOEXEC)) {
    bool written = fd_ >= 0;
    for (size_t done = 0; written && done < bytes.size();) {
      const ssize_t put = ::write(fd_, bytes.data() + done, bytes.size() - done);
      if (put < 0 && errno == EINTR) continue;
      written = put > 0;
      done += written ? size_t(put) : 0;
    }
    if (written) return;
    const std::string why = std::strerror(errno);
    if (fd_ >= 0) ::close(fd_);
    throw Error(name + ": cannot be given to the reader (" + why + "); free some memory", Error::Kind::work);
  }
  ~SharedBytes() { ::close(fd_); }
  SharedBytes(const SharedBytes&) = delete;
  SharedBytes& operator=(const SharedBytes&) = delete;
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

thread_local std::optional<std::span<const std::byte>> spokenBytes;  // of a SpokenReader

using Take = std::function<void(wire::Kind, std::span<const std::byte>)>;

void takeSpoken(const std::string& name, const Take& take, const ReaderLimits& limits) {
  constexpr size_t kPiece = 61;  // so that heads and payloads are divided everywhere
  Messages messages(name);
  messages.add(std::as_bytes(std::span(wire::kMagic)));
  for (auto rest = *spokenBytes; !rest.empty(); rest = rest.subspan(std::min(kPiece, rest.size()))) {
    messages.add(rest.first(std::min(kPiece, rest.size())));
    if (messages.hand(take, limits)) return;
  }
  fail(name, kGarbage);
}

/// `file`: as the reader is to open it.
void run(const std::string& what, const std::string& file, int input, const std::string& name, const Take& take,
         Job* job, const ReaderLimits& limits) {
  if (spokenBytes) return takeSpoken(name, take, limits);
  const std::filesystem::path program = readerProgram(what);
  Process process(program,
                  {what, file, std::to_string(limits.memoryBytes),
                   std::to_string(std::lround(std::ceil(limits.seconds))), std::to_string(limits.edge)},
                  input);
  const auto begin = std::chrono::steady_clock::now();
  const std::chrono::duration<double> most(2 * limits.seconds);
  Messages messages(name);
  std::vector<std::byte> piece(kPipeBytes);
  uint64_t received = 0;
  while (true) {
    if (job != nullptr) job->step(std::min(0.9, 0.1 + double(received) / (double(received) + 1e8)));
    if (std::chrono::steady_clock::now() - begin > most) failTime(name, limits);
    pollfd waiting{process.pipe(), POLLIN, 0};
    if (::poll(&waiting, 1, kLookMs) <= 0) continue;
    const ssize_t got = ::read(process.pipe(), piece.data(), piece.size());
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got <= 0) failEnd(name, process.wait(), limits);
    received += uint64_t(got);
    if (received > limits.memoryBytes) failMemory(name, limits);
    messages.add({piece.data(), size_t(got)});
    if (messages.hand(take, limits)) return;
  }
}

}  // namespace

SpokenReader::SpokenReader(std::span<const std::byte> spoken) {
  spokenBytes = spoken;
}
SpokenReader::~SpokenReader() {
  spokenBytes.reset();
}

void failWire() {
  throw Error(kGarbage);
}

std::string wireText(std::span<const std::byte> payload) {
  std::string text(reinterpret_cast<const char*>(payload.data()), std::min<size_t>(payload.size(), wire::kMostText));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return text;
}

std::filesystem::path readerProgram(std::string_view what) {
  if (what != "cad") return programBeside("argil-reader", "ARGIL_READER", "it reads glTF, Draco, OpenVDB and pictures");
  return programBeside("argil-reader-cad", "ARGIL_READER", "it reads STEP and IGES, and is made where OpenCASCADE is");
}

bool readsCad() {
  try {
    return !readerProgram("cad").empty();
  } catch (const Error&) {
    return false;
  }
}

void runReader(const std::string& what, const std::filesystem::path& file, const Take& take, Job* job,
               const ReaderLimits& limits) {
  // Absolute: a name may begin with a dash, and whoever changes the folder meanwhile changes nothing.
  run(what, std::filesystem::absolute(file).string(), -1, displayName(file), take, job, limits);
}

void runReaderOn(const std::string& what, std::span<const std::byte> bytes, const std::string& name, const Take& take,
                 Job* job, const ReaderLimits& limits) {
  const SharedBytes shared(bytes, name);
  run(what, "-", shared.fd(), name, take, job, limits);
}

}  // namespace argil::io
