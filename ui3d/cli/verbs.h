#pragma once
// The verbs of the command line: one function each, called by main with parsed options. All throw Error.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/surface/surface.h"
#include "engine/models/import_place.h"
#include "haptics/devices/hand_path.h"

namespace argil::cli {

/// 16 or 32 bits a voxel.
inline clay::Precision precisionOf(int bits) {
  return bits == 16 ? clay::Precision::fixed16 : clay::Precision::float32;
}

struct SculptOptions {
  std::filesystem::path script;
  std::filesystem::path input;  ///< A mesh in place of the script's clay.
  std::vector<std::filesystem::path> outputs;
  std::filesystem::path png, beforePng;
  std::filesystem::path report;  ///< JSON.
  std::filesystem::path record;  ///< The strokes as they were cut, as a script.
  bool overwrite = false;        ///< Files that exist already may be replaced, inputs never: so in all verbs.
  bool live = false;
  std::optional<double> voxelMm;
  std::optional<int> bits;  ///< As precisionOf(); else the script's.
  std::string quality;      ///< As engine::readQuality() takes it; empty: the script's.
  /// None: fine where it is written, as convert has it, draft where it is drawn.
  std::optional<clay::Grade> surface;
  std::string device = "touch";
  std::string view = "iso";
  std::array<int, 2> size{1280, 720};
  Job* job = nullptr;
};
/// Sculpts a script, prints one table, writes what was asked for.
void sculpt(const SculptOptions& options);

struct ConvertOptions {
  std::filesystem::path input, output;
  bool overwrite = false;
  std::optional<double> voxelMm;            ///< By way of clay, which closes and repairs; else triangle by triangle.
  std::optional<int> bits;                  ///< Of clay, as precisionOf(); else what a document has.
  engine::ImportPlace place;                ///< Of an input that is a model.
  std::optional<double> reduce;             ///< To so many triangles at most, or below 1 to that part of them.
  std::optional<double> errorMm;            ///< To as few triangles as keep within this.
  std::optional<int> faces;                 ///< STEP: smooth faces at most.
  bool alongGuides = false;                 ///< Edges of quads and faces follow closed curves among the guides.
  double maskDensity = 1;                   ///< So many times as many of them lie where the clay is masked.
  bool mirror = false;                      ///< Quads on both sides of the clay's mirror plane are images.
  std::optional<int> quads, textures;       ///< OBJ and GLB: quads at most; pixels a side of pictures on them.
  bool guides = false;                      ///< Of a CAD model's faces, in the document.
  bool draco = false;                       ///< glTF packed with Draco.
  bool recentre = false;                    ///< Moved to zero before it is written.
  bool putBack = false;                     ///< Clay where the imported file had it.
  std::string destination;                  ///< Of engine::exportPresets(); empty: none.
  clay::Grade surface = clay::Grade::fine;  ///< Of clay that becomes triangles.
  Job* job = nullptr;
};
void convert(const ConvertOptions& options);

struct InspectOptions {
  std::filesystem::path input;
  engine::ImportPlace place;      ///< Of an input that is a model.
  std::optional<double> voxelMm;  ///< Also say what it costs as clay.
  bool cost = false;              ///< Of a model what it would cost as clay, of a document what it takes of memory.
  /// A way to print (engine/print/print_check.h): also what stands in its way. Empty: none.
  std::string print;
  std::optional<double> wallMm, gapMm, outletMm;  ///< In place of its own limits.
  /// Also what a mould of two halves has against it: "best", an axis or "x,y,z". Empty: nothing.
  std::string pull;
  std::optional<double> draftDegrees;  ///< 2 when left out.
  bool json = false;
  Job* job = nullptr;
};
void inspect(const InspectOptions& options);

struct RecoverOptions {
  std::filesystem::path journal;  ///< Empty: list what there is.
  std::filesystem::path output;
  std::filesystem::path base;  ///< These as engine::RecoverChoice has them.
  bool withoutLast = false, repair = false, overwrite = false;
  Job* job = nullptr;
};
void recover(const RecoverOptions& options);

struct RenderOptions {
  std::filesystem::path input, output;
  bool overwrite = false;
  std::optional<double> voxelMm;
  engine::ImportPlace place;  ///< Of an input that is a model.
  clay::Grade surface = clay::Grade::crisp;
  std::string view = "iso";
  bool orthographic = false;
  std::array<int, 2> size{1280, 720};
  int frames = 1;   ///< Above 1: one revolution about the upright axis through the model's centre.
  int samples = 2;  ///< A pixel along each axis: 1 to 4.
  std::string shading = "lit", matcap = "clay",
              stereo = "mono";                     ///< As render/view/look.h and render/view/stereo.h name them.
  std::optional<double> eyeDistance, convergence;  ///< Parts of the distance to the model's centre.
  std::optional<double> depthFade;                 ///< 0 to 1.
  std::string section;                             ///< X,Y,Z,NX,NY,NZ; empty: none.
  bool light = false;                              ///< A light background.
  Job* job = nullptr;
};
/// A picture, or the frames of a turntable: then the output's name holds one %d or %0Nd for the frame's number, from 0.
void render(const RenderOptions& options);

struct FeelOptions {
  std::filesystem::path input;
  std::filesystem::path path;    ///< CSV of a hand path.
  std::filesystem::path output;  ///< CSV, a row a tick; empty: the summary alone.
  bool overwrite = false;
  haptics::HandPathLayout layout;  ///< Of a file that is not in the project's own layout; else empty.
  std::string contact = "proxy", device = "touch";
  double radiusMm = 3;
  std::optional<double> voxelMm, stiffnessNmm;
  std::optional<double> sizeMm;  ///< The mesh is centred at zero and scaled until its longest side is this.
  double friction = 0;
  std::string texture;  ///< As engine::parseTexture reads it.
  double rateHz = 1000;
  bool freeHand = false;
  bool part = false;  ///< The mesh as it is, not made clay.
  bool fit = false;
  std::string move, onto;  ///< "x,y,z"; empty: not.
  double pressMm = 1;
  Job* job = nullptr;
};
/// Feels a mesh, made clay or as it is, along a recorded hand path; prints a summary, writes every tick.
void feel(const FeelOptions& options);

struct DevicesOptions {
  std::string sheet;     ///< Name of a device whose sheet to print.
  std::string test;      ///< Name of a device to try for a few seconds. Neither: list them.
  std::string firmware;  ///< File of a Falcon's firmware, which is loaded where it is missing.
};
void devices(const DevicesOptions& options);

struct ToolsOptions {
  bool json = false, ids = false;
  bool scripts = false;     ///< The page on scripts, docs/scripts.md.
  bool operations = false;  ///< Those on whole pieces in place of the tools.
  bool quality = false;     ///< Axes of quality and what presets set them to, in place of the tools.
  std::string demo;         ///< Id of a tool: prints the script of its scene instead.
};
/// Prints the tools that there are and what can be set of each.
void tools(const ToolsOptions& options);

struct PluginsOptions {
  bool json = false;
  std::string describe, enable, disable;  ///< Ids of plugins; one of them at most.
  std::string check;                      ///< A folder.
  std::vector<std::string> make;          ///< Kind and folder of a new one.
};
/// Prints the plugins that there are, or does what the options say to one. Throws Error.
void plugins(const PluginsOptions& options);

/// `argil bench WORDS...`: becomes the program argil-bench that stands beside this one, with the words after the verb.
/// Returns only by Error: it is not there.
[[noreturn]] void bench(char** words);

}  // namespace argil::cli
