#include "house_rules.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string_view>

namespace argil::house {
namespace {

namespace fs = std::filesystem;

// The arrows of the plan, transitive ones included. A module is named by its folder.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"clay", {}},
    {"plugins/sdk", {}},
    {"plugins/runner", {"plugins/sdk", "io", "clay"}},
    {"haptics", {"clay"}},
    {"io", {"clay"}},
    {"render", {"clay"}},
    {"engine", {"haptics", "io", "clay", "plugins/sdk", "plugins/runner"}},
    {"bench", {"engine", "render", "haptics", "io", "clay"}},
    {"ui3d", {"engine", "render", "haptics", "io", "clay", "plugins/sdk", "plugins/runner"}},
};
// Folders of a module from the ground up: each may include what stands before it. Files beside them may include all,
// and nothing in a folder includes those.
const std::map<std::string, std::vector<std::string>> kFloors = {
    {"clay",
     {"base", "kernels", "store", "field", "mesh", "surface", "import", "brush", "whole", "cage", "mould", "unwrap"}},
    {"haptics", {"base", "threads", "scene", "contact", "servo", "devices", "analysis"}},
    {"io", {"bytes", "records", "sandbox", "reader", "cad_reader", "models", "cad", "textured"}},
    {"engine", {"document", "print", "tools", "text", "plugins", "saving", "models", "session"}},
    {"render", {"view", "surface", "gpu", "renderer"}},
    {"ui3d/studio", {"view", "files", "input", "widgets", "kit", "panels"}},
};
constexpr std::array kTopFolders = {"clay", "haptics", "render", "io",        "engine",  "bench",
                                    "ui3d", "plugins", "tests",  "installer", "scripts", "cmake"};
constexpr std::array kSourceSuffixes = {".h",    ".hpp",  ".inl",  ".c",  ".cpp",   ".vert",
                                        ".frag", ".comp", ".glsl", ".sh", ".cmake", ".py"};
constexpr std::array kHeavyPrefixes = {"openvdb/", "nanovdb/", "vulkan/", "volk.h"};
constexpr std::array kForeignParsers = {"stb_image.h", "draco/compression/decode.h", "png.h", "jpeglib.h"};

struct Include {
  size_t line = 0;
  std::string target;
  bool quoted = false;
};

struct Source {
  std::string path;    // relative to the root, with '/'
  std::string module;  // empty outside of the modules
  size_t lines = 0;
  std::vector<Include> includes;
};

using Tree = std::map<std::string, Source>;

template <size_t n>
bool oneOf(const std::array<const char*, n>& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

std::string moduleOf(const std::string& path) {
  const size_t first = path.find('/');
  if (first == std::string::npos) return {};
  const std::string top = path.substr(0, first);
  if (top == "plugins") {
    const size_t second = path.find('/', first + 1);
    return second == std::string::npos ? std::string() : path.substr(0, second);
  }
  return kMayInclude.count(top) ? top : std::string();
}

// Where a file stands in a house of floors: its module and its floor, counted from the ground; beside the folders,
// above all.
struct FloorPlace {
  std::string house, folder;
  size_t floor = 0;
};
std::optional<FloorPlace> floorOf(const std::string& path) {
  for (const auto& [house, floors] : kFloors) {
    if (!path.starts_with(house + "/")) continue;
    const std::string rest = path.substr(house.size() + 1), folder = rest.substr(0, rest.find('/'));
    if (rest.find('/') == std::string::npos) return FloorPlace{house, house, floors.size()};
    const auto found = std::find(floors.begin(), floors.end(), folder);
    if (found == floors.end()) return std::nullopt;
    return FloorPlace{house, house + "/" + folder, size_t(found - floors.begin())};
  }
  return std::nullopt;
}

std::set<std::string> mayInclude(const std::string& module) {
  const auto found = kMayInclude.find(module);
  if (found != kMayInclude.end()) return found->second;
  return {"plugins/sdk"};  // an example plugin
}

std::optional<Include> parseInclude(std::string_view text) {
  const auto skipBlanks = [&] { text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size())); };
  skipBlanks();
  if (!text.starts_with('#')) return std::nullopt;
  text.remove_prefix(1);
  skipBlanks();
  if (!text.starts_with("include")) return std::nullopt;
  text.remove_prefix(7);
  skipBlanks();
  if (text.empty() || (text[0] != '"' && text[0] != '<')) return std::nullopt;
  const bool quoted = text[0] == '"';
  const size_t end = text.find(quoted ? '"' : '>', 1);
  if (end == std::string_view::npos) return std::nullopt;
  return Include{0, std::string(text.substr(1, end - 1)), quoted};
}

