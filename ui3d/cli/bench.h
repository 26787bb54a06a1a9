#pragma once
// What benchmarks share: a result, how it is printed, how it is kept.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "clay/job.h"

namespace argil::cli {

/// A figure. Keys that do not apply stay empty and are left out of the JSON.
struct BenchResult {
  std::string name;         ///< A path, such as edit/ball20/48M.
  std::string unit = "us";
  double median = 0;
  std::optional<double> p99, p999;
  uint64_t n = 0;
  int threads = 1;
  std::optional<double> peer;   ///< The same work by the named library in the same run, in `unit`.
  std::string peerName;
  std::optional<double> ratio;  ///< peer / median.
  std::optional<uint64_t> bricks, chunks, triangles, bytes, memory, hash;  ///< memory: bytes at the peak, beside what was there before.
  std::string note;             ///< For the reader of the table; not in the JSON.
};

/// Microseconds of many runs.
class Samples {
 public:
  void add(double us) { us_.push_back(us); }
  [[nodiscard]] uint64_t count() const { return us_.size(); }
  [[nodiscard]] double quantile(double q) const;
  [[nodiscard]] double median() const { return quantile(0.5); }
  /// A result with n, median and, where there are enough of them, p99 and p999.
  [[nodiscard]] BenchResult result(std::string name) const;

 private:
  mutable std::vector<double> us_;
};

/// Microseconds since it was made, by the steady clock.
class Stopwatch {
 public:
  [[nodiscard]] double us() const { return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Prints each result as it comes and keeps them for the JSON.
class BenchReport {
 public:
  void add(BenchResult result);
  void keep(BenchResult result) { results_.push_back(std::move(result)); }  ///< For the JSON alone.
  void heading(const std::string& text) const;
  void write(const std::filesystem::path& file, const std::string& bench) const;

 private:
  std::vector<BenchResult> results_;
};

struct BenchOptions {
  std::vector<std::string> names;   ///< edit, surface, fine, touch, render, keep, undo, io, whole, buzz, stability; empty: all but the last.
  std::filesystem::path json;
  std::filesystem::path figure;     ///< SVG, of the one benchmark that draws: buzz or stability.
  double largest = 48;              ///< Million active voxels of the largest model.
  double seconds = 60;              ///< Of the paced servo.
  std::filesystem::path folder;     ///< Where io writes; empty: that of temporary files.
  Job* job = nullptr;
};

void benchEdit(BenchReport& report, const BenchOptions& options);
void benchSurface(BenchReport& report, const BenchOptions& options);
void benchFine(BenchReport& report, const BenchOptions& options);
void benchFineError(BenchReport& report, const BenchOptions& options);  ///< The second half of fine.
void benchTouch(BenchReport& report, const BenchOptions& options);
void benchRender(BenchReport& report, const BenchOptions& options);
void benchKeep(BenchReport& report, const BenchOptions& options);
void benchUndo(BenchReport& report, const BenchOptions& options);
void benchIo(BenchReport& report, const BenchOptions& options);
void benchWhole(BenchReport& report, const BenchOptions& options);
void benchBuzz(BenchReport& report, const BenchOptions& options);
void benchStability(BenchReport& report, const BenchOptions& options);

}  // namespace argil::cli
