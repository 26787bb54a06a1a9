// Drivers against facts that were published by others, byte for byte, worked out here by other means than the drivers
// use: their emulators share the drivers' kinematics and factors, and would share their mistakes.

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <numbers>
#include <thread>
#include <vector>

#include "../../support/devices/pty_emulator.h"
#include "../../support/devices/spacemouse_emulator.h"
#include "haptics/base/clock.h"
#include "haptics/devices/byte_transport.h"
#include "haptics/devices/falcon.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/spacemouse.h"

namespace argil::haptics {
namespace {

using namespace std::chrono_literals;

// ---- Novint Falcon
// ------------------------------------------------------------------------------------------------------------
// Published: the lengths of the linkage and the encoders' gearing (libnifalcon, FalconGeometry.h, with the names of R.
// E. Stamper, "A Three Degree of Freedom Parallel Manipulator with Only Translational Degrees of Freedom", University
// of Maryland 1997, PhD 97-4, p. 30); torque = Jᵀ · force, and the motors' words are −10 000 times the torque in N·m
// (libnifalcon, FalconKinematicStamper, getForces), all lessened alike when one is over its end. The packets: sixteen
// bytes, nibbles as 0x41 and up, the lowest first.

constexpr double kDeg = std::numbers::pi / 180;

// One leg is a chain of four bars from the base: arm, hinge, rod, hinge. Its end in the base's frame, mm, for Stamper's
// three angles: θ1 of the arm, θ2 of the rods in the arm's plane, θ3 of the rods out of it.
Eigen::Vector3d legEnd(int leg, double t1, double t2, double t3) {
  const double a = 60, b = 102.5, c = 14.43, d = 11.25, e = 11.25, f = -25, r = 40, s = -23.09;
  const double phi[] = {105 * kDeg, -15 * kDeg, -135 * kDeg};
  // In the leg's frame: u outwards, v along the arm's axis, w towards the person.
  Eigen::Vector3d p(a * std::cos(t1) - c + (d + e + b * std::sin(t3)) * std::cos(t2), b * std::cos(t3) - f,
                    a * std::sin(t1) + (d + e + b * std::sin(t3)) * std::sin(t2));
  p += Eigen::Vector3d(r, s, 0);
  return Eigen::AngleAxisd(phi[leg], Eigen::Vector3d::UnitZ()) * p;
}

// Where all three chains end in one place: nine equations, for the place and the six angles that no encoder sees, by
// Newton with differences, from a rough place in the middle.
Eigen::Vector3d closeLinkage(const Eigen::Vector3d& theta1) {
  Eigen::Matrix<double, 9, 1> x;
  x << 0, 0, 110, 100 * kDeg, 80 * kDeg, 100 * kDeg, 80 * kDeg, 100 * kDeg, 80 * kDeg;
  const auto miss = [&](const Eigen::Matrix<double, 9, 1>& y) {
    Eigen::Matrix<double, 9, 1> m;
    for (int i = 0; i < 3; ++i) m.segment<3>(3 * i) = legEnd(i, theta1[i], y[3 + 2 * i], y[4 + 2 * i]) - y.head<3>();
    return m;
  };
  for (int step = 0; step < 100; ++step) {
    const Eigen::Matrix<double, 9, 1> m = miss(x);
    if (m.norm() < 1e-10) break;
    Eigen::Matrix<double, 9, 9> slope;
    for (int i = 0; i < 9; ++i) {
      const double h = i < 3 ? 1e-4 : 1e-6;
      Eigen::Matrix<double, 9, 1> y = x;
      y[i] += h;
      slope.col(i) = (miss(y) - m) / h;
    }
    Eigen::Matrix<double, 9, 1> move = slope.fullPivLu().solve(m);
    if (move.tail<6>().norm() > 0.3) move *= 0.3 / move.tail<6>().norm();
    x -= move;
  }
  EXPECT_LT(miss(x).norm(), 1e-7) << "the linkage closes";
  return x.head<3>();
}

Eigen::Vector3d anglesOf(const std::array<int, 3>& counts) {
  Eigen::Vector3d t;
  // 320 slots read four times; the motor's shaft of 14.25 mm drives a sector of 110 mm.
  for (int i = 0; i < 3; ++i) t[i] = (35 + counts[size_t(i)] * (360.0 / 1280) * (14.25 / 110)) * kDeg;
  return t;
}

/// A Falcon that runs and is homed, whose arms stand where the test puts them, and that keeps the last packet.
class BareFalcon final : public ByteTransport {
 public:
  struct Wire {
    std::mutex mutex;
    std::array<int, 3> counts{};
    uint8_t buttons = 0;
    std::vector<uint8_t> last, answer;
    size_t packets = 0;
  };
  explicit BareFalcon(Wire& wire) : wire_(wire) {}
  Opening open() override { return Opening::opened; }
  void close() noexcept override {}
  std::string sentence() const override { return "bare"; }
  Transfer control(FtdiRequest, uint16_t) override { return Transfer::ok; }
  Transfer write(std::span<const uint8_t> bytes, int64_t) override {
    const std::scoped_lock lock(wire_.mutex);
    wire_.last.assign(bytes.begin(), bytes.end());
    ++wire_.packets;
    wire_.answer = {0x3C};
    for (const int count : wire_.counts)
      for (int nibble = 0; nibble < 4; ++nibble)
        wire_.answer.push_back(static_cast<uint8_t>(0x41 + ((static_cast<unsigned>(count) >> (4 * nibble)) & 15)));
    wire_.answer.push_back(static_cast<uint8_t>(0x41 + 0x70 + wire_.buttons));
    wire_.answer.push_back(0x41);
    wire_.answer.push_back(0x3E);
    return Transfer::ok;
  }
  Transfer read(std::span<uint8_t> into, size_t& count, int64_t) override {
    const std::scoped_lock lock(wire_.mutex);
    count = std::min(into.size(), wire_.answer.size());
    std::copy_n(wire_.answer.begin(), count, into.begin());
    wire_.answer.clear();
    return count > 0 ? Transfer::ok : Transfer::timeout;
  }
  bool clearToSend() const noexcept override { return true; }

