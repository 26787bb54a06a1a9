// Wavefront OBJ: polygons of a file in the sense of its appendix B (vertices, faces, objects); the rest is passed over.
// Colours behind a position are what MeshLab and others write.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "io/bytes/empty_objects.h"
#include "io/bytes/text_cursor.h"
#include "io/models/colour_list.h"
#include "io/models/draco_mesh.h"
#include "io/models/format_table.h"
#include "io/models/mesh_file.h"
#include "io/models/mtl.h"

namespace argil::io {

namespace {

/// What may begin a line besides v and f, and whether the mesh loses something by passing over it.
constexpr std::array<std::string_view, 6> kHarmless = {"vn", "s", "mg", "maplib", "lod", "bevel"};
constexpr size_t kMostLibrary = 16u << 20;  // bytes of a material library
constexpr size_t kMostPictures = 64;        // of a file
constexpr int kLargestPicture = 8192;       // pixels along an edge
constexpr std::array<std::string_view, 2> kLines = {"l", "p"};
constexpr std::array<std::string_view, 9> kFreeForm = {"vp",   "cstype", "deg",  "curv", "curv2",
                                                       "surf", "parm",   "trim", "end"};

template <size_t N>
bool contains(const std::array<std::string_view, N>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

class ObjReader {
 public:
  explicit ObjReader(const Input& input)
      : input_(input), cursor_(input, {.hashComments = true, .backslashContinues = true}), ticker_(input) {}

  ModelFile read() {
    file_.format = "OBJ";
    while (!cursor_.atEnd()) {
      if (cursor_.wordOnLine()) statement(cursor_.word());
      cursor_.skipLine();
      ticker_.at(cursor_.offset());
    }
    if (highest_ > file_.mesh.positions.size()) {
      fail(input_.name, "line " + std::to_string(highestLine_) + ": a face names vertex " + std::to_string(highest_) +
                            " and the file has " + std::to_string(file_.mesh.positions.size()) +
                            "; repair the line or export again");
    }
    polygons_.divide(file_, input_.job);
    note(lines_, "line and point elements were left out");
    note(freeForm_, "statements of free-form curves and surfaces were left out");
    note(unknown_, "lines of an unknown kind were left out");
    if (groups_.size() > 1) note(groups_.size(), "groups were put together");
    return model();
  }

 private:
  /// Triangles from `begin` on, up to the next run, belong to an object.
  struct Run {
    size_t begin;
    uint32_t object;
  };
  /// Likewise of a material, by its place in materials_; none: white beside others. Before the first run there is none.
  struct MaterialRun {
    size_t begin;
    std::optional<size_t> material;
  };
  struct NamedMaterial {
    Material material;
    std::filesystem::path folder;          ///< Of its library.
    std::optional<uint32_t> picture = {};  ///< In pictures, once it was read.
    bool looked = false;                   ///< For its picture.
  };

  void statement(std::string_view word) {
    if (word == "v") {
      vertex();
    } else if (word == "f" || word == "fo") {
      face();
    } else if (word == "o") {
      object_ = objectNamed(cleanName(cursor_.restOfLine()));
    } else if (word == "g") {
      group_ = cursor_.restOfLine();
      newGroup_ = true;
    } else if (word == "mtllib") {
      library(cursor_.restOfLine());
    } else if (word == "usemtl") {
      const auto known = materialsByName_.find(cleanName(cursor_.restOfLine()));
      material_ = known == materialsByName_.end() ? std::nullopt : std::optional(known->second);
    } else if (word == "vt") {
      texturePlace();
    } else if (word == "usemap") {
      ++pictures_;
    } else if (contains(kLines, word)) {
      ++lines_;
    } else if (contains(kFreeForm, word)) {
      ++freeForm_;
    } else if (!contains(kHarmless, word)) {
      ++unknown_;
    }
  }

  /// One name with blanks in it, or several; below the file's folder. What is missing or no text is a note.
  void library(std::string_view names) {
    const std::string whole = trimmed(names);
    if (!libraries_.insert(whole).second) return;
    if (input_.folder.empty() || whole.empty()) {
      file_.notes.emplace_back("materials and their colours were left out");
      return;
    }
    if (read(whole)) return;
    size_t from = 0, missing = 0;
    while ((from = whole.find_first_not_of(" \t", from)) != std::string::npos) {
      const size_t to = std::min(whole.find_first_of(" \t", from), whole.size());
      missing += !read(whole.substr(from, to - from));
      from = to;
    }
    if (missing != 0)
      file_.notes.push_back("the colours of materials were left out: " + shown(whole) +
                            " is not beside the file, or cannot be read");
  }

  static std::string trimmed(std::string_view text) {
    const size_t from = text.find_first_not_of(" \t\r"), to = text.find_last_not_of(" \t\r");
    return from == std::string_view::npos ? std::string() : std::string(text.substr(from, to - from + 1));
  }

  bool read(const std::string& name) {
    const std::filesystem::path below = std::filesystem::path(name).lexically_normal();
    if (below.is_absolute() || below.empty() || *below.begin() == "..") return false;
    const std::filesystem::path path = input_.folder / below;
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none) || std::filesystem::file_size(path, none) > kMostLibrary || none)
      return false;
    try {
      const FileBytes bytes = readFile(path);
      MaterialLibrary found = parseMtl({bytes.bytes(), displayName(path)});
      for (auto& [material, what] : found.materials) {
        pictures_ += what.map.file.empty() ? 0 : 1;
        materialsByName_.insert_or_assign(material, materials_.size());
        materials_.push_back({std::move(what), path.parent_path()});
      }
      pictures_ += found.pictures;
    } catch (const Error&) {
      return false;
    }
    return true;
  }

