#pragma once
// The house plan, checked on a source tree: which module may include which, where heavy headers may be seen, how long a
// file is.

#include <filesystem>
#include <string>
#include <vector>

namespace argil::house {

/// One breach, as a line: "haptics/x.h:3: includes io/y.h, but haptics may include clay only".
using Breaches = std::vector<std::string>;

/// Includes that go against the plan's arrows, that leave a module by "..", or that name a file that is not there.
/// Tests are free; each plugin beside the sdk may include the sdk only. Throws std::filesystem::filesystem_error when
/// `root` is not a folder.
[[nodiscard]] Breaches arrows(const std::filesystem::path& root);

/// Includes by which a folder of a module sees one that stands on it, and headers in folders that are no floor of
/// theirs.
[[nodiscard]] Breaches floors(const std::filesystem::path& root);

/// Folders of more source files than a reader looks through.
[[nodiscard]] Breaches crowdedFolders(const std::filesystem::path& root, size_t most = 40);

/// Lines of more than 120 characters outside of raw string literals.
[[nodiscard]] Breaches wideLines(const std::filesystem::path& root);

/// Names of files and folders of the tree, in prose and code, that are not there: "clay/base/gone.h", `engine/gone`.
[[nodiscard]] Breaches danglingNames(const std::filesystem::path& root);

/// Source files that are not named in snake_case; files of test cases that do not end in _test.cpp, or that do and hold
/// none; test cases and suites whose name does not begin with a capital.
[[nodiscard]] Breaches misnamedSources(const std::filesystem::path& root);

/// Includes by which a file of one module gets to see OpenVDB's or Vulkan's headers through a header of another.
[[nodiscard]] Breaches heavyHeaders(const std::filesystem::path& root);

/// Files outside of io/reader that include a library that takes other people's files apart: those run in its confined
/// process alone. Tests are free.
[[nodiscard]] Breaches foreignParsers(const std::filesystem::path& root);

/// Files over `maxLines` lines that the NOTES.md of their top folder does not name.
[[nodiscard]] Breaches longFiles(const std::filesystem::path& root, size_t maxLines = 600);

/// How many source files the checks see; a tree of none checks nothing.
[[nodiscard]] size_t sourceCount(const std::filesystem::path& root);

}  // namespace argil::house
