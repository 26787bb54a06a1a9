#pragma once
// STEP files for tests.

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clay/base/vec.h"

namespace argil::samples {

/// What else a part may be.
struct StepPart {
  std::vector<Vec3d> blocks{Vec3d::Zero()};       ///< Where it has such a block.
  std::vector<std::array<double, 3>> bodies;      ///< Red, green, blue of the blocks, or none.
  std::map<size_t, std::array<double, 3>> faces;  ///< Of single faces, counted through: seven a block, the bore last.
};

/// A block with a corner at zero and a bore through its middle along z, in mm, as CAD programs write it: planes with
/// lines and circles, a cylinder with a seam. Its volume is x y z − π r² z.
inline std::string stepOfBoredBlock(const Vec3d& size, double radius, const StepPart& part = {}) {
  std::string data;
  int count = 0;
  const auto put = [&](const std::string& entity) {
    data += fmt::format("#{}={};\n", ++count, entity);
    return fmt::format("#{}", count);
  };
  const auto numbers = [](const Vec3d& v) { return fmt::format("({:.6f},{:.6f},{:.6f})", v.x(), v.y(), v.z()); };
  const auto point = [&](const Vec3d& at) { return put("CARTESIAN_POINT(''," + numbers(at) + ")"); };
  const auto direction = [&](const Vec3d& way) { return put("DIRECTION(''," + numbers(way) + ")"); };
  const auto axes = [&](const Vec3d& at, const Vec3d& z, const Vec3d& x) {
    const std::string origin = point(at), up = direction(z), right = direction(x);
    return put(fmt::format("AXIS2_PLACEMENT_3D('',{},{},{})", origin, up, right));
  };
  const Vec3d x = Vec3d::UnitX(), z = Vec3d::UnitZ();
  const auto vertex = [&](const Vec3d& at) { return put(fmt::format("VERTEX_POINT('',{})", point(at))); };
  const auto line = [&](const std::string& from, const std::string& to, const Vec3d& at, const Vec3d& end) {
    const std::string origin = point(at), way = direction((end - at).normalized());
    const std::string vector = put(fmt::format("VECTOR('',{},1.)", way));
    const std::string curve = put(fmt::format("LINE('',{},{})", origin, vector));
    return put(fmt::format("EDGE_CURVE('',{},{},{},.T.)", from, to, curve));
  };
  const auto oriented = [&](const std::string& edge, bool along) {
    return put(fmt::format("ORIENTED_EDGE('',*,*,{},.{}.)", edge, along ? 'T' : 'F'));
  };
  const auto loop = [&](const std::vector<std::string>& edges) {
    return put(fmt::format("EDGE_LOOP('',({}))", fmt::join(edges, ",")));
  };
  std::vector<std::string> solids, allFaces;
  for (const Vec3d& start : part.blocks) {
    const Vec3d foot = start + Vec3d(size.x() / 2, size.y() / 2, 0);
    const auto corner = [&](int i) -> Vec3d {
      return start + Vec3d((i & 1) * size.x(), (i >> 1 & 1) * size.y(), (i >> 2) * size.z());
    };
    std::vector<std::string> vertices, faces;
    for (int i = 0; i < 8; ++i) vertices.push_back(vertex(corner(i)));
    std::map<std::pair<int, int>, std::string> edges;
    for (int i = 0; i < 8; ++i)
      for (const int bit : {1, 2, 4})
        if (!(i & bit))
          edges[{i, i | bit}] = line(vertices[size_t(i)], vertices[size_t(i | bit)], corner(i), corner(i | bit));
    std::array<std::string, 2> rims, ends;
    for (size_t top = 0; top < 2; ++top) {
      const Vec3d middle = foot + double(top) * size.z() * z;
      ends[top] = vertex(middle + radius * x);
      const std::string circle = put(fmt::format("CIRCLE('',{},{:.6f})", axes(middle, z, x), radius));
      rims[top] = put(fmt::format("EDGE_CURVE('',{},{},{},.T.)", ends[top], ends[top], circle));
    }
    const std::string seam = line(ends[0], ends[1], foot + radius * x, foot + radius * x + size.z() * z);
    for (const auto& f : std::vector<std::array<int, 4>>{
             {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
      std::vector<std::string> around;
      for (size_t k = 0; k < 4; ++k) {
        const int from = f[k], to = f[(k + 1) % 4];
        around.push_back(oriented(edges.at({std::min(from, to), std::max(from, to)}), from < to));
      }
      const Vec3d across = corner(f[1]) - corner(f[0]), other = corner(f[3]) - corner(f[0]);
      std::string bounds = put(fmt::format("FACE_OUTER_BOUND('',{},.T.)", loop(around)));
      if (faces.size() < 2)
        bounds += ',' + put(fmt::format("FACE_BOUND('',{},.T.)", loop({oriented(rims[faces.size()], faces.empty())})));
      const std::string plane =
          put(fmt::format("PLANE('',{})", axes(corner(f[0]), across.cross(other).normalized(), across.normalized())));
      faces.push_back(put(fmt::format("ADVANCED_FACE('',({}),{},.T.)", bounds, plane)));
    }
    const std::string wall =
        loop({oriented(seam, true), oriented(rims[1], true), oriented(seam, false), oriented(rims[0], false)});
    const std::string bound = put(fmt::format("FACE_BOUND('',{},.T.)", wall));
    const std::string cylinder = put(fmt::format("CYLINDRICAL_SURFACE('',{},{:.6f})", axes(foot, z, x), radius));
    faces.push_back(put(fmt::format("ADVANCED_FACE('',({}),{},.F.)", bound, cylinder)));
    const std::string shell = put(fmt::format("CLOSED_SHELL('',({}))", fmt::join(faces, ",")));
    solids.push_back(put(fmt::format("MANIFOLD_SOLID_BREP('Bored block',{})", shell)));
    allFaces.insert(allFaces.end(), faces.begin(), faces.end());
  }
  const std::string length = put("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
  const std::string angle = put("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
  const std::string solidAngle = put("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
  const std::string error =
      put(fmt::format("UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),{},'accuracy','')", length));
  const std::string context =
      put(fmt::format("(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({}))"
                      "GLOBAL_UNIT_ASSIGNED_CONTEXT(({},{},{}))REPRESENTATION_CONTEXT('',''))",
                      error, length, angle, solidAngle));
  const std::string shape = put(fmt::format("ADVANCED_BREP_SHAPE_REPRESENTATION('',({},{}),{})",
                                            axes(Vec3d::Zero(), z, x), fmt::join(solids, ","), context));
  std::vector<std::string> styled;
  const auto style = [&](const std::string& item, const std::array<double, 3>& rgb) {
    std::string use = put(fmt::format("COLOUR_RGB('',{:.3f},{:.3f},{:.3f})", rgb[0], rgb[1], rgb[2]));
    for (const char* wrapped :
         {"FILL_AREA_STYLE_COLOUR('',{})", "FILL_AREA_STYLE('',({}))", "SURFACE_STYLE_FILL_AREA({})",
          "SURFACE_SIDE_STYLE('',({}))", "SURFACE_STYLE_USAGE(.BOTH.,{})", "PRESENTATION_STYLE_ASSIGNMENT(({}))"})
      use = put(fmt::format(fmt::runtime(wrapped), use));
    styled.push_back(put(fmt::format("STYLED_ITEM('',({}),{})", use, item)));
  };
  for (size_t i = 0; i < part.bodies.size(); ++i) style(solids.at(i), part.bodies[i]);
  for (const auto& [face, rgb] : part.faces) style(allFaces.at(face), rgb);
  if (!styled.empty())
    static_cast<void>(put(fmt::format("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',({}),{})",
                                      fmt::join(styled, ","), context)));
  const std::string application = put("APPLICATION_CONTEXT('automotive design')");
  static_cast<void>(put(fmt::format(
      "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{})", application)));
  const std::string product = put(fmt::format("PRODUCT('Bored block','Bored block','',({}))",
                                              put(fmt::format("PRODUCT_CONTEXT('',{},'mechanical')", application))));
  const std::string formation = put(fmt::format("PRODUCT_DEFINITION_FORMATION('','',{})", product));
  const std::string design = put(fmt::format("PRODUCT_DEFINITION_CONTEXT('part definition',{},'design')", application));
  const std::string definition = put(fmt::format("PRODUCT_DEFINITION('design','',{},{})", formation, design));
  const std::string defined = put(fmt::format("PRODUCT_DEFINITION_SHAPE('','',{})", definition));
  static_cast<void>(put(fmt::format("SHAPE_DEFINITION_REPRESENTATION({},{})", defined, shape)));
  return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','2026-01-01T00:00:00',(''),(''),'','','')"
         ";"
         "\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n" +
         data + "ENDSEC;\nEND-ISO-10303-21;\n";
}

}  // namespace argil::samples
