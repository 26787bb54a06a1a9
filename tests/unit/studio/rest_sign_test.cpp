// What the studio tells those who wait for it.

#include "ui3d/studio/view/rest_sign.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "clay/base/error.h"

namespace argil::studio {
namespace {

class RestSignTest : public ::testing::Test {
 protected:
  void TearDown() override { unsetenv("ARGIL_REST"); }
  void name(size_t bytes) {
    std::ofstream(file_) << std::string(bytes, '\0');
    setenv("ARGIL_REST", file_.c_str(), 1);
  }
  std::filesystem::path file_ = std::filesystem::temp_directory_path() / "rest";
};

TEST_F(RestSignTest, WithoutAFileNothingHappens) {
  RestSign sign;
  EXPECT_FALSE(sign.wanted());
  sign.tell(true);
}

TEST_F(RestSignTest, TurnsAreCounted) {
  name(RestSign::kBytes);
  {
    RestSign sign;
    EXPECT_TRUE(sign.wanted());
    for (int i = 0; i < 300; ++i) sign.tell(true);
    sign.tell(false);
  }
  std::ifstream in(file_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  uint64_t counts[2];
  ASSERT_EQ(bytes.size(), sizeof counts);
  std::memcpy(counts, bytes.data(), sizeof counts);
  EXPECT_EQ(counts[0], 1u);
  EXPECT_EQ(counts[1], 300u);
}

TEST_F(RestSignTest, AFileThatCannotHoldThemIsRefused) {
  for (const size_t bytes : {size_t{0}, size_t{8}, size_t{17}}) {
    name(bytes);
    EXPECT_THROW(RestSign(), Error) << bytes;
  }
  setenv("ARGIL_REST", (file_.string() + "/not/there").c_str(), 1);
  EXPECT_THROW(RestSign(), Error);
}

}  // namespace
}  // namespace argil::studio
