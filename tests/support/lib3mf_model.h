#pragma once
// What lib3mf 1.8, a reader that is not ours, finds in a 3MF file.

#include <Model/COM/NMR_DLLInterfaces.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "io/models/model_file.h"

namespace argil::samples {

struct PeerObject {
  std::string name;
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<std::array<io::Colour, 3>> corners;  ///< As its triangles' own properties are.
};

struct PeerModel {
  DWORD unit = 0;                   ///< NMR::MODELUNIT_MILLIMETER, ...
  std::vector<PeerObject> objects;  ///< Of the items of the build, in their order.
  std::vector<io::Colour> materials;
  std::vector<std::pair<std::string, std::string>> metadata;
  std::vector<std::string> warnings;
};

namespace peer {

inline void check(LIB3MFRESULT result, const char* what) {
  if (result != LIB3MF_OK) throw std::runtime_error(std::string("lib3mf: ") + what + " " + std::to_string(result));
}

/// Text from a function that takes a buffer, its size and where to put what it needs.
template <class Get>
std::string text(Get&& get) {
  std::string buffer(4096, '\0');
  ULONG needed = 0;
  check(get(buffer.data(), ULONG(buffer.size()), &needed), "text");
  return buffer.c_str();
}

/// What lib3mf handed out goes back to it.
class Owned {
 public:
  Owned() = default;
  ~Owned() {
    for (auto each = all_.rbegin(); each != all_.rend(); ++each) NMR::lib3mf_release(*each);
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  void operator()(NMR::PLib3MFBase* object) { all_.push_back(object); }

 private:
  std::vector<NMR::PLib3MFBase*> all_;
};

}  // namespace peer

/// Throws std::runtime_error when lib3mf does.
inline PeerModel readByLib3mf(const std::filesystem::path& path) {
  using namespace NMR;
  using peer::check;
  peer::Owned own;
  PLib3MFModel* model = nullptr;
  check(lib3mf_createmodel(&model), "create");
  own(model);
  PLib3MFModelReader* reader = nullptr;
  check(lib3mf_model_queryreader(model, "3mf", &reader), "reader");
  own(reader);
  check(lib3mf_reader_setstrictmodeactive(reader, true), "strict");
  if (lib3mf_reader_readfromfileutf8(reader, path.c_str()) != LIB3MF_OK) {
    DWORD code = 0;
    LPCSTR message = nullptr;
    check(lib3mf_getlasterror(reader, &code, &message), "last error");
    throw std::runtime_error(std::string("lib3mf: ") + message);
  }
  PeerModel result;
  DWORD count = 0;
  check(lib3mf_reader_getwarningcount(reader, &count), "warnings");
  for (DWORD i = 0; i < count; ++i) {
    DWORD code = 0;
    result.warnings.push_back(peer::text([&](char* to, ULONG size, ULONG* needed) {
      return lib3mf_reader_getwarningutf8(reader, i, &code, to, size, needed);
    }));
  }
  check(lib3mf_model_getunit(model, &result.unit), "unit");
  check(lib3mf_model_getmetadatacount(model, &count), "metadata");
  for (DWORD i = 0; i < count; ++i) {
    result.metadata.emplace_back(peer::text([&](char* to, ULONG size, ULONG* needed) {
                                   return lib3mf_model_getmetadatakeyutf8(model, i, to, size, needed);
                                 }),
                                 peer::text([&](char* to, ULONG size, ULONG* needed) {
                                   return lib3mf_model_getmetadatavalueutf8(model, i, to, size, needed);
                                 }));
  }
  PLib3MFModelResourceIterator* groups = nullptr;
  check(lib3mf_model_getbasematerials(model, &groups), "materials");
  own(groups);
  for (BOOL more = 0; lib3mf_resourceiterator_movenext(groups, &more) == LIB3MF_OK && more;) {
    PLib3MFModelResource* group = nullptr;
    check(lib3mf_resourceiterator_getcurrent(groups, &group), "material");
    own(group);
    check(lib3mf_basematerial_getcount(group, &count), "count");
    for (DWORD i = 0; i < count; ++i) {
      io::Colour c;
      check(lib3mf_basematerial_getdisplaycolor(group, i, &c.red, &c.green, &c.blue, &c.alpha), "displaycolor");
      result.materials.push_back(c);
    }
  }
  PLib3MFModelBuildItemIterator* items = nullptr;
  check(lib3mf_model_getbuilditems(model, &items), "items");
  own(items);
  for (BOOL more = 0; lib3mf_builditemiterator_movenext(items, &more) == LIB3MF_OK && more;) {
    PLib3MFModelBuildItem* item = nullptr;
    check(lib3mf_builditemiterator_getcurrent(items, &item), "item");
    own(item);
    PLib3MFModelObjectResource* mesh = nullptr;
    check(lib3mf_builditem_getobjectresource(item, &mesh), "object");
    own(mesh);
    PeerObject object;
    object.name = peer::text(
        [&](char* to, ULONG size, ULONG* needed) { return lib3mf_object_getnameutf8(mesh, to, size, needed); });
    check(lib3mf_meshobject_getvertexcount(mesh, &count), "vertices");
    object.positions.resize(count);
    check(lib3mf_meshobject_getvertices(mesh, reinterpret_cast<MODELMESHVERTEX*>(object.positions.data()), count,
                                        nullptr),
          "vertices");
    check(lib3mf_meshobject_gettrianglecount(mesh, &count), "triangles");
    object.triangles.resize(count);
    check(lib3mf_meshobject_gettriangleindices(mesh, reinterpret_cast<MODELMESHTRIANGLE*>(object.triangles.data()),
                                               count, nullptr),
          "triangles");
    PLib3MFPropertyHandler* properties = nullptr;
    check(lib3mf_meshobject_createpropertyhandler(mesh, &properties), "properties");
    own(properties);
    for (DWORD i = 0; i < count; ++i) {
      eModelPropertyType type = MODELPROPERTYTYPE_NONE;
      check(lib3mf_propertyhandler_getpropertytype(properties, i, &type), "property");
      if (type != MODELPROPERTYTYPE_COLOR) continue;
      MODELMESH_TRIANGLECOLOR_SRGB colours;
      check(lib3mf_propertyhandler_getcolor(properties, i, &colours), "colour");
      object.corners.emplace_back();
      for (size_t c = 0; c < 3; ++c) {
        const MODELMESHCOLOR_SRGB& from = colours.m_Colors[c];
        object.corners.back()[c] = {from.m_Red, from.m_Green, from.m_Blue, from.m_Alpha};
      }
    }
    result.objects.push_back(std::move(object));
  }
  return result;
}

}  // namespace argil::samples
