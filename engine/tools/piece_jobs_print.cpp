// Operations that make a piece ready to print.

#include <fmt/format.h>

#include <array>
#include <iterator>

#include "clay/base/error.h"
#include "clay/mould/mould.h"
#include "clay/whole/drain.h"
#include "clay/whole/fill_hollows.h"
#include "clay/whole/pegs.h"
#include "engine/document/beside.h"
#include "engine/document/size_words.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {
namespace {

const Piece& pieceOf(const Document& document, const PieceArguments& arguments) {
  return *document.piece(arguments.pieces[0]);
}

std::string counted(size_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

PieceResult infill(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const auto& values = a.get<InfillValues>();
  const clay::FilledHollows made = clay::fillHollows(piece.version,
                                                     {.kind = values.kind,
                                                      .density = values.percent / 100,
                                                      .wallMm = values.wallMm,
                                                      .turn = piece.pose.rotation.toRotationMatrix()},
                                                     0, clay::WorkPart(job));
  PieceResult result;
  result.changed.push_back(piece);
  result.changed[0].version = made.version;
  result.notes.push_back(fmt::format("{}: {:.3g} % of {} mm³ filled, with cells of {:.3g} mm.", piece.name,
                                     100 * made.density, figure(made.hollowMm3), made.cellMm));
  return result;
}

// Where they can be printed: beside all there is, one beside the other, each on its own end.
class Standing {
 public:
  explicit Standing(const Document& document) : document_(document) {}
  void add(PieceResult& result, const Piece& of, clay::Version version, const Vec3d& up, std::string name) {
    Piece piece = of;
    piece.id = 0;
    piece.version = std::move(version);
    piece.name = std::move(name);
    piece.pose.rotation = Eigen::Quaterniond::FromTwoVectors(of.pose.rotation * up, Vec3d::UnitZ()) * of.pose.rotation;
    piece.pose.translation = Vec3d::Zero();
    piece.pose.translation = moveBeside(document_, boundsOf(piece));
    document_.add(piece);
    result.added.push_back(std::move(piece));
  }

 private:
  Document document_;  // with what was added
};

PieceResult drain(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const auto& values = a.get<DrainValues>();
  const clay::Drained made = clay::drain(piece.version,
                                         {.diameterMm = values.diameterMm,
                                          .vents = values.vents,
                                          .plugs = values.plugs,
                                          .clearanceMm = values.clearanceMm,
                                          .turn = piece.pose.rotation.toRotationMatrix()},
                                         clay::WorkPart(job));
  PieceResult result;
  result.changed.push_back(piece);
  result.changed[0].version = made.version;
  Standing standing(document);
  for (size_t i = 0; i < made.plugs.size(); ++i)
    standing.add(result, piece, made.plugs[i], made.holes[i].toMm - made.holes[i].fromMm,
                 fmt::format("{}, plug {}", piece.name, i + 1));
  std::string note = fmt::format("{}: {}", piece.name, counted(made.holes.size(), "hole", "holes"));
  for (const clay::DrainHole& hole : made.holes) {
    const Vec3d at = piece.pose.apply(hole.toMm);
    note += fmt::format("{}{} at {:.1f}, {:.1f}, {:.1f}", &hole == made.holes.data() ? ": " : "; ",
                        hole.vent ? "for air" : "for what runs out", at.x(), at.y(), at.z());
  }
  if (made.leftMm3 > 0) note += fmt::format("; {} mm³ stay", figure(made.leftMm3, 2));
  result.notes.push_back(note + ".");
  if (made.cups > 0)
    result.notes.push_back(
        fmt::format("{}: {} open to the outside and would hold a liquid as it stands: turn it, or carve a way out.",
                    piece.name, made.cups == 1 ? "1 hollow is" : fmt::format("{} hollows are", made.cups)));
  return result;
}

PieceResult cutWithPegs(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const auto& values = a.get<PegValues>();
  const Vec3d normal = piece.pose.rotation.conjugate() * a.plane.normal;
  const clay::PeggedHalves made = clay::cutWithPegs(piece.version,
                                                    {.pointMm = piece.pose.applyInverse(a.plane.pointMm),
                                                     .normal = normal,
                                                     .pegs = values.pegs,
                                                     .diameterMm = values.diameterMm,
                                                     .depthMm = values.depthMm,
                                                     .clearanceMm = values.clearanceMm,
                                                     .loose = values.loose},
                                                    clay::WorkPart(job));
  PieceResult result;
  result.changed.push_back(piece);
  result.changed[0].version = made.front;
  result.added.push_back(piece);
  result.added[0].version = made.back;
  result.added[0].name = fmt::format("{}, other side", piece.name);
  Standing standing(document);
  for (size_t i = 0; i < made.pins.size(); ++i)
    standing.add(result, piece, made.pins[i], normal, fmt::format("{}, pin {}", piece.name, i + 1));
  std::string note = fmt::format("{}: {}", piece.name, counted(made.pegs.size(), "peg", "pegs"));
  for (const clay::Peg& peg : made.pegs)
    note += fmt::format("{}{:.3g} mm wide, {:.3g} mm deep", &peg == made.pegs.data() ? ": " : "; ", peg.diameterMm,
                        peg.depthMm);
  if (made.without > 0)
    note += fmt::format("; {} of {} have no room for one", made.without, counted(size_t(made.areas), "area", "areas"));
  result.notes.push_back(note + ".");
  return result;
}

PieceResult mould(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const auto& values = a.get<MouldValues>();
  clay::MouldOptions options{.wallMm = values.wallMm,
                             .keys = values.keys,
                             .clearanceMm = values.clearanceMm,
                             .sprueMm = values.sprueMm,
                             .vents = values.vents,
                             .ventMm = values.ventMm};
  if (values.pull > 0) options.pull = piece.pose.rotation.conjugate() * Vec3d(Vec3d::Unit(values.pull - 1));
  const clay::Mould made = clay::makeMould(piece.version, options, 0, clay::WorkPart(job));
  PieceResult result;
  // The block's edges lie along the world's axes; each half lies on its back.
  Piece of = piece;
  of.pose.rotation.setIdentity();
  of.materials.clear();
  Standing standing(document);
  standing.add(result, of, made.lower, Vec3d::UnitZ(), fmt::format("{}, mould below", piece.name));
  standing.add(result, of, made.upper, -Vec3d::UnitZ(), fmt::format("{}, mould above", piece.name));
  // In hundredths, and without −0.
  const Vec3d pull = (100 * (piece.pose.rotation * Vec3d(made.turn.row(2).transpose()))).array().round() / 100 + 0.0;
  result.notes.push_back(fmt::format(
      "{}: pulled along {:.2f}, {:.2f}, {:.2f}; {}, {}, {}; the halves meet at {:.0f}° at most.", piece.name, pull.x(),
      pull.y(), pull.z(), counted(size_t(made.keys), "key", "keys"), counted(size_t(made.sprues), "sprue", "sprues"),
      counted(size_t(made.vents), "vent", "vents"), made.steepestDegrees));
  if (const double cast = 1e-4 * made.clayMm3; made.undercutMm3 > cast)
    result.notes.push_back(fmt::format("{}: {} mm³ are undercut, {:.2g} % of it: the cast has them filled.", piece.name,
                                       figure(made.undercutMm3), 100 * made.undercutMm3 / made.clayMm3));
  return result;
}

constexpr std::array<std::string_view, 3> kInfills{"gyroid", "struts", "cubic"};  // as clay::Infill has them
constexpr std::array kInfill{
    valueRow<&InfillValues::kind>({
        .id = "kind",
        .name = "Kind",
        .help = "gyroid: one smooth wall, two ways through; struts: bars, all of it open; cubic: closed cells.",
        .unit = "",
        .low = 0,
        .high = 2,
        .standard = 0,
        .choices = kInfills,
    }),
    valueRow<&InfillValues::percent>({
        .id = "density",
        .name = "Density",
        .help = "Part of the hollows that becomes clay.",
        .unit = "%",
        .low = 2,
        .high = 80,
        .standard = 15,
        .logarithmic = true,
    }),
    valueRow<&InfillValues::wallMm>({
        .id = "wall",
        .name = "Wall",
        .help = "Thickness of the infill's walls or bars.",
        .unit = "mm",
        .low = 0.01,
        .high = 100,
        .standard = 1,
        .logarithmic = true,
    }),
};
constexpr std::array kDrain{
    valueRow<&DrainValues::diameterMm>({
        .id = "diameter",
        .name = "Diameter",
        .help = "Of the holes.",
        .unit = "mm",
        .low = 0.01,
        .high = 100,
        .standard = 3,
        .logarithmic = true,
    }),
    valueRow<&DrainValues::vents>({
        .id = "vents",
        .name = "Holes for air",
        .help = "Also where a hollow is highest, so that air comes in and it drains upside down.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 1,
    }),
    valueRow<&DrainValues::plugs>({
        .id = "plugs",
        .name = "Plugs",
        .help = "A piece for each hole that closes it again, beside the clay.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 0,
    }),
    valueRow<&DrainValues::clearanceMm>({
        .id = "clearance",
        .name = "Clearance",
        .help = "By how much plugs are thinner all around than their holes.",
        .unit = "mm",
        .low = 0,
        .high = 5,
        .standard = 0.1,
    }),
};
constexpr std::array<std::string_view, 4> kPulls{"best", "x", "y", "z"};
constexpr std::array kMould{
    valueRow<&MouldValues::pull>({
        .id = "pull",
        .name = "Pull",
        .help = "Along which the halves come off: an axis, or where least is undercut.",
        .unit = "",
        .low = 0,
        .high = 3,
        .standard = 0,
        .choices = kPulls,
    }),
    valueRow<&MouldValues::wallMm>({
        .id = "wall",
        .name = "Wall",
        .help = "Of the block around the piece.",
        .unit = "mm",
        .low = 0.01,
        .high = 1000,
        .standard = 8,
        .logarithmic = true,
    }),
    valueRow<&MouldValues::keys>({
        .id = "keys",
        .name = "Keys",
        .help = "Cones in the corners that hold the halves in place.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 1,
    }),
    valueRow<&MouldValues::clearanceMm>({
        .id = "clearance",
        .name = "Clearance",
        .help = "Between a key and its hole.",
        .unit = "mm",
        .low = 0,
        .high = 5,
        .standard = 0.15,
    }),
    valueRow<&MouldValues::sprueMm>({
        .id = "sprue",
        .name = "Sprue",
        .help = "Width of the way in, at the piece; 0: none.",
        .unit = "mm",
        .low = 0,
        .high = 1000,
        .standard = 6,
        .zero = "none",
    }),
    valueRow<&MouldValues::vents>({
        .id = "vents",
        .name = "Vents",
        .help = "Ways out for air from every peak.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 1,
    }),
    valueRow<&MouldValues::ventMm>({
        .id = "vent",
        .name = "Vent",
        .help = "Width of a vent.",
        .unit = "mm",
        .low = 0.01,
        .high = 1000,
        .standard = 1.5,
        .logarithmic = true,
    }),
};
constexpr std::array kPegs{
    valueRow<&PegValues::pegs>({
        .id = "pegs",
        .name = "Pegs",
        .help = "In each area of the cut, as far as there is room.",
        .unit = "",
        .low = 1,
        .high = 8,
        .standard = 2,
    }),
    valueRow<&PegValues::diameterMm>({
        .id = "diameter",
        .name = "Diameter",
        .help = "Of a peg; 0: as suits the cut, 10 mm at most.",
        .unit = "mm",
        .low = 0,
        .high = 100,
        .standard = 0,
        .zero = "automatic",
    }),
    valueRow<&PegValues::depthMm>({
        .id = "depth",
        .name = "Depth",
        .help = "To which a peg goes into its hole; 0: as much as it is wide.",
        .unit = "mm",
        .low = 0,
        .high = 100,
        .standard = 0,
        .zero = "as its diameter",
    }),
    valueRow<&PegValues::clearanceMm>({
        .id = "clearance",
        .name = "Clearance",
        .help = "Between a peg and its hole, all around and at its end.",
        .unit = "mm",
        .low = 0,
        .high = 5,
        .standard = 0.15,
    }),
    valueRow<&PegValues::loose>({
        .id = "loose",
        .name = "Loose pins",
        .help = "Holes on both sides, and pins beside the clay: both halves lie flat in printing.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 0,
    }),
};

const std::array kRows{
    PieceJob{
        .id = "infill",
        .name = "Infill",
        .help = "Gives closed hollows an infill that holds them open.",
        .doing = "Filling",
        .group = "Print",
        .parameters = kInfill,
        .run = infill,
    },
    PieceJob{
        .id = "drain",
        .name = "Drain holes",
        .help = "Bores holes into hollows that are closed or open too narrowly, so that nothing stays in them.",
        .doing = "Draining",
        .group = "Print",
        .parameters = kDrain,
        .run = drain,
    },
    PieceJob{
        .id = "cut-pegs",
        .name = "Cut with pegs",
        .help = "Cuts along a plane into two pieces that find their place on each other.",
        .doing = "Cutting",
        .group = "Print",
        .takesPlane = true,
        .parameters = kPegs,
        .run = cutWithPegs,
    },
    PieceJob{
        .id = "mould",
        .name = "Mould",
        .help = "Makes a mould of two halves beside it that come off whatever its shape is.",
        .doing = "Making a mould",
        .group = "Print",
        .parameters = kMould,
        .run = mould,
    },
};

}  // namespace

std::span<const PieceJob> printJobs() {
  return kRows;
}

}  // namespace argil::engine