  /// x y z, and then a weight, which is of no use to polygons, or a colour of three or four numbers.
  void vertex() {
    const double x = cursor_.number("an x coordinate");
    const double y = cursor_.number("a y coordinate");
    const double z = cursor_.number("a z coordinate");
    if (file_.mesh.positions.size() >= UINT32_MAX) cursor_.fail("there are too many vertices; reduce the mesh first");
    std::array<double, 4> colour;
    size_t count = 0;
    while (count < colour.size() && cursor_.wordOnLine() && parseNumber(cursor_.word(), colour[count])) ++count;
    if (count >= 3) colours_.add(file_.mesh.positions.size(), {colour.data(), count});
    file_.mesh.positions.emplace_back(x, y, z);
  }

  /// u and v, of which v may be missing. What cannot be read is at zero: no face is lost by it.
  void texturePlace() {
    std::array<double, 2> place{};
    for (double& number : place) {
      double value = 0;
      if (!cursor_.wordOnLine() || !parseNumber(cursor_.word(), value) || !std::isfinite(value)) break;
      number = value;
    }
    texturePlaces_.push_back({float(place[0]), float(place[1])});
  }

  uint32_t objectNamed(const std::string& name) {
    const auto [found, isNew] = objects_.try_emplace(name, uint32_t(names_.size()));
    if (isNew) names_.push_back(name);
    return found->second;
  }

  void face() {
    corners_.clear();
    placesOfCorners_.clear();
    while (cursor_.wordOnLine()) corners_.push_back(corner(cursor_.word()));
    if (corners_.size() < 3) {
      cursor_.fail("a face has " + std::to_string(corners_.size()) +
                   " corners and needs 3; repair the line or export again");
    }
    if (runs_.empty() || runs_.back().object != object_) runs_.push_back({file_.mesh.triangles.size(), object_});
    if (newGroup_) groups_.emplace(group_);
    newGroup_ = false;
    const std::optional<size_t> before = materialRuns_.empty() ? std::nullopt : materialRuns_.back().material;
    if (material_ != before) materialRuns_.push_back({file_.mesh.triangles.size(), material_});
    const bool pictured = material_ && !materials_[*material_].material.map.file.empty();
    polygons_.add(file_, corners_, pictured ? placesOfCorners_ : std::span<const uint32_t>());
  }

