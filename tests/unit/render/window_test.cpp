// A real window on a screen of the tests' own. Every frame goes through the validation layer where it is installed.

#include <gtest/gtest.h>

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

#include <chrono>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include "clay/base/error.h"
#include "render/renderer/renderer.h"
#include "tests/support/x_server.h"
#include "tests/unit/render/field_surface.h"
#include "tests/unit/render/panel_sample.h"

extern "C" unsigned long glfwGetX11Window(GLFWwindow*);  // its own header brings in X11's macros

namespace argil::render {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;
using test::addRectangle;
using test::rgba;

class GlfwWindow {
 public:
  GlfwWindow(int width, int height) {
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    handle_ = glfwCreateWindow(width, height, "Argil", nullptr, nullptr);
  }
  ~GlfwWindow() {
    if (handle_) glfwDestroyWindow(handle_);
  }
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  WindowHooks hooks() {
    WindowHooks hooks;
    uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    hooks.instanceExtensions.assign(names, names + count);
    hooks.makeSurface = [this](void* instance) -> uint64_t {
      VkSurfaceKHR surface = VK_NULL_HANDLE;
      if (glfwCreateWindowSurface(static_cast<VkInstance>(instance), handle_, nullptr, &surface) != VK_SUCCESS)
        return 0;
      return reinterpret_cast<uint64_t>(surface);
    };
    hooks.size = [this] {
      std::array<int, 2> size{};
      if (!glfwGetWindowAttrib(handle_, GLFW_ICONIFIED)) glfwGetFramebufferSize(handle_, &size[0], &size[1]);
      return size;
    };
    return hooks;
  }
  [[nodiscard]] GLFWwindow* handle() const { return handle_; }
  void resize(int width, int height) {
    glfwSetWindowSize(handle_, width, height);
    glfwPollEvents();
  }

  [[nodiscard]] unsigned long id() const { return glfwGetX11Window(handle_); }

