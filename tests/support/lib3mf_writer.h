#pragma once
// A 3MF file as lib3mf 1.8 writes it: several objects with names and colours, transforms, units.

#include <Model/COM/NMR_DLLInterfaces.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

#include "io/models/model_file.h"
#include "tests/support/lib3mf_model.h"

namespace argil::samples {

/// Objects in mm. The first wherever `places` says, as a component that `inner` moves; without places each where it
/// is. Corners of triangles have their colours where the object has any. Throws std::runtime_error when lib3mf does.
inline void writeByLib3mf(const std::filesystem::path& path, const std::vector<io::ModelObject>& objects,
                          const std::vector<Eigen::Affine3d>& places, const Eigen::Affine3d& inner, bool inches) {
  using namespace NMR;
  using peer::check;
  peer::Owned own;
  const auto transformOf = [](const Eigen::Affine3d& t) {
    MODELTRANSFORM transform;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) transform.m_fFields[row][column] = float(t.matrix()(row, column));
    return transform;
  };
  PLib3MFModel* model = nullptr;
  check(lib3mf_createmodel(&model), "create");
  own(model);
  check(lib3mf_model_setunit(model, inches ? MODELUNIT_INCH : MODELUNIT_MILLIMETER), "unit");
  for (const io::ModelObject& object : objects) {
    PLib3MFModelMeshObject* mesh = nullptr;
    check(lib3mf_model_addmeshobject(model, &mesh), "mesh");
    own(mesh);
    check(lib3mf_object_setnameutf8(mesh, object.name.c_str()), "name");
    for (const Vec3d& p : object.mesh.positions) {
      const Vec3d at = inches ? Vec3d(p / 25.4) : p;
      MODELMESHVERTEX vertex{{float(at.x()), float(at.y()), float(at.z())}};
      check(lib3mf_meshobject_addvertex(mesh, &vertex, nullptr), "vertex");
    }
    for (const auto& [a, b, c] : object.mesh.triangles) {
      MODELMESHTRIANGLE triangle{{a, b, c}};
      check(lib3mf_meshobject_addtriangle(mesh, &triangle, nullptr), "triangle");
    }
    if (!object.vertexColours.empty() || !object.triangleColours.empty()) {
      PLib3MFPropertyHandler* properties = nullptr;
      check(lib3mf_meshobject_createpropertyhandler(mesh, &properties), "properties");
      own(properties);
      PLib3MFDefaultPropertyHandler* common = nullptr;  // Without it the file is not written.
      check(lib3mf_object_createdefaultpropertyhandler(mesh, &common), "common properties");
      own(common);
      check(lib3mf_defaultpropertyhandler_setcolorrgba(common, 255, 255, 255, 255), "common colour");
      for (size_t t = 0; t < object.mesh.triangles.size(); ++t) {
        MODELMESH_TRIANGLECOLOR_SRGB colours;
        for (size_t k = 0; k < 3; ++k) {
          const io::Colour& c = object.triangleColours.empty() ? object.vertexColours[object.mesh.triangles[t][k]]
                                                               : object.triangleColours[t];
          colours.m_Colors[k] = {c.red, c.green, c.blue, c.alpha};
        }
        check(lib3mf_propertyhandler_setgradientcolor(properties, DWORD(t), &colours), "colour");
      }
    }
    PLib3MFModelObjectResource* placed = mesh;
    if (!places.empty()) {
      PLib3MFModelComponentsObject* group = nullptr;
      PLib3MFModelComponent* component = nullptr;
      check(lib3mf_model_addcomponentsobject(model, &group), "components");
      own(group);
      MODELTRANSFORM transform = transformOf(inner);
      check(lib3mf_componentsobject_addcomponent(group, mesh, &transform, &component), "component");
      own(component);
      placed = group;
    }
    for (size_t i = 0; i < std::max<size_t>(1, places.size()); ++i) {
      PLib3MFModelBuildItem* item = nullptr;
      MODELTRANSFORM transform = transformOf(places.empty() ? Eigen::Affine3d::Identity() : places[i]);
      check(lib3mf_model_addbuilditem(model, placed, &transform, &item), "item");
      own(item);
    }
  }
  PLib3MFModelWriter* writer = nullptr;
  check(lib3mf_model_querywriter(model, "3mf", &writer), "writer");
  own(writer);
  check(lib3mf_writer_writetofileutf8(writer, path.c_str()), "write");
}

}  // namespace argil::samples
