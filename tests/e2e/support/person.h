#pragma once
// A person before a screen: starts the studio, moves the mouse, presses keys, looks. Real X events, by the XTest
// extension.

#include <sys/types.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/view/image.h"

namespace argil::tests {

/// The studio as a program of its own on the DISPLAY of this process. Killed when it is still there at the end.
class RunningStudio {
 public:
  /// `home`: its settings and journals are kept there.
  RunningStudio(const std::vector<std::string>& arguments, const std::filesystem::path& home);
  ~RunningStudio();
  RunningStudio(const RunningStudio&) = delete;
  RunningStudio& operator=(const RunningStudio&) = delete;

  [[nodiscard]] bool running();
  /// Its exit code, 128 + signal when it was killed, −1 when it has not ended in that time.
  int wait(double seconds);
  [[nodiscard]] std::string said() const;  ///< On stderr.
  [[nodiscard]] uint64_t residentBytes() const;
  [[nodiscard]] double cpuSeconds() const;  ///< User and system.
  /// What each of its threads had to do until now, s: processor time; for those that draw also the time that they
  /// waited for a processor. Without those that tick at rest: the servo and devices.
  [[nodiscard]] std::map<pid_t, double> workSeconds() const;
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int code_ = -1;
  bool ended_ = false;
  std::filesystem::path err_;
};

/// Throws std::runtime_error for what a test cannot go on without.
class Person {
 public:
  /// Waits until the studio's window is there and shows something. Positions from now on are interface units: pixels
  /// over `scale`.
  explicit Person(RunningStudio& studio, double scale = 1);
  ~Person();
  Person(const Person&) = delete;
  Person& operator=(const Person&) = delete;

  void move(double x, double y);
  void press(int button = 1);
  void release(int button = 1);
  void click(double x, double y, int button = 1);
  /// Along these points, evenly in time, with a button held.
  void drag(const std::vector<std::array<double, 2>>& points, double seconds = 0.6, int button = 1);
  void wheel(int clicks);
  /// "ctrl+shift+z", "F", "[", "escape"; pressed and released.
  void key(const std::string& keys);
  void keyDown(const std::string& key);
  void keyUp(const std::string& key);
  void type(const std::string& text);

  void resize(int width, int height);
  void minimise();
  void restore();
  /// As the window manager's button does.
  void close();
  void pause(double seconds) const;
  /// Waits until the studio has taken in what was done, and has next to nothing to do for 0.6 s: a pause that is as
  /// long as the machine needs. At most 15 s.
  void ready() const;

  /// What the window shows, as it stands on the screen.
  [[nodiscard]] render::Image look() const;
  /// Waits until that has not changed for 0.6 s times the scale, but for what blinks, while the studio had next to
  /// nothing to do: on a busy machine it may stand still over its work. At most 60 s.
  [[nodiscard]] render::Image settled() const;
  /// The same, kept as NAME.png in $ARGIL_SHOTS if that is set.
  render::Image shot(const std::string& name) const;

 private:
  struct State;
  class Watch;
  std::unique_ptr<State> state_;
};

/// Throws std::runtime_error when it is no PNG.
[[nodiscard]] render::Image readPng(const std::filesystem::path& file);
/// Part of the pixels that differ by more than 8 in some channel: 0 to 1; 1 for pictures of different size.
[[nodiscard]] double difference(const render::Image& a, const render::Image& b);

}  // namespace argil::tests