  /// One object each where "o" names several that have no vertex in common; else all is one, or a surface would be
  /// torn.
  ModelFile model() {
    ModelFile model;
    model.format = std::move(file_.format);
    model.faces = file_.faces;
    model.polygons = file_.polygons;
    std::vector<Colour> colours = colours_.take(file_.mesh.positions.size());
    std::vector<Colour> ofTriangles;
    // Colours of vertices go before: who paints keeps a material beside it.
    const bool coloured = std::any_of(materialRuns_.begin(), materialRuns_.end(), [this](const MaterialRun& run) {
      return run.material && materials_[*run.material].material.colour;
    });
    if (colours.empty() && coloured) ofTriangles = materialColours();
    std::vector<SurfacePicture> pictures;
    std::vector<PicturePlaces> places = picturePlaces(pictures);
    if (places.empty()) pictures.clear();
    const bool several =
        std::any_of(runs_.begin(), runs_.end(), [this](const Run& run) { return run.object != runs_[0].object; });
    if (several && apart()) {
      split(model, colours, ofTriangles, pictures, places);
    } else if (!file_.mesh.triangles.empty()) {
      if (several) file_.notes.emplace_back("the objects share vertices and were put together");
      ModelObject& all = model.objects.emplace_back();
      if (!several) all.name = names_[runs_[0].object];
      all.mesh = std::move(file_.mesh);
      all.vertexColours = std::move(colours);
      all.triangleColours = std::move(ofTriangles);
      all.pictures = std::move(pictures);
      all.places = std::move(places);
    }
    for (ModelObject& object : model.objects) {
      const std::vector<Colour>& list = object.triangleColours;
      if (list.empty() || std::any_of(list.begin(), list.end(), [&](const Colour& c) { return c != list[0]; }))
        continue;
      object.colour = list[0];
      object.triangleColours.clear();
    }
    std::vector<bool> filled(names_.size());
    for (const Run& run : runs_) filled[run.object] = true;
    std::vector<std::string> empty;
    for (size_t i = 1; i < names_.size(); ++i)
      if (!filled[i]) empty.push_back(names_[i]);
    if (!empty.empty()) file_.notes.push_back(emptyObjects(empty));
    note(pictures_, "pictures of materials were left out");
    model.notes = std::move(file_.notes);
    return model;
  }

  /// Where each triangle lies on the picture of its material; empty when none has one. Reads the pictures.
  std::vector<PicturePlaces> picturePlaces(std::vector<SurfacePicture>& pictures) {
    std::vector<PicturePlaces> places;
    if (polygons_.places.empty()) return places;
    for (size_t r = 0; r < materialRuns_.size(); ++r) {
      if (!materialRuns_[r].material) continue;
      const size_t end = r + 1 < materialRuns_.size() ? materialRuns_[r + 1].begin : file_.mesh.triangles.size();
      NamedMaterial& each = materials_[*materialRuns_[r].material];
      for (size_t t = materialRuns_[r].begin; t < end; ++t) {
        PicturePlaces of;
        bool whole = true;
        for (size_t k = 0; k < 3 && whole; ++k) {
          const uint32_t at = polygons_.places[t][k];
          whole = at < texturePlaces_.size();
          if (!whole) break;
          const MaterialMap& map = each.material.map;
          const double u = double(texturePlaces_[at][0]) * map.scale[0] + map.offset[0],
                       v = double(texturePlaces_[at][1]) * map.scale[1] + map.offset[1];
          of.corners[k] = {float(u), float(1 - v)};
        }
        if (!whole) continue;
        if (!each.looked) lookForPicture(each, pictures);
        if (!each.picture) break;
        of.picture = *each.picture;
        if (places.empty()) places.resize(file_.mesh.triangles.size());
        places[t] = of;
      }
    }
    return places;
  }

