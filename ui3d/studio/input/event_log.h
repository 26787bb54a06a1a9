#pragma once
// Recordings of a session: one event a line, as JSON.

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "ui3d/studio/view/event.h"

namespace argil::studio {

/// An event as a line: {"t": 1.25, "kind": "press", "x": 640, "y": 360, "button": "left", "modifiers": ["ctrl"]}. Only
/// what matters to its kind is written; what is left out when it is read is as in Event.
[[nodiscard]] std::string toLine(const Event& event);
/// Throws Error that says what is wrong with the line.
[[nodiscard]] Event fromLine(const std::string& line);

/// Empty lines and lines that begin with # do not count. Throws Error with file and line number: one that cannot be
/// read, a number that is not finite, a time that goes back.
[[nodiscard]] std::vector<Event> readEvents(const std::filesystem::path& file);

/// Writes events as they come; each is in the file at once, so that a crash leaves what led to it. One thread.
class EventWriter {
 public:
  /// Throws Error when the file is there already or cannot be made.
  explicit EventWriter(const std::filesystem::path& file);
  /// Throws Error when the disk is full.
  void write(const Event& event);

 private:
  std::filesystem::path file_;
  std::ofstream out_;
};

}  // namespace argil::studio
