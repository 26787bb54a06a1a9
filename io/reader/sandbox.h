#pragma once
// What argil-reader may not do once it looks at a file.

#include <cstdint>
#include <filesystem>
#include <string>

namespace argil::io::reader {

/// Address space, CPU time, no files to write, no core, no new privileges; ends with the thread that started us. Under
/// AddressSanitizer, which reserves terabytes, the address space stays free and confine() does nothing, as its leak
/// check traces itself.
void limitResources(uint64_t memoryBytes, uint64_t seconds);

/// What may be read from here on.
enum class Readable : uint8_t {
  file,    ///< This one alone.
  folder,  ///< What lies in its folder and below: glTF keeps its buffers there.
};

/// From here on no other file is opened (Landlock), and system calls are those that computing and reading need
/// (seccomp): nothing is opened to write, nothing is sent to anybody, no process is started, none but our own gets a
/// signal. Others fail with EPERM. Returns a sentence for the person where the system can do only one of the two, or
/// neither; else nothing. Throws Error when it can and does not.
[[nodiscard]] std::string confine(const std::filesystem::path& file, Readable readable);

}  // namespace argil::io::reader
