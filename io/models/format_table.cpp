#include "io/models/format_table.h"

#include <array>

#include "io/models/three_mf_read.h"
#include "io/models/three_mf_write.h"

namespace argil::io {
namespace {

constexpr std::array kFormats = {
    Format{.name = "STL",
           .extension = ".stl",
           .recognizes = recognizesStl,
           .parseModel = parseStl,
           .encoder = makeStlEncoder,
           .singlePrecision = true},
    Format{.name = "OBJ",
           .extension = ".obj",
           .recognizes = recognizesObj,
           .parseModel = parseObj,
           .encoder = makeObjEncoder,
           .objects = true,
           .colours = true},
    Format{.name = "PLY",
           .extension = ".ply",
           .recognizes = recognizesPly,
           .parseMesh = parsePly,
           .encoder = makePlyEncoder,
           .singlePrecision = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "OFF", .extension = ".off", .recognizes = recognizesOff, .parseMesh = parseOff},
    Format{.name = "3MF",
           .extension = ".3mf",
           .recognizes = recognizesThreeMf,
           .parseModel = parseThreeMf,
           .write = writeThreeMf,
           .singlePrecision = true,
           .objects = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "glTF (binary)",
           .extension = ".glb",
           .recognizes = recognizesGlb,
           .readInProcess = readGltf,
           .write = writeGlb,
           .objects = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "glTF",
           .extension = ".gltf",
           .recognizes = recognizesGltf,
           .readInProcess = readGltf,
           .write = writeGltf,
           .objects = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "Draco",
           .extension = ".drc",
           .recognizes = recognizesDraco,
           .readInProcess = readDraco,
           .write = writeDraco,
           .colours = true,
           .triangleColours = true},
};

}  // namespace

std::span<const Format> formats() {
  return kFormats;
}

}  // namespace argil::io
