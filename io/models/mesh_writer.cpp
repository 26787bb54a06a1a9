#include "io/models/mesh_writer.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "io/bytes/atomic_file.h"
#include "io/bytes/input.h"
#include "io/models/format_table.h"
#include "io/models/model_writer.h"

namespace argil::io {

namespace {

/// Elements between two looks at the job.
constexpr size_t kStep = 16384;

// `streamed`: that can be written piece by piece.
const Format& formatFor(const std::filesystem::path& path, const WriteOptions& options, bool streamed) {
  const std::string extension =
      endingOf(options.extension.empty() ? path : std::filesystem::path("x" + options.extension));
  std::string supported;
  for (const Format& format : formats()) {
    if (format.encoder == nullptr && (streamed || format.write == nullptr)) continue;
    if (format.extension == extension) return format;
    supported += (supported.empty() ? "" : ", ") + std::string(format.extension);
  }
  fail(displayName(path), (extension.empty() ? std::string("has no ending") : "cannot write " + shown(extension)) +
                              "; name a file that ends in one of " + supported);
}

/// The nearest 32-bit number. Through memory: g++ 12 at -O2 (SLP vectorization) drops a narrowing that is widened again
/// at once, and would report that nothing was lost.
double narrowed(double value) {
  const volatile float narrow = float(value);
  return double(narrow);
}

void requireAmount(const std::filesystem::path& path, const MeshCounts& counts) {
  if (counts.triangles == 0 || counts.vertices == 0) {
    throw Error(displayName(path) + ": there is no surface to write; add clay first", Error::Kind::work);
  }
  if (std::max(counts.triangles, counts.vertices) > UINT32_MAX) {
    throw Error(displayName(path) + ": the formats hold 4 294 967 295 triangles at most; reduce the surface first",
                Error::Kind::work);
  }
}

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

[[noreturn]] void failWork(const std::string& name, const std::string& wrong) {
  throw Error(name + ": " + wrong, Error::Kind::work);
}

/// Notes what 32-bit numbers lose. The first that cannot be written is looked for where the whole says that there is
/// one: most have none, and then one pass without branches is enough.
void checkPositions(const std::string& name, std::span<const Vec3d> positions, uint64_t first, bool single,
                    WriteReport& report) {
  bool good = true;
  double loss = 0;
  const double most = single ? double(std::numeric_limits<float>::max()) : std::numeric_limits<double>::max();
  const double* const numbers = positions.front().data();
  for (size_t i = 0; i < 3 * positions.size(); ++i) good &= std::abs(numbers[i]) <= most;
  if (!good) {
    for (size_t i = 0; i < 3 * positions.size(); ++i) {
      if (!std::isfinite(numbers[i]))
        failWork(name, "vertex " + std::to_string(first + i / 3) + " is not finite; nothing was written");
      if (std::abs(numbers[i]) > most) {
        failWork(name, "a coordinate of " + rounded(numbers[i]) +
                           " mm does not fit the format; move the model nearer to the origin or write .obj");
      }
    }
  }
  if (!single) return;
  for (size_t i = 0; i < 3 * positions.size(); ++i) loss = std::max(loss, std::abs(narrowed(numbers[i]) - numbers[i]));
  report.rounding = std::max(report.rounding, loss);
}

void checkCorners(const std::string& name, std::span<const std::array<uint32_t, 3>> triangles, uint64_t vertices) {
  uint32_t highest = 0;
  for (const auto& triangle : triangles)
    for (const uint32_t v : triangle) highest = std::max(highest, v);
  if (!triangles.empty() && highest >= vertices)
    failWork(name, "a triangle names a vertex that is not there; nothing was written");
}

void checkMesh(const std::string& name, const clay::TriangleMesh& mesh, bool single, WriteReport& report) {
  if (!mesh.positions.empty()) checkPositions(name, mesh.positions, report.vertices, single, report);
  checkCorners(name, mesh.triangles, mesh.positions.size());
  report.vertices += mesh.positions.size();
  report.triangles += mesh.triangles.size();
}

/// One a vertex; white where the object says nothing. Colours of triangles become the mean at their corners.
std::vector<Colour> coloursOfVertices(const ModelObject& object) {
  if (object.triangleColours.empty() && !object.vertexColours.empty()) return object.vertexColours;
  std::vector<Colour> colours(object.mesh.positions.size(), object.colour.value_or(Colour{}));
  if (object.triangleColours.empty()) return colours;
  std::vector<std::array<uint64_t, 5>> sums(colours.size());
  for (size_t t = 0; t < object.triangleColours.size(); ++t) {
    const Colour& c = object.triangleColours[t];
    for (const uint32_t v : object.mesh.triangles[t]) {
      if (v >= sums.size()) continue;  // Refused when the triangles come.
      auto& sum = sums[v];
      sum = {sum[0] + c.red, sum[1] + c.green, sum[2] + c.blue, sum[3] + c.alpha, sum[4] + 1};
    }
  }
  for (size_t v = 0; v < colours.size(); ++v) {
    const auto& sum = sums[v];
    const auto mean = [&](size_t k) { return static_cast<uint8_t>((sum[k] + sum[4] / 2) / sum[4]); };
    if (sum[4] > 0) colours[v] = {mean(0), mean(1), mean(2), mean(3)};
  }
  return colours;
}

Colour colourOfTriangle(const ModelObject& object, size_t triangle) {
  if (!object.triangleColours.empty()) return object.triangleColours[triangle];
  if (object.vertexColours.empty()) return object.colour.value_or(Colour{});
  const auto& [a, b, c] = object.mesh.triangles[triangle];
  return meanOf(object.vertexColours[a], object.vertexColours[b], object.vertexColours[c]);
}

// What is lost must stay small beside the model itself: below a thousandth of its extent.
constexpr double kMostLoss = 1e-3;

void refuseCoarse(const std::string& name, const Eigen::AlignedBox3d& box, double rounding) {
  if (box.isEmpty() || !(rounding > kMostLoss * box.sizes().maxCoeff())) return;
  failWork(name, "the model is so small for where it lies that the format's 32-bit numbers would lose " +
                     rounded(rounding) + " mm of its " + rounded(box.sizes().maxCoeff()) +
                     " mm; move it to zero as it is exported (convert --recentre), or write .obj");
}

void warnOfRounding(const std::string& name, const WriteOptions& options, WriteReport& report) {
  if (report.rounding <= options.tolerance) return;
  report.warning = name + ": coordinates lose up to " + rounded(report.rounding) +
                   " mm to the format's 32-bit numbers, more than " + rounded(options.tolerance) +
                   " mm; move the model nearer to the origin or write .obj";
}

}  // namespace

struct MeshWriter::State {
  State(const std::filesystem::path& path, const Format& row, const MeshCounts& promised, const WriteOptions& wishes,
        Job* watcher)
      : name(displayName(path)),
        format(row),
        options(wishes),
        counts(promised),
        job(watcher),
        encoder(row.encoder(wishes)),
        file(path),
        sink(file),
        single(row.singlePrecision && !(wishes.doubles && row.extension == ".ply")) {}

