// 3MF packages that were cut off or damaged, in their archive and in their XML: an Error of one line or a model that
// keeps its promises.
#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "io/models/model_file.h"
#include "tests/support/damage.h"
#include "tests/support/package_samples.h"

namespace argil::io {
namespace {

constexpr uint32_t kSeed = 20269;

/// Uses most of what the reader knows.
std::string inside() {
  return "<metadata name=\"Title\">A &amp; B</metadata><resources><basematerials id=\"5\"><base name=\"a\" "
         "displaycolor=\"#FF0000\"/></basematerials>\n"
         "<m:colorgroup id=\"6\"><m:color color=\"#FF0000\"/><m:color color=\"#00FF00FF\"/></m:colorgroup>\n"
         "<object id=\"1\" name=\"t\" pid=\"5\" pindex=\"0\">" +
         samples::tetrahedronXml({"pid=\"6\" p1=\"0\" p2=\"1\" p3=\"1\"", "pid=\"6\" p1=\"1\"", "", "p1=\"0\""}) +
         "</object><object id=\"2\"><components><component objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 "
         "0\"/><component objectid=\"3\" p:path=\"/b.model\"/></components></object>"
         "</resources><build><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 5 6 7\"/><item "
         "objectid=\"1\"/></build>";
}

std::string package(const std::string& model) {
  return samples::zip({{"_rels/.rels", samples::kRelations},
                       {"3D/3dmodel.model", model, true},
                       {"b.model", samples::modelXml("<resources><object id=\"3\">" + samples::tetrahedronXml() +
                                                     "</object></resources><build/>")}});
}

bool loads(std::string_view bytes) {
  // An own allocation of the exact length, so that a sanitizer sees every byte read beyond it.
  const std::vector<std::byte> exact(samples::bytesOf(bytes).begin(), samples::bytesOf(bytes).end());
  try {
    const ModelFile file = parseModel(exact, "a.3mf");
    EXPECT_FALSE(file.objects.empty());
    for (const ModelObject& object : file.objects) {
      EXPECT_FALSE(object.mesh.triangles.empty());
      for (const Vec3d& p : object.mesh.positions) EXPECT_TRUE(p.allFinite());
      for (const auto& triangle : object.mesh.triangles) {
        for (const uint32_t corner : triangle) EXPECT_LT(corner, object.mesh.positions.size());
      }
      EXPECT_TRUE(object.triangleColours.empty() || object.triangleColours.size() == object.mesh.triangles.size());
      EXPECT_TRUE(object.vertexColours.empty() || object.vertexColours.size() == object.mesh.positions.size());
    }
    return true;
  } catch (const Error& error) {
    const std::string sentence = error.what();
    EXPECT_EQ(sentence.find("a.3mf: "), 0u) << sentence;
    EXPECT_EQ(sentence.find_first_of("\r\n"), std::string::npos) << sentence;
    EXPECT_EQ(error.kind(), Error::Kind::input) << sentence;
    return false;
  }
}

TEST(DamagedPackages, TheSampleLoads) {
  EXPECT_TRUE(loads(package(samples::modelXml(inside()))));
}

TEST(DamagedPackages, CutAtEveryByte) {
  const std::string whole = package(samples::modelXml(inside()));
  for (size_t length = 0; length < whole.size(); ++length)
    EXPECT_FALSE(loads(std::string_view(whole).substr(0, length))) << length;
}

TEST(DamagedPackages, ModelsCutAtEveryByte) {
  const std::string whole = samples::modelXml(inside());
  for (size_t length = 0; length + 1 < whole.size(); ++length)
    EXPECT_FALSE(loads(package(whole.substr(0, length)))) << length;
}

TEST(DamagedPackages, Mutations) {
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
  constexpr std::string_view kInteresting[] = {"-1",        "4294967295", "99999999999999999999",
                                               "nan",       "1e999",      "0",
                                               "\n",        "<",          "/>",
                                               "&#0;",      "\"",         "</object>",
                                               "<mesh>",    "<!--",       "]]>",
                                               " id=\"1\"", "\xff"};
  const std::string model = samples::modelXml(inside()), archive = package(model);
  int loaded = 0;
  for (int i = 0; i < 20000; ++i) {
    const bool inModel = below(4) != 0;
    const std::string bytes = samples::damaged(inModel ? model : archive, kInteresting, random);
    loaded += loads(inModel ? package(bytes) : bytes);
    if (HasFailure()) FAIL() << "mutation " << i;
  }
  // Neither end of the road may be empty, or the mutations test nothing.
  EXPECT_GT(loaded, 500);
  EXPECT_LT(loaded, 19500);
}

}  // namespace
}  // namespace argil::io
