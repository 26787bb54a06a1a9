#pragma once
// The reader's parsing in this process: what it would send, or its sentence.

#include <string>
#include <vector>

#include "io/reader/sender.h"
#include "tests/fuzz/require.h"

namespace argil::tests {

/// What `read(sender)` sends behind the magic, its end included; empty when it throws an Error, which must be a
/// sentence without the file's name.
template <class Read>
std::vector<std::byte> spokenBy(const Read& read) {
  std::vector<std::byte> spoken;
  io::reader::Sender sender(
      [&](std::span<const std::byte> bytes) { spoken.insert(spoken.end(), bytes.begin(), bytes.end()); });
  try {
    read(sender);
  } catch (const Error& error) {
    requireSentence(error);
    return {};
  }
  sender.plain(io::wire::Kind::end);
  sender.flush();
  spoken.erase(spoken.begin(), spoken.begin() + sizeof io::wire::kMagic);
  return spoken;
}

}  // namespace argil::tests
