// .drc files: what Draco itself reads in them, and what we read back.
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clay/mesh/mesh_topology.h"
#include "io/models/draco_mesh.h"
#include "io/models/model_file.h"
#include "io/models/model_writer.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using testing::HasSubstr;

std::unique_ptr<draco::Mesh> decoded(const std::filesystem::path& path) {
  const std::string bytes = samples::slurp(path);
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
  EXPECT_TRUE(mesh.ok());
  return mesh.ok() ? std::move(mesh).value() : nullptr;
}

ModelObject cubeAt(const Vec3d& middle) {
  ModelObject object;
  object.mesh = samples::cube(10, middle);
  return object;
}

TEST(Draco, DracoReadsWhatWeWrite) {
  const samples::Folder folder;
  std::vector<ModelObject> objects = {cubeAt({0.1, 0.2, 0.3}), cubeAt({100.7, 0, 0})};
  objects[1].colour = Colour{10, 20, 30, 40};
  const WriteReport report = writeModel(folder / "a.drc", {objects, {}});
  EXPECT_EQ(report.format, "Draco");
  EXPECT_EQ(report.triangles, 24u);
  EXPECT_EQ(report.vertices, 16u);
  EXPECT_EQ(report.bytes, std::filesystem::file_size(folder / "a.drc"));
  const double step = 120.6 / 65535;
  EXPECT_GT(report.deviation, 0);
  EXPECT_LE(report.rounding, step / 2 * 1.01);
  EXPECT_LE(report.deviation, step / 2 * std::sqrt(3.0) * 1.01);

  const auto mesh = decoded(folder / "a.drc");
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->num_faces(), 24u);
  const auto* position = mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  const auto* colour = mesh->GetNamedAttribute(draco::GeometryAttribute::COLOR);
  ASSERT_NE(colour, nullptr);
  double worst = 0;
  for (uint32_t i = 0; i < mesh->num_points(); ++i) {
    std::array<float, 3> at{};
    position->GetMappedValue(draco::PointIndex(i), at.data());
    std::array<uint8_t, 4> c{};
    colour->GetMappedValue(draco::PointIndex(i), c.data());
    double nearest = INFINITY;
    for (const ModelObject& object : objects) {
      for (const Vec3d& p : object.mesh.positions)
        nearest = std::min(nearest, (p - Vec3d(double(at[0]), double(at[1]), double(at[2]))).norm());
    }
    worst = std::max(worst, nearest);
    EXPECT_EQ(c, at[0] < 50 ? (std::array<uint8_t, 4>{255, 255, 255, 255}) : (std::array<uint8_t, 4>{10, 20, 30, 40}));
  }
  // What the report states is what the decoder shows, to the last bit of a double.
  EXPECT_NEAR(worst, report.deviation, 1e-12);

  const ModelFile model = readModel(folder / "a.drc");
  EXPECT_EQ(model.format, "Draco");
  EXPECT_FALSE(model.unitMm);
  ASSERT_EQ(model.objects.size(), 1u);
  EXPECT_TRUE(clay::checkTopology(model.objects[0].mesh).closed());
  EXPECT_NEAR(clay::checkTopology(model.objects[0].mesh).volume, 16000, 10);
  EXPECT_EQ(
      std::count(model.objects[0].vertexColours.begin(), model.objects[0].vertexColours.end(), Colour{10, 20, 30, 40}),
      8);
}

TEST(Draco, ErrorIsKept) {
  const samples::Folder folder;
  const ModelObject object = cubeAt({3.3, 1.1, 2.7});
  uint64_t last = 0;
  for (const double error : {1.0, 0.01, 1e-5}) {
    WriteOptions options;
    options.quantization = error;
    const WriteReport report = writeModel(folder / "a.drc", {{&object, 1}, {}}, options);
    EXPECT_LE(report.rounding, error);
    EXPECT_GE(report.bytes, last);
    last = report.bytes;
  }
  WriteOptions finest;
  finest.quantization = 1e-30;
  EXPECT_LT(writeModel(folder / "a.drc", {{&object, 1}, {}}, finest).deviation, 1e-5);
  EXPECT_TRUE(decoded(folder / "a.drc"));
}

TEST(Draco, LinearLightKeepsEveryByte) {
  for (int c = 0; c < 256; ++c) {
    const double linear = linearOf(uint8_t(c)) / 65535.0;
    const double srgb = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    EXPECT_EQ(std::lround(255 * srgb), c);
  }
}

TEST(Draco, PointCloudsAreRefused) {
  const samples::Folder folder;
  draco::PointCloud cloud;
  cloud.set_num_points(3);
  auto position = std::make_unique<draco::PointAttribute>();
  position->Init(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32, false, 3);
  cloud.AddAttribute(std::move(position));
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodePointCloudToBuffer(cloud, &buffer).ok());
  samples::spill(folder / "a.drc", {buffer.data(), buffer.size()});
  EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readModel(folder / "a.drc")); }), HasSubstr("cloud of points"));
}

}  // namespace
}  // namespace argil::io