 private:
  Wire& wire_;
};

std::array<int, 3> motorWords(const std::vector<uint8_t>& packet) {
  std::array<int, 3> words{};
  for (size_t arm = 0; arm < 3; ++arm) {
    unsigned bits = 0;
    for (size_t nibble = 0; nibble < 4; ++nibble)
      bits |= unsigned(packet.at(1 + 4 * arm + nibble) - 0x41) << (4 * nibble);
    words[arm] = static_cast<int16_t>(static_cast<uint16_t>(bits));
  }
  return words;
}

struct Falcon {
  BareFalcon::Wire wire;
  std::unique_ptr<Device> device = openFalcon(FalconOptions(), std::make_unique<BareFalcon>(wire));

  // Puts the arms there and waits until the driver has answered to them with a force of its own.
  DeviceState at(const std::array<int, 3>& counts, uint8_t buttons, const Vec3d& force) {
    {
      const std::scoped_lock lock(wire.mutex);
      wire.counts = counts;
      wire.buttons = buttons;
    }
    DeviceState state;
    size_t from = 0;
    {
      const std::scoped_lock lock(wire.mutex);
      from = wire.packets;
    }
    int fresh = 0;
    for (int i = 0; i < 20000; ++i) {
      fresh += device->read(double(nowNs()) * 1e-9, state);
      device->write(double(nowNs()) * 1e-9, force);
      std::this_thread::sleep_for(500us);
      const std::scoped_lock lock(wire.mutex);
      const std::array<int, 3> words = motorWords(wire.last.empty() ? std::vector<uint8_t>(16, 0x41) : wire.last);
      const bool pushing = words != std::array<int, 3>{} || force.norm() == 0;
      if (fresh > 20 && pushing && wire.packets > from + 20) break;
    }
    EXPECT_GT(fresh, 20) << device->status();
    return state;
  }
};

const std::array<std::array<int, 3>, 7> kFalconCounts = {{{0, 0, 0},
                                                          {-600, -600, -600},
                                                          {300, 300, 300},
                                                          {-400, 100, 250},
                                                          {500, -300, 0},
                                                          {-100, -700, 200},
                                                          {0, 0, -500}}};

TEST(GoldenFalcon, CountsAreThePlacesThatItsLinkageHas) {
  Falcon falcon;
  const double origin = closeLinkage(anglesOf({0, 0, 0})).z();
  for (const auto& counts : kFalconCounts) {
    const Eigen::Vector3d place = closeLinkage(anglesOf(counts));
    const DeviceState state = falcon.at(counts, 0, Vec3d::Zero());
    // The device's origin is 115 mm before the base.
    EXPECT_LT((state.pose.translation - (place - Eigen::Vector3d(0, 0, 115))).norm(), 0.005)
        << counts[0] << " " << counts[1] << " " << counts[2] << ": " << state.pose.translation.transpose()
        << " and not " << place.transpose();
  }
  // By hand: at equal angles the grip is on the axis. At count 0 the arms stand at 35°: 60 cos 35° = 49.149 and 60 sin
  // 35° = 34.415 mm. Sideways the rods bridge −23.09 + 25 = 1.91 mm of their 102.5 mm: 102.482 mm are left in the arm's
  // plane, with both hinges 124.982. Outwards they must bridge 40 + 49.149 − 14.43 = 74.719 mm: √(124.982² − 74.719²) =
  // 100.187, and 34.415 before the base: 134.60 mm.
  EXPECT_NEAR(origin, 134.60, 0.01);
}

TEST(GoldenFalcon, ForcesAreTheWordsThatVirtualWorkAsksFor) {
  Falcon falcon;
  for (const auto& counts : kFalconCounts)
    for (const Vec3d& force : {Vec3d(1, 0, 0), Vec3d(0, -1.5, 0), Vec3d(0, 0, 2), Vec3d(-0.7, 0.9, -1.1)}) {
      const Eigen::Vector3d t = anglesOf(counts);
      // A push of the hand over a small motion of each arm: τ = f · dp/dθ.
      Eigen::Vector3d torqueNmm;
      for (int i = 0; i < 3; ++i) {
        constexpr double kStep = 1e-4;
        const Eigen::Vector3d turn = kStep * Eigen::Vector3d::Unit(i);
        torqueNmm[i] = force.dot((closeLinkage(t + turn) - closeLinkage(t - turn)) / (2 * kStep));
      }
      Eigen::Vector3d words = -10000 * 1e-3 * torqueNmm;
      if (words.cwiseAbs().maxCoeff() > 4096) words *= 4096 / words.cwiseAbs().maxCoeff();
      (void)falcon.at(counts, 0, force);
      const std::scoped_lock lock(falcon.wire.mutex);
      const std::array<int, 3> sent = motorWords(falcon.wire.last);
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(sent[size_t(i)], words[i], 1 + 2e-3 * words.norm())
            << "arm " << i << " for " << force.transpose() << " at " << counts[0] << " " << counts[1] << " "
            << counts[2];
      EXPECT_EQ(falcon.wire.last.front(), 0x3C);
      EXPECT_EQ(falcon.wire.last.back(), 0x3E);
      EXPECT_EQ(falcon.wire.last.size(), 16u);
    }
}

TEST(GoldenFalcon, ButtonsAreThoseOfItsGrip) {
  // Published: 1 right, 2 forward, 4 centre, 8 left. Argil's first is the centre.
  Falcon falcon;
  for (const auto& [raw, wanted] :
       {std::pair{uint8_t{4}, 1u}, {uint8_t{1}, 2u}, {uint8_t{2}, 4u}, {uint8_t{8}, 8u}, {uint8_t{0}, 0u}})
    EXPECT_EQ(falcon.at({0, 0, 0}, raw, Vec3d::Zero()).buttons, wanted) << int(raw);
}

// ---- Haply Inverse3
// ----------------------------------------------------------------------------------------------------------- Published
// (docs.haply.co, "Developing with Inverse3"; its Python samples push in newtons and read metres): 0x2A and three
// little-endian 32-bit floats are answered by 0x2B with place and velocity. Floats are written out here by hand, as
// IEEE 754 has them.

class BareHaply final : public testing::PtyEmulator {
 public:
  ~BareHaply() override { stop(); }
  std::vector<uint8_t> last() const {
    const std::scoped_lock lock(mutex_);
    return last_;
  }

