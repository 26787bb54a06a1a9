// Every test program works in a folder of its own, gone afterwards: two that run at once, of two build folders or of
// two people, never meet, and the journals of documents never lie with those of the person who runs the tests.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace argil::tests {
namespace {

class OwnFolder : public ::testing::Environment {
 public:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "argil-tests-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    folder_ = name;
    // A test that stands for another user finds its way through.
    std::filesystem::permissions(folder_, std::filesystem::perms::others_exec, std::filesystem::perm_options::add);
    before_ = std::filesystem::temp_directory_path();
    setenv("TMPDIR", name.c_str(), 1);
    setenv("TEST_TMPDIR", (name + "/").c_str(), 1);  // GoogleTest's own name for it
    const std::filesystem::path state = folder_ / "state";
    std::filesystem::create_directory(state);
    setenv("ARGIL_STATE", state.c_str(), 1);
    // Nor are plugins that somebody has enabled there.
    setenv("XDG_CONFIG_HOME", (name + "/config").c_str(), 1);
    setenv("XDG_DATA_HOME", (name + "/data").c_str(), 1);
  }
  void TearDown() override {
    setenv("TMPDIR", before_.c_str(), 1);
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

 private:
  std::filesystem::path folder_, before_;
};

// Owned by GoogleTest.
[[maybe_unused]] const ::testing::Environment* const installed = ::testing::AddGlobalTestEnvironment(new OwnFolder);

}  // namespace
}  // namespace argil::tests