Tree readTree(const fs::path& root) {
  if (!fs::is_directory(root)) {
    throw fs::filesystem_error("not a folder", root, std::make_error_code(std::errc::not_a_directory));
  }
  Tree tree;
  for (const char* top : kTopFolders) {
    if (!fs::is_directory(root / top)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / top)) {
      if (!entry.is_regular_file() || !oneOf(kSourceSuffixes, entry.path().extension().string())) continue;
      Source source;
      source.path = fs::relative(entry.path(), root).generic_string();
      source.module = moduleOf(source.path);
      std::ifstream file(entry.path());
      for (std::string text; std::getline(file, text);) {
        ++source.lines;
        if (auto include = parseInclude(text)) {
          include->line = source.lines;
          source.includes.push_back(*include);
        }
      }
      tree.emplace(source.path, std::move(source));
    }
  }
  return tree;
}

// The file of the tree that an include means: from the root, else from the includer's folder. Null: not ours.
const Source* resolve(const Tree& tree, const Source& from, const Include& include) {
  for (const fs::path& candidate : {fs::path(include.target), fs::path(from.path).parent_path() / include.target}) {
    const auto found = tree.find(candidate.lexically_normal().generic_string());
    if (found != tree.end()) return &found->second;
  }
  return nullptr;
}

std::string place(const Source& source, const Include& include) {
  return source.path + ":" + std::to_string(include.line) + ": includes " + include.target;
}

bool isHeavy(const Include& include) {
  return std::any_of(kHeavyPrefixes.begin(), kHeavyPrefixes.end(),
                     [&](const char* prefix) { return include.target.starts_with(prefix); });
}

bool reachesHeavy(const Tree& tree, const Source& source, std::set<std::string>& seen) {
  if (!seen.insert(source.path).second) return false;
  return std::any_of(source.includes.begin(), source.includes.end(), [&](const Include& include) {
    if (isHeavy(include)) return true;
    const Source* next = resolve(tree, source, include);
    return next && reachesHeavy(tree, *next, seen);
  });
}

}  // namespace

Breaches arrows(const fs::path& root) {
  Breaches breaches;
  const Tree tree = readTree(root);
  for (const auto& [path, source] : tree) {
    if (source.module.empty()) continue;
    for (const Include& include : source.includes) {
      if (include.target.find("..") != std::string::npos) {
        breaches.push_back(place(source, include) + ", which leaves its folder: write \"module/file.h\"");
        continue;
      }
      const Source* target = resolve(tree, source, include);
      const std::string module = target ? target->module : moduleOf(include.target);
      if (!target && !module.empty()) {
        breaches.push_back(place(source, include) + ", which is not there");
      } else if (target && module.empty()) {
        breaches.push_back(place(source, include) + ", which is no module");
      } else if (!module.empty() && module != source.module && !mayInclude(source.module).count(module)) {
        breaches.push_back(place(source, include) + ", but no arrow leads from " + source.module + " to " + module);
      }
    }
  }
  return breaches;
}

Breaches floors(const fs::path& root) {
  Breaches breaches;
  const Tree tree = readTree(root);
  for (const auto& [path, source] : tree) {
    const auto here = floorOf(path);
    if (!here && !source.module.empty() && kFloors.count(source.module) && path.ends_with(".h"))
      breaches.push_back(path + ": its folder is none of the floors of " + source.module);
    if (!here) continue;
    for (const Include& include : source.includes) {
      const Source* target = resolve(tree, source, include);
      const auto there = target ? floorOf(target->path) : std::nullopt;
      if (there && there->house == here->house && there->floor > here->floor)
        breaches.push_back(place(source, include) + ", but " + there->folder + " stands on " + here->folder);
    }
  }
  return breaches;
}

Breaches crowdedFolders(const fs::path& root, size_t most) {
  std::map<std::string, size_t> files;
  for (const auto& [path, source] : readTree(root)) ++files[fs::path(path).parent_path().generic_string()];
  Breaches breaches;
  for (const auto& [folder, count] : files)
    if (count > most)
      breaches.push_back(folder + ": " + std::to_string(count) + " files, and " + std::to_string(most) +
                         " is the most");
  return breaches;
}

Breaches heavyHeaders(const fs::path& root) {
  Breaches breaches;
  const Tree tree = readTree(root);
  for (const auto& [path, source] : tree) {
    if (source.module.empty()) continue;
    for (const Include& include : source.includes) {
      const Source* target = resolve(tree, source, include);
      std::set<std::string> seen;
      if (target && target->module != source.module && reachesHeavy(tree, *target, seen)) {
        breaches.push_back(place(source, include) + ", through which it sees OpenVDB's or Vulkan's headers");
      }
    }
  }
  return breaches;
}

Breaches foreignParsers(const fs::path& root) {
  Breaches breaches;
  for (const auto& [path, source] : readTree(root)) {
    if (source.module.empty() || path.starts_with("io/reader/")) continue;
    for (const Include& include : source.includes)
      if (!include.quoted && oneOf(kForeignParsers, include.target))
        breaches.push_back(place(source, include) + ", which only the reader process may run");
  }
  return breaches;
}

