#include "io/models/foreign_files.h"

#include <array>
#include <string_view>

namespace argil::io {

namespace {

struct Sign {
  size_t at;
  std::string_view bytes;
  const char* is;
};

using namespace std::string_view_literals;

constexpr const char* kVolume = "make a surface of it first, in 3D Slicer for example, and export that as STL";
constexpr const char* kScene = "export it as glTF (.glb) or OBJ in the program that made it";
constexpr const char* kPicture = "a picture is no model";

struct Foreign {
  Sign sign;
  const char* instead;
};

constexpr std::array kForeign = {
    Foreign{{344, "n+1\0"sv, "a NIfTI volume"}, kVolume},
    Foreign{{344, "ni1\0"sv, "a NIfTI volume"}, kVolume},
    Foreign{{0, "NRRD"sv, "a NRRD volume"}, kVolume},
    Foreign{{128, "DICM"sv, "a DICOM picture"}, kVolume},
    Foreign{{0, "ObjectType = Image"sv, "a MetaImage volume"}, kVolume},
    Foreign{{0, "NDims ="sv, "a MetaImage volume"}, kVolume},
    Foreign{{0, "Kaydara FBX Binary"sv, "an FBX scene"}, kScene},
    Foreign{{0, "; FBX"sv, "an FBX scene"}, kScene},
    Foreign{{0, "BLENDER"sv, "a Blender document"}, kScene},
    Foreign{{0, "PXR-USDC"sv, "a USD scene"}, kScene},
    Foreign{{0, "#usda"sv, "a USD scene"}, kScene},
    Foreign{{0, "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<COLLADA"sv, "a COLLADA scene"}, kScene},
    Foreign{{0, "\x89PNG"sv, "a PNG picture"}, kPicture},
    Foreign{{0, "\xff\xd8\xff"sv, "a JPEG picture"}, kPicture},
    Foreign{{0, "%PDF"sv, "a PDF document"}, "export the model itself"},
    Foreign{{0, "\xff\xfe"sv, "text in UTF-16"}, "save it as UTF-8"},
    Foreign{{0, "\xfe\xff"sv, "text in UTF-16"}, "save it as UTF-8"},
    Foreign{{0, "7z\xbc\xaf\x27\x1c"sv, "a 7z archive"}, "unpack it first"},
    Foreign{{0, "Rar!"sv, "a RAR archive"}, "unpack it first"},
};

}  // namespace

std::string whatForeignFileIs(const Input& input) {
  for (const auto& [sign, instead] : kForeign) {
    if (input.text().size() >= sign.at + sign.bytes.size() &&
        input.text().substr(sign.at, sign.bytes.size()) == sign.bytes) {
      return std::string("is ") + sign.is + ": " + instead;
    }
  }
  return {};
}

}  // namespace argil::io
