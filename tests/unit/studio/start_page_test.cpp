// The page at the start: by keys, with pictures of documents, gone when work begins.

#include <unistd.h>

#include <filesystem>

#include "clay/base/error.h"
#include "engine/saving/thumbnail.h"
#include "panels_rig.h"
#include "render/view/image.h"

namespace argil::studio {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> png(int edge) {
  render::Image image{edge, edge, {}};
  for (int i = 0; i < edge * edge; ++i) image.rgba.insert(image.rgba.end(), {uint8_t(i), 90, 40, 255});
  const std::vector<uint8_t> bytes = render::encodePng(image);
  const auto* from = reinterpret_cast<const std::byte*>(bytes.data());
  return {from, from + bytes.size()};
}

TEST(StartPage, ShowsThePicturesThatDocumentsHold) {
  const fs::path file = fs::temp_directory_path() / ("argil-start-" + std::to_string(getpid()) + ".argil");
  PanelsRig rig;
  rig.bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1; }, "a block");
  rig.frame();
  EXPECT_FALSE(rig.state.shown.firstStart) << "work has begun";
  engine::SaveExtras extras;
  extras.thumbnail = png(12);
  rig.bench.saveAs(file, extras);
  rig.until([&] { return rig.bench.snapshot()->file.path == file && !rig.bench.snapshot()->file.unsaved; }, "saved");
  EXPECT_EQ(engine::thumbnailOf(file), extras.thumbnail);
  EXPECT_THROW((void)engine::thumbnailOf(file.string() + ".gone"), Error);

  rig.state.recentFiles = {file.string(), "/no/such.argil", "/no/model.stl"};
  rig.state.shown.firstStart = true;  // From the Help menu: it stays although there is clay.
  std::vector<std::pair<uint32_t, const render::Image*>> pictures;
  rig.until(
      [&] {
        pictures = rig.panels->takePictures();
        return !pictures.empty();
      },
      "the picture");
  EXPECT_TRUE(rig.state.shown.firstStart);
  ASSERT_EQ(pictures.size(), 1u);
  EXPECT_EQ(pictures[0].second->width, 12);
  rig.frame();
  EXPECT_TRUE(rig.panels->takePictures().empty()) << "each once";
  rig.panels->forgetPictures();
  EXPECT_EQ(rig.panels->takePictures().size(), 1u) << "the device was lost";
  fs::remove(file);
}

TEST(StartPage, IsGoneThroughByKeys) {
  PanelsRig rig;
  ASSERT_TRUE(rig.state.shown.firstStart);
  rig.key(ImGuiKey_Tab);
  rig.key(ImGuiKey_RightArrow);  // The ball.
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_UpArrow);
  rig.key(ImGuiKey_Enter);
  rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1; }, "a ball");
  EXPECT_EQ(rig.bench.snapshot()->document->pieces[0].name, "Sphere");
  EXPECT_FALSE(rig.state.shown.firstStart);
}

TEST(StartPage, ClosesByEscapeAndStaysAwayWhenItIsNotWanted) {
  PanelsRig rig;
  rig.key(ImGuiKey_Escape);
  EXPECT_FALSE(rig.state.shown.firstStart);
  rig.run("panel.firstStart");
  EXPECT_TRUE(rig.state.shown.firstStart);
  const ImVec2 at = rig.find("First start", {"Show this page when Argil starts", "switch"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  EXPECT_FALSE(rig.state.startPage);
}

}  // namespace
}  // namespace argil::studio
