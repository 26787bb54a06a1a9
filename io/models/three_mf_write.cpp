// 3MF core specification 1.3, materials and properties 1.2: https://github.com/3MFConsortium
#include "io/models/three_mf_write.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <optional>

#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "io/bytes/input.h"
#include "io/bytes/xml_scan.h"
#include "io/bytes/zip_writer.h"
#include "io/models/three_mf_part.h"

namespace argil::io {

namespace {

/// Vertices or triangles in a block: a megabyte of text or less.
constexpr size_t kBlock = 16384;
constexpr size_t kTokensPerThread = 3;
constexpr std::string_view kModelPath = "3D/3dmodel.model";

constexpr std::string_view kContentTypes =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Types "
    "xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n"
    "<Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n"
    "<Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n</Types>\n";

/// Names that the specification gives to metadata; others need a namespace. Application is ours.
constexpr std::string_view kKnownMetadata[] = {"Title",        "Designer", "Description",  "Copyright",
                                               "LicenseTerms", "Rating",   "CreationDate", "ModificationDate"};

// The longest text of one element, for the memory of a block: a 32-bit float has 15 characters at most, an index 10.
constexpr size_t kVertexBytes = 11 + 3 * 15 + 2 * 5 + 4;
constexpr size_t kTriangleBytes = 14 + 7 * 10 + 6 * 7 + 4;
constexpr size_t kColourBytes = 40;

void put(char*& to, std::string_view text) {
  std::memcpy(to, text.data(), text.size());
  to += text.size();
}

template <class Number>
void putNumber(char*& to, Number number) {
  to = std::to_chars(to, to + 16, number).ptr;
}

uint32_t packed(const Colour& c) {
  return uint32_t(c.red) << 24 | uint32_t(c.green) << 16 | uint32_t(c.blue) << 8 | c.alpha;
}

std::string hexadecimal(uint32_t colour) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text = "#";
  for (int shift = 28; shift >= 0; shift -= 4) text += kDigits[colour >> shift & 15];
  return text;
}

/// Each once, in order. Memory: twice 4 bytes for each that is distinct, whatever `colours` has.
std::vector<uint32_t> distinct(std::span<const Colour> colours) {
  std::vector<uint32_t> result;
  size_t sorted = 0;
  const auto merge = [&] {
    std::sort(result.begin() + static_cast<std::ptrdiff_t>(sorted), result.end());
    std::inplace_merge(result.begin(), result.begin() + static_cast<std::ptrdiff_t>(sorted), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    sorted = result.size();
  };
  for (const Colour& colour : colours) {
    if (!result.empty() && result.back() == packed(colour)) continue;
    result.push_back(packed(colour));
    if (result.size() >= 2 * sorted + 65536) merge();
  }
  merge();
  return result;
}

/// How one object is written.
struct Plan {
  const ModelObject* object = nullptr;
  uint32_t id = 0;
  std::string property;           ///< Attributes that name its colour; empty when it has none.
  uint32_t group = 0;             ///< Of its triangles' colours; 0: none.
  std::vector<uint32_t> colours;  ///< Of that group, in order.
  std::vector<Vec3d> positions;   ///< Instead of the object's, with
  std::vector<uint32_t> place;    ///< those of its vertices; empty: as they are.
  [[nodiscard]] const std::vector<Vec3d>& vertices() const {
    return place.empty() ? object->mesh.positions : positions;
  }
  /// Numbers of the vertices as they are written.
  [[nodiscard]] std::array<uint32_t, 3> corners(size_t triangle) const {
    const auto& [a, b, c] = object->mesh.triangles[triangle];
    return place.empty() ? std::array{a, b, c} : std::array{place[a], place[b], place[c]};
  }
  /// Welding can leave triangles that name a vertex twice, which the format forbids.
  [[nodiscard]] bool isWritten(size_t triangle) const {
    const auto [a, b, c] = corners(triangle);
    return place.empty() || (a != b && b != c && c != a);
  }
  [[nodiscard]] bool byTriangle() const { return !object->triangleColours.empty(); }
  [[nodiscard]] size_t index(const Colour& colour) const {
    return static_cast<size_t>(std::lower_bound(colours.begin(), colours.end(), packed(colour)) - colours.begin());
  }
};

/// Text as it stands, or a range of something of an object.
struct Block {
  enum class Kind { text, colours, vertices, triangles } kind = Kind::text;
  size_t plan = 0, begin = 0, end = 0;
  std::string text;
};

struct PackedBlock {
  std::string text;
  std::vector<std::byte> packed;
};

class ModelText {
 public:
  ModelText(const std::string& name, const ModelView& model, bool welds) {
    uint32_t id = 1;
    std::vector<uint32_t> materials;
    for (const ModelObject& object : model.objects) {
      if (object.mesh.triangles.empty()) continue;
      const bool fits =
          (object.vertexColours.empty() || object.vertexColours.size() == object.mesh.positions.size()) &&
          (object.triangleColours.empty() || object.triangleColours.size() == object.mesh.triangles.size());
      if (!fits)
        throw Error(name + ": an object has colours that do not fit its mesh; nothing was written", Error::Kind::work);
      plans_.emplace_back().object = &object;
      if (welds) weld(plans_.back());
      if (object.triangleColours.empty() && object.vertexColours.empty() && object.colour)
        materials.push_back(packed(*object.colour));
    }
    std::sort(materials.begin(), materials.end());
    materials.erase(std::unique(materials.begin(), materials.end()), materials.end());
    addHead(model);
    if (!materials.empty()) addMaterials(materials, id++);
    for (size_t i = 0; i < plans_.size(); ++i) addObject(i, materials, id);
    std::string build = "</resources>\n<build>\n";
    for (const Plan& plan : plans_) build += "<item objectid=\"" + std::to_string(plan.id) + "\"/>\n";
    addText(build + "</build>\n</model>\n");
  }

  [[nodiscard]] size_t blocks() const { return blocks_.size(); }
  /// As they are written.
  void count(WriteReport& report) const {
    for (const Plan& plan : plans_) {
      if (plan.place.empty()) continue;
      report.vertices -= plan.place.size() - plan.positions.size();
      for (size_t t = 0; t < plan.object->mesh.triangles.size(); ++t) report.triangles -= plan.isWritten(t) ? 0 : 1;
    }
  }

  /// No less than the text has.
  [[nodiscard]] uint64_t mostBytes() const {
    uint64_t sum = 0;
    for (const Block& block : blocks_) sum += block.text.size() + (block.end - block.begin) * kTriangleBytes;
    return sum;
  }

  /// Any thread.
  [[nodiscard]] std::string make(size_t index) const {
    const Block& block = blocks_[index];
    if (block.kind == Block::Kind::text) return block.text;
    const Plan& plan = plans_[block.plan];
    std::string text((block.end - block.begin) * std::max({kVertexBytes, kTriangleBytes, kColourBytes}), '\0');
    char* to = text.data();
    for (size_t i = block.begin; i < block.end; ++i) {
      if (block.kind == Block::Kind::vertices) {
        putVertex(to, plan.vertices()[i]);
      } else if (block.kind == Block::Kind::triangles) {
        if (plan.isWritten(i)) putTriangle(to, plan, i);
      } else {
        put(to, "<m:color color=\"");
        put(to, hexadecimal(plan.colours[i]));
        put(to, "\"/>\n");
      }
    }
    text.resize(static_cast<size_t>(to - text.data()));
    return text;
  }

 private:
  void addText(std::string text) { blocks_.push_back({Block::Kind::text, 0, 0, 0, std::move(text)}); }

  void addRange(Block::Kind kind, size_t plan, size_t count) {
    for (size_t begin = 0; begin < count; begin += kBlock)
      blocks_.push_back({kind, plan, begin, std::min(begin + kBlock, count), {}});
  }

  void addHead(const ModelView& model) {
    std::string head = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" xmlns=\"{}\" "
        "xmlns:m=\"{}\" xmlns:argil=\"urn:argil\">\n<metadata name=\"Application\">Argil</metadata>\n",
        three_mf::kCore, three_mf::kMaterial);
    // A name may stand once.
    std::vector<std::pair<std::string, std::string>> once;
    for (const auto& [given, value] : model.metadata) {
      if (given == "Application" || given.empty()) continue;
      const bool known =
          std::find(std::begin(kKnownMetadata), std::end(kKnownMetadata), given) != std::end(kKnownMetadata);
      std::string name = known ? given : "argil:";
      for (const char c : known ? std::string_view() : std::string_view(given)) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        const bool more = (c >= '0' && c <= '9') || c == '.' || c == '-';
        name += letter || (more && name.back() != ':') ? c : '_';
      }
      const auto same = std::find_if(once.begin(), once.end(), [&](const auto& each) { return each.first == name; });
      if (same == once.end()) {
        once.emplace_back(name, value);
      } else {
        same->second += "; " + value;
      }
    }
    for (const auto& [name, value] : once)
      head += "<metadata name=\"" + name + "\">" + xmlEscaped(value) + "</metadata>\n";
    addText(head + "<resources>\n");
  }

