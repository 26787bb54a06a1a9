#pragma once
// How much may come out of an archive: what it unpacks to is bounded by what it is, and by the memory there is. For
// this module's files.

#include <cstdint>
#include <string>

namespace argil::io {

/// Of one part, or of one packed file.
inline constexpr uint64_t kMostUnpacked = uint64_t{4} << 30;
/// So much may come out of anything.
inline constexpr uint64_t kFreeUnpacked = uint64_t{16} << 20;
/// Beyond that, bytes from one packed byte. Deflate can make 1032 of one. Meshes pack 5:1 to 10:1; the most that was
/// seen of something that is no attack is a flat grid as text STL with all its digits, 36:1.
inline constexpr uint64_t kMostUnpackRatio = 50;

[[nodiscard]] inline bool isTooDense(uint64_t unpacked, uint64_t packed) {
  return unpacked > kFreeUnpacked && unpacked / kMostUnpackRatio > packed;
}

/// Bytes that this process may still take: what the system has available, and what its limit of address space leaves.
/// The most there is where the system does not say.
[[nodiscard]] uint64_t availableMemory();

/// Half of it may be filled by what is unpacked, as a mesh is made of it beside. Throws Error that names the file when
/// `bytes` do not fit.
void requireMemory(const std::string& name, uint64_t bytes);

}  // namespace argil::io
