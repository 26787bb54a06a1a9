#include "io/three_mf_read.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "io/three_mf_part.h"
#include "io/xml_scan.h"
#include "io/zip_reader.h"

namespace argil::io {

namespace {

using namespace three_mf;

constexpr const char* kRelations = "http://schemas.openxmlformats.org/package/2006/relationships";
constexpr const char* kRootRelations = "_rels/.rels";
/// A few bytes of components can ask for anything: so many uses are followed, and so much is made of copies beside what the file holds.
constexpr uint64_t kMostUses = 65536;
constexpr uint64_t kMostCopied = 16'000'000;
constexpr size_t kMostNested = 64;

/// "/3D/a.model" as the archive names it.
std::string_view inArchive(std::string_view path) { return path.starts_with('/') ? path.substr(1) : path; }

/// A mesh that is placed: `transform` brings it into the coordinates of the build.
struct Placed {
  Object* object;
  Transform transform;
  std::string name;
};

class PackageReader {
 public:
  explicit PackageReader(const Input& input) : input_(input), zip_(input) {}

  ModelFile read() {
    Part& root = part(rootPath());
    if (!root.hasResources) refuse(root, "it has no <resources>, which 3MF demands; export it again");
    if (!root.hasBuild) refuse(root, "it has no <build>, which 3MF demands; export it again");
    for (const Use& item : root.items) follow(root, item, {}, "");
    ModelFile model;
    model.format = "3MF";
    model.unitMm = root.unitMm;
    model.metadata = std::move(root.metadata);
    model.notes = losses_.sentences();
    put(model);
    return model;
  }

 private:
  [[noreturn]] void refuse(const Part& part, const std::string& wrong) const { fail(input_.name, "part " + shown(part.path) + ": " + wrong); }

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
    Part& made = parts_.emplace(key, readPart(Input{bytes.bytes(), input_.name, input_.job}, key, losses_)).first->second;
    if (root_ == nullptr) root_ = &made;
    if (made.unitMm != root_->unitMm) refuse(made, "its unit is another than that of the other parts; save the model with one unit");
    for (const auto& [id, object] : made.objects) {
      held_ += std::max(object.content.mesh.triangles.size(), object.content.mesh.positions.size());
    }
    return made;
  }

  void follow(Part& from, const Use& use, const Transform& outer, const std::string& name) {
    if (++uses_ > kMostUses) refuse(from, "it places more than " + std::to_string(kMostUses) + " objects; it may be an attack, or save it as fewer");
    Part& in = use.path.empty() ? from : part(use.path);
    const auto found = in.objects.find(use.object);
    if (found == in.objects.end()) refuse(in, "object " + std::to_string(use.object) + " is used and not there; export it again");
    Object& object = found->second;
    if (!object.printed) return;
    if (std::find(trail_.begin(), trail_.end(), &object) != trail_.end()) refuse(in, "object " + std::to_string(use.object) + " contains itself; export it again");
    if (trail_.size() >= kMostNested) refuse(in, "its objects are nested more than " + std::to_string(kMostNested) + " deep; save it as fewer");
    const Transform transform = use.transform.then(outer);
    const std::string& own = object.content.name.empty() ? name : object.content.name;
    if (!object.content.mesh.triangles.empty()) {
      made_ += std::max(object.content.mesh.triangles.size(), object.content.mesh.positions.size());
      if (made_ > kMostCopied && made_ - kMostCopied > held_) refuse(in, "its copies have too many triangles together; save it as fewer or reduce it");
      placed_.push_back({&object, transform, own});
      ++uses_of_[&object];
    }
    trail_.push_back(&object);
    for (const Use& component : object.components) follow(in, component, transform, own);
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
          if (!p.allFinite()) fail(input_.name, "a transform moves " + (object.name.empty() ? "an object" : shown(object.name)) + " beyond all numbers; repair it");
        }
        if (placed.transform.mirrors()) {
          for (auto& triangle : object.mesh.triangles) std::swap(triangle[1], triangle[2]);
        }
      }
      model.objects.push_back(std::move(object));
      if (input_.job != nullptr) input_.job->step(1);
    }
  }

  const Input& input_;
  ZipReader zip_;
  std::map<std::string, Part> parts_;
  const Part* root_ = nullptr;
  Losses losses_;
  std::vector<const Object*> trail_;
  std::vector<Placed> placed_;
  std::map<const Object*, uint64_t> uses_of_;
  uint64_t uses_ = 0, made_ = 0, held_ = 0;
};

}  // namespace

bool recognizesThreeMf(const Input& input) {
  if (!input.text().starts_with("PK\x03\x04")) return false;
  try {
    const ZipReader zip(input);
    return std::any_of(zip.parts().begin(), zip.parts().end(), [](const ZipReader::Part& part) { return part.name.ends_with(".model"); });
  } catch (const Error&) {
    return false;
  }
}

ModelFile parseThreeMf(const Input& input) { return PackageReader(input).read(); }

}  // namespace argil::io