 private:
  GLFWwindow* handle_ = nullptr;
};

/// Polls until something is so; false when it takes unreasonably long.
template <class Condition>
bool within(std::chrono::seconds patience, Condition&& condition) {
  const auto latest = steady_clock::now() + patience;
  while (!condition()) {
    if (steady_clock::now() > latest) return false;
    glfwPollEvents();
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

class WindowTest : public testing::Test {
 protected:
  static constexpr int kWidth = 200, kHeight = 140;

  static void open(bool windowManager) {
    screen_.windowManager = windowManager;
    if (!support::XServer::missing(screen_).empty()) return;
    server_ = std::make_unique<support::XServer>(screen_);
    ASSERT_TRUE(glfwInit());
  }
  static void SetUpTestSuite() { open(false); }
  static void TearDownTestSuite() {
    if (server_) glfwTerminate();
    server_.reset();
  }
  void SetUp() override {
    if (!server_) GTEST_SKIP() << support::XServer::missing(screen_);
    if (devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: pictures cannot be drawn";
    window_.emplace(kWidth, kHeight);
    ASSERT_TRUE(window_->handle());
    start({});
    panels_ = test::emptyPanels(kWidth, kHeight);
    addRectangle(panels_, {8, 8, 60, 100}, rgba(240, 120, 10, 200));
  }
  void TearDown() override {
    if (!renderer_) return;
    for (const std::string& message : renderer_->validationMessages()) ADD_FAILURE() << message;
  }
  void start(RendererOptions options) {
    options.validation = true;
    options.quality.supersample = 1;
    options.quality.shadowPixels = 256;
    renderer_.emplace(options);
    renderer_->attach(window_->hooks());
    surface_ = {};
    load(16);
    shot_.view = View::named("iso", renderer_->bounds(), double(kWidth) / kHeight);
  }
  void load(double radius) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    renderer_->update(
        surface_.update(grid, {-3, -3, -3}, {2, 2, 2}, [&](const Vec3d& p) { return p.norm() - radius; }));
  }
  /// What the X server has in the window, straight from it.
  [[nodiscard]] Image onScreen() const {
    const auto pixels = server_->pixels(window_->id());
    return {pixels.width, pixels.height, pixels.rgba};
  }
  bool present() { return renderer_->present(shot_, panels_); }
  Image still(int width = kWidth, int height = kHeight) { return renderer_->render(shot_, width, height, &panels_); }

  static inline support::XServer::Options screen_;
  static inline std::unique_ptr<support::XServer> server_;
  std::optional<GlfwWindow> window_;
  test::FieldSurface surface_;
  std::optional<Renderer> renderer_;
  Shot shot_;
  UiFrame panels_;
};

TEST_F(WindowTest, ShowsThePictureThatAnImageHolds) {
  ASSERT_TRUE(present());
  const Image shown = renderer_->lastPresented();
  EXPECT_TRUE(within(120s, [&] { return onScreen() == shown; })) << "the screen shows something else";
  EXPECT_EQ(still(), shown);
  // Another picture drawn since does not change what the window showed.
  (void)renderer_->render(shot_, 64, 48);
  EXPECT_EQ(renderer_->lastPresented(), shown);
}

TEST_F(WindowTest, FramesUnderWayKeepTheirOwnNumbers) {
  // Every second frame has other lines and panels; each is shown while the next is made.
  std::array<Shot, 2> shots{shot_, shot_};
  std::array<UiFrame, 2> panels{panels_, panels_};
  for (int i = 0; i < 400; ++i) {
    shots[1].overlays.polylines.push_back({{Vec3d(-9, -9, 0.05 * i), Vec3d(9, 9, 0.05 * i)}, {1, 0, 0, 1}});
    addRectangle(panels[1], {float(i % 20) * 10, 110, float(i % 20) * 10 + 6, 130}, rgba(i & 255, 255 - (i & 255), 40));
  }
  std::array<Image, 2> want;
  for (size_t k : {0, 1}) {
    want[k] = renderer_->render(shots[k], kWidth, kHeight, &panels[k]);
  }
  EXPECT_NE(want[0], want[1]);
  for (int i = 0; i < 24; ++i) {
    const size_t k = size_t(i % 2);
    ASSERT_TRUE(renderer_->present(shots[k], panels[k]));
    if (i % 5 == 4) {
      EXPECT_EQ(renderer_->lastPresented(), want[k]) << "frame " << i;
    }
  }
  EXPECT_EQ(renderer_->lastPresented(), want[1]);
}

TEST_F(WindowTest, QualityMayChangeFromFrameToFrame) {
  Quality still, moving = still.moving();
  still.shadowPixels = moving.shadowPixels = 256;
  for (int i = 0; i < 12; ++i) {  // images are made anew while the last frame that used them is under way
    renderer_->setQuality(i % 2 ? still : moving);
    ASSERT_TRUE(present());
  }
  const Image shown = renderer_->lastPresented();
  EXPECT_EQ(shown, this->still());
  renderer_->setQuality(moving);
  EXPECT_NE(shown, this->still());
}

TEST_F(WindowTest, FollowsTwoHundredResizes) {
  std::mt19937 random(4);  // NOLINT: the same sizes each time
  ASSERT_TRUE(present());
  int shown = 0;
  std::array<int, 2> size{};
  for (int i = 0; i < 200; ++i) {
    size = {16 + int(random() % 240), 16 + int(random() % 200)};
    window_->resize(size[0], size[1]);
    shown += present();
  }
  EXPECT_GE(shown, 190);  // one that changes under the frame's hands may be left out
  ASSERT_TRUE(within(120s, [&] {
    return present() && renderer_->lastPresented().width == size[0] && renderer_->lastPresented().height == size[1];
  }));
  const Image last = renderer_->lastPresented();
  EXPECT_TRUE(within(120s, [&] { return onScreen() == last; }));
  window_->resize(kWidth, kHeight);
  ASSERT_TRUE(within(120s, [&] { return present() && renderer_->lastPresented().width == kWidth; }));
  EXPECT_EQ(renderer_->lastPresented(), still());
}

TEST_F(WindowTest, SmallerThanAPictureMayBe) {
  window_->resize(5, 3);
  EXPECT_TRUE(present());
  window_->resize(kWidth, kHeight);
  EXPECT_TRUE(present());
}

TEST_F(WindowTest, NothingToDrawOnCostsNothing) {
  ASSERT_TRUE(present());
  const Image shown = renderer_->lastPresented();
  WindowHooks hooks = window_->hooks();
  bool minimised = false;
  hooks.size = [&, real = hooks.size] { return minimised ? std::array<int, 2>{} : real(); };
  renderer_->attach(hooks);
  ASSERT_TRUE(present());
  const uint64_t bytes = renderer_->deviceBytes();
  minimised = true;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(present());
  EXPECT_EQ(renderer_->lastPresented(), shown);
  EXPECT_EQ(renderer_->deviceBytes(), bytes);
  minimised = false;
  EXPECT_TRUE(present());
}

TEST_F(WindowTest, AttachesAndDetachesFiftyTimes) {
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(present());  // what frames take turns with is there
  const uint64_t bytes = renderer_->deviceBytes();
  for (int i = 0; i < 50; ++i) {
    renderer_->detach();
    EXPECT_THROW(present(), Error);
    renderer_->attach(window_->hooks());
    EXPECT_TRUE(present());  // and goes while this frame is under way
  }
  EXPECT_EQ(renderer_->deviceBytes(), bytes);
  EXPECT_EQ(renderer_->lastPresented(), still());
}

TEST_F(WindowTest, ClosesWithFramesUnderWay) {
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(present());
    ASSERT_TRUE(present());
    renderer_->recover();  // ends the device, as closing does, and keeps what the validation layer says to that
    surface_ = {};
    load(16);
  }
  ASSERT_TRUE(present());
  renderer_->clear();  // drops the buffers that the frame reads
  ASSERT_TRUE(present());
}

TEST_F(WindowTest, WindowsThatCannotBeDrawnInAreRefused) {
  WindowHooks strange = window_->hooks();
  strange.instanceExtensions.emplace_back("VK_KHR_no_such_surface");
  EXPECT_THROW(renderer_->attach(strange), Error);
  WindowHooks none = window_->hooks();
  none.makeSurface = [](void*) { return uint64_t(0); };
  EXPECT_THROW(renderer_->attach(none), Error);
  EXPECT_THROW(renderer_->attach({}), Error);
  EXPECT_THROW(present(), Error);
  EXPECT_FALSE(renderer_->deviceLost());
  renderer_->attach(window_->hooks());
  EXPECT_TRUE(present());
}

TEST_F(WindowTest, ALostDeviceIsReplacedAndTheWindowGoesOn) {
  const uint8_t grey = 128;
  renderer_->setUiTexture(3, 1, 1, 1, &grey);
  addRectangle(panels_, {100, 20, 180, 60}, rgba(0, 0, 255), 3);
  ASSERT_TRUE(present());
  const Image before = renderer_->lastPresented();
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(present());
    renderer_->simulateDeviceLoss();
    EXPECT_FALSE(renderer_->deviceLost());
    try {
      present();
      FAIL() << "nothing was lost";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("lost"), std::string::npos) << error.what();
    }
    EXPECT_TRUE(renderer_->deviceLost());
    EXPECT_THROW((void)still(), Error);
    EXPECT_THROW(present(), Error);
    EXPECT_THROW(renderer_->setUiTexture(3, 1, 1, 1, &grey), Error);
    renderer_->detach();  // neither may fail on a lost device
    renderer_->attach(window_->hooks());

    renderer_->recover();
    EXPECT_FALSE(renderer_->deviceLost());
    EXPECT_EQ(renderer_->triangleCount(), 0u);
    surface_ = {};
    load(16);
    renderer_->setUiTexture(3, 1, 1, 1, &grey);
    ASSERT_TRUE(present());
    EXPECT_EQ(renderer_->lastPresented(), before);
  }
  EXPECT_TRUE(within(120s, [&] { return onScreen() == before; }));
}

