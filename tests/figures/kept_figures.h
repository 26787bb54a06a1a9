#pragma once
// Figures that were looked at once and kept: any change of what the program makes, beyond rounding, shows.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace argil::tests {

/// A text file in tests/figures, a line for each case: its name and its figures. Properties say what must hold; figures
/// say that what holds is still the same, to 2e-6 of what they measure (mathematical functions of other machines
/// round otherwise). A change that is meant: run the tests with ARGIL_KEEP_FIGURES=1, which writes the file anew, and
/// look at its difference.
class KeptFigures {
 public:
  explicit KeptFigures(std::filesystem::path file)
      : file_(std::move(file)), writes_(std::getenv("ARGIL_KEEP_FIGURES")) {
    std::ifstream in(file_);
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      std::string name;
      words >> name;
      for (double figure; words >> figure;) kept_[name].push_back(figure);
    }
    EXPECT_TRUE(writes_ || !kept_.empty()) << file_ << " cannot be read";
  }
  ~KeptFigures() {
    if (!writes_) {
      for (const auto& [name, figures] : kept_) EXPECT_TRUE(now_.count(name)) << name << " is kept, but nobody asked";
      return;
    }
    std::ofstream out(file_);
    for (const auto& [name, figures] : now_) {
      out << name;
      for (const double figure : figures) {
        char text[32];
        (void)std::snprintf(text, sizeof(text), " %.7g", figure);
        out << text;
      }
      out << '\n';
    }
  }
  KeptFigures(const KeptFigures&) = delete;
  KeptFigures& operator=(const KeptFigures&) = delete;

  /// `name` without blanks, once a file; `figures` of the order of one, or of their kept values where those are larger.
  void expect(const std::string& name, const std::vector<double>& figures) {
    EXPECT_TRUE(now_.emplace(name, figures).second) << name << " twice";
    if (writes_) return;
    const std::vector<double>& kept = kept_[name];
    ASSERT_EQ(figures.size(), kept.size()) << name << ": ARGIL_KEEP_FIGURES=1 keeps what it gives now";
    for (size_t i = 0; i < kept.size(); ++i) {
      EXPECT_TRUE(std::isfinite(figures[i])) << name;
      EXPECT_NEAR(figures[i], kept[i], 2e-6 * std::max(1.0, std::abs(kept[i]))) << name << ", figure " << i;
    }
  }

 private:
  std::filesystem::path file_;
  bool writes_;
  std::map<std::string, std::vector<double>> kept_, now_;
};

}  // namespace argil::tests
