#include "io/models/three_mf_read.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include "io/bytes/empty_objects.h"
#include "io/bytes/xml_scan.h"
#include "io/bytes/zip_reader.h"
#include "io/models/picture.h"
#include "io/models/slicer_settings.h"
#include "io/models/three_mf_part.h"

namespace argil::io {

namespace {

using namespace three_mf;

constexpr const char* kRelations = "http://schemas.openxmlformats.org/package/2006/relationships";
constexpr const char* kRootRelations = "_rels/.rels";
/// A few bytes of components can ask for anything: so many uses are followed, and so much is made of copies beside what
/// the file holds.
constexpr uint64_t kMostUses = 65536;
constexpr uint64_t kMostCopied = 16'000'000;
constexpr size_t kMostNested = 64;
constexpr size_t kMostPictures = 64;   // of a file
constexpr int kLargestPicture = 8192;  // pixels along an edge

/// "/3D/a.model" as the archive names it.
std::string_view inArchive(std::string_view path) {
  return path.starts_with('/') ? path.substr(1) : path;
}

/// A mesh that is placed: `transform` brings it into the coordinates of the build.
struct Placed {
  Object* object;
  Transform transform;
  std::string name;
  VolumeKind kind;
  uint32_t assembly;                         ///< The item of the build.
  const std::vector<SlicerVolume>* volumes;  ///< That its triangles are divided into; null: all are of one.
};

class PackageReader {
 public:
  explicit PackageReader(const Input& input) : input_(input), zip_(input) {}

  ModelFile read() {
    Part& root = part(rootPath());
    if (!root.hasResources) refuse(root, "it has no <resources>, which 3MF demands; export it again");
    if (!root.hasBuild) refuse(root, "it has no <build>, which 3MF demands; export it again");
    slicer_ = readSlicerSettings(zip_, input_);
    for (const Use& item : root.items) {
      const auto named = slicer_.names.find(item.object);
      follow(root, item, {}, {named == slicer_.names.end() ? "" : named->second, VolumeKind::solid, item.object});
      ++items_;
    }
    ModelFile model;
    model.format = "3MF";
    model.unitMm = root.unitMm;
    model.metadata = std::move(root.metadata);
    model.notes = losses_.sentences();
    model.notes.insert(model.notes.end(), pictureNotes_.begin(), pictureNotes_.end());
    if (!slicer_.trouble.empty()) model.notes.push_back(slicer_.trouble);
    if (!empty_.empty()) model.notes.push_back(emptyObjects(empty_));
    put(model);
    if (model.objects.empty() && !placed_.empty())
      fail(input_.name, "holds no solid volume: its volumes are cut away, or change settings");
    if (modifiers_ > 0)
      model.notes.push_back(counted(modifiers_, "volume changes", "volumes change") +
                            " settings of the slicer alone (modifiers) and " + (modifiers_ == 1 ? "was" : "were") +
                            " left out");
    if (supports_ > 0)
      model.notes.push_back(counted(supports_, "volume says", "volumes say") + " where the slicer puts supports and " +
                            (supports_ == 1 ? "was" : "were") + " left out");
    return model;
  }

 private:
  [[noreturn]] void refuse(const Part& part, const std::string& wrong) const {
    fail(input_.name, "part " + shown(part.path) + ": " + wrong);
  }

  FileBytes unpack(std::string_view path) {
    const ZipReader::Part* found = zip_.find(inArchive(path));
    if (found == nullptr) fail(input_.name, "has no part " + shown(path) + "; export it again");
    return zip_.read(*found);
  }

  std::string rootPath() {
    const FileBytes bytes = unpack(kRootRelations);
    const Input input{bytes.bytes(), input_.name, input_.job};
    XmlScanner xml(input, kRootRelations);
    xml.root();
    if (!xml.is(kRelations, "Relationships")) xml.fail("there are no relationships; export it again");
    std::string path;
    for (const size_t depth = xml.depth(); xml.child(depth);) {
      const std::string_view* type = xml.attribute("Type");
      const std::string_view* target = xml.attribute("Target");
      const std::string_view* mode = xml.attribute("TargetMode");
      if (type == nullptr || target == nullptr || *type != kModelRelation || !path.empty()) continue;
      if (mode != nullptr && *mode == "External") xml.fail("the model is in another place; save it as one file");
      path = xml.utf8(*target);
    }
    xml.finish();
    if (path.empty()) fail(input_.name, "is a package without a 3MF model; export it again");
    return path;
  }

  Part& part(const std::string& path) {
    const std::string key(inArchive(path));
    const auto known = parts_.find(key);
    if (known != parts_.end()) return known->second;
    const FileBytes bytes = unpack(path);
    Part& made =
        parts_.emplace(key, readPart(Input{bytes.bytes(), input_.name, input_.job}, key, losses_)).first->second;
    if (root_ == nullptr) root_ = &made;
    if (made.unitMm != root_->unitMm)
      refuse(made, "its unit is another than that of the other parts; save the model with one unit");
    if (!made.textures.empty()) givePictures(made);
    for (const auto& [id, object] : made.objects) {
      held_ += std::max(object.content.mesh.triangles.size(), object.content.mesh.positions.size());
    }
    return made;
  }