TEST_F(WindowTest, AnUploadMayBeTheOneThatFails) {
  ASSERT_TRUE(present());
  renderer_->simulateDeviceLoss();
  EXPECT_THROW(load(10), Error);
  EXPECT_TRUE(renderer_->deviceLost());
  renderer_->recover();
  surface_ = {};
  load(10);
  EXPECT_TRUE(present());
  EXPECT_EQ(renderer_->lastPresented(), still());
}

class ManagedWindowTest : public WindowTest {
 protected:
  static void SetUpTestSuite() { open(true); }
};

TEST_F(ManagedWindowTest, MinimisesAndComesBack) {
  ASSERT_TRUE(present());
  for (int i = 0; i < 3; ++i) {
    glfwIconifyWindow(window_->handle());
    ASSERT_TRUE(within(120s, [&] { return !present(); }));
    glfwRestoreWindow(window_->handle());
    ASSERT_TRUE(within(120s, [&] { return present(); }));
  }
  // What was there before the window came back to the screen was wiped.
  EXPECT_TRUE(within(120s, [&] { return present() && onScreen() == renderer_->lastPresented(); }));
  EXPECT_EQ(renderer_->lastPresented(), still());
}

TEST_F(ManagedWindowTest, MaximisesAndComesBack) {
  ASSERT_TRUE(present());
  glfwMaximizeWindow(window_->handle());
  ASSERT_TRUE(within(120s, [&] { return present() && renderer_->lastPresented().width > 1000; }));
  glfwRestoreWindow(window_->handle());
  ASSERT_TRUE(within(120s, [&] { return present() && renderer_->lastPresented().width == kWidth; }));
}

}  // namespace
}  // namespace argil::render
