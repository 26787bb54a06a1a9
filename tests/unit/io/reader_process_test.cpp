// The process that parses with other people's libraries: what it may, what it may not, and how its end is told.
#include "io/models/reader_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "io/models/model_file.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Another reader for the time of a test: a script, or a name that is not there.
class OtherReader {
 public:
  explicit OtherReader(const std::string& program) { ::setenv("ARGIL_READER", program.c_str(), 1); }
  ~OtherReader() { ::unsetenv("ARGIL_READER"); }
  OtherReader(const OtherReader&) = delete;
  OtherReader& operator=(const OtherReader&) = delete;
};

class ReaderProcess : public testing::Test {
 protected:
  ReaderProcess() { samples::spill(file_, "something"); }
  /// A reader that is a shell script.
  std::string script(const std::string& lines) {
    const auto path = folder_ / "reader";
    samples::spill(path, "#!/bin/sh\n" + lines + "\n");
    ::chmod(path.c_str(), 0755);
    return path.string();
  }
  std::string sentenceOf(const std::string& what, const ReaderLimits& limits = {}, Job* job = nullptr) {
    return samples::errorOf([&] {
      runReader(
          what, file_, [](wire::Kind, std::span<const std::byte>) {}, job, limits);
    });
  }

  samples::Folder folder_;
  std::filesystem::path file_ = folder_ / "a.bin";
};

TEST_F(ReaderProcess, MissingReaderIsNamed) {
  const OtherReader none("/nowhere/argil-reader");
  EXPECT_THAT(sentenceOf("gltf"), HasSubstr("/nowhere/argil-reader"));
}

TEST_F(ReaderProcess, SentencesComeThrough) {
  EXPECT_THAT(sentenceOf("draco"), HasSubstr("a.bin: its Draco data is damaged"));
  EXPECT_THAT(sentenceOf("gltf"), HasSubstr("a.bin: is no glTF"));
  EXPECT_THAT(sentenceOf("vdb"), HasSubstr("a.bin: is no OpenVDB file"));
  EXPECT_THAT(sentenceOf("png"), HasSubstr("does not know the format png"));
}

TEST_F(ReaderProcess, CrashesAreSentences) {
  const OtherReader crashing(script("kill -SEGV $$"));
  EXPECT_THAT(sentenceOf("gltf"), HasSubstr("made the reader crash (Segmentation fault)"));
}

// What a file needs grows with it: the least is for small ones.
TEST_F(ReaderProcess, ALargeModelMayTakeMoreMemoryThanASmallOne) {
  const auto told = folder_ / "told";
  const OtherReader telling(script("echo \"$3\" > '" + told.string() + "'"));
  const auto memoryFor = [&](uint64_t bytes) {
    const auto model = folder_ / "a.glb";
    samples::spill(model, "glTF");
    std::filesystem::resize_file(model, bytes);  // with a hole: nobody reads it
    EXPECT_THROW(static_cast<void>(readModel(model)), Error);
    return std::stoull(samples::slurp(told));
  };
  EXPECT_EQ(memoryFor(1000), ReaderLimits().memoryBytes);
  EXPECT_GE(memoryFor(uint64_t{3} << 30), uint64_t{9} << 30) << "the file itself, and its numbers as doubles";
}

TEST_F(ReaderProcess, GarbageIsASentence) {
  const OtherReader garbage(script("cat /proc/cpuinfo /proc/cpuinfo"));
  EXPECT_THAT(sentenceOf("gltf"), HasSubstr("sent what it should not"));
}

TEST_F(ReaderProcess, HugeMessageIsGarbage) {
  const OtherReader garbage(script("printf 'ARGILRD1\\003\\000\\000\\000\\377\\377\\377\\377'; sleep 5"));
  EXPECT_THAT(sentenceOf("gltf"), HasSubstr("sent what it should not"));
}

TEST_F(ReaderProcess, EarlyEndIsASentence) {
  const OtherReader empty(script("printf 'ARGILRD1'"));
  EXPECT_THAT(sentenceOf("gltf"), HasSubstr("ended too early"));
  // As the system's loader does without one of its libraries.
  const OtherReader cannotStart(script("exit 127"));
  EXPECT_THAT(sentenceOf("cad"), HasSubstr("a library that its reader needs is missing"));
}

TEST_F(ReaderProcess, EndlessReaderIsStopped) {
  const OtherReader sleeping(script("exec sleep 60"));
  EXPECT_THAT(sentenceOf("gltf", {.seconds = 0.1}), HasSubstr("takes more than"));
}