  void addMaterials(const std::vector<uint32_t>& materials, uint32_t id) {
    std::string text = "<basematerials id=\"" + std::to_string(id) + "\">\n";
    for (const uint32_t colour : materials)
      text += "<base name=\"" + hexadecimal(colour) + "\" displaycolor=\"" + hexadecimal(colour) + "\"/>\n";
    addText(text + "</basematerials>\n");
  }

  void addObject(size_t index, const std::vector<uint32_t>& materials, uint32_t& id) {
    Plan& plan = plans_[index];
    const ModelObject& object = *plan.object;
    if (plan.byTriangle() || !object.vertexColours.empty()) {
      plan.colours = distinct(plan.byTriangle() ? object.triangleColours : object.vertexColours);
      plan.group = id++;
      // An object whose triangles have colours must name one of its own.
      plan.property = " pid=\"" + std::to_string(plan.group) + "\" pindex=\"0\"";
      addText("<m:colorgroup id=\"" + std::to_string(plan.group) + "\">\n");
      addRange(Block::Kind::colours, index, plan.colours.size());
      addText("</m:colorgroup>\n");
    } else if (object.colour) {
      const auto material =
          std::lower_bound(materials.begin(), materials.end(), packed(*object.colour)) - materials.begin();
      plan.property = " pid=\"1\" pindex=\"" + std::to_string(material) + "\"";
    }
    plan.id = id++;
    const std::string name = object.name.empty() ? "" : " name=\"" + xmlEscaped(object.name) + "\"";
    addText("<object id=\"" + std::to_string(plan.id) + "\" type=\"model\"" + name + plan.property +
            ">\n<mesh>\n<vertices>\n");
    addRange(Block::Kind::vertices, index, plan.vertices().size());
    addText("</vertices>\n<triangles>\n");
    addRange(Block::Kind::triangles, index, object.mesh.triangles.size());
    addText("</triangles>\n</mesh>\n</object>\n");
  }