  /// Below the library's folder or the file's; its last name alone where that is another computer's.
  std::optional<std::filesystem::path> picturePath(const NamedMaterial& material) const {
    std::string name = material.material.map.file;
    std::replace(name.begin(), name.end(), '\\', '/');
    const std::filesystem::path whole = std::filesystem::path(name).lexically_normal();
    for (const std::filesystem::path& below : {whole, whole.filename()}) {
      if (below.is_absolute() || below.empty() || *below.begin() == "..") continue;
      for (const std::filesystem::path& folder : {material.folder, input_.folder}) {
        std::error_code none;
        if (std::filesystem::is_regular_file(folder / below, none)) return folder / below;
      }
    }
    return std::nullopt;
  }

  void lookForPicture(NamedMaterial& material, std::vector<SurfacePicture>& pictures) {
    material.looked = true;
    const std::string named = "the picture " + shown(material.material.map.file);
    --pictures_;
    const std::optional<std::filesystem::path> path = picturePath(material);
    if (!path) {
      file_.notes.push_back(named + " is not beside the file: its material has one colour");
      return;
    }
    try {
      std::shared_ptr<const ColourImage>& image = images_[*path];
      if (!image && images_.size() > kMostPictures) {
        file_.notes.push_back(named + " was left out: the file has more than " + std::to_string(kMostPictures));
        return;
      }
      if (!image) image = std::make_shared<const ColourImage>(readColourImage(*path, kLargestPicture, input_.job));
      const Colour colour = material.material.colour.value_or(Colour());
      // Black times a picture is black: programs that write both mean the picture.
      const bool black = colour.red == 0 && colour.green == 0 && colour.blue == 0;
      const auto part = [&](uint8_t c) { return black ? 1.0f : float(linearOf(c)) / 65535; };
      const auto wrap = material.material.map.clamp ? SurfacePicture::Wrap::clamp : SurfacePicture::Wrap::repeat;
      material.picture = uint32_t(pictures.size());
      pictures.push_back({.picture = image,
                          // Nobody names a picture to show none of it: for some, Tr 1 is opaque.
                          .factor = {part(colour.red), part(colour.green), part(colour.blue),
                                     material.material.opacity > 0 ? float(material.material.opacity) : 1.0f},
                          .wrapU = wrap,
                          .wrapV = wrap,
                          .alpha = SurfacePicture::Alpha::blend});
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      file_.notes.push_back(std::string("a picture was left out: ") + error.what());
    }
  }

  std::vector<Colour> materialColours() const {
    std::vector<Colour> all(file_.mesh.triangles.size());
    for (size_t r = 0; r < materialRuns_.size(); ++r) {
      const size_t end = r + 1 < materialRuns_.size() ? materialRuns_[r + 1].begin : all.size();
      std::fill(all.begin() + std::ptrdiff_t(materialRuns_[r].begin), all.begin() + std::ptrdiff_t(end),
                materialRuns_[r].material ? materials_[*materialRuns_[r].material].material.colour.value_or(Colour())
                                          : Colour());
    }
    return all;
  }

  template <class Each>
  void forEachRun(const Each& each) const {
    for (size_t r = 0; r < runs_.size(); ++r) {
      const size_t end = r + 1 < runs_.size() ? runs_[r + 1].begin : file_.mesh.triangles.size();
      each(runs_[r].object, std::span(file_.mesh.triangles).subspan(runs_[r].begin, end - runs_[r].begin));
    }
  }

  /// Whether each vertex belongs to one object at most.
  bool apart() const {
    constexpr uint32_t kNobody = UINT32_MAX;
    std::vector<uint32_t> owner(file_.mesh.positions.size(), kNobody);
    bool shared = false;
    forEachRun([&](uint32_t object, std::span<const std::array<uint32_t, 3>> triangles) {
      for (const auto& triangle : triangles) {
        for (const uint32_t v : triangle) {
          shared = shared || (owner[v] != kNobody && owner[v] != object);
          owner[v] = object;
        }
      }
    });
    return !shared;
  }

