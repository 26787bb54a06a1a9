// The command line: parses, calls a verb, turns what is thrown into one line and an exit code (0 done, 1 the work
// failed, 2 the call or the input is wrong).

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <map>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/interrupt.h"
#include "engine/models/export_presets.h"
#include "engine/plugins/plugins.h"
#include "engine/plugins/start_mark.h"
#include "haptics/threads/guard.h"
#include "io/bytes/output_files.h"
#include "io/models/model_file.h"
#include "ui3d/cli/verbs.h"
#ifdef ARGIL_STUDIO
#include "ui3d/studio/studio.h"
#endif

namespace {

using namespace argil;

#ifdef ARGIL_STUDIO
constexpr bool kHasStudio = true;
#else
constexpr bool kHasStudio = false;
#endif

// Tells a file from a mistyped verb: a file is there, or its word has an ending or a folder.
bool namesFile(const std::string& word) {
  std::error_code ignored;
  return word.find_first_of("./") != std::string::npos || std::filesystem::exists(word, ignored);
}

// Puts "studio" before its options and files: `argil --scale 2`, `argil head.argil`.
std::vector<std::string> withVerb(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  constexpr std::array<std::string_view, 4> kOwn{"--help", "-h", "--help-all", "--version"};
  if (!kHasStudio || words.empty() || std::find(kOwn.begin(), kOwn.end(), words[0]) != kOwn.end()) return words;
  const bool verb = !app.get_subcommands([&](const CLI::App* each) { return each->get_name() == words[0]; }).empty();
  if (words[0].starts_with('-') || (!verb && namesFile(words[0]))) words.insert(words.begin(), "studio");
  return words;
}

// CLI::Range lets what is no number through.
CLI::Validator numberFrom(double least, double most) {
  return {[least, most](const std::string& text) {
            double number = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
            const bool good =
                error == std::errc() && end == text.data() + text.size() && number >= least && number <= most;
            return good ? std::string() : fmt::format("give {} to {} instead of {}", least, most, text);
          },
          ""};
}

// "1280x720"
std::array<int, 2> parseSize(const std::string& text) {
  int width = 0, height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 || height < 16 || width > 8192 ||
      height > 8192)
    throw Error(fmt::format("--size {}: give WIDTHxHEIGHT in pixels, 16 to 8192 each", text));
  return {width, height};
}

