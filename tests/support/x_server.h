#pragma once
// A screen that nobody sees, for tests that open windows.

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace argil::support {

/// An X server (Xvfb) of its own for this process, and a window manager (openbox) if wanted. Several processes may each
/// have one at once. Sets DISPLAY while it lives; both programs end with it, and with this process however it ends.
class XServer {
 public:
  struct Options {
    int width = 1400, height = 900;  ///< Pixels of the screen, 24 bits each.
    bool windowManager = false;      ///< Windows get frames, can be minimised, and take keys when clicked.
  };

  /// What has to be installed first, as a sentence; empty when all is there.
  static std::string missing(const Options& options);
  static std::string missing() { return missing(Options()); }

  /// Returns when windows can be opened. Throws std::runtime_error when a program does not start.
  XServer() : XServer(Options()) {}
  explicit XServer(const Options& options);
  ~XServer();
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;

  /// As in DISPLAY: ":7".
  [[nodiscard]] const std::string& display() const { return display_; }

  /// RGBA, top row first.
  struct Pixels {
    int width = 0, height = 0;
    std::vector<uint8_t> rgba;
  };
  /// What the screen, or the inside of one window, shows now; empty when that window is not on the screen.
  [[nodiscard]] Pixels pixels(unsigned long window = 0) const;

 private:
  void startServer(const Options& options);
  void startWindowManager();
  void stop() noexcept;

  pid_t server_ = -1, manager_ = -1;
  std::string display_, displayBefore_;
  bool hadDisplay_ = false;
};

}  // namespace argil::support