  void split(ModelFile& model, const std::vector<Colour>& colours, const std::vector<Colour>& ofTriangles,
             const std::vector<SurfacePicture>& pictures, const std::vector<PicturePlaces>& places) {
    constexpr uint32_t kNone = UINT32_MAX;
    std::vector<uint32_t> place(file_.mesh.positions.size(), kNone);  // in the vertex's object
    std::vector<ModelObject> objects(names_.size());
    size_t index = 0;  // of the triangle in the file
    forEachRun([&](uint32_t number, std::span<const std::array<uint32_t, 3>> triangles) {
      ModelObject& object = objects[number];
      object.name = names_[number];
      for (std::array<uint32_t, 3> triangle : triangles) {
        for (uint32_t& v : triangle) {
          if (place[v] == kNone) {
            place[v] = uint32_t(object.mesh.positions.size());
            object.mesh.positions.push_back(file_.mesh.positions[v]);
            if (!colours.empty()) object.vertexColours.push_back(colours[v]);
          }
          v = place[v];
        }
        object.mesh.triangles.push_back(triangle);
        if (!ofTriangles.empty()) object.triangleColours.push_back(ofTriangles[index]);
        if (!places.empty()) object.places.push_back(places[index]);
        ++index;
      }
    });
    for (ModelObject& object : objects) {
      const auto pictured = [](const PicturePlaces& each) { return each.picture != PicturePlaces::kNone; };
      if (std::any_of(object.places.begin(), object.places.end(), pictured))
        object.pictures = pictures;
      else
        object.places.clear();
      if (!object.mesh.triangles.empty()) model.objects.push_back(std::move(object));
    }
  }

  /// "v", "v/vt", "v//vn", "v/vt/vn", any of the later ones empty.
  uint32_t corner(std::string_view word) {
    std::array<std::string_view, 3> parts;
    size_t count = 0;
    for (std::string_view rest = word; count < parts.size(); ++count) {
      const size_t slash = rest.find('/');
      parts[count] = rest.substr(0, slash);
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
      if (count == 2) refuse(word);
    }
    int64_t vertex = 0;
    int64_t unused = 0;
    if (!parseInteger(parts[0], vertex)) refuse(word);
    for (const std::string_view part : {parts[2], parts[1]}) {
      unused = 0;
      if (!part.empty() && !parseInteger(part, unused)) refuse(word);
    }
    const int64_t place = unused < 0 ? int64_t(texturePlaces_.size()) + unused : unused - 1;
    placesOfCorners_.push_back(place >= 0 && place < int64_t(PolygonList::kNone) ? uint32_t(place)
                                                                                 : PolygonList::kNone);
    const auto known = int64_t(file_.mesh.positions.size());
    if (vertex == 0) cursor_.fail("a face names vertex 0 and they count from 1; repair the line or export again");
    if (vertex < -known) {
      cursor_.fail("a face names vertex " + std::to_string(vertex) + " and " + std::to_string(known) +
                   " came before; repair the line or export again");
    }
    if (vertex < 0) return uint32_t(known + vertex);
    if (vertex > int64_t(UINT32_MAX)) {
      cursor_.fail("a face names vertex " + std::to_string(vertex) + ", more than a mesh may have; repair the line");
    }
    // Vertices may come after the faces that name them: this is judged at the end.
    if (uint64_t(vertex) > highest_) {
      highest_ = uint64_t(vertex);
      highestLine_ = cursor_.line();
    }
    return uint32_t(vertex - 1);
  }

  [[noreturn]] void refuse(std::string_view word) const {
    cursor_.fail(shown(word) +
                 " is no corner of a face (vertex, vertex/texture, vertex//normal or vertex/texture/normal)");
  }

  void note(uint64_t count, const char* what) {
    if (count != 0) file_.notes.push_back(std::to_string(count) + " " + what);
  }

