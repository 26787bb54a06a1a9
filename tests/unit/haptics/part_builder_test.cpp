// Parts built in the background: the newest request wins, and the old mesh lives until nobody can see it.

#include "haptics/part_builder.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "haptics/published.h"
#include "haptics/touch_bench.h"
#include "haptics/touchable_part.h"
#include "tests/support/mesh_samples.h"

namespace argil::haptics {
namespace {

using namespace std::chrono_literals;

std::shared_ptr<const clay::TriangleMesh> shared(clay::TriangleMesh mesh) {
  return std::make_shared<const clay::TriangleMesh>(std::move(mesh));
}

std::optional<PartBuilder::Result> wait(PartBuilder& builder, std::chrono::seconds most = 30s) {
  const auto end = std::chrono::steady_clock::now() + most;
  while (std::chrono::steady_clock::now() < end) {
    if (auto result = builder.poll()) return result;
    std::this_thread::sleep_for(1ms);
  }
  return std::nullopt;
}

TEST(PartBuilder, buildsAndGivesEachResultOnce) {
  PartBuilder builder;
  EXPECT_FALSE(builder.poll());
  EXPECT_EQ(builder.fraction(), 1);
  EXPECT_EQ(builder.request(shared(samples::cube(5))), 1u);
  const auto result = wait(builder);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->request, 1u);
  ASSERT_TRUE(result->mesh) << result->error;
  EXPECT_EQ(result->mesh->triangleCount(), 12u);
  EXPECT_FALSE(builder.poll());
  EXPECT_EQ(builder.fraction(), 1);
}

TEST(PartBuilder, theNewestRequestWins) {
  const auto large = shared(icosphere(40, 7));
  const auto small = shared(samples::cube(5));
  PartBuilder builder;
  for (uint64_t i = 0; i < 20; ++i) {
    EXPECT_EQ(builder.request(large), 2 * i + 1);
    if (i % 4) std::this_thread::sleep_for(std::chrono::milliseconds(i));
    EXPECT_EQ(builder.request(small), 2 * i + 2);
    // A request that has been overtaken is given up, and never answered.
    const auto result = wait(builder);
    ASSERT_TRUE(result);
    ASSERT_EQ(result->request, 2 * i + 2);
    ASSERT_TRUE(result->mesh);
    ASSERT_EQ(result->mesh->triangleCount(), 12u);
  }
}

TEST(PartBuilder, cancelsAndSaysWhatIsWrong) {
  PartBuilder builder;
  builder.request(shared(icosphere(40, 7)));
  builder.cancel();
  EXPECT_FALSE(wait(builder, 1s)) << "nobody asks for it any more";
  builder.request(shared({}));
  const auto result = wait(builder);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->mesh);
  EXPECT_NE(result->error.find("without triangles"), std::string::npos) << result->error;
}

TEST(PartBuilder, endsInTheMiddleOfWork) {
  const auto large = shared(icosphere(40, 7));
  for (int i = 0; i < 5; ++i) {
    PartBuilder builder;
    builder.request(large);
    std::this_thread::sleep_for(std::chrono::milliseconds(5 * i));
  }
  EXPECT_EQ(large.use_count(), 1) << "the mesh is not held after the builder is gone";
}

TEST(PartBuilder, theOldMeshServesUntilNoReaderCanSeeIt) {
  PartBuilder builder;
  Published<Scene> published;
  Scene scene = partScene(40, 4, 3);
  std::weak_ptr<const PartMesh> old = scene.parts[0].mesh;
  published.publish(std::make_unique<const Scene>(scene));

  Published<Scene>::Reader reader(published);
  TouchablePart part;
  const Scene* seen = reader.enter();
  part.reset(seen->parts[0], 3);
  EXPECT_NEAR(part.nearest({0, 43, 0}, 4, nullptr).distance, 3, 0.1);

  builder.request(shared(icosphere(38, 5)));
  const auto result = wait(builder);
  ASSERT_TRUE(result && result->mesh);
  scene.parts[0].mesh = result->mesh;
  published.publish(std::make_unique<const Scene>(scene));
  // The reader is still in its tick.
  EXPECT_FALSE(old.expired());
  EXPECT_NEAR(part.nearest({0, 43, 0}, 4, nullptr).distance, 3, 0.1);
  EXPECT_EQ(published.reclaim(), 1u);

  seen = reader.enter();
  EXPECT_TRUE(part.reset(seen->parts[0], 3));
  EXPECT_NEAR(part.nearest({0, 43, 0}, 6, nullptr).distance, 5, 0.1);
  EXPECT_EQ(published.reclaim(), 0u);
  EXPECT_TRUE(old.expired());
}

// A servo that touches while parts are rebuilt and swapped under it: never between two meshes.
TEST(PartBuilder, aReaderOnAnotherThreadAlwaysSeesAWholePart) {
  Published<Scene> published;
  Scene scene = partScene(40, 3, 40);
  published.publish(std::make_unique<const Scene>(scene));
  std::atomic<bool> stop{false};
  std::atomic<int> swaps{0};
  int wrong = 0, looked = 0;
  std::thread servo([&] {
    Published<Scene>::Reader reader(published);
    TouchablePart part;
    while (!stop) {
      const Scene* now = reader.enter();
      if (part.reset(now->parts[0], 3)) ++swaps;
      // The tool's radius tells which ball it is.
      const double distance = part.nearest({0, 0, 60}, 50, nullptr).distance;
      wrong += std::abs(distance - (60 - now->tool.radiusMm)) > 0.7;
      if (++looked % 64 == 0) std::this_thread::sleep_for(50us);
    }
  });
  PartBuilder builder;
  for (int i = 0; i < 12; ++i) {
    const double radius = 30 + i % 7;
    builder.request(shared(icosphere(radius, 3 + i % 2)));
    const auto result = wait(builder);
    if (!result || !result->mesh) break;
    scene.parts[0].mesh = result->mesh;
    scene.tool.radiusMm = radius;
    published.publish(std::make_unique<const Scene>(scene));
    std::this_thread::sleep_for(1ms);
  }
  stop = true;
  servo.join();
  EXPECT_LE(wrong, 0);
  EXPECT_GT(looked, 100);
  EXPECT_GT(swaps, 5);
  EXPECT_EQ(published.reclaim(), 0u);
}

}  // namespace
}  // namespace argil::haptics
