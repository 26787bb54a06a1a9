#include "io/cad/step_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "clay/base/error.h"

namespace argil::io {

namespace {

constexpr size_t kChunk = 1 << 20;

// Text as ISO 10303-21 has it: apostrophes twice, and what is not ASCII in hexadecimal UTF-16 between \X2\ and \X0\.
std::string quoted(const std::string& text) {
  std::string out = "'";
  bool wide = false;
  const auto leave = [&] {
    if (wide) out += "\\X0\\";
    wide = false;
  };
  for (size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const size_t length = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
    uint32_t code = length == 1 ? lead : lead & (0xffu >> (length + 1));
    for (size_t k = 1; k < length && i + k < text.size(); ++k)
      code = code << 6 | (static_cast<unsigned char>(text[i + k]) & 0x3fu);
    i += length;
    if (code >= 0x20 && code < 0x7f) {
      leave();
      out += static_cast<char>(code);
      if (code == '\'' || code == '\\') out += static_cast<char>(code);
      continue;
    }
    if (code < 0x20) continue;
    if (!wide) out += "\\X2\\";
    wide = true;
    if (code >= 0x10000) {
      code -= 0x10000;
      out += fmt::format("{:04X}{:04X}", 0xd800 + (code >> 10), 0xdc00 + (code & 0x3ff));
    } else {
      out += fmt::format("{:04X}", code);
    }
  }
  leave();
  return out + "'";
}

class Writer {
 public:
  Writer(AtomicFile& file, Job* job) : file_(file), job_(job) {}

  // A line of the data section; its number.
  template <class... Parts>
  size_t entity(fmt::format_string<Parts...> format, Parts&&... parts) {
    fmt::format_to(std::back_inserter(text_), "#{}=", ++last_);
    fmt::format_to(std::back_inserter(text_), format, std::forward<Parts>(parts)...);
    text_ += ";\n";
    if (text_.size() >= kChunk) flush();
    return last_;
  }
  size_t point(const Vec3d& p) {
    fmt::format_to(std::back_inserter(text_), "#{}=CARTESIAN_POINT('',(", ++last_);
    for (int i = 0; i < 3; ++i) {
      if (i > 0) text_ += ',';
      appendReal(text_, p[i]);
    }
    text_ += "));\n";
    if (text_.size() >= kChunk) flush();
    return last_;
  }
  void raw(std::string_view text) { text_ += text; }
  void flush() {
    file_.write(std::as_bytes(std::span(text_)));
    text_.clear();
  }
  void step(double fraction) const {
    if (job_) job_->step(fraction);
  }

