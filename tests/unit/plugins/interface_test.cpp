// What was promised of the plugin interface: structs only grow at their ends, and libraries that were compiled once are
// loaded for ever.

#include <gtest/gtest.h>

#include <cstddef>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "plugins/sdk/argil_plugin.h"
#include "tests/support/plugins/plugin_folders.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

struct Member {
  const char* name;
  size_t offset, bytes;
};
#define MEMBER(type, member)                                        \
  Member {                                                          \
#type "." #member, offsetof(type, member), sizeof(type::member) \
  }

// As they were when they were first published, on machines with 64 bits.
TEST(PluginInterface, StructsStayAsTheyWerePublished) {
  const std::vector<std::pair<Member, Member>> all{
      {MEMBER(argil_host, size), {"", 0, 4}},
      {MEMBER(argil_host, minor), {"", 4, 4}},
      {MEMBER(argil_host, self), {"", 8, 8}},
      {MEMBER(argil_host, say), {"", 16, 8}},
      {MEMBER(argil_host, progress), {"", 24, 8}},
      {MEMBER(argil_host, cancelled), {"", 32, 8}},
      {MEMBER(argil_plugin, size), {"", 0, 4}},
      {MEMBER(argil_plugin, minor), {"", 4, 4}},
      {MEMBER(argil_plugin, id), {"", 8, 8}},
      {MEMBER(argil_plugin, version), {"", 16, 8}},
      {MEMBER(argil_plugin, init), {"", 24, 8}},
      {MEMBER(argil_plugin, deinit), {"", 32, 8}},
      {MEMBER(argil_plugin, get), {"", 40, 8}},
      {MEMBER(argil_image, size), {"", 0, 4}},
      {MEMBER(argil_image, strength), {"", 4, 4}},
      {MEMBER(argil_image, a), {"", 8, 24}},
      {MEMBER(argil_image, b), {"", 32, 24}},
      {MEMBER(argil_image, radius), {"", 56, 8}},
      {MEMBER(argil_image, end_radius), {"", 64, 8}},
      {MEMBER(argil_image, axes), {"", 72, 36}},
      {MEMBER(argil_stroke, size), {"", 0, 4}},
      {MEMBER(argil_stroke, band), {"", 4, 4}},
      {MEMBER(argil_stroke, voxel_mm), {"", 8, 8}},
      {MEMBER(argil_stroke, origin_mm), {"", 16, 24}},
      {MEMBER(argil_stroke, amount), {"", 40, 4}},
      {MEMBER(argil_stroke, per_stamp), {"", 44, 4}},
      {MEMBER(argil_stroke, parameter_count), {"", 48, 4}},
      {MEMBER(argil_stroke, parameters), {"", 56, 8}},
      {MEMBER(argil_batch, size), {"", 0, 4}},
      {MEMBER(argil_batch, image_count), {"", 4, 4}},
      {MEMBER(argil_batch, images), {"", 8, 8}},
      {MEMBER(argil_batch, count), {"", 16, 4}},
      {MEMBER(argil_batch, margin), {"", 20, 4}},
      {MEMBER(argil_batch, coords), {"", 24, 8}},
      {MEMBER(argil_batch, phi), {"", 32, 8}},
      {MEMBER(argil_batch, brick), {"", 40, 4}},
      {MEMBER(argil_batch, plane), {"", 44, 4}},
      {MEMBER(argil_batch, row), {"", 48, 4}},
      {MEMBER(argil_batch, weight), {"", 56, 8}},
      {MEMBER(argil_batch, out), {"", 64, 8}},
      {MEMBER(argil_brush, size), {"", 0, 4}},
      {MEMBER(argil_brush, flags), {"", 4, 4}},
      {MEMBER(argil_brush, id), {"", 8, 8}},
      {MEMBER(argil_brush, margin), {"", 16, 4}},
      {MEMBER(argil_brush, parameter_count), {"", 20, 4}},
      {MEMBER(argil_brush, parameters), {"", 24, 8}},
      {MEMBER(argil_brush, begin), {"", 32, 8}},
      {MEMBER(argil_brush, bricks), {"", 40, 8}},
      {MEMBER(argil_brush, end), {"", 48, 8}},
  };
  const std::vector<std::pair<size_t, size_t>> sizes{
      {sizeof(argil_object), 32},       {sizeof(argil_export), 32},   {sizeof(argil_exporter), 56},
      {sizeof(argil_import), 56},       {sizeof(argil_importer), 24}, {sizeof(argil_work), 96},
      {sizeof(argil_operation), 40},    {sizeof(argil_hand), 56},     {sizeof(argil_element), 64},
      {sizeof(argil_local_model), 552}, {sizeof(argil_guide), 56},    {sizeof(argil_texture), 40},
      {sizeof(argil_device_state), 72}, {sizeof(argil_device), 40}};
  for (const auto& [now, published] : sizes) EXPECT_EQ(now, published) << &published - &sizes[0].second;
  for (const auto& [now, published] : all) {
    EXPECT_EQ(now.offset, published.offset) << now.name;
    EXPECT_EQ(now.bytes, published.bytes) << now.name;
  }
  EXPECT_EQ(ARGIL_PLUGIN_MAJOR, 1);
  EXPECT_STREQ(ARGIL_PLUGIN_SYMBOL, "argil_plugin_1");
  EXPECT_STREQ(ARGIL_BRUSH_1, "argil.brush/1");
  EXPECT_EQ(ARGIL_OK, 0);
  EXPECT_EQ(ARGIL_FAILED, 1);
  EXPECT_EQ(ARGIL_CANCELLED, 2);
  EXPECT_EQ(ARGIL_NO_MEMORY, 3);
  EXPECT_EQ(ARGIL_LEAVES_VALUES, 2u);
  EXPECT_EQ(ARGIL_BRUSH_LEAVES, 3u);
  EXPECT_EQ(ARGIL_BRUSH_SERIAL, 4u);
}

