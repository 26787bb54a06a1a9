// Projects of slicers: what they cut away is told from what is clay, and what only they understand is left out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/models/model_file.h"
#include "tests/support/package_samples.h"

namespace argil::io {
namespace {

using samples::bytesOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ModelFile parse(const std::string& bytes) {
  return parseModel(bytesOf(bytes), "a.3mf");
}

// Five tetrahedra in one mesh, as PrusaSlicer writes an object of five volumes.
std::string fiveVolumes() {
  std::string vertices, triangles;
  for (int i = 0; i < 5; ++i) {
    const auto at = [&](double x, double y, double z) {
      vertices += "<vertex x=\"" + std::to_string(10 * i + x) + "\" y=\"" + std::to_string(y) + "\" z=\"" +
                  std::to_string(z) + "\"/>";
    };
    at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 1);
    for (const auto& [a, b, c] : std::vector<std::array<int, 3>>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
      triangles += "<triangle v1=\"" + std::to_string(4 * i + a) + "\" v2=\"" + std::to_string(4 * i + b) + "\" v3=\"" +
                   std::to_string(4 * i + c) + "\"/>";
  }
  return "<resources><object id=\"1\"><mesh><vertices>" + vertices + "</vertices><triangles>" + triangles +
         "</triangles></mesh></object></resources><build><item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0 "
         "100\"/><item objectid=\"1\"/></build>";
}

std::string volume(int first, int last, const std::string& name, const std::string& kind) {
  return "<volume firstid=\"" + std::to_string(first) + "\" lastid=\"" + std::to_string(last) +
         "\"><metadata type=\"volume\" key=\"name\" value=\"" + name +
         "\"/><metadata type=\"volume\" key=\"volume_type\" value=\"" + kind + "\"/></volume>";
}

std::string prusa(const std::string& volumes) {
  return samples::threeMf(
      fiveVolumes(), "unit=\"millimeter\"",
      {{"Metadata/Slic3r_PE_model.config",
        "<?xml version=\"1.0\"?><config><object id=\"1\"><metadata type=\"object\" key=\"name\" value=\"bracket\"/>" +
            volumes + "</object></config>"}});
}

std::vector<std::string> namesOf(const std::vector<ModelObject>& objects) {
  std::vector<std::string> names;
  for (const ModelObject& each : objects) names.push_back(each.name);
  return names;
}

TEST(SlicerSettings, VolumesOfPrusaSlicerAreToldApart) {
  const ModelFile file =
      parse(prusa(volume(0, 3, "body", "ModelPart") + volume(4, 7, "pocket", "NegativeVolume") +
                  volume(8, 11, "dense", "ParameterModifier") + volume(12, 15, "no", "SupportBlocker") +
                  volume(16, 19, "yes", "SupportEnforcer")));
  EXPECT_THAT(namesOf(file.objects), ElementsAre("body", "body")) << "twice on the bed";
  EXPECT_THAT(namesOf(file.negatives), ElementsAre("pocket", "pocket"));
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(file.negatives[i].assembly, file.objects[i].assembly);
    EXPECT_EQ(file.negatives[i].mesh.positions.size(), 4u);
    EXPECT_EQ(file.negatives[i].mesh.positions[0], Vec3d(10, 0, i == 0 ? 100 : 0));
    EXPECT_EQ(file.objects[i].mesh.positions[0], Vec3d(0, 0, i == 0 ? 100 : 0));
    EXPECT_EQ(file.negatives[i].mesh.triangles, file.objects[i].mesh.triangles);
  }
  EXPECT_NE(file.objects[0].assembly, file.objects[1].assembly);
  EXPECT_THAT(file.notes, Contains(HasSubstr("2 volumes change settings")));
  EXPECT_THAT(file.notes, Contains(HasSubstr("4 volumes say where the slicer puts supports")));
}

TEST(SlicerSettings, AnOldModifierIsOne) {
  const ModelFile file =
      parse(prusa("<volume firstid=\"0\" lastid=\"15\"/><volume firstid=\"16\" lastid=\"19\"><metadata type=\"volume\" "
                  "key=\"modifier\" value=\"1\"/></volume>"));
  EXPECT_THAT(namesOf(file.objects), ElementsAre("bracket", "bracket")) << "as the slicer calls the object";
  EXPECT_EQ(file.objects[0].mesh.triangles.size(), 16u);
}

TEST(SlicerSettings, TriangleRunsThatDoNotFitAreNotBelieved) {
  for (const std::string& volumes :
       {volume(0, 3, "a", "ModelPart"), volume(0, 99, "a", "NegativeVolume"), volume(4, 19, "a", "NegativeVolume"),
        volume(0, 11, "a", "ModelPart") + volume(8, 19, "b", "NegativeVolume")}) {
    const ModelFile file = parse(prusa(volumes));
    EXPECT_EQ(file.objects.size(), 2u) << volumes;
    EXPECT_EQ(file.objects[0].mesh.triangles.size(), 20u);
    EXPECT_THAT(file.negatives, IsEmpty());
  }
}

TEST(SlicerSettings, WhatCannotBeReadIsToldAndTheModelComesIn) {
  for (const std::string& volumes : {std::string("<volume firstid=\"x\" lastid=\"3\"/>"), std::string("<volume>"),
                                     volume(9, 3, "a", "NegativeVolume")}) {
    const ModelFile file = parse(prusa(volumes));
    EXPECT_EQ(file.objects.size(), 2u);
    EXPECT_THAT(file.notes, Contains(HasSubstr("could not be read, all came in as solid")));
  }
}

TEST(SlicerSettings, NothingButNegativesIsNoModel) {
  const std::string error = samples::errorOf([&] { (void)parse(prusa(volume(0, 19, "pocket", "NegativeVolume"))); });
  EXPECT_THAT(error, HasSubstr("a.3mf: holds no solid volume"));
}

// Bambu Studio: an object of components, which lie in a part of their own.
TEST(SlicerSettings, PartsOfBambuStudioAreToldApart) {
  const std::string others =
      samples::modelXml("<resources><object id=\"1\">" + samples::tetrahedronXml() + "</object><object id=\"2\">" +
                        samples::tetrahedronXml() + "</object><object id=\"3\">" + samples::tetrahedronXml() +
                        "</object></resources><build/>");
  const std::string config =
      "<config><object id=\"8\"><metadata key=\"name\" value=\"whole\"/><part id=\"1\" "
      "subtype=\"normal_part\"><metadata key=\"name\" value=\"body\"/></part>"
      "<part id=\"2\" subtype=\"negative_part\"><metadata key=\"name\" value=\"hole\"/></part><part id=\"3\" "
      "subtype=\"modifier_part\"/></object></config>";
  const ModelFile file = parse(samples::threeMf(
      "<resources><object id=\"8\"><components><component p:path=\"/3D/Objects/a.model\" objectid=\"1\"/><component "
      "p:path=\"/3D/Objects/a.model\" objectid=\"2\" "
      "transform=\"1 0 0 0 1 0 0 0 1 7 0 0\"/><component p:path=\"/3D/Objects/a.model\" "
      "objectid=\"3\"/></components></object></resources><build><item objectid=\"8\"/></build>",
      "unit=\"millimeter\"", {{"3D/Objects/a.model", others}, {"Metadata/model_settings.config", config}}));
  EXPECT_THAT(namesOf(file.objects), ElementsAre("body"));
  ASSERT_THAT(namesOf(file.negatives), ElementsAre("hole"));
  EXPECT_EQ(file.negatives[0].mesh.positions[0], Vec3d(7, 0, 0));
  EXPECT_THAT(file.notes, Contains(HasSubstr("1 volume changes settings")));
}

}  // namespace
}  // namespace argil::io
