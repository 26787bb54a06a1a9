// Journals of a test program's documents: in a folder of its own, gone afterwards, never in that of the person who runs the tests.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace argil::tests {
namespace {

class StateFolder : public ::testing::Environment {
 public:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "argil-state-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    folder_ = name;
    setenv("ARGIL_STATE", name.c_str(), 1);
  }
  void TearDown() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

 private:
  std::filesystem::path folder_;
};

// Owned by GoogleTest.
[[maybe_unused]] const ::testing::Environment* const installed = ::testing::AddGlobalTestEnvironment(new StateFolder);

}  // namespace
}  // namespace argil::tests
