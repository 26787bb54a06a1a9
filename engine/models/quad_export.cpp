#include "engine/models/quad_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <span>
#include <utility>

#include "clay/base/error.h"
#include "clay/base/rounded_up.h"
#include "clay/cage/flat_quads.h"
#include "clay/field/region_work.h"
#include "clay/mesh/reduce.h"
#include "clay/surface/surface.h"
#include "clay/unwrap/bake.h"
#include "clay/unwrap/charts.h"
#include "clay/unwrap/unwrap.h"
#include "engine/models/model_colours.h"
#include "engine/models/quad_wishes.h"
#include "io/models/mesh_writer.h"
#include "io/textured/png.h"
#include "io/textured/textured_mesh.h"

namespace argil::engine {

namespace {

// sRGB between the corners of a triangle of the clay's surface.
std::array<uint8_t, 3> colourAt(const clay::TriangleMesh& surface, const std::vector<io::Colour>& colours,
                                uint32_t triangle, const Vec3d& at) {
  const auto& t = surface.triangles[triangle];
  const Vec3d &a = surface.positions[t[0]], b = surface.positions[t[1]] - a, c = surface.positions[t[2]] - a;
  const Vec3d p = at - a, area = b.cross(c);
  const double whole = std::max(area.squaredNorm(), 1e-300);
  const double second = std::clamp(p.cross(c).dot(area) / whole, 0.0, 1.0),
               third = std::clamp(b.cross(p).dot(area) / whole, 0.0, 1.0 - second);
  const auto part = [&](uint8_t io::Colour::*channel) {
    return static_cast<uint8_t>(std::lround((1 - second - third) * colours[t[0]].*channel +
                                            second * colours[t[1]].*channel + third * colours[t[2]].*channel));
  };
  return {part(&io::Colour::red), part(&io::Colour::green), part(&io::Colour::blue)};
}

io::TexturedObject objectOf(const Document& document, const Piece& piece, const ModelExport& what,
                            const clay::WorkPart& part, Job* job, std::vector<std::string>& sentences) {
  const int threads = clay::threadCount(0);
  clay::FlatQuads quads = clay::flatQuads(piece.version, *what.quads, what.mirrored, threads, part.part(0, 0.55),
                                          wishesFor(document, piece, what));
  const clay::CageMaker& maker = *quads.maker;
  io::TexturedObject out;
  out.name = piece.name;
  out.colour = fileColourOf(piece);
  out.mesh = std::move(quads.mesh);
  out.map = clay::unwrapped(out.mesh, {}, part.part(0.55, 0.8));
  out.frames = clay::framesOf(out.mesh, out.map);
  const clay::Deviation off = clay::deviation(maker.surface(), clay::trianglesOf(out.mesh), job);
  sentences.push_back(fmt::format(
      "{}: {} quads; {:.2g} mm RMS off the clay, {:.2g} at most; {} charts on {:.0f} % of the picture, stretched by "
      "{:.1f} %.",
      piece.name, out.mesh.quads.size(), off.rmsMm, clay::roundedUp(off.most()), out.map.charts, 100 * out.map.covered,
      100 * (out.map.stretch - 1)));
  if (quads.tooFarMm > 0)
    sentences.push_back(fmt::format("{}: {} quads {}, so more were drawn.", piece.name, *what.quads,
                                    std::isfinite(quads.tooFarMm)
                                        ? fmt::format("would lie up to {:.2g} mm off it", quads.tooFarMm)
                                        : "do not go around it"));
  const clay::QuadShapes shapes = clay::shapesOf(out.mesh);
  std::string shape = fmt::format(
      "{}: {} vertices have more or fewer than four quads; scaled Jacobians (1 for a rectangle) {:.2f} in the mean, "
      "{:.2f} at least",
      piece.name, clay::QuadTopology(out.mesh).irregular(), shapes.mean, shapes.least);
  if (quads.mirror)
    shape += fmt::format("; mirrored at {} = {:g} mm of the piece", "xyz"[quads.mirror->axis], quads.mirror->atMm);
  else if (what.mirrored)
    shape +=
        "; not mirrored: no plane across an axis of the piece mirrors its clay within two voxels, or its half "
        "could not be joined to its image";
  sentences.push_back(shape + ".");
  std::ranges::move(wishWords(document, piece, what, quads.met), std::back_inserter(sentences));
  if (what.texturePixels > 0) {
    std::vector<io::Colour> colours;
    {
      clay::Surface surface(false, maker.grade());
      surface.update(piece.version, threads);
      colours = vertexColoursOf(surface, piece);
    }
    std::function<std::array<uint8_t, 3>(uint32_t, const Vec3d&)> painted;
    if (!colours.empty())
      painted = [&](uint32_t triangle, const Vec3d& at) { return colourAt(maker.surface(), colours, triangle, at); };
    const int pixels = what.texturePixels;
    const clay::BakedPictures pictures = clay::baked(piece.version, maker.surface(), maker.tree(), out.mesh, out.map,
                                                     pixels, painted, threads, part.part(0.8, 1));
    out.normals = io::pngOf(pixels, pixels, std::span<const uint8_t>(pictures.normals));
    out.heights = io::pngOf(pixels, pixels, std::span<const uint16_t>(pictures.heights));
    if (painted) out.colours = io::pngOf(pixels, pixels, std::span<const uint8_t>(pictures.colours));
    out.heightMm = pictures.heightMm;
    sentences.push_back(fmt::format(
        "{}: pictures of {} × {} pixels, {:.2g} mm each; heights up to {:.2g} mm; {:.1f} % of the pixels met no clay "
        "along their normal and took what is nearest.",
        piece.name, pixels, pixels, out.map.mmOfSide / pixels, out.heightMm, 100 * pictures.missed));
  }
  // Into the world.
  const Eigen::Matrix3d turn = piece.pose.rotation.toRotationMatrix();
  const Vec3d move = piece.pose.translation + (what.putBack ? piece.fileOffsetMm : Vec3d::Zero());
  for (Vec3d& p : out.mesh.positions) p = turn * p + move;
  for (Vec3d& n : out.frames.normals) n = turn * n;
  for (Vec3d& t : out.frames.tangents) t = turn * t;
  return out;
}

}  // namespace

std::vector<std::string> writeQuads(const std::filesystem::path& file, const Document& document,
                                    const ModelExport& what, Job* job) {
  std::vector<const Piece*> pieces;
  for (const Piece& each : document.pieces)
    if (each.version && (what.piece != 0 ? each.id == what.piece : !what.visibleOnly || each.visible))
      pieces.push_back(&each);
  if (pieces.empty()) throw Error("there is no clay to export: show a piece, or export the hidden ones too");
  io::requireWritable(file);
  const clay::WorkPart all(job);
  std::vector<io::TexturedObject> objects;
  std::vector<std::string> sentences;
  for (size_t i = 0; i < pieces.size(); ++i)
    objects.push_back(
        objectOf(document, *pieces[i], what,
                 all.part(0.95 * double(i) / double(pieces.size()), 0.95 * double(i + 1) / double(pieces.size())), job,
                 sentences));
  const std::vector<std::string> names = io::writeTextured(file, objects, job);
  sentences.push_back(fmt::format("{} written.", fmt::join(names, ", ")));
  return sentences;
}

}  // namespace argil::engine
