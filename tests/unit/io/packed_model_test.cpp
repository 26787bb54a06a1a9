// Models in archives, and files that are no models.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstring>
#include <vector>

#include "io/bytes/unpack_limit.h"
#include "io/models/model_file.h"
#include "tests/support/package_samples.h"

namespace argil::io {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string gzip(const std::string& content) {
  libdeflate_compressor* packer = libdeflate_alloc_compressor(9);
  std::string packed(libdeflate_gzip_compress_bound(packer, content.size()), '\0');
  packed.resize(libdeflate_gzip_compress(packer, content.data(), content.size(), packed.data(), packed.size()));
  libdeflate_free_compressor(packer);
  return packed;
}

const std::string kTriangle = "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
// No word at its beginning says that it is OBJ: the ending must.
const std::string kObj = "s off\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

class PackedModel : public testing::Test {
 protected:
  ModelFile read(const std::string& name, const std::string& content) {
    samples::spill(folder / name, content);
    return readModel(folder / name);
  }
  std::string refusal(const std::string& name, const std::string& content) {
    return samples::errorOf([&] { (void)read(name, content); });
  }
  samples::Folder folder;
};

TEST_F(PackedModel, GzipIsUnpackedAndTheInnerEndingCounts) {
  EXPECT_EQ(read("a.off.gz", gzip(kTriangle)).objects.at(0).mesh.triangles.size(), 1u);
  EXPECT_EQ(read("a.obj.gz", gzip(kObj)).format, "OBJ");
  EXPECT_EQ(read("a.OBJ.GZ", gzip(kObj)).format, "OBJ");
  // Members one after the other are one file (RFC 1952, 2.2), and zeros may follow.
  EXPECT_EQ(read("b.off.gz", gzip(kTriangle.substr(0, 12)) + gzip(kTriangle.substr(12)) + std::string(512, '\0'))
                .objects.size(),
            1u);
}

TEST_F(PackedModel, DamagedGzipIsRefused) {
  const std::string whole = gzip(kTriangle);
  EXPECT_THAT(refusal("a.off.gz", whole.substr(0, whole.size() - 5)), HasSubstr("gzip cannot unpack it"));
  std::string wrong = whole;
  wrong[whole.size() - 6] ^= 1;  // The checksum.
  EXPECT_THAT(refusal("a.off.gz", wrong), HasSubstr("gzip cannot unpack it"));
  EXPECT_THAT(refusal("a.off.gz", whole + "and more"), HasSubstr("gzip cannot unpack it"));
  EXPECT_THAT(refusal("a.off.gz", gzip("")), HasSubstr("holds nothing"));
  EXPECT_THAT(refusal("a.gz", gzip(samples::zip({{"a.off", kTriangle}}))), HasSubstr("ZIP archive"));
}

// 1000:1; only 16 MiB are free. Where a last member hides how much there is, it is noticed as it comes.
TEST_F(PackedModel, AGzipBombIsRefusedBeforeItFillsTheMemory) {
  const std::string bomb = gzip(std::string(size_t(200) << 20, ' '));
  ASSERT_LT(bomb.size(), size_t(1) << 20);
  EXPECT_THAT(refusal("a.off.gz", bomb), HasSubstr("unpacks to more than 50 times its size"));
  EXPECT_THAT(refusal("a.off.gz", bomb + gzip(kTriangle)), HasSubstr("unpacks to more than 50 times its size"));
  // What is small may be as dense as it likes.
  EXPECT_EQ(read("b.off.gz", gzip(kTriangle + std::string(size_t(10) << 20, ' '))).objects.size(), 1u);
}

// Members whose end says little of all: it grows, and each byte comes out once.
TEST_F(PackedModel, ManyMembersAreOneFile) {
  std::string text = "OFF 30000 1 0\n", packed;
  for (int i = 0; i < 30000; ++i) text += std::to_string(i * 7919 % 10007) + " " + std::to_string(i) + " 1\n";
  text += "3 0 1 2\n";
  for (size_t at = 0; at < text.size(); at += 9973) packed += gzip(text.substr(at, 9973));
  EXPECT_EQ(read("a.off.gz", packed).objects.at(0).mesh.positions.size(), 30000u);
}

// What is in the archive in the archive counts as if it came out of the first.
TEST_F(PackedModel, ArchivesInArchivesAreJudgedTogether) {
  const std::string inner =
      samples::zip({{"3D/a.model", std::string(65535, 'x'), true}, {"b", std::string(400'000, 'b')}});
  std::string dense = inner;
  const size_t table = dense.find("PK\x01\x02");
  const uint32_t claimed = 20'000'000;
  std::memcpy(&dense[table + 24], &claimed, 4);
  // 43:1 as it is; but half of it came from next to nothing.
  EXPECT_THAT(refusal("a.3mf", dense), Not(HasSubstr("50 times its size")));
  EXPECT_THAT(refusal("a.gz", gzip(dense)), HasSubstr("50 times its size"));
}

// What the system has left, or the limit that it was given, is shared with the mesh.
TEST(UnpackLimit, HalfOfTheMemoryThatIsLeft) {
#ifndef __SANITIZE_ADDRESS__
  constexpr uint64_t kMiB = uint64_t{1} << 20;
  EXPECT_GT(availableMemory(), 64 * kMiB);
  EXPECT_NO_THROW(requireMemory("a.3mf", 20 * kMiB));
  const auto inATightPlace = [] {
    rlimit space{};
    std::ifstream status("/proc/self/statm");
    uint64_t pages = 0;
    status >> pages;
    space.rlim_cur = space.rlim_max = pages * uint64_t(::sysconf(_SC_PAGESIZE)) + 100 * kMiB;
    ::setrlimit(RLIMIT_AS, &space);
    const uint64_t left = availableMemory();
    if (left > 100 * kMiB || left < 80 * kMiB) ::_exit(3);
    requireMemory("a.3mf", 30 * kMiB);  // Half of it, or little less.
    try {
      requireMemory("a.3mf", 60 * kMiB);
    } catch (const Error& error) {
      std::fputs(error.what(), stderr);
      ::_exit(0);
    }
    ::_exit(4);
  };
  EXPECT_EXIT(inATightPlace(), testing::ExitedWithCode(0), "a.3mf: unpacks to 60 MiB, too much for the .* MiB");
#endif
}

TEST_F(PackedModel, AZipOfOneModelIsRead) {
  const ModelFile model = read(
      "a.zip", samples::zip({{"readme.txt", "Hello"}, {"deep/in/part.obj", kObj, true}, {"__MACOSX/part.obj", "x"}}));
  EXPECT_EQ(model.format, "OBJ");
  EXPECT_EQ(model.objects.at(0).mesh.triangles.size(), 1u);
}

TEST_F(PackedModel, OtherZipsSayWhy) {
  EXPECT_THAT(refusal("a.zip", samples::zip({{"a.obj", kObj}, {"b.stl", "x"}})),
              HasSubstr("a ZIP archive of 2 models"));
  EXPECT_THAT(refusal("a.zip", samples::zip({{"a.txt", "x"}})), HasSubstr("without a model"));
  EXPECT_THAT(refusal("a.zip", samples::zip({{"a.obj", ""}})), HasSubstr("empty model"));
  EXPECT_THAT(refusal("a.zip", samples::zip({{"a.glb", "glTF..."}})), HasSubstr("unpack it first"));
  EXPECT_THAT(refusal("a.zip", samples::zip({{"a.obj", "v 0 0 x\n"}})), HasSubstr("a.zip: a.obj: line 1"));
}

TEST_F(PackedModel, WhatIsNoModelIsCalledByItsName) {
  std::string nifti(352, '\0');
  nifti.replace(344, 4, "n+1", 4);
  EXPECT_THAT(refusal("scan.nii", nifti), HasSubstr("is a NIfTI volume: make a surface of it first"));
  EXPECT_THAT(refusal("scan.nii.gz", gzip(nifti)), HasSubstr("is a NIfTI volume: make a surface of it first"));
  EXPECT_THAT(refusal("a.obj", std::string("\xff\xfev\0 \0", 6)), HasSubstr("is text in UTF-16: save it as UTF-8"));
  EXPECT_THAT(refusal("a.fbx", "Kaydara FBX Binary  "), HasSubstr("an FBX scene"));
  EXPECT_THAT(refusal("a.blend", "BLENDER-v304"), HasSubstr("a Blender document"));
  EXPECT_THAT(refusal("a.txt", "Dear reader,\n"), HasSubstr("no format that can be read"));
}

}  // namespace
}  // namespace argil::io
