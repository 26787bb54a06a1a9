#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "io/models/mesh_file.h"
#include "io/models/model_file.h"
#include "tests/support/package_samples.h"

namespace argil::io {
namespace {

using samples::bytesOf;
using samples::errorOf;
using samples::tetrahedronXml;
using samples::threeMf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr Colour kRed{255, 0, 0, 255}, kGreen{0, 255, 0, 255}, kBlue{0, 0, 255, 128}, kWhite{};

ModelFile parse(const std::string& bytes) {
  return parseModel(bytesOf(bytes), "a.3mf");
}

std::string inResources(const std::string& resources, const std::string& build = "<item objectid=\"1\"/>") {
  return "<resources>" + resources + "</resources><build>" + build + "</build>";
}

std::string tetrahedron(const std::string& attributes = "id=\"1\"") {
  return "<object " + attributes + ">" + tetrahedronXml() + "</object>";
}

void expectRefused(const std::string& bytes, const char* because) {
  const std::string error = errorOf([&] { (void)parse(bytes); });
  EXPECT_THAT(error, StartsWith("a.3mf: "));
  EXPECT_THAT(error, HasSubstr(because));
}

TEST(ThreeMfRead, AMeshWithNameUnitAndMetadata) {
  const ModelFile file = parse(threeMf("<metadata name=\"Title\">A &amp; B</metadata><metadata name=\"Rating\"/>" +
                                           inResources(tetrahedron("id=\"1\" name=\"tetra\"")),
                                       "unit=\"inch\""));
  EXPECT_EQ(file.format, "3MF");
  EXPECT_EQ(file.unitMm, 25.4);
  EXPECT_EQ(file.faces, 4u);
  EXPECT_THAT(file.notes, IsEmpty());
  EXPECT_THAT(file.metadata, ElementsAre(std::pair<std::string, std::string>("Title", "A & B")));
  ASSERT_EQ(file.objects.size(), 1u);
  const ModelObject& object = file.objects[0];
  EXPECT_EQ(object.name, "tetra");
  EXPECT_THAT(object.mesh.positions, ElementsAre(Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)));
  EXPECT_EQ(object.mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}));
  EXPECT_FALSE(object.colour);
  EXPECT_TRUE(object.triangleColours.empty() && object.vertexColours.empty());
}

TEST(ThreeMfRead, TheUnitIsMillimetresWhereNoneIsGiven) {
  EXPECT_EQ(parse(threeMf(inResources(tetrahedron()), "")).unitMm, 1.0);
  EXPECT_EQ(parse(threeMf(inResources(tetrahedron()), "unit=\"micron\"")).unitMm, 0.001);
  expectRefused(threeMf(inResources(tetrahedron()), "unit=\"cubit\""), "cubit");
}