 private:
  AtomicFile& file_;
  Job* job_;
  std::string text_;
  size_t last_ = 0;
};

std::string listOf(const std::vector<size_t>& numbers) {
  std::string out = "(";
  for (const size_t each : numbers) fmt::format_to(std::back_inserter(out), "{}#{}", out.size() > 1 ? "," : "", each);
  return out + ")";
}

// Along one side, and along both: how often each knot is there, and where.
struct Knots {
  std::string curve, surface;
};
const Knots& knots() {
  static const Knots made = [] {
    std::string often = "(4", where = "(0.";
    for (int i = 1; i <= clay::kPatchSpans; ++i) {
      often += i < clay::kPatchSpans ? ",2" : ",4";
      where += fmt::format(",{}.", i);
    }
    often += ")";
    where += ")";
    return Knots{often + "," + where, often + "," + often + "," + where + "," + where};
  }();
  return made;
}

// A solid for each body of it, with its cavities.
std::vector<size_t> writeBody(Writer& out, const CadBody& body, double from, double to) {
  const clay::PatchSurface& surface = *body.surface;
  const clay::QuadTopology topology(surface.cage.positions.size(), surface.cage.quads);
  std::vector<size_t> points(surface.points.size());
  for (size_t i = 0; i < points.size(); ++i) points[i] = out.point(body.pose * surface.points[i]);
  out.step(from + 0.5 * (to - from));
  std::vector<size_t> vertices(topology.vertexCount());
  for (size_t v = 0; v < vertices.size(); ++v) vertices[v] = out.entity("VERTEX_POINT('',#{})", points[v]);
  std::vector<size_t> edges;
  for (const clay::QuadTopology::Edge& edge : topology.edges()) {
    std::vector<size_t> along;
    for (int p = 0; p < clay::kPatchPoints; ++p) {
      const auto [i, j] = clay::fromCorner(edge.side[0], p, 0, clay::kPatchPoints);
      along.push_back(points[surface.patches[edge.quad[0]][size_t(i)][size_t(j)]]);
    }
    const size_t curve = out.entity("B_SPLINE_CURVE_WITH_KNOTS('',3,{},.UNSPECIFIED.,.F.,.F.,{},.UNSPECIFIED.)",
                                    listOf(along), knots().curve);
    edges.push_back(out.entity("EDGE_CURVE('',#{},#{},#{},.T.)", vertices[edge.from], vertices[edge.to], curve));
  }
  std::vector<size_t> faces;
  for (uint32_t f = 0; f < surface.patches.size(); ++f) {
    std::string net = "(";
    for (const auto& row : surface.patches[f]) {
      std::vector<size_t> numbers;
      for (const uint32_t each : row) numbers.push_back(points[each]);
      net += (net.size() > 1 ? "," : "") + listOf(numbers);
    }
    const size_t patch = out.entity(
        "B_SPLINE_SURFACE_WITH_KNOTS('',3,3,{}),.UNSPECIFIED.,.F.,.F.,.F.,{},.UNSPECIFIED.)", net, knots().surface);
    std::vector<size_t> sides;
    for (int s = 0; s < 4; ++s) {
      const uint32_t edge = topology.edgeOf(f, s);
      const bool forward = topology.edges()[edge].quad[0] == f && topology.edges()[edge].side[0] == s;
      sides.push_back(out.entity("ORIENTED_EDGE('',*,*,#{},{})", edges[edge], forward ? ".T." : ".F."));
    }
    const size_t loop = out.entity("EDGE_LOOP('',{})", listOf(sides));
    const size_t bound = out.entity("FACE_OUTER_BOUND('',#{},.T.)", loop);
    faces.push_back(out.entity("ADVANCED_FACE('',(#{}),#{},.T.)", bound, patch));
  }
  const auto closed = [&](const std::vector<uint32_t>& quads) {
    std::vector<size_t> own;
    for (const uint32_t f : quads) own.push_back(faces[f]);
    return out.entity("CLOSED_SHELL('',{})", listOf(own));
  };
  std::vector<size_t> solids;
  for (const CadSolid& solid : solidsOf(surface, topology)) {
    std::vector<size_t> cavities;
    for (const std::vector<uint32_t>& each : solid.cavities)
      cavities.push_back(out.entity("ORIENTED_CLOSED_SHELL('',*,#{},.T.)", closed(each)));
    const size_t outer = closed(solid.outer);
    solids.push_back(cavities.empty()
                         ? out.entity("MANIFOLD_SOLID_BREP({},#{})", quoted(body.name), outer)
                         : out.entity("BREP_WITH_VOIDS({},#{},{})", quoted(body.name), outer, listOf(cavities)));
  }
  out.step(to);
  return solids;
}

}  // namespace

void writeStep(AtomicFile& file, const std::string& name, std::span<const CadBody> bodies, Job* job) {
  if (bodies.empty()) throw Error("there is nothing to write");
  Writer out(file, job);
  out.raw(
      fmt::format("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME({},'',(''),(''),'Argil','Argil',"
                  "'');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));\nENDSEC;\nDATA;\n",
                  quoted(name)));
  const size_t application = out.entity("APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
  (void)out.entity("APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#{})",
                   application);
  const size_t context = out.entity("PRODUCT_CONTEXT('',#{},'mechanical')", application);
  const size_t definitionContext =
      out.entity("PRODUCT_DEFINITION_CONTEXT('part definition',#{},'design')", application);
  const size_t length = out.entity("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
  const size_t angle = out.entity("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
  const size_t solid = out.entity("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
  const size_t fine = out.entity(
      "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),#{},'distance_accuracy_value','confusion accuracy')",
      length);
  const size_t space = out.entity(
      "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{}))GLOBAL_UNIT_ASSIGNED_CONTEXT((#{},"
      "#{},#"
      "{}))REPRESENTATION_CONTEXT('','3D'))",
      fine, length, angle, solid);
  const size_t origin = out.point(Vec3d::Zero());
  const size_t z = out.entity("DIRECTION('',(0.,0.,1.))"), x = out.entity("DIRECTION('',(1.,0.,0.))");
  const size_t axes = out.entity("AXIS2_PLACEMENT_3D('',#{},#{},#{})", origin, z, x);

  std::vector<size_t> styles;
  for (size_t i = 0; i < bodies.size(); ++i) {
    const CadBody& body = bodies[i];
    const std::vector<size_t> solids =
        writeBody(out, body, double(i) / double(bodies.size()), double(i + 1) / double(bodies.size()));
    const size_t product = out.entity("PRODUCT({0},{0},'',(#{1}))", quoted(body.name), context);
    (void)out.entity("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{}))", product);
    const size_t formation = out.entity("PRODUCT_DEFINITION_FORMATION('','',#{})", product);
    const size_t definition = out.entity("PRODUCT_DEFINITION('design','',#{},#{})", formation, definitionContext);
    const size_t shape = out.entity("PRODUCT_DEFINITION_SHAPE('','',#{})", definition);
    std::vector<size_t> items{axes};
    items.insert(items.end(), solids.begin(), solids.end());
    const size_t representation =
        out.entity("ADVANCED_BREP_SHAPE_REPRESENTATION({},{},#{})", quoted(body.name), listOf(items), space);
    (void)out.entity("SHAPE_DEFINITION_REPRESENTATION(#{},#{})", shape, representation);
    if (!body.colour) continue;
    std::string rgb;
    for (const float each : *body.colour) {
      rgb += ',';
      appendReal(rgb, double(each));
    }
    const size_t colour = out.entity("COLOUR_RGB(''{})", rgb);
    const size_t fill = out.entity("FILL_AREA_STYLE_COLOUR('',#{})", colour);
    const size_t area = out.entity("FILL_AREA_STYLE('',(#{}))", fill);
    const size_t style = out.entity("SURFACE_STYLE_FILL_AREA(#{})", area);
    const size_t side = out.entity("SURFACE_SIDE_STYLE('',(#{}))", style);
    const size_t usage = out.entity("SURFACE_STYLE_USAGE(.BOTH.,#{})", side);
    const size_t assigned = out.entity("PRESENTATION_STYLE_ASSIGNMENT((#{}))", usage);
    for (const size_t brep : solids) styles.push_back(out.entity("STYLED_ITEM('',(#{}),#{})", assigned, brep));
  }
  if (!styles.empty())
    (void)out.entity("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{},#{})", listOf(styles), space);
  out.raw("ENDSEC;\nEND-ISO-10303-21;\n");
  out.flush();
}

}  // namespace argil::io
