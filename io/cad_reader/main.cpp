// argil-reader-cad: as argil-reader, of STEP and IGES; a program of its own, as OpenCASCADE is not everywhere and takes
// long to be loaded.
//   argil-reader-cad cad FILE [MEMORY-BYTES SECONDS]

#include <array>

#include "io/cad_reader/read_cad.h"
#include "io/reader/run.h"

int main(int argc, char** argv) {
  using namespace argil::io::reader;
  static constexpr std::array<Reads, 1> kTable{
      {{"cad", [](const auto& file, int, Sender& sender) { readCad(file, sender); }}}};
  run(argc, argv, kTable);
}