// (x, y, z) -> (2x, 3y, z) -> + (10, 20, 30): the component's transform goes first.
TEST(ThreeMfRead, TransformsOfItemsAndComponentsAreApplied) {
  const std::string parts =
      tetrahedron() +
      "<object id=\"2\" name=\"pair\"><components><component objectid=\"1\" transform=\"2 0 0 0 3 0 0 0 1 0 0 0\"/>"
      "<component objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/></components></object>";
  const ModelFile file =
      parse(threeMf(inResources(parts,
                                "<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 10 20 30\"/><item objectid=\"1\" "
                                "transform=\" 0 1 0  0 0 1 1 0 0 0 0 0 \"/>")));
  ASSERT_EQ(file.objects.size(), 3u);
  EXPECT_EQ(file.faces, 12u);
  EXPECT_EQ(file.objects[0].name, "pair");
  EXPECT_THAT(file.objects[0].mesh.positions,
              ElementsAre(Vec3d(10, 20, 30), Vec3d(12, 20, 30), Vec3d(10, 23, 30), Vec3d(10, 20, 31)));
  EXPECT_THAT(file.objects[1].mesh.positions,
              ElementsAre(Vec3d(10, 20, 30), Vec3d(9, 20, 30), Vec3d(10, 21, 30), Vec3d(10, 20, 31)));
  EXPECT_EQ(file.objects[1].mesh.triangles[0], (std::array<uint32_t, 3>{0, 1, 2})) << "a mirror turns triangles";
  EXPECT_THAT(file.objects[2].mesh.positions,
              ElementsAre(Vec3d(0, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(1, 0, 0)));
  EXPECT_EQ(file.objects[2].mesh.triangles[0], (std::array<uint32_t, 3>{0, 2, 1}));
}

TEST(ThreeMfRead, OtherPartsOfThePackage) {
  const std::string other = samples::modelXml("<resources>" + tetrahedron("id=\"7\"") + "</resources><build/>");
  const std::string inside = inResources(
      "<object id=\"1\"><components><component objectid=\"7\" p:path=\"/3D/Objects/a.model\"/></components></object>",
      "<item objectid=\"1\"/><item objectid=\"7\" p:path=\"/3D/Objects/a.model\" transform=\"1 0 0 0 1 0 0 0 1 5 0 "
      "0\"/>");
  const ModelFile file = parse(threeMf(inside, "requiredextensions=\"p\"", {{"3D/Objects/a.model", other}}));
  ASSERT_EQ(file.objects.size(), 2u);
  EXPECT_EQ(file.objects[1].mesh.positions[1], Vec3d(6, 0, 0));
  expectRefused(threeMf(inside), "has no part \"/3D/Objects/a.model\"");
  expectRefused(threeMf(inside, "unit=\"inch\"", {{"3D/Objects/a.model", other}}), "its unit is another");
}

TEST(ThreeMfRead, ColoursOfObjectsTrianglesAndCorners) {
  const std::string groups =
      "<basematerials id=\"5\"><base name=\"a\" displaycolor=\"#FF0000\"/><base name=\"b\" "
      "displaycolor=\"#0000FF80\"/></basematerials>"
      "<m:colorgroup id=\"6\"><m:color color=\"#FF0000\"/><m:color color=\"#00FF00FF\"/><m:color "
      "color=\"#0000ff80\"/></m:colorgroup>";
  const auto of = [&](const std::string& attributes, const std::vector<std::string>& triangles) {
    const ModelFile file = parse(threeMf(
        inResources(groups + "<object id=\"1\" " + attributes + ">" + tetrahedronXml(triangles) + "</object>")));
    EXPECT_THAT(file.notes, IsEmpty());
    return file.objects.at(0);
  };
  EXPECT_EQ(of("pid=\"5\" pindex=\"1\"", {"", "", "", ""}).colour, kBlue);
  const ModelObject byTriangle =
      of("pid=\"5\" pindex=\"1\"", {"", "pid=\"6\" p1=\"1\"", "p1=\"0\"", "pid=\"6\" p1=\"1\" p2=\"1\" p3=\"1\""});
  EXPECT_THAT(byTriangle.triangleColours, ElementsAre(kBlue, kGreen, kRed, kGreen));
  EXPECT_EQ(byTriangle.colour, kBlue);
  // Vertices 0 and 2 red, 1 green, 3 blue.
  const ModelObject byVertex =
      of("pid=\"6\" pindex=\"0\"", {"p1=\"0\" p2=\"0\" p3=\"1\"", "p1=\"0\" p2=\"1\" p3=\"2\"",
                                    "p1=\"0\" p2=\"2\" p3=\"0\"", "p1=\"1\" p2=\"0\" p3=\"2\""});
  EXPECT_THAT(byVertex.vertexColours, ElementsAre(kRed, kGreen, kRed, kBlue));
  EXPECT_TRUE(byVertex.triangleColours.empty());
  EXPECT_TRUE(of("", {"p1=\"0\"", "", "", ""}).triangleColours.empty()) << "no group is named";
}

TEST(ThreeMfRead, WhatIsNotKeptIsANote) {
  const std::string groups =
      "<m:colorgroup id=\"6\"><m:color color=\"#FF0000\"/><m:color color=\"#00FF00FF\"/></m:colorgroup>"
      "<m:texture2d id=\"8\" path=\"/a.png\" contenttype=\"image/png\"/><m:texture2dgroup id=\"9\" "
      "texid=\"8\"><m:tex2coord u=\"0\" v=\"0\"/></m:texture2dgroup>";
  // Vertex 0 is red in one triangle and green in another, which a vertex alone cannot say.
  const std::string mixed = "<object id=\"1\">" +
                            tetrahedronXml({"pid=\"6\" p1=\"0\" p2=\"1\" p3=\"1\"", "pid=\"6\" p1=\"1\"",
                                            "pid=\"9\" p1=\"0\"", "pid=\"6\" p1=\"77\""}) +
                            "</object>";
  const ModelFile file = parse(threeMf(inResources(groups + mixed + tetrahedron("id=\"2\" type=\"support\""),
                                                   "<item objectid=\"1\"/><item objectid=\"2\"/>")));
  ASSERT_EQ(file.objects.size(), 1u);
  EXPECT_THAT(file.notes, ElementsAre(HasSubstr("1 colour is named"), HasSubstr("1 object is no model"),
                                      HasSubstr("the picture \"/a.png\" is not in the file")));
  // A vertex for each colour that a corner has in one place.
  const ModelObject& object = file.objects[0];
  EXPECT_TRUE(object.triangleColours.empty());
  const Colour wanted[4][3] = {
      {kRed, kGreen, kGreen}, {kGreen, kGreen, kGreen}, {kWhite, kWhite, kWhite}, {kWhite, kWhite, kWhite}};
  for (size_t t = 0; t < 4; ++t)
    for (size_t k = 0; k < 3; ++k) EXPECT_EQ(object.vertexColours.at(object.mesh.triangles[t][k]), wanted[t][k]);
  EXPECT_EQ(object.mesh.positions.size(), 9u);
  EXPECT_TRUE(clay::checkTopology(clay::weldExact(object.mesh)).closed());
}

TEST(ThreeMfRead, WhatTheModelNeedsAndIsNotKnownIsRefused) {
  const std::string beams =
      "requiredextensions=\"b\" xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\"";
  expectRefused(threeMf(inResources(tetrahedron()), beams), "needs beam lattices");
  expectRefused(threeMf(inResources(tetrahedron()), "requiredextensions=\"m p q\" xmlns:q=\"urn:q\""), "urn:q");
  expectRefused(threeMf(inResources(tetrahedron()), "requiredextensions=\"q\""), "\"q\"");
  EXPECT_EQ(parse(threeMf(inResources(tetrahedron()), "requiredextensions=\" m  p \"")).faces, 4u);
}

TEST(ThreeMfRead, BrokenModelsAreRefusedWithTheirReason) {
  expectRefused(threeMf("<build/>"), "no <resources>");
  expectRefused(threeMf("<resources/>"), "no <build>");
  expectRefused(threeMf(inResources("")), "object 1 is used and not there");
  expectRefused(threeMf(inResources(tetrahedron(), "")), "holds no triangles");
  expectRefused(threeMf(inResources(tetrahedron() + tetrahedron())), "stands twice");
  expectRefused(threeMf(inResources("<object/>")), "has no id");
  expectRefused(threeMf(inResources(tetrahedron("id=\"-1\""))), "not negative");
  expectRefused(threeMf(inResources(tetrahedron(), "<item objectid=\"1\" transform=\"1 0 0\"/>")),
                "number of a transform");
  expectRefused(threeMf(inResources(tetrahedron(), "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0 0 0\"/>")),
                "more than 12");
  expectRefused(threeMf(inResources(
                    tetrahedron(), "<item objectid=\"1\" transform=\"1e308 0 0 1e308 1 0 0 0 1 1e308 1e308 1e308\"/>")),
                "beyond all numbers");
  const auto mesh = [](const std::string& vertex, const std::string& triangle) {
    return threeMf(inResources(
        "<object id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"1\" z=\"0\"/>" + vertex +
        "</vertices><triangles>" + triangle + "</triangles></mesh></object>"));
  };
  const std::string vertex = "<vertex x=\"1\" y=\"0\" z=\"0\"/>", triangle = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>";
  EXPECT_EQ(parse(mesh(vertex, triangle)).faces, 1u);
  expectRefused(mesh("<vertex x=\"nan\" y=\"0\" z=\"0\"/>", triangle), "only finite");
  expectRefused(mesh("<vertex x=\"1e999\" y=\"0\" z=\"0\"/>", triangle), "only finite");
  expectRefused(mesh("<vertex x=\"1,5\" y=\"0\" z=\"0\"/>", triangle), "a number is needed");
  expectRefused(mesh("<vertex x=\"1\" y=\"0\"/>", triangle), "no x, y and z");
  expectRefused(mesh(vertex, "<triangle v1=\"0\" v2=\"1\"/>"), "no v1, v2 and v3");
  expectRefused(mesh(vertex, "<triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"), "names vertex 3");
  expectRefused(mesh(vertex, "<triangle v1=\"0\" v2=\"1\" v3=\"99999999999\"/>"), "not negative");
}

TEST(ThreeMfRead, ObjectsInObjectsEndSomewhere) {
  const std::string cycle =
      "<object id=\"1\"><components><component objectid=\"2\"/></components></object><object "
      "id=\"2\"><components><component objectid=\"1\"/></components></object>";
  expectRefused(threeMf(inResources(cycle)), "contains itself");
  std::string doubled = tetrahedron("id=\"100\"");
  for (int i = 30; i >= 1; --i) {
    const std::string component = "<component objectid=\"" + std::to_string(i == 30 ? 100 : i + 1) + "\"/>";
    doubled +=
        "<object id=\"" + std::to_string(i) + "\"><components>" + component + component + "</components></object>";
  }
  expectRefused(threeMf(inResources(doubled)), "places more than");
  // 64 objects within each other, the mesh among them, are the most.
  const auto nested = [](int outer) {
    std::string deep = tetrahedron("id=\"100\"");
    for (int i = outer; i >= 1; --i)
      deep += "<object id=\"" + std::to_string(i) + "\"><components><component objectid=\"" +
              std::to_string(i == outer ? 100 : i + 1) + "\"/></components></object>";
    return threeMf(inResources(deep));
  };
  EXPECT_EQ(parseModel(bytesOf(nested(63)), "a.3mf").objects.size(), 1u);
  expectRefused(nested(64), "deep");
  expectRefused(nested(70), "deep");
}

TEST(ThreeMfRead, PackagesWithoutAModelAreRefused) {
  expectRefused(samples::zip({{"_rels/.rels", "<a/>"}, {"3D/3dmodel.model", ""}}), "no relationships");
  expectRefused(samples::zip({{"a.txt", ""}}), "has no part \"_rels/.rels\"");
  expectRefused(samples::zip({{"_rels/.rels", samples::kRelations}}), "has no part \"/3D/3dmodel.model\"");
  const std::string error = errorOf([] { (void)parseModel(bytesOf(samples::zip({{"a.txt", ""}})), "a.zip"); });
  EXPECT_THAT(error, HasSubstr("ZIP archive"));
  EXPECT_EQ(parseModel(bytesOf(threeMf(inResources(tetrahedron()))), "a.zip").format, "3MF") << "the content decides";
}

struct Real {
  const char* name;
  size_t objects;
  uint64_t triangles;
  Vec3d least, most;  ///< After the transforms of the build.
};

// Triangles from the list that came with the data; boxes from the XML by a script, or by hand.
TEST(ThreeMfRead, RealFiles) {
  const char* root = std::getenv("ARGIL_DATA");
  if (root == nullptr) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const std::filesystem::path data = std::filesystem::path(root) / "3mf";
  const Real real[] = {
      {"box.3mf", 1, 12, {0, 0, 0}, {10, 20, 30}},
      {"box_prod.3mf", 1, 12, {35, 33, 16.92}, {45, 53, 46.92}},
      {"dodeca_chain_loop_color.3mf", 1, 7680, {1.58698, 3.96245, 1.59398}, {221.461, 144.637, 17.594}},
      {"heartgears.3mf", 1, 30636, {0.00118637, 0.00637054, 0.00279617}, {79.5723, 47.6736, 76.435}},
      // x' = 1.25 z, y' = x, z' = 1.666667 y of a step of 20 × 18 × 32, and the same moved by (30, 40, 0).
      {"MUSTPASS_Chapter3.2c_MultipleItemsTransform.3mf", 2, 60, {0, 0, 0}, {70, 60, 1.666667 * 18}},
      {"malformed_property_index_oob.3mf", 1, 1, {0, 0, 0}, {10, 20, 0}},
  };
  for (const Real& each : real) {
    SCOPED_TRACE(each.name);
    const ModelFile file = readModel(data / each.name);
    EXPECT_EQ(file.objects.size(), each.objects);
    EXPECT_EQ(file.faces, each.triangles);
    EXPECT_EQ(file.unitMm, 1.0);
    Vec3d least = file.objects[0].mesh.positions[0], most = least;
    uint64_t triangles = 0;
    for (const ModelObject& object : file.objects) {
      triangles += object.mesh.triangles.size();
      for (const Vec3d& p : object.mesh.positions) {
        least = least.cwiseMin(p);
        most = most.cwiseMax(p);
      }
    }
    EXPECT_EQ(triangles, each.triangles);
    EXPECT_LT((least - each.least).norm(), 1e-12) << least.transpose();
    EXPECT_LT((most - each.most).norm(), 1e-12) << most.transpose();
  }
  EXPECT_THAT(readModel(data / "malformed_property_index_oob.3mf").notes, ElementsAre(HasSubstr("1 colour is named")));
  EXPECT_THAT(errorOf([&] { (void)readModel(data / "MUSTFAIL_Chapter3.4c_MissingResourceElement.3mf"); }),
              HasSubstr("no <resources>"));
  EXPECT_EQ(readModel(data / "heartgears.3mf").objects[0].name, "heart gears");
}

// Colours of single triangles as the XML has them: its lines 3067, 3767, 4467, ... name p1 0, 1, 5, 0, 6, 4, 6, 7, 5,
// 2, 0.
TEST(ThreeMfRead, RealColours) {
  const char* root = std::getenv("ARGIL_DATA");
  if (root == nullptr) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const ModelFile file = readModel(std::filesystem::path(root) / "3mf" / "dodeca_chain_loop_color.3mf");
  const ModelObject& object = file.objects.at(0);
  EXPECT_EQ(object.name, "dodeca_chain_loop (color)");
  const Colour group[] = {{255, 0, 128, 255}, {255, 255, 255, 255}, {128, 128, 255, 255},
                          {0, 255, 6, 255},   {128, 64, 0, 255},    {252, 221, 3, 255},
                          {0, 255, 255, 255}, {255, 0, 255, 255},   {255, 255, 0, 255}};
  const size_t named[] = {0, 1, 5, 0, 6, 4, 6, 7, 5, 2, 0};
  ASSERT_EQ(object.triangleColours.size(), 7680u);
  for (size_t i = 0; i < std::size(named); ++i) EXPECT_EQ(object.triangleColours[700 * i], group[named[i]]) << i;
  EXPECT_EQ(file.metadata.size(), 7u);
  EXPECT_EQ(file.metadata[0].second, "Dodeca Chain Loop");
  EXPECT_THAT(file.notes, IsEmpty());
}

}  // namespace
}  // namespace argil::io
