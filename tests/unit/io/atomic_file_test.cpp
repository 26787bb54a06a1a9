#include "io/bytes/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <iterator>
#include <optional>
#include <string>
#include <thread>

#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::bytesOf;
using samples::errorOf;
using samples::slurp;
using samples::spill;

TEST(AtomicFile, AppearsWholeAtCommit) {
  const samples::Folder folder;
  AtomicFile file(folder / "new.bin");
  file.write(bytesOf("first "));
  file.write(bytesOf("second"));
  EXPECT_FALSE(std::filesystem::exists(folder / "new.bin"));
  file.commit();
  EXPECT_EQ(slurp(folder / "new.bin"), "first second");
  EXPECT_EQ(file.bytes(), 12u);
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, WithoutCommitTheOldFileStandsAndNothingIsLeft) {
  const samples::Folder folder;
  spill(folder / "old.bin", "old");
  {
    AtomicFile file(folder / "old.bin");
    file.write(bytesOf("new"));
    EXPECT_EQ(folder.entries(), 2u);
    EXPECT_EQ(slurp(folder / "old.bin"), "old");
  }
  EXPECT_EQ(slurp(folder / "old.bin"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

// Who gives up often, as a preview does, would run out of files.
TEST(AtomicFile, HoldsNoFileOpenWhenItIsGone) {
  const samples::Folder folder;
  const auto open = [] {
    const std::filesystem::directory_iterator files("/proc/self/fd");
    return std::distance(begin(files), end(files));
  };
  const auto before = open();
  for (const bool commits : {false, true}) {
    AtomicFile file(folder / "a.bin");
    file.write(bytesOf("new"));
    EXPECT_EQ(open(), before + 1);
    if (commits) file.commit();
  }
  EXPECT_EQ(open(), before);
}

TEST(AtomicFile, TwoWritersOfOneTargetDoNotMix) {
  const samples::Folder folder;
  AtomicFile one(folder / "x");
  AtomicFile two(folder / "x");
  one.write(bytesOf("one"));
  two.write(bytesOf("two"));
  one.commit();
  two.commit();
  EXPECT_EQ(slurp(folder / "x"), "two");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, KeepsThePermissionsOfTheFileItReplaces) {
  const samples::Folder folder;
  spill(folder / "private", "old");
  std::filesystem::permissions(folder / "private", std::filesystem::perms(0600));
  AtomicFile file(folder / "private");
  file.write(bytesOf("new"));
  file.commit();
  struct stat facts {};
  ASSERT_EQ(::stat((folder / "private").c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 07777, 0600u);
}

TEST(AtomicFile, FollowsALink) {
  const samples::Folder folder;
  std::filesystem::create_directory(folder / "deep");
  spill(folder / "deep/real", "old");
  std::filesystem::create_symlink("deep/real", folder / "link");
  AtomicFile file(folder / "link");
  file.write(bytesOf("new"));
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(slurp(folder / "deep/real"), "new");
}

TEST(AtomicFile, RefusesWhatIsNoPlaceForAFile) {
  const samples::Folder folder;
  const auto contains = [](const std::filesystem::path& path, const char* part) {
    const std::string error = errorOf([&] { const AtomicFile file(path); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  contains(folder.path(), "is a folder");
  contains(folder / "", "does not name a file");
  contains(folder / "missing" / "a.stl", "its folder does not exist");
  contains("/proc/a.stl", "its folder");
  contains(folder / std::string(300, 'x'), "cannot be written");
  contains("/dev/null/a.stl", "its folder does not exist");
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(AtomicFile, WritesDevicesAndPipesWhereTheyAre) {
  const samples::Folder folder;
  {
    AtomicFile file("/dev/null");
    file.write(bytesOf("gone"));
    file.commit();
    EXPECT_TRUE(file.inPlace());
  }
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_FALSE(errorOf([] {
                 AtomicFile file("/dev/full");
                 file.write(bytesOf("gone"));
               }).empty());
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { read = slurp(folder / "pipe"); });
  {
    AtomicFile file(folder / "pipe");
    file.write(bytesOf("all"));
    file.commit();
  }
  reader.join();
  EXPECT_EQ(read, "all");
  EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe"));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, ALongNameStillHasATemporaryOne) {
  const samples::Folder folder;
  const std::string name(250, 'x');
  AtomicFile file(folder / name);
  file.commit();
  EXPECT_TRUE(std::filesystem::exists(folder / name));
}

/// Files of this process may not grow beyond `bytes` while it lives: stands for a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit tight{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &tight);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit old_{};
  void (*handler_)(int) = SIG_DFL;
};

TEST(AtomicFile, AFullDiskLeavesTheOldFile) {
  const samples::Folder folder;
  spill(folder / "old.bin", "old");
  std::optional<Error> error;
  {
    const FullDisk full(1000);
    try {
      AtomicFile file(folder / "old.bin");
      file.write(bytesOf(std::string(5000, 'n')));
      file.commit();
    } catch (const Error& thrown) {
      error = thrown;
    }
  }
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), Error::Kind::work);
  EXPECT_NE(std::string(error->what()).find("cannot be written"), std::string::npos) << error->what();
  EXPECT_EQ(slurp(folder / "old.bin"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
}  // namespace argil::io
