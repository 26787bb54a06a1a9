#pragma once
// What benchmarks share: a result, how it is printed, how it is kept.

#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/job.h"

namespace argil::bench {

/// A figure. Keys that do not apply stay empty and are left out of the JSON.
struct BenchResult {
  std::string name;  ///< A path, such as edit/ball20/48M.
  std::string unit = "us";
  double median = 0;
  std::optional<double> p99, p999;
  uint64_t n = 0;
  int threads = 1;
  std::optional<double> peer;  ///< The same work by the named library in the same run, in `unit`.
  std::string peerName;
  std::optional<double> ratio;  ///< peer / median.
  /// memory: bytes at the peak, beside what was there before.
  std::optional<uint64_t> bricks, chunks, triangles, bytes, memory, hash;
  std::string note;  ///< For the reader of the table; not in the JSON.
};

/// Microseconds of many runs.
class Samples {
 public:
  void add(double us) { us_.push_back(us); }
  [[nodiscard]] uint64_t count() const { return us_.size(); }
  [[nodiscard]] double quantile(double q) const;
  [[nodiscard]] double median() const { return quantile(0.5); }
  [[nodiscard]] double mean() const;
  /// A result with n, median and, where there are enough of them, p99 and p999.
  [[nodiscard]] BenchResult result(std::string name) const;

 private:
  mutable std::vector<double> us_;
};

/// Microseconds since it was made, by the steady clock.
class Stopwatch {
 public:
  [[nodiscard]] double us() const {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Microseconds of the processor, of all threads together, since it was made: other programs beside it count little.
class CoreStopwatch {
 public:
  [[nodiscard]] double us() const { return now() - start_; }

 private:
  static double now() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
  }
  double start_ = now();
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
  std::vector<std::string> names;  ///< As benchNames() lists them; empty: those that run by default.
  std::filesystem::path json;
  bool overwrite = false;        ///< Files that exist already may be replaced.
  std::filesystem::path figure;  ///< SVG, of the one benchmark that draws: buzz or stability.
  double largest = 48;           ///< Million active voxels of the largest model.
  double seconds = 60;           ///< Of the paced servo.
  std::filesystem::path from;    ///< tradeoff, pairs: what was measured before.
  std::filesystem::path folder;  ///< Where files are written; empty: the folder of temporary files.
  double longestS = 60;          ///< day: of the hand, in one stroke; 1 to 600.
  int threads = 0;               ///< day: of strokes; 0: as many as a session takes.
  double cellSeconds = 20;       ///< day, edit-tools: a stroke that has taken so much work is cut off.
  std::vector<double> tips;      ///< day, edit-tools: radii, voxels; empty: their own.
  double hours = 4;              ///< day: simulated.
  int sculpts = 200;             ///< cad: random ones.
  std::vector<std::string>
      tools;  ///< day, edit-tools: ids of the tools that are measured; empty: all that need no file.
  Job* job = nullptr;
};

/// Names of all benchmarks, "edit, surface, ...", in the order in which they run.
[[nodiscard]] std::string benchNames();

/// Runs those that are named, prints a table, writes what was asked for. Throws Error: a name or a value out of range.
void runBenchmarks(const BenchOptions& options);

void benchEdit(BenchReport& report, const BenchOptions& options);
void benchEditTools(BenchReport& report, const BenchOptions& options);
void benchSurface(BenchReport& report, const BenchOptions& options);
void benchFine(BenchReport& report, const BenchOptions& options);
void benchFineError(BenchReport& report, const BenchOptions& options);  ///< The second half of fine.
void benchTouch(BenchReport& report, const BenchOptions& options);
void benchRender(BenchReport& report, const BenchOptions& options);
void benchSave(BenchReport& report, const BenchOptions& options);
void benchUndo(BenchReport& report, const BenchOptions& options);
void benchUndoPicture(BenchReport& report, const BenchOptions& options);  ///< The first half of undo.
void benchIo(BenchReport& report, const BenchOptions& options);
void benchWhole(BenchReport& report, const BenchOptions& options);
void benchDay(BenchReport& report, const BenchOptions& options);  ///< All four parts of a day's work.
void benchBuzz(BenchReport& report, const BenchOptions& options);
void benchStability(BenchReport& report, const BenchOptions& options);
void benchExtremes(BenchReport& report, const BenchOptions& options);
void benchPairs(BenchReport& report, const BenchOptions& options);
void benchCosts(BenchReport& report, const BenchOptions& options);
void benchPlugins(BenchReport& report, const BenchOptions& options);
void benchPrint(BenchReport& report, const BenchOptions& options);
void benchCad(BenchReport& report, const BenchOptions& options);
/// The same without smooth faces.
void benchCadQuads(BenchReport& report, const BenchOptions& options);
void benchLooks(BenchReport& report, const BenchOptions& options);
void benchTradeoff(BenchReport& report, const BenchOptions& options);

}  // namespace argil::bench
