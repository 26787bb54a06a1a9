#pragma once
// What argil-reader may not do once it looks at a file.

#include <cstdint>

namespace argil::io::reader {

/// Address space, CPU time, no files to write, no core, no new privileges; ends with the thread that started us. Under
/// AddressSanitizer, which reserves terabytes, the address space stays free and the filter of confine() is left out, as
/// its leak check traces itself.
void limitResources(uint64_t memoryBytes, uint64_t seconds);

/// From here on system calls are those that computing and reading files need: nothing is opened to write, nothing is
/// sent to anybody, no process is started. Others fail with EPERM. x86-64 only; elsewhere the limits stand alone.
void confine();

}  // namespace argil::io::reader
