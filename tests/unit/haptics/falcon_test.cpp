// The Falcon's bytes, the loading of its firmware, and what its driver does beyond the conformance suite.

#include "haptics/devices/falcon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <thread>

#include "../../support/devices/falcon_emulator.h"
#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "haptics/devices/falcon_protocol.h"

namespace argil::haptics {
namespace {

using ::testing::ElementsAre;
using testing::FalconEmulator;
using testing::FalconFault;
using testing::FalconLine;
using ::testing::HasSubstr;
using ::testing::Pair;

constexpr unsigned kSeed = 17;

std::vector<uint8_t> someFirmware(size_t size = 1000) {
  std::mt19937 random(kSeed);
  std::vector<uint8_t> bytes(size);
  for (uint8_t& b : bytes) b = static_cast<uint8_t>(random());
  return bytes;
}

std::vector<uint8_t> replyBytes(int a, int b, int c, uint8_t flags) {
  std::vector<uint8_t> bytes = {'<'};
  for (const int value : {a, b, c})
    for (int shift = 0; shift < 16; shift += 4) bytes.push_back(static_cast<uint8_t>(0x41 + ((value >> shift) & 0xf)));
  bytes.push_back(static_cast<uint8_t>(0x41 + flags));
  bytes.push_back(0x41);
  bytes.push_back('>');
  return bytes;
}

std::string text(const FalconPacket& p) {
  return {p.begin(), p.end()};
}

TEST(FalconProtocol, PacksMotorsAndLights) {
  EXPECT_EQ(text(encodeFalcon({})), "<AAAAAAAAAAAAAA>");
  EXPECT_EQ(text(encodeFalcon({{0x123, -1, 0}, kFalconLedRed, false})), "<DCBAPPPPAAAACA>");
  EXPECT_EQ(text(encodeFalcon({{0, 0, 4096}, kFalconLedBlue, true})), "<AAAAAAAAAAABJA>")
      << "homing is asked for in the byte of LEDs";
  EXPECT_EQ(encodeFalcon({{100'000, -100'000, 0}, 0, false}), encodeFalcon({{4096, -4096, 0}, 0, false}))
      << "motors are limited";
}

TEST(FalconProtocol, ReadsAnswersSplitAnywhere) {
  const auto bytes = replyBytes(-1234, 0, 2345, 0x70 | 5);
  // The decoder knows nothing of packets: before, between and after are the same.
  for (size_t cut = 0; cut <= bytes.size(); ++cut) {
    FalconDecoder decoder;
    FalconReply reply;
    int whole = 0;
    for (const uint8_t b : bytes) whole += decoder.feed(b, reply);
    EXPECT_EQ(whole, 1);
    EXPECT_THAT(reply.counts, ElementsAre(-1234, 0, 2345));
    EXPECT_EQ(reply.buttons, 5);
    EXPECT_EQ(reply.homed, 7);
    EXPECT_EQ(decoder.dropped(), 0u);
  }
}

TEST(FalconProtocol, FindsAnswersAgainAfterGarbageOfAnyLength) {
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  const auto good = replyBytes(1, -2, 3, 0x70);
  for (int round = 0; round < 20'000; ++round) {
    FalconDecoder decoder;
    FalconReply reply;
    std::vector<uint8_t> stream(random() % 40);
    for (uint8_t& b : stream) b = static_cast<uint8_t>(random());
    if (round % 2) stream.assign(good.begin(), good.begin() + long(random() % good.size()));  // An answer torn off.
    for (const uint8_t b : stream) (void)decoder.feed(b, reply);
    // One answer may be swallowed by what came before, where that reached the filler; never two.
    const bool torn = round % 2 && stream.size() < 14;
    int whole = 0;
    for (int twice = 0; twice < 2; ++twice)
      for (const uint8_t b : good) whole += decoder.feed(b, reply);
    ASSERT_GE(whole, torn ? 2 : 1) << round;
    EXPECT_THAT(reply.counts, ElementsAre(1, -2, 3));
  }
}

TEST(FalconProtocol, TakesNoPacketThatIsNotWellFormed) {
  const auto good = replyBytes(100, 200, 300, 0x70);
  for (size_t i = 0; i < good.size(); ++i)
    for (const uint8_t wrong : {uint8_t{0}, uint8_t{0x40}, uint8_t{'>'}, uint8_t{0xff}}) {
      if (i == 14 || (i == 15 && wrong == '>')) continue;  // Nothing is known of the filler.
      auto bytes = good;
      bytes[i] = wrong;
      FalconDecoder decoder;
      FalconReply reply;
      for (const uint8_t b : bytes) EXPECT_FALSE(decoder.feed(b, reply)) << i;
      EXPECT_GT(decoder.dropped(), 0u);
    }
}

class FirmwareFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::temp_directory_path() / ("argil-falcon-" + std::to_string(::getpid()));
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::string write(const std::vector<uint8_t>& bytes) {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return path_.string();
  }
  std::string complaint(const std::string& path) {
    try {
      (void)readFalconFirmware(path);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }
  std::filesystem::path path_;
};

TEST_F(FirmwareFile, IsReadOrRefusedInOneSentence) {
  EXPECT_EQ(readFalconFirmware(write(someFirmware())), someFirmware());
  EXPECT_THAT(complaint(""), HasSubstr("falcon.firmware"));
  EXPECT_THAT(complaint("/nowhere/falcon.bin"), HasSubstr("/nowhere/falcon.bin"));
  EXPECT_THAT(complaint(write({})), HasSubstr("is empty"));
  EXPECT_THAT(complaint(write(std::vector<uint8_t>((1 << 20) + 1))), HasSubstr("at most 1048576 bytes"));
  EXPECT_NE(complaint(std::filesystem::temp_directory_path()), "none") << "a folder is no firmware";
  FalconOptions options;
  options.firmware = "/nowhere/falcon.bin";
  EXPECT_THROW((void)openFalcon(options), Error) << "before any device is looked for";
}

struct Load {
  FalconEmulator falcon{someFirmware()};
  FalconLine line{falcon};
  std::vector<uint8_t> firmware = someFirmware();
  FalconLoader loader{line, firmware};
  Load() {
    falcon.powerCycle();
    (void)line.open();
  }
  FalconLoader::Progress run() {
    FalconLoader::Progress progress;
    do progress = loader.step();
    while (progress == FalconLoader::Progress::loading);
    return progress;
  }
};

TEST(FalconFirmware, IsLoadedInTheOrderThatTheBootLoaderWants) {
  Load load;
  EXPECT_EQ(load.run(), FalconLoader::Progress::done) << load.loader.problem();
  EXPECT_TRUE(load.falcon.running());
  EXPECT_EQ(load.loader.attempts(), 1);
  EXPECT_THAT(load.falcon.requests(),
              ElementsAre(Pair(0, 1), Pair(0, 2), Pair(9, 16), Pair(3, 0x4138), Pair(4, 8), Pair(2, 0), Pair(1, 0x0200),
                          Pair(1, 0x0100), Pair(1, 0x0101), Pair(1, 0x0100), Pair(3, 0x15), Pair(9, 1), Pair(3, 2),
                          Pair(0, 1), Pair(0, 2)));
}

TEST(FalconFirmware, IsLoadedAnewWhenAnEchoIsWrong) {
  Load load;
  load.falcon.wrongEchoes(2);
  EXPECT_EQ(load.run(), FalconLoader::Progress::done) << load.loader.problem();
  EXPECT_TRUE(load.falcon.running());
  EXPECT_EQ(load.loader.attempts(), 3);
  EXPECT_THAT(load.loader.problem(), HasSubstr("byte 70 of its firmware came back wrong"));
}

TEST(FalconFirmware, IsGivenUpAfterSomeAttemptsWithTheReason) {
  Load load;
  load.falcon.wrongEchoes(1000);
  EXPECT_EQ(load.run(), FalconLoader::Progress::failed);
  EXPECT_FALSE(load.falcon.running());
  EXPECT_EQ(load.loader.attempts(), 5);
}

TEST(FalconFirmware, KeepsGreetingABootLoaderThatIsSlowToHear) {
  Load load;
  load.falcon.ignoreGreetings(8);
  EXPECT_EQ(load.run(), FalconLoader::Progress::done) << load.loader.problem();
  EXPECT_EQ(load.loader.attempts(), 1);
}

TEST(FalconFirmware, WaitsUntilTheDeviceIsClearToSend) {
  Load load;
  load.falcon.setClearAfterNs(120'000'000);
  EXPECT_EQ(load.run(), FalconLoader::Progress::done) << load.loader.problem();
  EXPECT_EQ(load.loader.attempts(), 1) << "what is sent too early is lost";
}

TEST(FalconFirmware, StopsWhenItIsUnplugged) {
  Load load;
  while (load.loader.loaded() == 0) ASSERT_EQ(load.loader.step(), FalconLoader::Progress::loading);
  load.falcon.unplug();
  EXPECT_EQ(load.run(), FalconLoader::Progress::gone);
}

/// A driver over the emulator, and a servo's turn a millisecond.
class FalconDriver : public FirmwareFile {
 protected:
  void open(const std::string& firmware = "") {
    FalconOptions options;
    options.firmware = firmware;
    device = openFalcon(options, std::make_unique<FalconLine>(falcon));
  }
  bool until(const std::function<bool()>& done, const Vec3d& force = Vec3d::Zero(), double seconds = 30) {
    const int64_t end = nowNs() + int64_t(seconds * 1e9);
    while (nowNs() < end) {
      const double now = double(nowNs()) * 1e-9;
      fresh = device->read(now, state);
      device->write(now, fresh ? force : Vec3d(0, 0, 0));
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  [[nodiscard]] bool says(const std::string& part) const { return device->status().find(part) != std::string::npos; }

  FalconEmulator falcon{someFirmware()};
  std::unique_ptr<Device> device;
  DeviceState state;
  bool fresh = false;
};

TEST_F(FalconDriver, LoadsTheFirmwareThatItIsGiven) {
  falcon.powerCycle();
  falcon.setHomed(true);
  open(write(someFirmware()));
  EXPECT_TRUE(until([&] { return fresh; })) << device->status();
  EXPECT_TRUE(says("ready")) << device->status();
}

TEST_F(FalconDriver, SaysHowFarALongLoadIsAndStopsInTheMidstOfIt) {
  const auto firmware = someFirmware(1 << 15);
  FalconEmulator slow(firmware);
  slow.powerCycle();
  FalconOptions options;
  options.firmware = write(firmware);
  device = openFalcon(options, std::make_unique<FalconLine>(slow));
  EXPECT_TRUE(until([&] { return says("being loaded, "); })) << device->status();
  const int64_t begin = nowNs();
  device.reset();
  EXPECT_LT(double(nowNs() - begin) * 1e-9, 1.5);
}

TEST_F(FalconDriver, SaysThatItNeedsFirmwareAndGoesOnOnceItRuns) {
  falcon.powerCycle();
  open();
  EXPECT_TRUE(until([&] { return says("falcon.firmware"); })) << device->status();
  EXPECT_FALSE(fresh);
  falcon.loadElsewhere();
  EXPECT_TRUE(until([&] { return fresh; })) << device->status();
}

TEST_F(FalconDriver, SaysWhyAFirmwareCannotBeLoaded) {
  falcon.powerCycle();
  falcon.wrongEchoes(1000);
  open(write(someFirmware()));
  EXPECT_TRUE(until([&] { return says("came back wrong"); })) << device->status();
  EXPECT_FALSE(fresh);
  falcon.wrongEchoes(0);
  falcon.setHomed(true);
  EXPECT_TRUE(until([&] { return fresh; })) << device->status();
}

TEST_F(FalconDriver, AsksToBeHomedAndGivesNoPlaceBefore) {
  falcon.setHomed(false);
  open();
  EXPECT_TRUE(until([&] { return says("not homed"); }, {0, 0, 5})) << device->status();
  EXPECT_FALSE(fresh);
  EXPECT_EQ(falcon.lights(), kFalconLedRed | kFalconHomingBit);
  EXPECT_EQ(falcon.peakN(), 0);
  falcon.setHomed(true);
  EXPECT_TRUE(until([&] { return fresh; }, Vec3d::Zero(), 1)) << device->status();
  EXPECT_TRUE(until([&] { return falcon.lights() == kFalconLedGreen; }));
  falcon.setHomed(false);  // Its firmware began anew: its counts mean nothing now.
  EXPECT_TRUE(until([&] { return !fresh && falcon.forceN().norm() == 0 && says("not homed"); }, {0, 0, 5}))
      << device->status();
}

TEST_F(FalconDriver, NamesItsButtonsFromTheCentre) {
  open();
  ASSERT_TRUE(until([&] { return fresh; }));
  for (const auto& [raw, bit] :
       {std::pair{4, 1u}, std::pair{1, 2u}, std::pair{2, 4u}, std::pair{8, 8u}, std::pair{13, 11u}}) {
    falcon.hand(Vec3d::Zero(), uint8_t(raw));
    EXPECT_TRUE(until([&, b = bit] { return state.buttons == b && state.pressure == 1; }))
        << raw << " gave " << state.buttons;
  }
  falcon.hand(Vec3d::Zero(), 0);
  EXPECT_TRUE(until([&] { return state.buttons == 0 && state.pressure == 0; }));
}

TEST_F(FalconDriver, KeepsTheDirectionOfAForceThatItsMotorsCannotReach) {
  falcon.hand({0, 0, 30}, 0);
  open();
  ASSERT_TRUE(until([&] { return fresh; }));
  const Vec3d force = device->sheet().peakForceN * Vec3d(0.8, 0.6, 0);
  EXPECT_TRUE(until([&] { return falcon.forceN().norm() > 4; }, force));
  EXPECT_TRUE(until([&] { return falcon.forceN().normalized().dot(force.normalized()) > 0.9999; }, force))
      << falcon.forceN().transpose();
  EXPECT_LT(falcon.forceN().norm(), 0.9 * force.norm()) << "the limit of the motors is the nearer one here";
}

TEST_F(FalconDriver, FindsAnswersAmongLitter) {
  falcon.misbehave(FalconFault::littered);
  open();
  ASSERT_TRUE(until([&] { return fresh; })) << device->status();
  int count = 0;
  EXPECT_TRUE(until([&] { return (count += fresh) == 100; }));
  EXPECT_LT(state.pose.translation.norm(), 0.061);
}

TEST_F(FalconDriver, TakesNoLateAnswerForOneInTime) {
  open();
  ASSERT_TRUE(until([&] { return fresh; }));
  falcon.misbehave(FalconFault::late);  // Twenty milliseconds, steadily: each comes while a later question waits.
  EXPECT_TRUE(until([&] { return !fresh; }));
  const int64_t begin = nowNs();
  EXPECT_FALSE(until([&] { return fresh; }, {0, 0, 4}, 0.3))
      << "after " << double(nowNs() - begin) * 1e-6 << " ms: " << device->status();
  EXPECT_EQ(falcon.forceN().norm(), 0);
  falcon.misbehave(FalconFault::none);
  EXPECT_TRUE(until([&] { return fresh; }, Vec3d::Zero(), 1)) << device->status();
}

TEST_F(FalconDriver, IsAtZeroAfterAStallAndGoesOn) {
  open();
  ASSERT_TRUE(until([&] { return fresh && falcon.forceN().norm() > 3; }, {0, 0, 4}));
  falcon.misbehave(FalconFault::stall);
  EXPECT_TRUE(until([&] { return !fresh; }, {0, 0, 4}));
  EXPECT_TRUE(until([&] { return !says("ready"); }, {0, 0, 4}));
  const uint64_t before = falcon.packets();
  falcon.misbehave(FalconFault::none);
  EXPECT_TRUE(until([&] { return falcon.packets() > before; }, {0, 0, 4}));
  EXPECT_TRUE(until([&] { return falcon.forceN().norm() == 0; }, Vec3d::Zero()));
  EXPECT_TRUE(until([&] { return fresh && says("ready"); }, Vec3d::Zero(), 1)) << device->status();
}

TEST_F(FalconDriver, LoadsItsFirmwareAnewAfterItWasSwitchedOff) {
  open(write(someFirmware()));
  ASSERT_TRUE(until([&] { return fresh; }));
  falcon.powerCycle();
  EXPECT_TRUE(until([&] { return !fresh; }));
  falcon.setHomed(true);
  EXPECT_TRUE(until([&] { return fresh; })) << device->status();
}

TEST_F(FalconDriver, ExchangesAThousandTimesASecond) {
  open();
  ASSERT_TRUE(until([&] { return fresh; }));
  const uint64_t before = falcon.packets();
  const int64_t begin = nowNs();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const double rate = double(falcon.packets() - before) / (double(nowNs() - begin) * 1e-9);
  std::printf("exchanges a second: %.0f\n", rate);
  EXPECT_GT(rate, 300) << "a generous bound: the machine may be busy";
  EXPECT_LT(rate, 1500) << "no faster than its sheet says";
}

}  // namespace
}  // namespace argil::haptics