  [[noreturn]] void failWork(const std::string& wrong) const { io::failWork(name, wrong); }

  void step() {
    const double all = double(counts.vertices + counts.triangles);
    if (job != nullptr) job->step(double(report.vertices + report.triangles) / all);
  }

  std::string name;
  const Format& format;
  WriteOptions options;
  MeshCounts counts;
  Job* job;
  std::unique_ptr<MeshEncoder> encoder;
  AtomicFile file;
  ByteSink sink;
  bool single;
  Eigen::AlignedBox3d box;  // of what a single-precision format was given
  WriteReport report;
};

MeshWriter::MeshWriter(const std::filesystem::path& path, const MeshCounts& counts, const WriteOptions& options,
                       Job* job) {
  const Format& format = formatFor(path, options, true);
  requireAmount(path, counts);
  state_ = std::make_unique<State>(path, format, counts, options, job);
  state_->encoder->begin(state_->sink, counts);
  state_->step();
}

MeshWriter::~MeshWriter() = default;

void MeshWriter::vertices(std::span<const Vec3d> positions) {
  vertices(positions, {});
}

void MeshWriter::vertices(std::span<const Vec3d> positions, std::span<const Colour> colours) {
  State& s = *state_;
  if (positions.size() > s.counts.vertices - s.report.vertices) s.failWork("more vertices came than were announced");
  if (colours.size() != (s.counts.colours ? positions.size() : 0))
    s.failWork("vertices came without the colours that were announced, or with others");
  while (!positions.empty()) {
    const auto piece = positions.first(std::min(kStep, positions.size()));
    checkPositions(s.name, piece, s.report.vertices, s.single, s.report);
    if (s.single)
      for (const Vec3d& p : piece) s.box.extend(p);
    if (s.counts.colours) {
      s.encoder->colouredVertices(s.sink, piece, colours.first(piece.size()));
      colours = colours.subspan(piece.size());
    } else {
      s.encoder->vertices(s.sink, piece);
    }
    s.report.vertices += piece.size();
    s.step();
    positions = positions.subspan(piece.size());
  }
}

void MeshWriter::object(const std::string& name) {
  state_->encoder->object(state_->sink, name);
}

void MeshWriter::triangles(std::span<const std::array<uint32_t, 3>> list) {
  triangles(list, {});
}

void MeshWriter::triangles(std::span<const std::array<uint32_t, 3>> triangles, std::span<const Colour> colours) {
  State& s = *state_;
  if (colours.size() != (s.counts.triangleColours ? triangles.size() : 0))
    s.failWork("triangles came without the colours that were announced, or with others");
  if (s.report.vertices != s.counts.vertices) s.failWork("triangles came before all vertices");
  if (triangles.size() > s.counts.triangles - s.report.triangles) s.failWork("more triangles came than were announced");
  while (!triangles.empty()) {
    const auto piece = triangles.first(std::min(kStep, triangles.size()));
    checkCorners(s.name, piece, s.counts.vertices);
    if (s.counts.triangleColours) {
      s.encoder->colouredTriangles(s.sink, piece, colours.first(piece.size()));
      colours = colours.subspan(piece.size());
    } else {
      s.encoder->triangles(s.sink, piece);
    }
    s.report.triangles += piece.size();
    s.step();
    triangles = triangles.subspan(piece.size());
  }
}

WriteReport MeshWriter::finish() {
  State& s = *state_;
  if (s.report.vertices != s.counts.vertices || s.report.triangles != s.counts.triangles) {
    s.failWork("fewer vertices or triangles came than were announced");
  }
  refuseCoarse(s.name, s.box, s.report.rounding);
  s.encoder->end(s.sink);
  s.sink.flush();
  s.file.commit();
  s.report.format = s.format.name;
  if (s.format.extension == ".stl") s.report.format += s.options.text ? " (text)" : " (binary)";
  s.report.bytes = s.file.bytes();
  warnOfRounding(s.name, s.options, s.report);
  return s.report;
}

void requireWritable(const std::filesystem::path& path, const WriteOptions& options) {
  static_cast<void>(formatFor(path, options, false));
  std::error_code failed;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, failed))
    fail(displayName(path), "its folder is not there; make it first or name another");
  if (std::filesystem::is_directory(path, failed)) fail(displayName(path), "is a folder; name a file");
}

