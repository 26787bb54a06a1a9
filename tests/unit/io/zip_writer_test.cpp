#include "io/bytes/zip_writer.h"

#include <gtest/gtest.h>

#include <random>

#include "io/bytes/zip_reader.h"
#include "tests/support/lib3mf_model.h"
#include "tests/support/package_samples.h"

namespace argil::io {
namespace {

std::string content(const std::filesystem::path& path, const char* name) {
  const FileBytes file = readFile(path);
  const Input input{file.bytes(), "a.zip"};
  ZipReader zip(input);
  const FileBytes part = zip.read(*zip.find(name));
  return {reinterpret_cast<const char*>(part.data.get()), part.size};
}

/// Text, noise and nothing, packed as blocks of their own.
TEST(ZipWriter, BlocksAreOneStream) {
  const samples::Folder folder;
  std::mt19937 random(20267);
  std::string text, noise;
  for (int i = 0; i < 100000; ++i) text += "<v x=\"" + std::to_string(random() % 1000) + "\"/>";
  for (int i = 0; i < 3'000'000; ++i) noise += static_cast<char>(random());
  AtomicFile file(folder / "a.zip");
  ZipWriter zip(file);
  DeflateBlock packer;
  std::vector<std::byte> packed;
  zip.add("first", "1");
  zip.begin("second", 10'000'000);
  for (const std::string& block : {text, noise, std::string(), text, std::string("x")}) {
    packer.pack(block, packed);
    zip.block(block, packed);
  }
  zip.end();
  zip.begin("empty", 0);
  zip.end();
  zip.add("last", "");
  zip.finish();
  file.commit();
  EXPECT_EQ(content(folder / "a.zip", "first"), "1");
  EXPECT_EQ(content(folder / "a.zip", "second"), text + noise + text + "x");
  EXPECT_EQ(content(folder / "a.zip", "empty"), "");
  EXPECT_EQ(content(folder / "a.zip", "last"), "");
  // Readers that take the file from its begin go by what stands behind a part: signature, checksum and two sizes of
  // four bytes each.
  const std::string bytes = samples::slurp(folder / "a.zip");
  const size_t next = bytes.rfind("PK\x03\x04");  // of "last"
  ASSERT_GT(next, 16u);
  EXPECT_EQ(bytes.substr(next - 16, 8), std::string("PK\x07\x08\0\0\0\0", 8));
  EXPECT_EQ(bytes.substr(next - 4, 4), std::string(4, '\0')) << "of an empty one";
}

// What a part beyond 4 GiB would look like, for readers that go by the local header or by the table.
TEST(ZipWriter, PartsThatMayBeLargeAreReadByOthers) {
  const samples::Folder folder;
  AtomicFile file(folder / "a.3mf");
  ZipWriter zip(file);
  zip.add("[Content_Types].xml",
          "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"><Default Extension=\"rels\" "
          "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default Extension=\"model\" "
          "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>");
  zip.add("_rels/.rels", samples::kRelations);
  std::string model = samples::modelXml("<resources><object id=\"1\" type=\"model\">" + samples::tetrahedronXml() +
                                        "</object></resources><build><item objectid=\"1\"/></build>");
  // lib3mf wants more of models that name the production extension.
  const size_t production = model.find(" xmlns:p=");
  model.erase(production, model.find('>', production) - production);
  DeflateBlock packer;
  std::vector<std::byte> packed;
  packer.pack(model, packed);
  zip.begin("3D/3dmodel.model", uint64_t(5) << 30);
  zip.block(model, packed);
  zip.end();
  zip.finish();
  file.commit();
  EXPECT_EQ(content(folder / "a.3mf", "3D/3dmodel.model"), model);
  EXPECT_EQ(samples::readByLib3mf(folder / "a.3mf").objects.at(0).triangles.size(), 4u);
}

}  // namespace
}  // namespace argil::io
