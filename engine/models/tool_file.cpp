#include "engine/models/tool_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "clay/brush/stamp_shape.h"
#include "clay/import/height_image.h"
#include "engine/models/load_document.h"
#include "engine/tools/tool_table.h"
#include "io/models/picture.h"

namespace argil::engine {
namespace {

constexpr int kMostImage = 8192;  // pixels along an edge

}  // namespace

void loadToolFile(Tool& tool) {
  const ToolRow& row = rowOf(tool);
  if (row.file == ToolFile::none || (row.file == ToolFile::image ? bool(tool.content.image) : bool(tool.content.shape)))
    return;
  if (tool.file.empty())
    throw Error(fmt::format("the tool {} needs a file: choose {}", row.name,
                            row.file == ToolFile::image ? "an image" : "a shape"));
  if (row.file == ToolFile::image) {
    const io::GreyImage image = io::readGreyImage(tool.file, kMostImage);
    std::vector<uint16_t> grey(image.grey.size());
    std::transform(image.grey.begin(), image.grey.end(), grey.begin(),
                   [](float g) { return uint16_t(std::lround(std::clamp(g, 0.0f, 1.0f) * 65535)); });
    tool.content.image = std::make_shared<const clay::HeightImage>(image.width, image.height, grey);
    return;
  }
  // Clay as it is, a mesh as what it bounds.
  ModelImport asItIs;
  asItIs.asPart = true;
  const LoadedDocument loaded = loadDocument(tool.file, asItIs);
  const Document& document = *loaded.document;
  if (!document.pieces.empty())
    tool.content.shape = clay::StampShape::of(document.pieces.front().version);
  else if (!document.parts.empty())
    tool.content.shape = clay::StampShape::of(*document.parts.front().mesh);
  else
    throw Error(fmt::format("{}: holds nothing that could be a tip", tool.file));
}

}  // namespace argil::engine