  static void weld(Plan& plan) {
    const clay::TriangleMesh& mesh = plan.object->mesh;
    if (clay::checkTopology(mesh).boundaryEdges == 0) return;
    clay::VertexWelder welder;
    plan.place.resize(mesh.positions.size());
    welder.add(mesh.positions, plan.place);
    plan.positions = welder.take();
    bool any = false;
    for (size_t t = 0; t < mesh.triangles.size() && !any; ++t) any = plan.isWritten(t);
    if (!any) plan.place.clear();  // All of it is points and lines: as it is.
  }

  static void putVertex(char*& to, const Vec3d& p) {
    put(to, "<vertex x=\"");
    putNumber(to, static_cast<float>(p.x()));
    put(to, "\" y=\"");
    putNumber(to, static_cast<float>(p.y()));
    put(to, "\" z=\"");
    putNumber(to, static_cast<float>(p.z()));
    put(to, "\"/>\n");
  }

  static void putTriangle(char*& to, const Plan& plan, size_t i) {
    const auto corners = plan.corners(i);
    put(to, "<triangle v1=\"");
    putNumber(to, corners[0]);
    put(to, "\" v2=\"");
    putNumber(to, corners[1]);
    put(to, "\" v3=\"");
    putNumber(to, corners[2]);
    if (plan.group != 0) {
      // The object names the group too, but some readers look here alone.
      put(to, "\" pid=\"");
      putNumber(to, plan.group);
    }
    if (plan.group != 0 && plan.byTriangle()) {
      put(to, "\" p1=\"");
      putNumber(to, plan.index(plan.object->triangleColours[i]));
    } else if (plan.group != 0) {
      constexpr std::string_view kNames[] = {"\" p1=\"", "\" p2=\"", "\" p3=\""};
      for (size_t c = 0; c < 3; ++c) {
        put(to, kNames[c]);
        putNumber(to, plan.index(plan.object->vertexColours[plan.object->mesh.triangles[i][c]]));
      }
    }
    put(to, "\"/>\n");
  }

  std::vector<Plan> plans_;
  std::vector<Block> blocks_;
};

std::string relations() {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n"
      "<Relationship Target=\"/{}\" Id=\"rel0\" Type=\"{}\"/>\n</Relationships>\n",
      kModelPath, three_mf::kModelRelation);
}

}  // namespace

void writeThreeMf(AtomicFile& file, const ModelView& model, const WriteOptions& options, WriteReport& report,
                  Job* job) {
  const ModelText text(displayName(file.target()), model, options.weld);
  text.count(report);
  ZipWriter zip(file);
  zip.add("[Content_Types].xml", kContentTypes);
  zip.add("_rels/.rels", relations());
  zip.begin(kModelPath, text.mostBytes());
  tbb::enumerable_thread_specific<DeflateBlock> packers;
  const auto tokens = kTokensPerThread * static_cast<size_t>(tbb::this_task_arena::max_concurrency());
  // Blocks on their way, by number: blocks leave in order, so those under way lie closer together than there are
  // tokens. The pipeline does not free what it holds when it is cancelled.
  std::vector<PackedBlock> underWay(tokens);
  size_t next = 0, written = 0;
  const auto number = [&](tbb::flow_control& control) -> size_t {
    if (next == text.blocks()) control.stop();
    return next++;
  };
  const auto pack = [&](size_t index) {
    PackedBlock& block = underWay[index % tokens];
    block.text = text.make(index);
    packers.local().pack(block.text, block.packed);
    return index;
  };
  const auto put = [&](size_t index) {
    const PackedBlock& block = underWay[index % tokens];
    zip.block(block.text, block.packed);
    ++written;
    if (job != nullptr) job->step(static_cast<double>(written) / static_cast<double>(text.blocks()));
  };
  tbb::parallel_pipeline(tokens, tbb::make_filter<void, size_t>(tbb::filter_mode::serial_in_order, number) &
                                     tbb::make_filter<size_t, size_t>(tbb::filter_mode::parallel, pack) &
                                     tbb::make_filter<size_t, void>(tbb::filter_mode::serial_in_order, put));
  zip.end();
  zip.finish();
}

}  // namespace argil::io