  void notePicture(const std::string& sentence) {
    if (std::find(pictureNotes_.begin(), pictureNotes_.end(), sentence) == pictureNotes_.end())
      pictureNotes_.push_back(sentence);
  }

  /// The picture of a part of the package; null, and a note, where it cannot be had.
  std::shared_ptr<const ColourImage> pictureAt(const std::string& path) {
    const auto known = images_.find(path);
    if (known != images_.end()) return known->second;
    std::shared_ptr<const ColourImage>& image = images_[path];
    const std::string named = "the picture " + shown(path);
    const ZipReader::Part* found = path.empty() ? nullptr : zip_.find(inArchive(path));
    if (found == nullptr) {
      notePicture(named + " is not in the file: its surface has one colour");
    } else if (images_.size() > kMostPictures) {
      notePicture(named + " was left out: the file has more than " + std::to_string(kMostPictures));
    } else {
      try {
        const FileBytes bytes = zip_.read(*found);
        image = std::make_shared<const ColourImage>(unpackPicture(bytes.bytes(), kLargestPicture, input_.job));
      } catch (const Cancelled&) {
        throw;
      } catch (const Error& error) {
        const std::string_view wrong = error.what(), prefix = "the picture: ";
        notePicture(named + " was left out and its surface has one colour: " +
                    std::string(wrong.substr(wrong.starts_with(prefix) ? prefix.size() : 0)));
      }
    }
    return image;
  }

  void givePictures(Part& part) {
    for (auto& [id, object] : part.objects) {
      ModelObject& content = object.content;
      std::map<uint32_t, uint32_t> numbers;  // of textures: in the object
      for (PicturePlaces& places : content.places) {
        if (places.picture == PicturePlaces::kNone) continue;
        const auto [at, isNew] = numbers.try_emplace(places.picture, PicturePlaces::kNone);
        const Texture& texture = part.textures[places.picture];
        if (isNew) {
          if (const auto image = pictureAt(texture.path)) {
            at->second = uint32_t(content.pictures.size());
            content.pictures.push_back({.picture = image,
                                        .wrapU = texture.wrapU,
                                        .wrapV = texture.wrapV,
                                        .alpha = SurfacePicture::Alpha::blend});
          }
        }
        places.picture = at->second;
      }
      if (content.pictures.empty()) content.places.clear();
    }
  }

  // What is known of an object before it is looked at.
  struct Known {
    std::string name;
    VolumeKind kind = VolumeKind::solid;
    uint32_t slicerObject = 0;  // of the first part, which the item of the build names
  };

  static std::string counted(uint64_t n, const char* one, const char* many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
  }

  void follow(Part& from, const Use& use, const Transform& outer, const Known& known) {
    if (++uses_ > kMostUses)
      refuse(from,
             "it places more than " + std::to_string(kMostUses) + " objects; it may be an attack, or save it as fewer");
    Part& in = use.path.empty() ? from : part(use.path);
    const auto found = in.objects.find(use.object);
    if (found == in.objects.end())
      refuse(in, "object " + std::to_string(use.object) + " is used and not there; export it again");
    Object& object = found->second;
    if (!object.printed) return;
    if (std::find(trail_.begin(), trail_.end(), &object) != trail_.end())
      refuse(in, "object " + std::to_string(use.object) + " contains itself; export it again");
    if (trail_.size() >= kMostNested)
      refuse(in, "its objects are nested more than " + std::to_string(kMostNested) + " deep; save it as fewer");
    const Transform transform = use.transform.then(outer);
    const std::string& own = object.content.name.empty() ? known.name : object.content.name;
    if (!object.content.mesh.triangles.empty()) {
      made_ += std::max(object.content.mesh.triangles.size(), object.content.mesh.positions.size());
      if (made_ > kMostCopied && made_ - kMostCopied > held_)
        refuse(in, "its copies have too many triangles together; save it as fewer or reduce it");
      const auto volumes = trail_.empty() ? slicer_.volumes.find(use.object) : slicer_.volumes.end();
      placed_.push_back(
          {&object, transform, own, known.kind, items_, volumes == slicer_.volumes.end() ? nullptr : &volumes->second});
      ++uses_of_[&object];
    } else if (object.components.empty()) {
      empty_.push_back(own);
    }
    trail_.push_back(&object);
    for (const Use& component : object.components) {
      const auto part = slicer_.parts.find({known.slicerObject, component.object});
      if (part == slicer_.parts.end())
        follow(in, component, transform, {own, known.kind, known.slicerObject});
      else
        follow(in, component, transform,
               {part->second.name.empty() ? own : part->second.name, part->second.kind, known.slicerObject});
    }
    trail_.pop_back();
  }

