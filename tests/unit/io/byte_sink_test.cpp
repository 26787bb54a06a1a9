#include "io/bytes/byte_sink.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "clay/base/error.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::slurp;

TEST(ByteSink, EveryByteInItsOrder) {
  const samples::Folder folder;
  std::string expected;
  {
    AtomicFile file(folder / "a.bin");
    ByteSink sink(file);
    uint32_t state = 1;
    const auto next = [&] { return state = state * 1664525 + 1013904223; };
    while (expected.size() < 5 * ByteSink::kSize) {
      std::string piece(next() >> 12 & 0xffff, char(next() >> 24));
      if (next() >> 28 == 0) piece.resize(ByteSink::kSize + 1 + (next() >> 16), 'x');
      expected += piece;
      if (next() >> 31) {
        sink.text(piece);
      } else if (piece.size() <= ByteSink::kSize) {
        std::memcpy(sink.room(piece.size()), piece.data(), piece.size());
      } else {
        sink.text(piece);
      }
      sink.little(state);
      expected.append(reinterpret_cast<const char*>(&state), sizeof state);
    }
    sink.flush();
    EXPECT_EQ(file.bytes(), expected.size());
    sink.text("end");
    expected += "end";
    sink.flush();
    file.commit();
  }
  EXPECT_TRUE(slurp(folder / "a.bin") == expected);
}

TEST(ByteSink, WhatTheWritingThreadMeetsIsThrownToTheCaller) {
  rlimit old{};
  ::getrlimit(RLIMIT_FSIZE, &old);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{ByteSink::kSize + 1000, old.rlim_max};
  const samples::Folder folder;
  {
    AtomicFile file(folder / "a.bin");
    ByteSink sink(file);
    ::setrlimit(RLIMIT_FSIZE, &tight);
    const std::string piece(100000, 'x');
    EXPECT_THROW(
        {
          for (int i = 0; i < 100; ++i) sink.text(piece);
        },
        Error);
    EXPECT_THROW(sink.flush(), Error) << "it stays failed";
    ::setrlimit(RLIMIT_FSIZE, &old);
  }
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(ByteSink, IsLeftWithoutFlush) {
  const samples::Folder folder;
  {
    AtomicFile file(folder / "a.bin");
    ByteSink sink(file);
    sink.text(std::string(3 * ByteSink::kSize / 4, 'x'));
    sink.text(std::string(3 * ByteSink::kSize / 4, 'x'));
  }
  EXPECT_EQ(folder.entries(), 0u);
}

}  // namespace
}  // namespace argil::io
