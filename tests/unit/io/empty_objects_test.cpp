// Objects without triangles do not vanish in silence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/bytes/empty_objects.h"
#include "io/models/model_file.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/package_samples.h"

namespace argil::io {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(EmptyObjects, AreNamedInOneSentence) {
  const auto said = [](std::vector<std::string> names) { return emptyObjects(names); };
  EXPECT_EQ(said({"Sketch1"}), "the object Sketch1 has no triangles and was left out");
  EXPECT_EQ(said({""}), "an object without a name has no triangles and was left out");
  EXPECT_EQ(said({"a", ""}), "2 objects have no triangles and were left out: a, one without a name");
  EXPECT_EQ(said({"a", "b", "c", "d", "e", "f"}),
            "6 objects have no triangles and were left out: a, b, c, d, e and others");
}

std::string object(int id, const std::string& name, const std::string& inside) {
  return "<object id=\"" + std::to_string(id) + "\" type=\"model\" name=\"" + name + "\">" + inside + "</object>";
}
const std::string kEmptyMesh =
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/></vertices><triangles/></mesh>";
const std::string kMesh =
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"1\" "
    "z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles></mesh>";

ModelFile threeMf(const std::string& objects, const std::string& items) {
  return parseModel(
      samples::bytesOf(samples::threeMf("<resources>" + objects + "</resources><build>" + items + "</build>")),
      "a.3mf");
}

TEST(EmptyObjects, AreToldOf3mf) {
  const std::string two = object(1, "Sketch1", kEmptyMesh) + object(2, "Body1", kMesh);
  EXPECT_THAT(threeMf(two, "<item objectid=\"1\"/><item objectid=\"2\"/>").notes,
              ElementsAre("the object Sketch1 has no triangles and was left out"));
  EXPECT_THAT(threeMf(two, "<item objectid=\"2\"/>").notes, IsEmpty()) << "what is not built is not missed";
  // Within another, and one of neither a mesh nor components.
  EXPECT_THAT(threeMf(two + object(3, "All",
                                   "<components><component objectid=\"1\"/><component objectid=\"2\"/>"
                                   "</components>"),
                      "<item objectid=\"3\"/>")
                  .notes,
              ElementsAre("the object Sketch1 has no triangles and was left out"));
  EXPECT_THAT(
      threeMf(object(1, "Nothing", "") + object(2, "Body1", kMesh), "<item objectid=\"1\"/><item objectid=\"2\"/>")
          .notes,
      ElementsAre("the object Nothing has no triangles and was left out"));
}

TEST(EmptyObjects, AreToldOfObjAndStl) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto obj = [&](const std::string& text) { return parseModel(samples::bytesOf(text), "a.obj").notes; };
  EXPECT_THAT(obj("o sketch\n" + vertices + "o body\nf 1 2 3\n"),
              ElementsAre("the object sketch has no triangles and was left out"));
  EXPECT_THAT(obj(vertices + "o body\nf 1 2 3\no a\no b\n"),
              ElementsAre("2 objects have no triangles and were left out: a, b"));
  EXPECT_THAT(obj("o lines\n" + vertices + "l 1 2\no body\nf 1 2 3\n"),
              Contains("the object lines has no triangles and was left out"));
  EXPECT_THAT(obj("o body\n" + vertices + "f 1 2 3\no body\n"), IsEmpty()) << "a name that returns is one object";
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\nendsolid\n";
  const auto stl = [&](const std::string& text) { return parseModel(samples::bytesOf(text), "a.stl").notes; };
  EXPECT_THAT(stl("solid sketch\nendsolid\nsolid body\n" + facet),
              ElementsAre("the object sketch has no triangles and was left out"));
  EXPECT_THAT(stl("solid body\n" + facet + "solid\nendsolid\n"),
              ElementsAre("an object without a name has no triangles and was left out"));
  EXPECT_THAT(stl("solid body\n" + facet), IsEmpty());
}

TEST(EmptyObjects, AreToldOfGltf) {
  const samples::Folder folder;
  const auto notes = [&](const std::string& sketch) {
    samples::spill(
        folder / "a.gltf",
        R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"name":"Sketch1"},{"mesh":1}],)"
        R"("meshes":[{"primitives":[)" +
            sketch +
            R"(]},{"primitives":[{"attributes":{"POSITION":0}}]}],)"
            R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":)"
            R"([{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
            R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
    return readModel(folder / "a.gltf").notes;
  };
  const std::string told = "the object Sketch1 has no triangles and was left out";
  EXPECT_THAT(notes(""), ElementsAre(told));
  EXPECT_THAT(notes(R"({"attributes":{"POSITION":0},"mode":1})"), Contains(told));
  EXPECT_THAT(notes(R"({"attributes":{"POSITION":0},"mode":4})"), IsEmpty());
}

}  // namespace
}  // namespace argil::io