Breaches longFiles(const fs::path& root, size_t maxLines) {
  Breaches breaches;
  for (const auto& [path, source] : readTree(root)) {
    if (source.lines <= maxLines) continue;
    const std::string top = path.substr(0, path.find('/'));
    std::ifstream file(root / top / "NOTES.md");
    std::stringstream notes;
    notes << file.rdbuf();
    if (notes.str().find(fs::path(path).filename().string()) == std::string::npos) {
      breaches.push_back(path + ": " + std::to_string(source.lines) + " lines, and " + top +
                         "/NOTES.md gives no reason");
    }
  }
  return breaches;
}

Breaches wideLines(const fs::path& root) {
  constexpr size_t kMost = 120;
  Breaches breaches;
  for (const auto& [path, source] : readTree(root)) {
    if (!path.ends_with(".h") && !path.ends_with(".cpp")) continue;
    std::ifstream file(root / path);
    size_t number = 0;
    bool raw = false;
    for (std::string line; std::getline(file, line);) {
      ++number;
      const bool begins = line.find("R\"") != std::string::npos;
      const bool exempt = raw || begins;
      if (begins) raw = true;
      const size_t from = begins ? line.find("R\"") + 2 : 0;
      const size_t end = line.find(")", from);
      if (raw && end != std::string::npos && line.find('"', end) != std::string::npos) raw = false;
      const auto characters = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
      if (!exempt && characters > std::ptrdiff_t(kMost))
        breaches.push_back(path + ":" + std::to_string(number) + ": " + std::to_string(characters) + " characters");
    }
  }
  return breaches;
}

Breaches misnamedSources(const fs::path& root) {
  const std::regex snake("[a-z0-9]+(_[a-z0-9]+)*\\.(h|cpp)"), test(R"(^TEST(?:_F|_P)?\((\w+),\s*(\w+))");
  Breaches breaches;
  for (const auto& [path, source] : readTree(root)) {
    const std::string file = fs::path(path).filename().string();
    if (!file.ends_with(".h") && !file.ends_with(".cpp")) continue;
    if (!std::regex_match(file, snake)) breaches.push_back(path + ": is not in snake_case");
    if (!path.starts_with("tests/")) continue;
    std::ifstream in(root / path);
    bool tests = false;
    for (std::string line; std::getline(in, line);) {
      std::smatch found;
      if (!line.starts_with("TEST") || !std::regex_search(line, found, test)) continue;
      tests = true;
      for (const int group : {1, 2})
        if (!std::isupper(static_cast<unsigned char>(*found[group].first)))
          breaches.push_back(path + ": " + found[1].str() + "." + found[2].str() + " does not begin with a capital");
    }
    if (tests != file.ends_with("_test.cpp"))
      breaches.push_back(path + (tests ? ": holds tests and does not end in _test.cpp" : ": holds no test"));
  }
  return breaches;
}

Breaches danglingNames(const fs::path& root) {
  constexpr std::array kProse = {".md", ".h", ".cpp", ".txt", ".sh", ".py", ".cmake", ".json"};
  // A path that begins with a folder of the tree: with a suffix anywhere, without one where it is set as code.
  const std::regex name(
      R"re((^|[^\w/.-])((?:clay|haptics|render|io|engine|ui3d|bench|tests|installer|scripts|cmake|docs)/[\w/-]+))re"
      R"re((\.(?:h|cpp|md|sh|txt|json|py|cmake|rules|svg|png))?(`?))re");
  Breaches breaches;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    const std::string path = fs::relative(entry.path(), root).generic_string();
    if (!entry.is_regular_file() || path.starts_with(".") || path.starts_with("build/") ||
        path.starts_with("tests/unit/house/") || path.starts_with("tests/fuzz/"))
      continue;
    if (!oneOf(kProse, entry.path().extension().string())) continue;
    std::ifstream file(entry.path());
    size_t number = 0;
    for (std::string line; std::getline(file, line);) {
      ++number;
      for (auto at = std::sregex_iterator(line.begin(), line.end(), name); at != std::sregex_iterator(); ++at) {
        const std::string stem = (*at)[2].str(), suffix = (*at)[3].str();
        const size_t before = size_t(at->position()) + (*at)[1].length();
        const bool code = before > 0 && line[before - 1] == '`' && !(*at)[4].str().empty();
        if ((suffix.empty() && !code) || stem.find("NAME") != std::string::npos) continue;  // NAME: any
        bool there = fs::exists(root / (stem + suffix));
        if (suffix.empty())
          for (const char* ending : {".h", ".cpp"}) there |= fs::exists(root / (stem + ending));
        if (!there) breaches.push_back(path + ":" + std::to_string(number) + ": names " + stem + suffix);
      }
    }
  }
  return breaches;
}

size_t sourceCount(const fs::path& root) {
  return readTree(root).size();
}

}  // namespace argil::house
