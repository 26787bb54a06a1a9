#include "ui3d/studio/files/file_kinds.h"

#include <algorithm>
#include <array>

#include "io/bytes/input.h"
#include "io/models/added_formats.h"

namespace argil::studio {
namespace {

constexpr std::array kKinds{
    FileKind{".argil", "Argil", "mm", true, false, "", false},
    FileKind{".json", "Script", "mm", true, false, "", false},
    // Writers in the order in which they are offered.
    FileKind{".3mf", "3MF", "as the file says", true, true, "For printing: unit, colours and names are in the file.",
             true},
    FileKind{".stl", "STL", "", true, true,
             "For printing, where 3MF is not understood. It names no unit: read it as mm.", true},
    FileKind{".obj", "OBJ", "", true, true, "For other modellers. It names no unit: read it as mm.", true},
    FileKind{".ply", "PLY", "", true, true, "For scanners' and researchers' programs. It names no unit: read it as mm.",
             true},
    FileKind{".glb", "glTF binary", "metres", true, true,
             "For the web and for game engines, in one file. Lengths become metres, as the format wants.", true},
    FileKind{".gltf", "glTF", "metres", true, true, "For the web, as text. Lengths become metres, as the format wants.",
             true},
    FileKind{".drc", "Draco", "", true, true,
             "The smallest file: rounded within a stated error. It names no unit: read it as mm.", true},
    FileKind{".step", "STEP", "mm", true, true,
             "For CAD: few smooth faces, fitted to the clay; it is said how far they lie off.", false},
    FileKind{".iges", "IGES", "mm", true, true, "For CAD programs that read no STEP: the same few smooth faces.",
             false},
    FileKind{".vdb", "OpenVDB", "", true, true,
             "The clay itself, as a level set, for effects and simulation. It names no unit: read it as mm.", false},
    // One model in it, of a kind that names no unit as a rule.
    FileKind{".gz", "Packed model", "", true, true, "", false},
    FileKind{".zip", "Packed model", "", true, true, "", false},
    FileKind{".off", "OFF", "", true, true, "", false},
    FileKind{".stp", "STEP", "mm", true, true, "", false},
    FileKind{".igs", "IGES", "mm", true, true, "", false},
};

std::vector<std::string> endings(bool FileKind::*which) {
  std::vector<std::string> result;
  for (const FileKind& kind : fileKinds())
    if (kind.*which) result.emplace_back(kind.ending);
  return result;
}

}  // namespace

std::span<const FileKind> fileKinds() {
  static std::vector<FileKind> all(kKinds.begin(), kKinds.end());
  const std::vector<io::AddedFormatFacts> added = io::addedFormats();
  // A history in many files is written by the command.
  for (size_t i = all.size() - kKinds.size(); i < added.size(); ++i)
    all.push_back({added[i].extension, added[i].name, "", added[i].reads, added[i].reads,
                   added[i].writes && !added[i].frames ? "By a plugin; lengths in mm." : "", true});
  return all;
}

const FileKind* kindOf(const std::filesystem::path& file) {
  const std::string ending = io::endingOf(file);
  const std::span<const FileKind> kinds = fileKinds();
  const auto row =
      std::find_if(kinds.begin(), kinds.end(), [&](const FileKind& kind) { return kind.ending == ending; });
  return row == kinds.end() ? nullptr : &*row;
}

bool asksForUnits(const std::filesystem::path& file) {
  const FileKind* kind = kindOf(file);
  return kind && kind->units.empty();
}

std::vector<std::string> endingsToOpen() {
  return endings(&FileKind::opens);
}
std::vector<std::string> endingsToImport() {
  return endings(&FileKind::imports);
}
std::vector<std::string> endingsOfImages() {
  return {".png", ".jpg", ".jpeg", ".bmp", ".tga", ".pgm"};
}

}  // namespace argil::studio
