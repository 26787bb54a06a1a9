#pragma once
// A plugin: a folder that says in plugin.json what it brings.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/plugins/plugin_brush.h"
#include "engine/tools/added_tools.h"
#include "haptics/base/device.h"

namespace argil::engine {

struct Plugin {
  /// A brush: a formula, or one of the library, which `facts` are of. Their ids begin with that of the plugin.
  struct Brush {
    AddedTool tool;
    std::optional<PluginBrushFacts> facts;
  };

  /// A format of the library: read, written, or both.
  struct Format {
    std::string id, name;
    std::string ending;  ///< With its dot.
    bool reads = false, writes = false;
    /// Where every step of a document's history goes into a file of its own: the ending of those. Empty: it is one
    /// file.
    std::string frameEnding;
    double unitMm = 0;  ///< mm in one unit of what is read; 0: the user is asked.
  };
  /// An operation of the library on a whole piece; a guide of it that is felt.
  struct Operation {
    std::string id, name, help, doing;
    std::vector<AddedTool::Number> numbers;
  };
  /// A tool that presses heights into the surface.
  struct Texture {
    AddedTool tool;
  };
  struct Guide {
    std::string id, name, help;
    std::vector<AddedTool::Number> numbers;
  };

  /// Something that a hand holds. `nodes`: in /dev, with '*' for any letters; its library may open these.
  struct Device {
    std::string id, name, help;
    haptics::DeviceSheet sheet;
    std::vector<std::string> nodes;
  };

  std::string id;  ///< Such as "org.argil.formulas".
  std::string name, version, licence, help;
  std::vector<Brush> brushes;
  std::vector<Format> formats;
  std::vector<Operation> operations;
  std::vector<Guide> guides;
  std::vector<Texture> textures;
  std::vector<Device> devices;
  std::string library;   ///< Its file's name; empty: it runs no code of its own.
  std::string checksum;  ///< SHA-256 of its plugin.json, in hexadecimal digits.
};

/// Of a plugin's folder; what else lies beside it is none.
inline constexpr std::string_view kPluginEnding = ".argil-plugin";
inline constexpr std::string_view kPluginFile = "plugin.json";
inline constexpr int kPluginFormat = 1;
/// Folder in that of a plugin with libraries for this machine.
#if defined(__x86_64__)
inline constexpr std::string_view kPluginMachine = "x86_64-linux";
#elif defined(__aarch64__)
inline constexpr std::string_view kPluginMachine = "aarch64-linux";
#else
inline constexpr std::string_view kPluginMachine = "linux";
#endif

/// Reads `folder`/plugin.json; runs nothing. Formulas are compiled, so what cannot work is told here. Throws Error that
/// names file and place.
[[nodiscard]] Plugin readPlugin(const std::filesystem::path& folder);
/// Of its text. `name` stands in messages.
[[nodiscard]] Plugin parsePlugin(std::string_view text, const std::string& name);

/// Each thing that it brings, for lists.
struct Brought {
  std::string_view kind;  ///< "brush", "format", "operation", "guide", "texture" or "device".
  std::string id, name, help;
  std::string formula;  ///< Of a brush that is one.
  std::vector<AddedTool::Number> numbers;
};
[[nodiscard]] std::vector<Brought> broughtBy(const Plugin& plugin);

/// What it is allowed, in a sentence without its subject.
[[nodiscard]] std::string mayOf(const Plugin& plugin);

/// How its library is started. `checksum`: as libraryChecksum() has it; empty: it is not compared.
[[nodiscard]] PluginLibrary libraryOf(const Plugin& plugin, const std::filesystem::path& folder, std::string checksum);
/// SHA-256 of the file of its library; empty where that is not there.
[[nodiscard]] std::string libraryChecksum(const Plugin& plugin, const std::filesystem::path& folder);

}  // namespace argil::engine
