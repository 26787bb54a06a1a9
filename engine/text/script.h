#pragma once
// A sculpting session as a text: what `argil sculpt` runs and what a recorded session is written as.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "clay/base/vec.h"
#include "clay/kernels/brick.h"
#include "engine/document/document.h"
#include "engine/document/stroke_images.h"
#include "engine/document/tool.h"
#include "engine/print/print_check.h"
#include "engine/text/guide_setup.h"
#include "engine/tools/path_point.h"
#include "engine/tools/piece_jobs.h"
#include "haptics/scene/scene.h"

namespace argil::engine {

/// What moves the tool along a stroke's path.
enum class Drive : uint8_t {
  tip,  ///< The tool's centre goes exactly along the path: pure geometry.
  /// The path is where a simulated hand wants to go; device and servo answer, and the clay is cut where they say.
  hand,
};

/// Lays a path onto whatever clay is there: each point moves along `direction` until the ball's front is `pressMm`
/// below the first surface that it meets. Points that meet none are left out.
struct Onto {
  Vec3d direction = -Vec3d::UnitZ();  ///< Not zero; its length does not matter.
  double pressMm = 0;                 ///< Negative: above the surface.

  friend bool operator==(const Onto&, const Onto&) = default;
};

struct ScriptStroke {
  Tool tool;
  Drive drive = Drive::tip;
  std::vector<PathPoint> path;  ///< At least one point.
  std::optional<Onto> onto = {};
  StrokeImages images = {};  ///< Repeated in mirrors and around an axis.
  std::string piece = {};    ///< Name of the piece that it works on from here on; empty: the one as before.

  friend bool operator==(const ScriptStroke&, const ScriptStroke&) = default;
};

/// An operation on whole pieces: a row of pieceJobs(). Pieces go by their names.
struct ScriptOperation {
  std::string id;     ///< Of the row.
  size_t before = 0;  ///< Done before the stroke of this number; those of one number in their order.
  /// As many as the row takes; none for a row of one: the piece that is worked on.
  std::vector<std::string> pieces = {};
  PieceArguments arguments = {};  ///< But for `pieces`.
  std::string name = {};          ///< Of a row that makes a piece: its name; empty: as the row names it.
  /// Where its middle comes to lie and where its z axis points; the length does not matter.
  Vec3d centreMm = Vec3d::Zero(), axis = Vec3d::UnitZ();