  const Input& input_;
  TextCursor cursor_;
  Ticker ticker_;
  MeshFile file_;  ///< All of it, before it is known what is an object of its own.
  ColourList colours_;
  std::vector<uint32_t> corners_;
  PolygonList polygons_;
  std::vector<std::string> names_{""};  ///< Of the objects; what comes before the first "o" has none.
  std::map<std::string, uint32_t> objects_{{"", 0}};
  uint32_t object_ = 0;
  std::vector<Run> runs_;
  std::string_view group_;
  bool newGroup_ = false;
  std::set<std::string_view> groups_;  ///< Those with faces, as the file writes them.
  std::set<std::string> libraries_;    ///< Looked for already.
  std::vector<NamedMaterial> materials_;
  std::map<std::string, size_t> materialsByName_;
  std::optional<size_t> material_;  ///< The one in use.
  std::vector<std::array<float, 2>> texturePlaces_;
  std::vector<uint32_t> placesOfCorners_;
  std::map<std::filesystem::path, std::shared_ptr<const ColourImage>> images_;
  std::vector<MaterialRun> materialRuns_;
  uint64_t pictures_ = 0;
  uint64_t highest_ = 0;  ///< Highest vertex that a face names, counted from 1.
  uint64_t highestLine_ = 0;
  uint64_t lines_ = 0;
  uint64_t freeForm_ = 0;
  uint64_t unknown_ = 0;
};

class ObjEncoder : public MeshEncoder {
 public:
  void begin(ByteSink& sink, const MeshCounts&) override { sink.text("# Written by Argil, units: mm\n"); }

  void vertices(ByteSink& sink, std::span<const Vec3d> positions) override { colouredVertices(sink, positions, {}); }

  /// Colours, 0 to 1, behind the coordinates: no standard, but what MeshLab, Blender and others write and read.
  void colouredVertices(ByteSink& sink, std::span<const Vec3d> positions, std::span<const Colour> colours) override {
    for (size_t i = 0; i < positions.size(); ++i) {
      const Vec3d& p = positions[i];
      sink.text("v");
      for (const double x : {p.x(), p.y(), p.z()}) {
        sink.text(" ");
        sink.decimal(x);
      }
      if (!colours.empty()) {
        for (const uint8_t level : {colours[i].red, colours[i].green, colours[i].blue}) {
          sink.text(" ");
          sink.decimal(float(level) / 255.0f);
        }
      }
      sink.text("\n");
    }
  }

  /// Names differ: one of a name that was there is a later part of the same object for readers.
  void object(ByteSink& sink, const std::string& name) override {
    std::string plain = name.empty() ? "Object" : name;
    for (char& c : plain)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    std::string own = plain;
    for (int number = 2; !names_.insert(own).second; ++number) own = plain + " " + std::to_string(number);
    sink.text("o ");
    sink.text(own);
    sink.text("\n");
  }

  void triangles(ByteSink& sink, std::span<const std::array<uint32_t, 3>> triangles) override {
    for (const auto& triangle : triangles) {
      sink.text("f");
      for (const uint32_t v : triangle) {
        sink.text(" ");
        sink.decimal(uint64_t(v) + 1);
      }
      sink.text("\n");
    }
  }

  void end(ByteSink&) override {}

 private:
  std::set<std::string> names_;
};

}  // namespace

bool recognizesObj(const Input& input) {
  TextCursor cursor(input, {.hashComments = true, .backslashContinues = true});
  if (!cursor.wordAhead()) return false;
  const std::string_view first = cursor.word();
  return first == "v" || first == "vn" || first == "vt" || first == "mtllib" || first == "usemtl" || first == "o" ||
         first == "g";
}

ModelFile parseObj(const Input& input) {
  return ObjReader(input).read();
}

std::unique_ptr<MeshEncoder> makeObjEncoder(const WriteOptions&) {
  return std::make_unique<ObjEncoder>();
}

}  // namespace argil::io