bool writesPiecewise(const std::filesystem::path& path) {
  return formatFor(path, {}, false).encoder != nullptr;
}

WriteReport writeMesh(const std::filesystem::path& path, const clay::TriangleMesh& mesh, const WriteOptions& options,
                      Job* job) {
  if (formatFor(path, options, false).encoder == nullptr) {
    ModelObject object;
    object.mesh = mesh;
    return writeModel(path, {{&object, 1}, {}}, options, job);
  }
  MeshWriter writer(path, {mesh.positions.size(), mesh.triangles.size()}, options, job);
  writer.vertices(mesh.positions);
  writer.triangles(mesh.triangles);
  return writer.finish();
}

std::vector<std::string> lossesOf(const std::filesystem::path& path, const ModelView& model,
                                  const WriteOptions& options) {
  const Format& format = formatFor(path, options, false);
  const std::string name(format.name);
  const auto& objects = model.objects;
  const auto any = [&](const auto& has) { return std::any_of(objects.begin(), objects.end(), has); };
  const bool byTriangle = any([](const ModelObject& each) { return !each.triangleColours.empty(); });
  // One colour of the whole model is no news.
  const bool painted = byTriangle || any([](const ModelObject& each) { return !each.vertexColours.empty(); }) ||
                       any([&](const ModelObject& each) { return each.colour != objects.front().colour; });
  std::vector<std::string> sentences;
  if (!format.colours && painted) sentences.push_back(name + " has no colours: they are left out.");
  if (format.colours && !format.triangleColours && byTriangle)
    sentences.push_back(name +
                        " has colours of vertices alone: those of triangles become the mean around each vertex.");
  if (!format.objects && objects.size() > 1)
    sentences.push_back(
        fmt::format("{} holds one mesh: {} objects become one, without their names.", name, objects.size()));
  return sentences;
}

