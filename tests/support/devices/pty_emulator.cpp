#include "pty_emulator.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "haptics/servo/servo.h"

namespace argil::haptics::testing {

using namespace std::chrono_literals;

PtyEmulator::PtyEmulator() {
  static std::atomic<int> number{0};
  path_ = std::filesystem::temp_directory_path() /
          ("argil-pty-" + std::to_string(getpid()) + "-" + std::to_string(number++));
}

PtyEmulator::~PtyEmulator() {
  stop();
}

void PtyEmulator::stop() {
  unplug();
}

void PtyEmulator::plug() {
  unplug();
  master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0 || grantpt(master_) != 0 || unlockpt(master_) != 0) throw std::runtime_error("no pseudo-terminal");
  const std::string name = ptsname(master_);
  termios line{};
  const int slave = open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  tcgetattr(slave, &line);
  cfmakeraw(&line);  // Or the terminal would echo what is sent before the driver has opened it.
  tcsetattr(slave, TCSANOW, &line);
  slave_ = slave;  // Held open, or the master would see a hang-up between two openings by the driver.
  stop_.store(false);
  thread_ = std::thread([this, master = master_] { run(master); });
  std::filesystem::create_symlink(name, path_);
}

void PtyEmulator::unplug() {
  std::filesystem::remove(path_);
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
  if (master_ >= 0) close(master_);
  if (slave_ >= 0) close(slave_);
  master_ = slave_ = -1;
  const std::scoped_lock lock(mutex_);
  forceN_.setZero();  // No power.
}

void PtyEmulator::hand(const Vec3d& positionMm, uint32_t buttons) {
  const std::scoped_lock lock(mutex_);
  hand_ = {positionMm, buttons};
}

Vec3d PtyEmulator::forceN() const {
  const std::scoped_lock lock(mutex_);
  return forceN_;
}

double PtyEmulator::peakN() const {
  const std::scoped_lock lock(mutex_);
  return peakN_;
}

uint64_t PtyEmulator::told() const {
  const std::scoped_lock lock(mutex_);
  return toldN_.size();
}

Vec3d PtyEmulator::toldN(uint64_t which) const {
  const std::scoped_lock lock(mutex_);
  return toldN_[which];
}

void PtyEmulator::motors(const Vec3d& forceN) {
  const std::scoped_lock lock(mutex_);
  toldN_.push_back(forceN);
  forceN_ = forceN;
  peakN_ = std::max(peakN_, forceN.allFinite() ? forceN.norm() : 1e9);
}

void PtyEmulator::send(int master, std::vector<uint8_t> bytes) {
  const Misbehaviour what = misbehaviour_.load();
  const auto put = [master](std::span<const uint8_t> part) { (void)!write(master, part.data(), part.size()); };
  switch (what) {
    case Misbehaviour::none:
      break;
    case Misbehaviour::split:
      put(std::span(bytes).first(bytes.size() / 2));
      std::this_thread::sleep_for(200us);
      put(std::span(bytes).subspan(bytes.size() / 2));
      return;
    case Misbehaviour::garbage:
      for (uint8_t& b : bytes) b = static_cast<uint8_t>(random_());
      break;
    case Misbehaviour::shortAnswers:
      bytes.resize(bytes.size() / 2);
      break;
    case Misbehaviour::late:
      std::this_thread::sleep_for(30ms);
      break;
    case Misbehaviour::silent:
      return;
    case Misbehaviour::notFinite:
    case Misbehaviour::wrongEcho:
      spoil(what, bytes);
      break;
  }
  put(bytes);
}

void PtyEmulator::run(int master) {
  (void)becomeRealtime(90, false);  // A device answers whatever else this machine does.
  std::vector<uint8_t> in;
  while (!stop_.load()) {
    if (endless_.load()) {
      const std::vector<uint8_t> noise(4096, 0x55);
      if (write(master, noise.data(), noise.size()) <= 0) std::this_thread::sleep_for(50us);
      uint8_t chunk[256];
      if (read(master, chunk, sizeof chunk) > 0) in.clear();
      continue;
    }
    pollfd p{master, POLLIN, 0};
    if (poll(&p, 1, 5) <= 0) continue;
    uint8_t chunk[256];
    const ssize_t n = read(master, chunk, sizeof chunk);
    if (n <= 0) {
      std::this_thread::sleep_for(1ms);  // Nobody has the line open.
      continue;
    }
    in.insert(in.end(), chunk, chunk + n);
    while (!in.empty()) {
      Hand hand;
      {
        const std::scoped_lock lock(mutex_);
        hand = hand_;
      }
      std::vector<uint8_t> out;
      const size_t taken = answer(in, hand, out);
      if (taken == 0) break;
      in.erase(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(taken));
      if (!out.empty()) send(master, std::move(out));
    }
  }
}

}  // namespace argil::haptics::testing