  void put(ModelFile& model) {
    for (Placed& placed : placed_) {
      ModelObject object = --uses_of_[placed.object] == 0 ? std::move(placed.object->content) : placed.object->content;
      object.name = std::move(placed.name);
      model.faces += object.mesh.triangles.size();
      if (!placed.transform.isIdentity()) {
        for (Vec3d& p : object.mesh.positions) {
          p = placed.transform(p);
          if (!p.allFinite())
            fail(input_.name, "a transform moves " + (object.name.empty() ? "an object" : shown(object.name)) +
                                  " beyond all numbers; repair it");
        }
        if (placed.transform.mirrors()) {
          for (auto& triangle : object.mesh.triangles) std::swap(triangle[1], triangle[2]);
          for (PicturePlaces& places : object.places) std::swap(places.corners[1], places.corners[2]);
        }
      }
      object.assembly = placed.assembly;
      if (placed.volumes != nullptr && areWhole(*placed.volumes, object.mesh.triangles.size())) {
        for (const SlicerVolume& volume : *placed.volumes) {
          if (volume.kind == VolumeKind::solid || volume.kind == VolumeKind::negative)
            give(model, volumeOf(object, volume), volume.kind);
          else
            leaveOut(volume.kind);
        }
      } else {
        give(model, std::move(object), placed.kind);
      }
      if (input_.job != nullptr) input_.job->step(1);
    }
  }

  void leaveOut(VolumeKind kind) { ++(kind == VolumeKind::modifier ? modifiers_ : supports_); }

  void give(ModelFile& model, ModelObject&& object, VolumeKind kind) {
    if (kind == VolumeKind::solid)
      model.objects.push_back(std::move(object));
    else if (kind == VolumeKind::negative)
      model.negatives.push_back(std::move(object));
    else
      leaveOut(kind);
  }

  // Each triangle belongs to one volume.
  static bool areWhole(const std::vector<SlicerVolume>& volumes, size_t triangles) {
    uint64_t next = 0;
    for (const SlicerVolume& volume : volumes) {
      if (volume.first != next) return false;
      next = volume.last + 1;
    }
    return next == triangles;
  }

  ModelObject volumeOf(const ModelObject& all, const SlicerVolume& volume) {
    ModelObject object;
    object.name = volume.name.empty() ? all.name : volume.name;
    object.colour = all.colour;
    object.assembly = all.assembly;
    if (vertexPlace_.size() < all.mesh.positions.size()) vertexPlace_.resize(all.mesh.positions.size(), UINT32_MAX);
    for (uint64_t t = volume.first; t <= volume.last; ++t) {
      auto triangle = all.mesh.triangles[t];
      for (uint32_t& corner : triangle) {
        uint32_t& at = vertexPlace_[corner];
        if (at == UINT32_MAX) {
          at = uint32_t(object.mesh.positions.size());
          object.mesh.positions.push_back(all.mesh.positions[corner]);
          if (!all.vertexColours.empty()) object.vertexColours.push_back(all.vertexColours[corner]);
        }
        corner = at;
      }
      object.mesh.triangles.push_back(triangle);
      if (!all.triangleColours.empty()) object.triangleColours.push_back(all.triangleColours[t]);
      if (!all.places.empty()) object.places.push_back(all.places[t]);
    }
    object.pictures = all.pictures;
    for (uint64_t t = volume.first; t <= volume.last; ++t)
      for (const uint32_t corner : all.mesh.triangles[t]) vertexPlace_[corner] = UINT32_MAX;
    return object;
  }

  const Input& input_;
  ZipReader zip_;
  SlicerSettings slicer_;
  std::map<std::string, Part> parts_;
  const Part* root_ = nullptr;
  std::map<std::string, std::shared_ptr<const ColourImage>> images_;  // by paths; null: cannot be had
  std::vector<std::string> pictureNotes_;
  Losses losses_;
  std::vector<const Object*> trail_;
  std::vector<Placed> placed_;
  std::map<const Object*, uint64_t> uses_of_;
  uint64_t uses_ = 0, made_ = 0, held_ = 0;
  uint64_t modifiers_ = 0, supports_ = 0;  // volumes that were left out
  std::vector<std::string> empty_;         // names of objects that are built and have no triangles
  uint32_t items_ = 0;
  std::vector<uint32_t> vertexPlace_;  // in the volume that is being taken out; none: UINT32_MAX
};

}  // namespace

bool recognizesThreeMf(const Input& input) {
  if (!input.text().starts_with("PK\x03\x04")) return false;
  try {
    const ZipReader zip(input);
    return std::any_of(zip.parts().begin(), zip.parts().end(),
                       [](const ZipReader::Part& part) { return part.name.ends_with(".model"); });
  } catch (const Error&) {
    return false;
  }
}

ModelFile parseThreeMf(const Input& input) {
  return PackageReader(input).read();
}

}  // namespace argil::io
