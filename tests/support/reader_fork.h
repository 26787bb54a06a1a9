#pragma once
// What reader_fork asks of reader_forks: words and three streams over a socket; a wait status comes back.

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

namespace argil::tests {

/// Of the reader_forks that a test of this process started.
inline std::string forkName(pid_t of) {
  return "argil-reader-forks-" + std::to_string(of);
}

/// Listening at an abstract name, or connected to it; −1 where that fails.
inline int forkSocket(const char* name, bool listens) {
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  const size_t length = std::min(std::strlen(name), sizeof at.sun_path - 2);
  std::memcpy(at.sun_path + 1, name, length);
  const auto size = socklen_t(offsetof(sockaddr_un, sun_path) + 1 + length);
  const auto* address = reinterpret_cast<const sockaddr*>(&at);
  const int failed = listens ? ::bind(fd, address, size) | ::listen(fd, 64) : ::connect(fd, address, size);
  if (failed == 0) return fd;
  ::close(fd);
  return -1;
}

inline bool sendCall(int socket, int argc, char** argv) {
  std::string words;
  for (int i = 0; i < argc; ++i) words.append(argv[i]).push_back('\0');
  iovec part{words.data(), words.size()};
  alignas(cmsghdr) char room[CMSG_SPACE(3 * sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part, message.msg_iovlen = 1;
  message.msg_control = room, message.msg_controllen = sizeof room;
  cmsghdr* header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET, header->cmsg_type = SCM_RIGHTS, header->cmsg_len = CMSG_LEN(3 * sizeof(int));
  const int streams[3] = {0, 1, 2};
  std::memcpy(CMSG_DATA(header), streams, sizeof streams);
  return ::sendmsg(socket, &message, 0) == ssize_t(words.size());
}

inline bool receiveCall(int socket, std::vector<std::string>& words, int (&streams)[3]) {
  std::string text(1 << 14, '\0');
  iovec part{text.data(), text.size()};
  alignas(cmsghdr) char room[CMSG_SPACE(3 * sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part, message.msg_iovlen = 1;
  message.msg_control = room, message.msg_controllen = sizeof room;
  const ssize_t got = ::recvmsg(socket, &message, 0);
  const cmsghdr* header = got > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (!header || header->cmsg_type != SCM_RIGHTS || header->cmsg_len != CMSG_LEN(sizeof streams)) return false;
  std::memcpy(streams, CMSG_DATA(header), sizeof streams);
  for (size_t at = 0; at < size_t(got); at += words.back().size() + 1) words.emplace_back(text.c_str() + at);
  return true;
}

}  // namespace argil::tests
