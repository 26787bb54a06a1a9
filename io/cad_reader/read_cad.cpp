// STEP and IGES, by OpenCASCADE.

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <NCollection_DataMap.hxx>
#include <Poly_Triangulation.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TDF_Label.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Shape.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "clay/base/error.h"
#include "io/bytes/empty_objects.h"
#include "io/cad_reader/face_form.h"
#include "io/cad_reader/read_cad.h"
#include "io/reader/mesh_data.h"
#include "io/reader/reader.h"

namespace argil::io::reader {

namespace {

constexpr double kDeflection = 2e-4;  // of the model's diagonal: how far triangles lie off the faces
constexpr double kAngle = 0.06;       // radians between two triangles of a curve: a cylinder loses 0.06 % of its volume
constexpr double kSewing = 1e-3;      // of the diagonal: loose faces whose edges are that near become one shell
constexpr int kMostDepth = 64;        // of assemblies
constexpr Bytes4 kWhite{255, 255, 255, 255};

Bytes4 bytesOf(const Quantity_Color& colour) {
  return {srgbByte(colour.Red()), srgbByte(colour.Green()), srgbByte(colour.Blue()), 255};
}

std::string nameOf(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return {};
  std::string text(size_t(name->Get().LengthOfCString()) + 1, '\0');
  Standard_PCharacter at = text.data();
  text.resize(size_t(name->Get().ToUTF8CString(at)));
  return text;
}

class Model {
 public:
  Model(const Handle(TDocStd_Document) & document, Sender& sender)
      : shapes_(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
        colours_(XCAFDoc_DocumentTool::ColorTool(document->Main())),
        sender_(sender) {}

  void send(bool sew) {
    TDF_LabelSequence free;
    shapes_->GetFreeShapes(free);
    Bnd_Box box;
    bool faces = false;
    for (int i = 1; i <= free.Length(); ++i) {
      const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(free(i));
      BRepBndLib::Add(shape, box);
      faces = faces || TopExp_Explorer(shape, TopAbs_FACE).More();
    }
    if (!faces || box.IsVoid()) throw Error("holds no faces; check what was exported");
    diagonal_ = std::sqrt(box.SquareExtent());
    if (!(std::isfinite(diagonal_) && diagonal_ > 0)) throw Error("has faces without a size; export it again");
    for (int i = 1; i <= free.Length(); ++i) visit(free(i), TopLoc_Location(), nameOf(free(i)), std::nullopt, 0);
    if (sew) sewLoose();
    for (Part& part : parts_) mesh(part);
    if (sent_ == 0) throw Error("holds no faces that could be made triangles; export it again");
    // IGES has each of its curves as a part.
    if (!sew && !empty_.empty()) sender_.note(emptyObjects(empty_));
    if (skipped_ > 0) sender_.note(std::to_string(skipped_) + " faces could not be made triangles and are not kept");
  }

 private:
  using Colours = NCollection_DataMap<TopoDS_Shape, Bytes4, TopTools_ShapeMapHasher>;
  struct Part {
    TopoDS_Shape shape;  // not in its place yet
    TopLoc_Location place;
    std::string name;
    std::optional<Bytes4> colour;
    Colours inner;  // of what is within the shape: solids, shells, faces
  };
  struct Face {
    TopoDS_Face face;
    uint32_t solid;  // from 1; 0: in none
    std::optional<Bytes4> colour;
  };

  // The label's own colour: of surfaces before the general one.
  std::optional<Bytes4> colourOf(const TDF_Label& label) const {
    Quantity_Color colour;
    for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
      if (colours_->GetColor(label, type, colour)) return bytesOf(colour);
    return std::nullopt;
  }

  // All faces, in order. A colour of a face goes before one of its shell, and that before one of its solid.
  static std::vector<Face> facesOf(const Part& part) {
    struct Open {
      TopoDS_Shape shape;
      uint32_t solid;
      std::optional<Bytes4> colour;
    };
    std::vector<Face> faces;
    std::vector<Open> open{{part.shape, 0, std::nullopt}};
    uint32_t solids = 0;
    while (!open.empty()) {
      Open at = std::move(open.back());
      open.pop_back();
      if (const Bytes4* own = part.inner.Seek(at.shape)) at.colour = *own;
      if (at.shape.ShapeType() == TopAbs_FACE) {
        faces.push_back({TopoDS::Face(at.shape), at.solid, at.colour});
        continue;
      }
      if (at.shape.ShapeType() == TopAbs_SOLID) at.solid = ++solids;
      if (at.shape.ShapeType() > TopAbs_FACE) continue;  // edges, vertices
      const auto first = std::ptrdiff_t(open.size());
      for (TopoDS_Iterator child(at.shape); child.More(); child.Next())
        open.push_back({child.Value(), at.solid, at.colour});
      std::reverse(open.begin() + first, open.end());
    }
    return faces;
  }

  void visit(const TDF_Label& label, const TopLoc_Location& place, std::string name, std::optional<Bytes4> colour,
             int depth) {
    if (depth > kMostDepth) throw Error("has assemblies within assemblies without end; export it again");
    const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
    if (shape.IsNull()) return;
    if (!colour) colour = colourOf(label);
    if (!XCAFDoc_ShapeTool::IsAssembly(label)) {
      Colours inner;
      TDF_LabelSequence coloured;
      XCAFDoc_ShapeTool::GetSubShapes(label, coloured);
      for (int i = 1; i <= coloured.Length(); ++i)
        if (const auto own = colourOf(coloured(i))) inner.Bind(XCAFDoc_ShapeTool::GetShape(coloured(i)), *own);
      parts_.push_back({shape, place, std::move(name), colour, std::move(inner)});
      return;
    }
    TDF_LabelSequence components;
    XCAFDoc_ShapeTool::GetComponents(label, components);
    for (int i = 1; i <= components.Length(); ++i) {
      TDF_Label of;
      if (!XCAFDoc_ShapeTool::GetReferredShape(components(i), of)) continue;
      const std::string component = nameOf(of).empty() ? nameOf(components(i)) : nameOf(of);
      const std::optional<Bytes4> given = colour ? colour : colourOf(components(i));
      visit(of, place * XCAFDoc_ShapeTool::GetLocation(components(i)), component.empty() ? name : component, given,
            depth + 1);
    }
  }

  // Faces that belong to no solid, as IGES has them: those whose edges lie close together become shells.
  void sewLoose() {
    BRepBuilderAPI_Sewing sewing(kSewing * diagonal_);
    std::vector<Part> solid;
    std::vector<Face> loose;
    Part sewn;
    for (Part& part : parts_) {
      if (TopExp_Explorer(part.shape, TopAbs_SOLID).More()) {
        solid.push_back(std::move(part));
        continue;
      }
      for (Face& face : facesOf(part)) {
        face.face.Move(part.place);
        if (!face.colour) face.colour = part.colour;
        sewing.Add(face.face);
        loose.push_back(std::move(face));
      }
      if (!sewn.colour) sewn.colour = part.colour;
      if (sewn.name.empty()) sewn.name = part.name;
    }
    parts_ = std::move(solid);
    if (loose.empty()) return;
    sewing.Perform();
    sewn.shape = sewing.SewedShape();
    for (const Face& face : loose)
      if (face.colour) sewn.inner.Bind(sewing.Modified(face.face), *face.colour);
    parts_.push_back(std::move(sewn));
    sender_.note((loose.size() == 1 ? "1 loose face was" : std::to_string(loose.size()) + " loose faces were") +
                 std::string(" sewn together, ") + std::to_string(sewing.NbFreeEdges()) + " of their edges stay open");
  }

  // All faces of a part as one mesh, whose vertices on shared edges are one; solids that touch stay apart.
  void mesh(Part& part) {
    if (part.shape.IsNull()) return;
    BRepMesh_IncrementalMesh mesher(part.shape, kDeflection * diagonal_, Standard_False, kAngle, Standard_False);
    MeshData data;
    data.colour = part.colour;
    const std::vector<Face> faces = facesOf(part);
    const bool coloured = std::ranges::any_of(faces, [&](const Face& each) { return each.colour.has_value(); });
    std::map<std::pair<uint32_t, std::array<double, 3>>, uint32_t> known;
    for (const Face& each : faces) {
      const TopoDS_Face face = TopoDS::Face(each.face.Moved(part.place));
      TopLoc_Location place;
      const Handle(Poly_Triangulation) triangles = BRep_Tool::Triangulation(face, place);
      if (triangles.IsNull()) {
        ++skipped_;
        continue;
      }
      std::vector<uint32_t> of(size_t(triangles->NbNodes()));
      for (int i = 1; i <= triangles->NbNodes(); ++i) {
        const gp_Pnt p = triangles->Node(i).Transformed(place.Transformation());
        const std::array<double, 3> key{p.X(), p.Y(), p.Z()};
        const auto [found, fresh] = known.try_emplace({each.solid, key}, uint32_t(data.positions.size()));
        if (fresh) data.positions.push_back(key);
        of[size_t(i) - 1] = found->second;
      }
      if (const auto found = formOf(face, diagonal_)) data.faces.push_back(*found);
      const bool turned = face.Orientation() == TopAbs_REVERSED;
      for (int i = 1; i <= triangles->NbTriangles(); ++i) {
        int a = 0, b = 0, c = 0;
        triangles->Triangle(i).Get(a, b, c);
        if (turned) std::swap(b, c);
        const std::array<uint32_t, 3> t{of.at(size_t(a) - 1), of.at(size_t(b) - 1), of.at(size_t(c) - 1)};
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        data.triangles.push_back(t);
        if (coloured) data.triangleColours.push_back(each.colour.value_or(part.colour.value_or(kWhite)));
      }
    }
    if (data.triangles.empty()) {
      empty_.push_back(part.name);
      return;
    }
    simplifyColours(data);
    sendMesh(data, part.name, sender_);
    ++sent_;
  }

  // Where all triangles are of one colour it is that of the whole.
  static void simplifyColours(MeshData& data) {
    std::vector<Bytes4>& all = data.triangleColours;
    if (all.empty() || std::ranges::any_of(all, [&](const Bytes4& each) { return each != all.front(); })) return;
    data.colour = all.front();
    all.clear();
  }

  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colours_;
  Sender& sender_;
  double diagonal_ = 0;
  std::vector<Part> parts_;
  std::vector<std::string> empty_;  // names of parts without triangles
  uint64_t sent_ = 0, skipped_ = 0;
};

template <class Reader>
void read(const char* format, bool sew, Sender& sender, const auto& open) {
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  Reader reader;
  reader.SetColorMode(Standard_True);
  reader.SetNameMode(Standard_True);
  if (open(reader) != IFSelect_RetDone) throw Error(std::string("cannot be read as ") + format + "; export it again");
  if (!reader.Transfer(document)) throw Error("holds nothing that could be read; check what was exported");
  sender.text(wire::Kind::format, format);
  Model(document, sender).send(sew);
}

}  // namespace

void readCad(const std::filesystem::path& file, Sender& sender) {
  // What it has to say would go to standard output, which is the wire.
  Message::DefaultMessenger()->ChangePrinters().Clear();
  const std::vector<unsigned char> content = contentOf(file);
  // The library takes a byte order mark for a word. Of IGES it reads files alone, whose columns the mark moves.
  constexpr std::string_view kMark = "\xef\xbb\xbf", kStep = "ISO-10303-21;";
  std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
  const bool marked = text.starts_with(kMark);
  if (marked) text.remove_prefix(kMark.size());
  const auto open = [&](auto& reader) { return reader.ReadFile(file.c_str()); };
  try {
    if (text.starts_with(kStep) && marked) {
      std::istringstream stream{std::string(text)};
      read<STEPCAFControl_Reader>("STEP", false, sender,
                                  [&](auto& reader) { return reader.ChangeReader().ReadStream(file.c_str(), stream); });
    } else if (text.starts_with(kStep)) {
      read<STEPCAFControl_Reader>("STEP", false, sender, open);
    } else if (marked) {
      throw Error("begins with a byte order mark, which moves the columns of IGES; save it as plain ASCII");
    } else {
      read<IGESCAFControl_Reader>("IGES", true, sender, open);
    }
  } catch (const Standard_Failure& failure) {
    throw Error(std::string("is damaged (") + failure.GetMessageString() + "); export it again");
  }
}

}  // namespace argil::io::reader
