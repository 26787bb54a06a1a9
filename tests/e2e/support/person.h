#pragma once
// A person before a screen: starts the studio, moves the mouse, presses keys, looks. Real X events, by the XTest
// extension.

#include <sys/types.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/view/image.h"

namespace argil::tests {

/// The studio as a program of its own on the DISPLAY of this process. Killed when it is still there at the end.
class RunningStudio {
 public:
  /// `home`: its settings and journals are kept there. Where it has no settings yet and the long tests do not run,
  /// pictures at rest are without shadows and of one sample a pixel, which a software driver draws in a fraction of the
  /// time.
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
  /// Turns of its loop until now after which it had something left to do, and after which it had not (rest_sign.h).
  struct Turns {
    uint64_t acting = 0, resting = 0;
  };
  [[nodiscard]] Turns turns() const;
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int code_ = -1;
  bool ended_ = false;
  std::filesystem::path err_;
  const std::atomic<uint64_t>* turns_ = nullptr;
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
  /// Waits until the studio has done what it was asked and for 0.3 s nothing else came: a pause that is as long as the
  /// machine needs. At most five minutes.
  void ready() const;

  /// What the window shows, as it stands on the screen.
  [[nodiscard]] render::Image look() const;
  /// Waits until that has not changed for 0.6 s times the scale, but for what blinks, while the studio had nothing to
  /// do: on a busy machine it may stand still over its work. At most five minutes.
  [[nodiscard]] render::Image settled() const;
  /// The same, kept as NAME.png in $ARGIL_SHOTS if that is set.
  render::Image shot(const std::string& name) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Keeps it as NAME.png in $ARGIL_SHOTS if that is set; characters of the name that files do not like become '-'.
void keep(const render::Image& image, std::string name);
/// Throws std::runtime_error when it is no PNG.
[[nodiscard]] render::Image readPng(const std::filesystem::path& file);
/// Part of the pixels that differ by more than 8 in some channel: 0 to 1; 1 for pictures of different size.
[[nodiscard]] double difference(const render::Image& a, const render::Image& b);

}  // namespace argil::tests