 protected:
  size_t answer(std::span<const uint8_t> in, const Hand&, std::vector<uint8_t>& out) override {
    if (in[0] == 0x0A) {
      out = {0x0B, 1, 2, 3};
      return 1;
    }
    if (in.size() < 13) return 0;
    {
      const std::scoped_lock lock(mutex_);
      last_.assign(in.begin(), in.begin() + 13);
    }
    // 0.125 m, −0.25 m, 0.1875 m; at rest.
    out = {0x2B, 0x00, 0x00, 0x00, 0x3E, 0x00, 0x00, 0x80, 0xBE, 0x00, 0x00, 0x40, 0x3E,
           0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0};
    return 13;
  }
  void spoil(testing::Misbehaviour, std::vector<uint8_t>&) override {}

 private:
  mutable std::mutex mutex_;
  std::vector<uint8_t> last_;
};

TEST(GoldenHaply, SpeaksTheBytesOfItsProtocol) {
  BareHaply arm;
  arm.plug();
  HaplyOptions options;
  options.port = arm.path();
  options.centreMm = {0, 0, 0};
  options.realtime = false;
  const auto device = openHaply(options);
  DeviceState state;
  const std::vector<uint8_t> wanted = {0x2A, 0x00, 0x00, 0x40, 0x3F, 0x00, 0x00,
                                       0x20, 0xC0, 0x00, 0x00, 0x80, 0x3F};  // 0.75, −2.5 and 1 N.
  bool fresh = false;
  for (int i = 0; i < 20000 && (!fresh || arm.last() != wanted); ++i) {
    fresh = device->read(0, state) || fresh;
    device->write(0, {0.75, -2.5, 1});
    std::this_thread::sleep_for(500us);
  }
  EXPECT_EQ(arm.last(), wanted);
  ASSERT_TRUE(fresh) << device->status();
  EXPECT_LT((state.pose.translation - Vec3d(125, -250, 187.5)).norm(), 1e-9);
}

// ---- 3Dconnexion SpaceNavigator
// ----------------------------------------------------------------------------------------------- Published: what a
// SpaceNavigator's node gives for one tap on its top (3dconnexion forum, viewtopic 16943, 24 September 2016), whole
// reports of id, and three little-endian 16-bit numbers; its left button is 03 01 00. z is positive when it is pushed
// down.

class Played final : public HidSource {
 public:
  explicit Played(int fd) : fd_(fd) {}
  ~Played() override { close(); }
  DeviceLink::Opened open(std::string&) override {
    const auto d = testing::SpaceMouseEmulator::descriptor(testing::SpaceMouseEmulator::Layout::twoReports);
    nodes_.push_back({{d.begin(), d.end()}, fd_});
    return DeviceLink::Opened::ready;
  }
  std::span<const Node> nodes() const noexcept override { return nodes_; }
  void drop(size_t node) noexcept override { nodes_[node].fd = -1; }
  void close() noexcept override {
    nodes_.clear();
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
  std::vector<Node> nodes_;
};

TEST(GoldenSpaceMouse, TakesATapOnItsTopForAPushDown) {
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
  // The published tap's reports that push hardest, in place of their 8 ms held until the puck has moved: −8, 20, 85 of
  // 350, then its turn.
  const uint8_t push[] = {0x01, 0xF8, 0xFF, 0x14, 0x00, 0x55, 0x00},
                turn[] = {0x02, 0x00, 0x00, 0x15, 0x00, 0x00, 0x00};
  const uint8_t left[] = {0x03, 0x01, 0x00};
  SpaceMouseOptions options;
  options.deadZone = 0;
  const auto device = openSpaceMouse(options, std::make_unique<Played>(ends[1]));
  DeviceState state;
  const int64_t end = nowNs() + 10'000'000'000;
  while ((state.pose.translation.norm() < 1 || state.buttons == 0) && nowNs() < end) {
    for (const auto report :
         {std::span<const uint8_t>(push), std::span<const uint8_t>(turn), std::span<const uint8_t>(left)})
      (void)!send(ends[0], report.data(), report.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    std::this_thread::sleep_for(2ms);
    device->read(0, state);
  }
  ::close(ends[0]);
  // Down, and by the same proportions: to the left 8, towards the person 20, down 85. Ours: x right, y away, z up.
  const Vec3d way = state.pose.translation.normalized(), wanted = Vec3d(-8, -20, -85).normalized();
  EXPECT_LT((way - wanted).norm(), 1e-6) << way.transpose();
  EXPECT_EQ(state.buttons, 1u);
  // 21 about its y, which points towards the person.
  const Eigen::AngleAxisd turned(state.pose.rotation);
  EXPECT_LT((turned.axis() - Vec3d(0, -1, 0)).norm(), 1e-6) << turned.axis().transpose();
}

}  // namespace
}  // namespace argil::haptics