TEST_F(ReaderProcess, MemoryIsLimited) {
#ifndef __SANITIZE_ADDRESS__
  // A .drc of many zeros cannot be held in 64 MiB.
  std::filesystem::resize_file(file_, size_t{200} << 20);
  EXPECT_THAT(sentenceOf("draco", {.memoryBytes = uint64_t{400} << 20}), HasSubstr("Draco"));
  EXPECT_THAT(sentenceOf("draco", {.memoryBytes = uint64_t{192} << 20}), HasSubstr("192 MiB of memory"));
#endif
}

TEST_F(ReaderProcess, WhatItSendsIsLimited) {
  const OtherReader endless(
      script("printf ARGILRD1; while :; do printf '\\004\\000\\000\\000\\004\\000\\000\\000abcd'; done"));
  EXPECT_THAT(sentenceOf("gltf", {.memoryBytes = 100000}), HasSubstr("memory"));
}

// A note without a word costs a misled reader eight bytes, and whoever keeps it several times as many.
TEST_F(ReaderProcess, EndlessNotesAreGarbage) {
  const OtherReader endless(
      script("printf ARGILRD1; while :; do printf '\\003\\000\\000\\000\\000\\000\\000\\000'; done"));
  EXPECT_THAT(sentenceOf("gltf", {.memoryBytes = 100000}), HasSubstr("sent what it should not"));
}

TEST_F(ReaderProcess, CancelKillsIt) {
  const OtherReader sleeping(script("exec sleep 60"));
  Job job;
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    job.cancel();
  });
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW(runReader(
                   "gltf", file_, [](wire::Kind, std::span<const std::byte>) {}, &job),
               Cancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  other.join();
}

// It tries to open another file, to write, to remove, to connect, to signal, to fork and to become another program.
// Where the system cannot stop it, that is told.
TEST_F(ReaderProcess, MayReadOneFileAndDoNothingElse) {
#ifndef __SANITIZE_ADDRESS__
  samples::spill(folder_ / "a.bin.other", "secret");
  std::vector<std::string> notes;
  runReader("forbidden", file_, [&](wire::Kind kind, std::span<const std::byte> payload) {
    if (kind == wire::Kind::note) notes.push_back(wireText(payload));
  });
  ASSERT_FALSE(notes.empty());
  if (notes[0].find("cannot confine") == std::string::npos) {
    EXPECT_THAT(notes, testing::ElementsAre("all was tried"));
  }
  EXPECT_EQ(samples::slurp(file_), "something");
  EXPECT_EQ(folder_.entries(), 2u);
#endif
}

// The buffers of a .gltf lie in its folder; those of other folders stay closed, through links too.
TEST_F(ReaderProcess, GltfReadsItsFolderAlone) {
  const auto inside = folder_ / "in";
  std::filesystem::create_directory(inside);
  std::string bytes(36, '\0');
  for (const auto& [at, value] : {std::pair{12, 1.0f}, {28, 1.0f}}) std::memcpy(bytes.data() + at, &value, 4);
  samples::spill(folder_ / "out.bin", bytes);
  samples::spill(inside / "in.bin", bytes);
  std::filesystem::create_symlink(folder_ / "out.bin", inside / "link.bin");
  const auto read = [&](const std::string& buffer) {
    samples::spill(
        inside / "a.gltf",
        R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":")" +
            buffer + R"("}]})");
    try {
      return readModel(inside / "a.gltf").objects.size() == 1 ? std::string() : std::string("no object");
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  EXPECT_EQ(read("in.bin"), "");
  EXPECT_NE(read("../out.bin"), "");
#ifndef __SANITIZE_ADDRESS__
  EXPECT_NE(read("link.bin"), "") << "a link leads out of the folder";
#endif
}

// Its first bytes say who reads it: a file of 100 GiB (of holes) is not taken into memory to find that out.
TEST_F(ReaderProcess, LargeFilesAreNotReadTwice) {
  for (const auto& [name, head] : {std::pair{"a.drc", "DRACO"}, {"a.glb", "glTF"}}) {
    samples::spill(folder_ / name, head);
    std::filesystem::resize_file(folder_ / name, uint64_t{100} << 30);
    EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readModel(folder_ / name)); }), HasSubstr("is larger than"));
  }
}

TEST_F(ReaderProcess, TextIsOneLine) {
  const std::string raw = "two\nlines\x1b[31m";
  EXPECT_EQ(wireText(std::as_bytes(std::span(raw))), "two?lines?[31m");
}

}  // namespace
}  // namespace argil::io
