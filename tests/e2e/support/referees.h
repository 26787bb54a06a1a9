#pragma once
// Other programs, asked what they make of our files.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/e2e/support/command.h"

namespace argil::tests {

/// Whether there is such a program; if not it is said that it was not asked.
inline bool installed(const std::string& program) {
  const bool is = std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
  if (!is) std::printf("%s is not installed: not asked\n", program.c_str());
  return is;
}

/// What a command prints, run in that folder; a failure where it ends with anything but 0.
inline std::string outputOf(const std::string& command, const fs::path& scratch) {
  const fs::path out = scratch / "said.txt";
  const int code = std::system(("cd " + scratch.string() + " && " + command + " >" + out.string() + " 2>&1").c_str());
  EXPECT_EQ(code, 0) << command << "\n" << slurp(out);
  return slurp(out);
}

}  // namespace argil::tests