// tests/unit/plugins/kept has the libraries of the examples as version 1.0 of the header was published.
TEST(PluginInterface, LibrariesThatWereCompiledOnceAreLoadedForEver) {
  if (std::string(kPluginMachine) != "x86_64-linux") GTEST_SKIP() << "they were compiled for x86-64";
  const fs::path root = fs::temp_directory_path() / "kept-plugins";
  for (const std::string name : {"soften", "clay-strips"}) {
    SCOPED_TRACE(name);
    const fs::path made = root / (name + std::string(kPluginEnding));
    fs::create_directories(made / kPluginMachine);
    const fs::path kept = fs::path(ARGIL_SOURCE_DIR) / "tests/unit/plugins/kept/1.0";
    fs::copy_file(kept / (name + ".json"), made / kPluginFile, fs::copy_options::overwrite_existing);
    const Plugin plugin = readPlugin(made);
    fs::copy_file(kept / plugin.library, made / kPluginMachine / plugin.library, fs::copy_options::overwrite_existing);
    auto brush = std::make_shared<clay::Brush>();
    brush->operations.push_back({clay::Property::distance, clay::Method::external});
    brush->external = tests::brushIn(made);
    for (const auto& number : plugin.brushes.at(0).tool.numbers)
      brush->values.push_back(static_cast<float>(number.standard));
    const clay::Version base = clay::makeSphere(clay::Store::make(), clay::Grid{}, Vec3d::Zero(), 20);
    clay::BrushStroke stroke(base, brush);
    for (int i = 0; i < 8; ++i) stroke.apply({Vec3d(i, 2, 40), Vec3d(i + 1, 2, 40), 9, 0.6f});
    EXPECT_NE(stroke.finish().hash(), base.hash());
  }
  fs::remove_all(root);
}

}  // namespace
}  // namespace argil::engine