int run(int argc, char** argv) {
  CLI::App app{"Argil: digital clay that you touch."};
  app.set_version_flag("--version", ARGIL_VERSION);
  app.require_subcommand(kHasStudio ? 0 : 1, 1);
  Job& job = interruptibleJob();

  // How a model comes in, for all verbs that read one.
  const auto addPlace = [](CLI::App* verb, engine::ImportPlace& place) {
    verb->add_option("--units", place.units,
                     "Units of an input that names none: mm, um, cm, m, in, ft, or auto: guessed by its size and kind")
        ->capture_default_str();
    verb->add_option("--up", place.up,
                     "The axis of a model that points up: z, y, -z, -y, x, -x, or auto: guessed by its shape and kind; "
                     "as it lies when left out");
    verb->add_option("--height", place.heightMm, "Scale a model until it is so many mm high");
    verb->add_flag("--ground", place.stands,
                   "Stand a model on the ground: its lowest point at z = 0, its middle at x = y = 0");
  };
  const auto surfaceOption = [](CLI::App* verb, auto& surface, const char* otherwise) {
    const std::map<std::string, clay::Grade> grades = {
        {"draft", clay::Grade::draft}, {"crisp", clay::Grade::crisp}, {"fine", clay::Grade::fine}};
    verb->add_option("--surface", surface,
                     "Where the surface stands: draft, crisp with sharp creases, or fine with exact ones")
        ->transform(CLI::CheckedTransformer(grades).description(""))
        ->default_str(otherwise);
  };
  const auto addOverwrite = [](CLI::App* verb, bool& overwrite) {
    verb->add_flag("--overwrite", overwrite,
                   "Replace outputs that exist already; without it they are refused. Inputs are never replaced");
  };
  cli::SculptOptions sculpt;
  std::string sculptSize = "1280x720";
  auto* sculptVerb = app.add_subcommand("sculpt", "Run a script of strokes and operations on whole pieces");
  sculptVerb->add_option("script", sculpt.script, "Script (JSON)")->required();
  sculptVerb->add_option("-i,--input", sculpt.input, "Mesh or document in place of the script's clay");
  sculptVerb->add_option(
      "-o,--output", sculpt.outputs,
      "Document (.argil), level set (.vdb) or model to write (" + io::writableEndings() + "); may be repeated");
  sculptVerb->add_option("--png", sculpt.png, "Picture of the result");
  sculptVerb->add_option("--before-png", sculpt.beforePng, "Picture of the clay before the first stroke");
  sculptVerb->add_option("--report", sculpt.report, "Figures as JSON");
  sculptVerb->add_option("--record", sculpt.record, "The strokes as they were cut, as a script that repeats them");
  addOverwrite(sculptVerb, sculpt.overwrite);
  sculptVerb->add_flag("--live", sculpt.live, "Hand-driven strokes through the servo in real time");
  sculptVerb->add_option("--voxel", sculpt.voxelMm, "Voxel size in mm");
  sculptVerb->add_option("--bits", sculpt.bits, "Of a voxel's distance: 32, or 16 in half the memory")
      ->check(CLI::IsMember({16, 32}));
  sculptVerb->add_option(
      "--quality", sculpt.quality,
      "Speed against accuracy: draft, balanced, fine or machine (what this one can do), and axes behind it, such as "
      "fine,spacing=0.05; argil tools --quality lists them");
  sculptVerb->add_option("--device", sculpt.device, "Simulated device (argil devices lists them)")
      ->capture_default_str();
  surfaceOption(sculptVerb, sculpt.surface, "fine in files, crisp in pictures");
  sculptVerb->add_option("--view", sculpt.view, "front, back, left, right, top, bottom or iso")->capture_default_str();
  sculptVerb->add_option("--size", sculptSize, "Picture size")->capture_default_str();

  cli::ConvertOptions convert;
  auto* convertVerb = app.add_subcommand("convert", "Convert a model or document, straight or by way of clay");
  convertVerb
      ->add_option("input", convert.input,
                   "Document (.argil), level set (.vdb) or model (" + io::readableEndings() + ")")
      ->required();
  convertVerb
      ->add_option(
          "output", convert.output,
          "Document (.argil: without the history of the input, fit to be given away), level set (.vdb), solids "
          "for CAD (.step, .stp) or model (" +
              io::writableEndings() + ")")
      ->required();
  addOverwrite(convertVerb, convert.overwrite);
  convertVerb->add_option("--voxel", convert.voxelMm, "By way of clay with this voxel size in mm: closed and repaired");
  convertVerb->add_option("--bits", convert.bits, "Clay with so many bits a voxel: 32, or 16 in half the memory")
      ->check(CLI::IsMember({16, 32}));
  addPlace(convertVerb, convert.place);
  surfaceOption(convertVerb, convert.surface, "fine");
  convertVerb->add_option("--reduce", convert.reduce, "To so many triangles at most, or below 1 to that part of them");
  convertVerb->add_option("--error", convert.errorMm,
                          "To as few triangles, or smooth faces for CAD, as stay within so many mm of the shape");
  convertVerb->add_option("--faces", convert.faces, "STEP and IGES: so many smooth faces at most, of each piece");
  convertVerb->add_option(
      "--quads", convert.quads,
      "OBJ and GLB: quads in place of triangles, so many at most a piece, or more where these would lie too far off");
  convertVerb->add_flag("--along-guides", convert.alongGuides,
                        "Edges of quads and smooth faces follow the closed curves among the document's guides");
  convertVerb->add_option("--mask-density", convert.maskDensity,
                          "So many times as many quads or smooth faces a mm² where the clay is masked, 0.0625 to 16");
  convertVerb->add_flag("--mirror", convert.mirror,
                        "With --quads: mirror images on both sides of a plane that mirrors the clay");
  convertVerb->add_option(
      "--textures", convert.textures,
      "With --quads: normals, colours and heights of the clay as pictures of so many pixels a side");
  convertVerb->add_flag("--guides", convert.guides,
                        "STEP and IGES to .argil: planes, axes and middles of the largest faces as guides");
  convertVerb->add_flag("--recentre", convert.recentre,
                        "Move it to zero: for formats whose numbers are too coarse where it lies");
  convertVerb->add_flag("--put-back", convert.putBack, "Clay that import moved nearer: to where its file had it");
  std::string destinations;
  for (const engine::ExportPreset& each : engine::exportPresets())
    destinations += (destinations.empty() ? "" : ", ") + std::string(each.id);
  convertVerb->add_option("--for", convert.destination, "What the output is for: " + destinations);
  convertVerb->add_flag("--draco", convert.draco,
                        "glTF packed with Draco: a tenth of the size, which fewer programs can open");

  cli::InspectOptions inspect;
  auto* inspectVerb = app.add_subcommand("inspect", "What a file holds: size, volume, area, topology");
  inspectVerb->add_option("file", inspect.input, "Document or model")->required();
  addPlace(inspectVerb, inspect.place);
  inspectVerb->add_option("--voxel", inspect.voxelMm, "Also as clay with this voxel size in mm: what it costs");
  inspectVerb->add_flag("--cost", inspect.cost,
                        "Of a model what it would cost as clay, before that is made; of a document what it takes");
  inspectVerb->add_option("--print", inspect.print,
                          "Also what stands in the way of printing it: sla, fdm, sls, metal or casting; a model needs "
                          "--voxel");
  inspectVerb->add_option("--wall", inspect.wallMm, "With --print: the thinnest wall in mm that is asked for");
  inspectVerb->add_option("--gap", inspect.gapMm, "With --print: the narrowest gap in mm that is asked for");
  inspectVerb->add_option("--outlet", inspect.outletMm,
                          "With --print: the narrowest way out of a hollow in mm that is asked for");
  inspectVerb->add_option("--pull", inspect.pull,
                          "Also what is undercut when a mould of two halves comes off along it: best, x, y, z or a "
                          "direction such as 0,0.2,1");
  inspectVerb->add_option("--draft", inspect.draftDegrees,
                          "With --pull: the least angle in degrees between walls and the pull; 2 when left out");
  inspectVerb->add_flag("--json", inspect.json, "As JSON");

  cli::RecoverOptions recover;
  auto* recoverVerb =
      app.add_subcommand("recover", "What sessions that ended by a crash left, and its way into a file");
  recoverVerb->add_option("journal", recover.journal, "A journal; all are listed when left out");
  recoverVerb->add_option("-o,--output", recover.output, "Document to write (.argil)");
  addOverwrite(recoverVerb, recover.overwrite);
  recoverVerb->add_option("--base", recover.base, "Where the saved document that the journal was kept for lies by now");
  recoverVerb->add_flag("--without-last", recover.withoutLast,
                        "Leave out the last stroke that would be repeated: it may be what ended Argil");
  recoverVerb->add_flag("--repair", recover.repair,
                        "Where that saved document is lost: what the journal alone holds, its holes filled");

  cli::RenderOptions render;
  std::string renderSize = "1280x720";
  auto* renderVerb = app.add_subcommand("render", "A picture of a document or model, or the frames of a turntable");
  renderVerb->add_option("file", render.input, "Document or model")->required();
  renderVerb
      ->add_option("-o,--output", render.output,
                   "Picture (.png); with --frames %d or %03d in it for the frame's number")
      ->required();
  addOverwrite(renderVerb, render.overwrite);
  renderVerb->add_option("--frames", render.frames, "Frames of one revolution about the upright axis")
      ->capture_default_str();
  renderVerb->add_option("--samples", render.samples, "Samples a pixel along each axis, 1 to 4")->capture_default_str();
  renderVerb->add_option("--shading", render.shading, "matcap, lit or material")->capture_default_str();
  renderVerb->add_option("--matcap", render.matcap, "clay, wax, porcelain, steel, rubber or normals")
      ->capture_default_str();
  renderVerb->add_option("--stereo", render.stereo, "mono, anaglyph, side-by-side, top-bottom, left-eye or right-eye")
      ->capture_default_str();
  renderVerb->add_option("--eye-distance", render.eyeDistance,
                         "Between the eyes, as a part of the distance to the centre, 0 to 0.2; 0.035 when left out");
  renderVerb->add_option("--convergence", render.convergence,
                         "Distance without parallax, as a part of the same, 0.2 to 5; 1 when left out");
  renderVerb->add_option("--depth-fade", render.depthFade, "How much the farthest of the clay fades, 0 to 1");
  renderVerb->add_option("--section", render.section,
                         "Cut open by a plane: X,Y,Z,NX,NY,NZ, a point in mm and the side that is left out");
  renderVerb->add_flag("--light", render.light, "Light background");
  renderVerb->add_option("--size", renderSize, "Picture size")->capture_default_str();
  renderVerb->add_option("--view", render.view, "front, back, left, right, top, bottom or iso")->capture_default_str();
  renderVerb->add_flag("--orthographic", render.orthographic, "Without perspective");
  surfaceOption(renderVerb, render.surface, "crisp");
  renderVerb->add_option("--voxel", render.voxelMm, "Voxel size in mm");
  addPlace(renderVerb, render.place);

  cli::FeelOptions feel;
  auto* feelVerb = app.add_subcommand("feel", "What a hand feels along a recorded path: forces tick by tick");
  feelVerb->add_option("file", feel.input, "Mesh, made clay")->required();
  feelVerb->add_option("--path", feel.path, "Hand path (CSV: t_s,x_mm,y_mm,z_mm; other layouts with --units)")
      ->required();
  feelVerb->add_option("-o,--output", feel.output, "Every tick as CSV");
  addOverwrite(feelVerb, feel.overwrite);
  feelVerb->add_option("--contact", feel.contact, "proxy, god-object or penalty")->capture_default_str();
  feelVerb->add_option("--device", feel.device, "Whose limits hold (argil devices lists them)")->capture_default_str();
  feelVerb->add_option("--radius", feel.radiusMm, "Radius of the ball in mm")->capture_default_str();
  feelVerb->add_option("--voxel", feel.voxelMm, "Voxel size in mm");
  feelVerb->add_flag("--part", feel.part, "Touch the mesh as it is, without making it clay");
  feelVerb->add_option("--size", feel.sizeMm,
                       "Centre the mesh at zero and scale it until its longest side is this, mm");
  feelVerb->add_option("--stiffness", feel.stiffnessNmm,
                       "Of the surface in N/mm; 1 when left out, never above the device's own");
  feelVerb->add_option("--friction", feel.friction, "Coefficient, sticking and sliding")->capture_default_str();
  feelVerb->add_option("--texture", feel.texture,
                       "ridges:WAVELENGTH:AMPLITUDE, bumps:WAVELENGTH:AMPLITUDE, grain:WAVELENGTH:AMPLITUDE or "
                       "image:FILE:MM_PER_PIXEL:AMPLITUDE, in mm");
  feelVerb->add_option("--rate", feel.rateHz, "Ticks a second")->capture_default_str();
  feelVerb->add_flag("--free", feel.freeHand,
                     "A simulated hand and device in closed loop; else the hand is on the path whatever the force");
  feelVerb->add_option("--units", feel.layout.units,
                       "Of the path: mm, um, cm, m, in, ft; columns are then found by their usual names");
  feelVerb->add_option("--columns", feel.layout.columns, "Which column is which: t=clock,x=tip_x,...");
  feelVerb->add_option("--rows", feel.layout.rows, "Only rows whose column holds this: demo=3");
  feelVerb->add_flag("--fit", feel.fit, "Centre the path on the model and scale it down until it is no larger");
  feelVerb->add_option("--move", feel.move, "Then move it by X,Y,Z mm");
  feelVerb->add_option("--onto", feel.onto, "Then lay it onto the surface along this direction X,Y,Z");
  feelVerb->add_option("--press", feel.pressMm, "With --onto: so deep below the surface, mm")->capture_default_str();

  // Taken by main before anything else; here for --help.
  app.add_subcommand("bench",
                     "Measure this machine, a day's work on it, or the feel of simulated devices: argil-bench");

  cli::PluginsOptions plugins;
  auto* pluginsVerb = app.add_subcommand("plugins", "The plugins that are there, what each brings, which are enabled");
  pluginsVerb->add_flag("--json", plugins.json, "As JSON");
  const auto onPlugin = [&](const char* name, const char* help, std::string& id, const char* what) {
    pluginsVerb->add_subcommand(name, help)->add_option(what, id)->required();
  };
  onPlugin("describe", "All that a plugin says of itself", plugins.describe, "id");
  onPlugin("enable", "Use a plugin from now on, as it is now", plugins.enable, "id");
  onPlugin("disable", "Use it no longer", plugins.disable, "id");
  onPlugin("check", "Try what a plugin promises", plugins.check, "folder");
  pluginsVerb->add_subcommand("new", "Write a plugin that works, to begin with")
      ->add_option(
          "what", plugins.make,
          "Its kind (formula, brush, texture, operation, format, guide or device), and a folder that is not there yet")
      ->expected(2)
      ->required();
  pluginsVerb->require_subcommand(0, 1);

  cli::ToolsOptions tools;
  auto* toolsVerb = app.add_subcommand("tools", "The tools that there are, what each does and what can be set");
  toolsVerb->add_flag("--json", tools.json, "As JSON, with every parameter");
  toolsVerb->add_flag("--ids", tools.ids, "Their names in scripts alone, one a line");
  toolsVerb->add_flag("--operations", tools.operations, "The operations on whole pieces in place of the tools");
  toolsVerb->add_flag("--quality", tools.quality,
                      "What speed can be traded for, and what the presets draft, balanced and fine set");
  toolsVerb->add_flag("--scripts", tools.scripts,
                      "The page on scripts: every field, tool and operation, with units and ranges");
  toolsVerb->add_option("--demo", tools.demo, "Print a script that shows this tool");

  cli::DevicesOptions devices;
  auto* devicesVerb =
      app.add_subcommand("devices", "The devices that are plugged in or simulated, and what they can do");
  devicesVerb->add_option("--sheet", devices.sheet, "All that is known of this one");
  devicesVerb->add_option("--test", devices.test, "Try this one for a few seconds");
  devicesVerb->add_option("--firmware", devices.firmware,
                          "Firmware file of a Novint Falcon, loaded where it is missing");

#ifdef ARGIL_STUDIO
  studio::StudioOptions studio;
  std::string studioSize, studioTheme;
  auto* studioVerb = app.add_subcommand(
      "studio", "Open the studio; argil alone, argil FILE or argil with options of the studio does too");
  studioVerb->add_option("file", studio.file, "Document (.argil), script (.json), level set or model to open");
  studioVerb->add_option("--size", studioSize, "Of the window in pixels");
  studioVerb
      ->add_option("--scale", studio.scale, "Pixels an interface unit, 0.5 to 4; as the display says when left out")
      ->check(numberFrom(0.5, 4));
  studioVerb->add_option("--device", studio.device, "Stylus (argil devices lists them); pointer is mouse or pen")
      ->capture_default_str();
  studioVerb->add_option("--theme", studioTheme, "dark or light, for this start alone")
      ->check(CLI::IsMember({"dark", "light"}));
  studioVerb->add_option("--play", studio.play, "A recording in place of a person; the studio ends with it");
  studioVerb->add_option("--speed", studio.playSpeed, "The recording so many times as fast, 0.1 to 100")
      ->check(numberFrom(0.1, 100));
  studioVerb->add_option("--record", studio.record, "Record what the person does");
  studioVerb->add_option("--report", studio.report, "Figures as JSON at the end");
  bool safe = false, studioOverwrite = false;
  addOverwrite(studioVerb, studioOverwrite);
  studioVerb->add_flag("--safe", safe, "Without plugins");
  studioVerb->add_flag("--validate", studio.validate, "With Vulkan's validation layer");
#endif

  try {
    std::vector<std::string> words = withVerb(app, argc, argv);
    std::reverse(words.begin(), words.end());  // As CLI11 takes them.
    app.parse(words);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    fmt::print(stderr, "argil: {}; see argil --help\n", e.what());
    return 2;
  }

  // Tables of tools have what plugins bring before anybody reads them.
  std::unique_ptr<engine::StartMark> mark;
#ifdef ARGIL_STUDIO
  if (!safe && studio.play.empty() && (*studioVerb || app.get_subcommands().empty()) &&
      std::filesystem::exists(engine::pluginSettings())) {
    mark = std::make_unique<engine::StartMark>(engine::pluginSettings().replace_extension("starting"));
    safe = mark->lastDied();
    if (safe)
      studio.notice =
          "The last start ended before it was through, so that plugins are left out of this one. They are back at the "
          "next; Help, Plugins shows which there are.";
    studio.settled = [&mark] { mark->good(); };
  }
#endif
  if (!safe && (*sculptVerb || *convertVerb || *inspectVerb || *renderVerb || *feelVerb || *recoverVerb || *toolsVerb ||
                *devicesVerb || *studioVerb || app.get_subcommands().empty()))
    engine::Plugins().load();

  sculpt.job = convert.job = recover.job = inspect.job = render.job = feel.job = &job;
  if (*sculptVerb) {
    sculpt.size = parseSize(sculptSize);
    cli::sculpt(sculpt);
  }
  if (*convertVerb) cli::convert(convert);
  if (*inspectVerb) cli::inspect(inspect);
  if (*recoverVerb) cli::recover(recover);
  if (*renderVerb) {
    render.size = parseSize(renderSize);
    cli::render(render);
  }
  if (*feelVerb) cli::feel(feel);
  if (*toolsVerb) cli::tools(tools);
  if (*pluginsVerb) cli::plugins(plugins);
  if (*devicesVerb) cli::devices(devices);
#ifdef ARGIL_STUDIO
  if (*studioVerb || app.get_subcommands().empty()) {
    if (!studioSize.empty()) {
      const auto [width, height] = parseSize(studioSize);
      studio.width = width;
      studio.height = height;
    }
    const io::Files read{studio.file, studio.play}, written{studio.record, studio.report};
    io::requireNewFiles(read, written, studioOverwrite);
    if (!studioTheme.empty()) studio.theme = studioTheme == "light" ? studio::Theme::light : studio::Theme::dark;
    studio.interrupted = [&job] { return job.cancelled(); };
    studio::runStudio(studio);
  }
#endif
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc > 1 && std::string_view(argv[1]) == "bench") argil::cli::bench(argv + 1);
    const argil::haptics::Guard guard;  // Before any thread: it zeroes the devices should this process die.
    return run(argc, argv);
  } catch (const argil::Error& e) {
    fmt::print(stderr, "argil: {}\n", e.what());
    return e.kind() == argil::Error::Kind::input ? 2 : 1;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "argil: out of memory: use a larger voxel or a smaller model\n");
    return 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "argil: {}\n", e.what());
    return 1;
  }
}