WriteReport writeModel(const std::filesystem::path& path, const ModelView& model, const WriteOptions& options,
                       Job* job) {
  const Format& format = formatFor(path, options, false);
  MeshCounts counts;
  for (const ModelObject& object : model.objects) {
    counts.vertices += object.mesh.positions.size();
    counts.triangles += object.mesh.triangles.size();
  }
  requireAmount(path, counts);
  if (format.write == nullptr) {
    for (const ModelObject& object : model.objects) {
      counts.colours =
          counts.colours || object.colour || !object.vertexColours.empty() || !object.triangleColours.empty();
      counts.triangleColours = counts.triangleColours || !object.triangleColours.empty();
    }
    MeshWriter writer(path, counts, options, job);
    for (const ModelObject& object : model.objects) {
      if (counts.colours) {
        writer.vertices(object.mesh.positions, coloursOfVertices(object));
      } else {
        writer.vertices(object.mesh.positions);
      }
    }
    uint32_t first = 0;
    std::vector<std::array<uint32_t, 3>> moved;
    std::vector<Colour> colours;
    for (const ModelObject& object : model.objects) {
      if (!object.name.empty() || model.objects.size() > 1) writer.object(object.name);
      for (size_t at = 0; at < object.mesh.triangles.size(); at += kStep) {
        moved.clear();
        colours.clear();
        for (size_t i = at; i < std::min(at + kStep, object.mesh.triangles.size()); ++i) {
          const auto& [a, b, c] = object.mesh.triangles[i];
          moved.push_back({a + first, b + first, c + first});
          if (counts.triangleColours) colours.push_back(colourOfTriangle(object, i));
        }
        writer.triangles(moved, colours);
      }
      first += static_cast<uint32_t>(object.mesh.positions.size());
    }
    return writer.finish();
  }
  WriteReport report;
  const std::string name = displayName(path);
  Eigen::AlignedBox3d box;
  for (const ModelObject& object : model.objects) {
    checkMesh(name, object.mesh, format.singlePrecision, report);
    for (const Vec3d& p : object.mesh.positions) box.extend(p);
  }
  if (format.singlePrecision) refuseCoarse(name, box, report.rounding);
  AtomicFile file(path);
  format.write(file, model, options, report, job);
  file.commit();
  report.format = format.name;
  report.bytes = file.bytes();
  warnOfRounding(name, options, report);
  return report;
}

}  // namespace argil::io