  friend bool operator==(const ScriptOperation&, const ScriptOperation&) = default;
};

struct BlockSetup {
  Vec3d sizeMm = Vec3d::Constant(60);
  double roundMm = 0;
  Vec3d centreMm = Vec3d::Zero();
  friend bool operator==(const BlockSetup&, const BlockSetup&) = default;
};
struct SphereSetup {
  double radiusMm = 30;
  Vec3d centreMm = Vec3d::Zero();
  friend bool operator==(const SphereSetup&, const SphereSetup&) = default;
};
/// A mesh file. A path in a script is relative to the script's folder.
struct ImportSetup {
  std::filesystem::path file;
  friend bool operator==(const ImportSetup&, const ImportSetup&) = default;
};
/// Which axis of a mesh points up; files do not say. custom: y for OBJ and OFF, z for the others.
enum class Up : uint8_t { z, y, custom };
/// monostate: the clay comes from elsewhere (`argil sculpt -i`).
using ClaySetup = std::variant<std::monostate, BlockSetup, SphereSetup, ImportSetup>;

/// `{"argil": 1, "units": "mm", "setup": [...], "strokes": [...]}`. Setup items, each at most once: `{"voxel_mm":
/// 0.5}`, `{"quality": "draft"}` or `{"quality": {"preset": "fine", "spacing": 0.05}}`,
/// `{"fit_mm": 100}`, `{"up": "z", "y" or "custom"}`, and one of `{"block": {"size_mm": [x, y, z], "round_mm": 2,
/// "centre_mm": [x, y, z]}}`,
/// `{"sphere": {"radius_mm": 30, "centre_mm": [x, y, z]}}`, `{"import": "scan.stl"}`; for hand-driven strokes
/// `{"material": {"stiffness_nmm": 1, ...}}` and `{"materials": [{"name": "wax", "colour": "#3b5bd0", "material":
/// {...}}, ...]}` (rows 1, 2, ... of what the material tool lays; colour and material may be left out) and `{"guides":
/// [{"guide": "lock_to_plane", "at": [0, 0, 20], "direction": [0, 0, 1]}, ...]}` (engine/text/guide_setup.h). A stroke:
/// `{"tool": "carve" or any other id of engine/tools/tool_table.h, "radius_mm": 5, its other parameters with their
/// units
/// ("height_mm", "angle_deg", "strength": 0 to 1, "tip": "box", "colour": "#c8402e"; left out: as the tool begins),
/// "inverted": true, "file" of an image or a shape, "drive": "tip" or "hand", "onto": [x, y, z] and "press_mm": 2 (both
/// or none), "mirror": [[px, py, pz, nx, ny, nz], ...] (at most three planes by a point and a normal; left out: none),
/// "radial": {"turns": 6, "axis": [px, py, pz, ax, ay, az]}, "path": [[t_s, x, y, z], ...]}`, where a point may go on
/// with its pressure (0 to 1), with the stylus's quaternion qx, qy, qz, qw, or with both in that order; `"piece":
/// "Ring"` to work on another piece from here on. Between strokes, in the same list, operations on whole pieces, done
/// in the list's order: `{"operation": "offset" or any other id of engine/tools/piece_jobs.h ("argil tools
/// --operations" prints them), its parameters with their units ("distance_mm": 2, "angle_deg": 90, "from_percent": 10;
/// left out: as the row begins)`, and what the row takes:
/// `"piece": "Clay"` (left out: the one that is worked on) or of two `"pieces": ["Clay", "Ring"]`; `"plane": [px, py,
/// pz, nx, ny, nz]`; `"points": [[x, y, z], ...]` with
/// `"direction": [x, y, z]` and `"closed": true`, and of a lattice (whose points go z fastest, then y, then x) the
/// `"box": [lx, ly, lz, hx, hy, hz]` of the piece that they begin as; of a row that makes a piece `"name": "Ring"`,
/// `"centre_mm": [x, y, z]`, `"axis": [x, y, z]`. The clay of the setup is the piece "Clay"; a script that begins with
/// a new piece needs no setup. Places are world mm. `"print": {"process": "sla", "wall_mm": 1.2, "gap_mm": 0.5}` asks
/// what stands in the way of printing the pieces that there are in the end.
struct Script {
  std::optional<double> voxelMm;
  clay::Precision precision = clay::Precision::float32;  ///< `{"bits": 16}`: half the memory.
  std::optional<double> fitMm;     ///< An imported mesh is centred at zero and scaled until its longest side is this.
  Up up = Up::z;                   ///< An imported mesh is turned so that this axis of it points along z.
  std::optional<Quality> quality;  ///< Of the clay and of strokes that have none of their own.
  ClaySetup clay;
  haptics::Material material;          ///< How the clay feels to a hand.
  std::vector<MaterialRow> materials;  ///< What Tool::material names, from 1 on.
  std::vector<GuideSetup> guides;      ///< What a hand is held by.
  std::vector<ScriptStroke> strokes;
  std::vector<ScriptOperation> operations;  ///< In order.
  std::optional<PrintWish> print;           ///< What is looked at in the pieces that the script leaves.

  /// How new clay is made, as the script asks for it: its own "bits", else its quality's.
  [[nodiscard]] clay::Precision bits() const {
    return precision == clay::Precision::fixed16 || !quality ? precision : quality->clay.precision();
  }
  /// Another quality, also of strokes that have none of their own.
  void use(const Quality& given);
  friend bool operator==(const Script&, const Script&) = default;
};

/// Reads a script. Throws Error, one line that names `name`, the place in it (strokes[3].path[7]) and what is wrong:
/// bad JSON, a key that is unknown, missing or there twice, numbers that are not finite or out of range, times that
/// decrease.
[[nodiscard]] Script parseScript(std::string_view text, const std::string& name);

/// One step a line; parseScript gives back an equal script, to the bit. Throws Error for numbers that are not finite.
[[nodiscard]] std::string formatScript(const Script& script);

/// Writes it to a file, whole or not at all.
void writeScript(const std::filesystem::path& path, const Script& script);

struct RandomScriptOptions {
  size_t strokes = 100;
  Vec3d centreMm = Vec3d::Zero();
  double reachMm = 40;  ///< Paths stay within this of the centre, most of them near this distance.
  double minRadiusMm = 1, maxRadiusMm = 4;
  size_t maxPoints = 12;  ///< In a path; at least one.
  bool smooth = true;     ///< Smooth strokes too, beside carve and add.
};
/// Tip-driven strokes of every kind (dabs, jumps, repeated points): equal seeds give equal scripts on every machine.
[[nodiscard]] Script randomScript(uint64_t seed, const RandomScriptOptions& options = {});

}  // namespace argil::engine
