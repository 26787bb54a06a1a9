// argil bench stability: how stiff a wall may be before device and hand shake, in virtual time, beside what theory
// says.

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <mutex>
#include <span>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/bench.h"
#include "bench/svg_chart.h"
#include "haptics/analysis/stability_bench.h"
#include "haptics/devices/sheets.h"
#include "io/bytes/atomic_file.h"

namespace argil::bench {

namespace {

constexpr std::array kRates = {1000.0, 2000.0, 4000.0};
// Of the sheet's top damping; the second is what couplings have.
constexpr std::array kDampings = {0.0, 0.2, 0.5, 1.0};
constexpr size_t kCoupled = 1;
constexpr std::array kAllRates = {125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0};
constexpr std::array kDelaysMs = {0.0, 1.0, 2.0, 3.0, 5.0};
constexpr size_t kHands = 3, kTasks = std::size(haptics::kStabilityTasks);
constexpr uint64_t kContacts = 2000;  // Of each device.

/// The same device, exchanging as often as the servo turns.
haptics::DeviceSheet atRate(haptics::DeviceSheet sheet, double rateHz) {
  sheet.rateHz = rateHz;
  return sheet;
}

/// Every combination, in one array.
class Map {
 public:
  explicit Map(std::span<const haptics::DeviceSheet> sheets)
      : sheets_(sheets), limits_(sheets.size() * kRates.size() * kHands * kTasks * kDampings.size() * 2) {}

  [[nodiscard]] size_t size() const { return limits_.size(); }
  [[nodiscard]] double at(size_t device, size_t rate, size_t hand, size_t task, size_t damping, bool controlled) const {
    return limits_[((((device * kRates.size() + rate) * kHands + hand) * kTasks + task) * kDampings.size() + damping) *
                       2 +
                   (controlled ? 1 : 0)];
  }
  /// The least of grasping, tapping and clay that grows.
  [[nodiscard]] double held(size_t device, size_t rate, size_t hand, size_t damping, bool controlled) const {
    double least = 1e9;
    for (size_t task = 0; task < kTasks; ++task)
      if (haptics::kStabilityTasks[task] != haptics::StabilityTask::glide)
        least = std::min(least, at(device, rate, hand, task, damping, controlled));
    return least;
  }
  [[nodiscard]] double gliding(size_t device, size_t rate, size_t hand, size_t damping, bool controlled) const {
    return at(device, rate, hand, static_cast<size_t>(haptics::StabilityTask::glide), damping, controlled);
  }

  /// Fills it on all cores.
  void measure(Job* job) {
    std::atomic<size_t> next{0};
    std::exception_ptr failed;
    std::mutex mutex;
    const auto work = [&] {
      try {
        for (size_t i = next++; i < limits_.size(); i = next++) {
          if (job) job->step(static_cast<double>(i) / static_cast<double>(limits_.size()));
          // The slow ones, at high rates, first.
          const size_t index = limits_.size() - 1 - i;
          limits_[index] = haptics::largestQuietStiffness(caseOf(index));
        }
      } catch (...) {
        next = limits_.size();
        const std::scoped_lock lock(mutex);
        failed = std::current_exception();
      }
    };
    std::vector<std::thread> threads;
    for (unsigned t = 1; t < std::thread::hardware_concurrency(); ++t) threads.emplace_back(work);
    work();
    for (std::thread& t : threads) t.join();
    if (failed) std::rethrow_exception(failed);
  }

 private:
  [[nodiscard]] haptics::StabilityCase caseOf(size_t index) const {
    haptics::StabilityCase c;
    c.controlled = index % 2 == 1;
    index /= 2;
    const double damping = kDampings[index % kDampings.size()];
    index /= kDampings.size();
    c.task = haptics::kStabilityTasks[index % kTasks];
    index /= kTasks;
    c.hand = haptics::stabilityHands()[index % kHands].model;
    index /= kHands;
    c.rateHz = kRates[index % kRates.size()];
    c.sheet = atRate(sheets_[index / kRates.size()], c.rateHz);
    c.coupling.dampingNsmm = damping * c.sheet.topDampingNsmm;
    return c;
  }

  std::span<const haptics::DeviceSheet> sheets_;
  std::vector<double> limits_;
};

void keep(BenchReport& report, std::string name, const char* unit, double value, uint64_t n = 1) {
  BenchResult r;
  r.name = std::move(name);
  r.unit = unit;
  r.median = value;
  r.n = n;
  report.keep(std::move(r));
}

void table(BenchReport& report, const Map& map, std::span<const haptics::DeviceSheet> sheets) {
  fmt::print("  N/mm, without → with passivity control; damping without: none, with: that of the coupling\n");
  for (size_t d = 0; d < sheets.size(); ++d)
    for (size_t r = 0; r < kRates.size(); ++r) {
      const haptics::DeviceSheet sheet = atRate(sheets[d], kRates[r]);
      const haptics::CouplingBounds bounds = haptics::couplingBounds(sheet, 1 / kRates[r]);
      const haptics::Coupling coupling = haptics::coupleTo(sheet, 1 / kRates[r]);
      const std::string base = fmt::format("stability/{}/{:g}kHz/", sheets[d].name, kRates[r] / 1000);
      fmt::print("  {:<10} {:g} kHz: 2b/T {:.2f}, 2c/Δ {:.2f}, sheet's top {:.2f}, coupled at {:.2f}\n", sheets[d].name,
                 kRates[r] / 1000, bounds.colgateBrownNmm, bounds.quantizationNmm, sheets[d].topStiffnessNmm,
                 coupling.stiffnessNmm);
      keep(report, base + "colgate-brown", "N/mm", bounds.colgateBrownNmm);
      keep(report, base + "quantization", "N/mm", bounds.quantizationNmm);
      keep(report, base + "coupling", "N/mm", coupling.stiffnessNmm);
      for (size_t h = 0; h < kHands; ++h) {
        std::string line = fmt::format("    {:<6}", haptics::stabilityHands()[h].name);
        for (size_t t = 0; t < kTasks; ++t) {
          line += fmt::format("  {} {:6.2f} → {:6.2f}", haptics::name(haptics::kStabilityTasks[t]),
                              map.at(d, r, h, t, 0, false), map.at(d, r, h, t, kCoupled, true));
          for (size_t b = 0; b < kDampings.size(); ++b)
            for (const bool controlled : {false, true})
              keep(report,
                   fmt::format("{}{}/{}/B{:g}/{}", base, haptics::stabilityHands()[h].name,
                               haptics::name(haptics::kStabilityTasks[t]), kDampings[b],
                               controlled ? "controlled" : "bare"),
                   "N/mm", map.at(d, r, h, t, b, controlled));
        }
        fmt::print("{}\n", line);
      }
    }
}

ChartSeries series(std::string name, int colour, ChartSeries::Line line, ChartSeries::Mark mark) {
  ChartSeries s;
  s.name = std::move(name);
  s.colour = colour;
  s.line = line;
  s.mark = mark;
  return s;
}

Chart figure(const Map& map, std::span<const haptics::DeviceSheet> sheets) {
  using Line = ChartSeries::Line;
  using Mark = ChartSeries::Mark;
  Chart chart;
  chart.title = "Largest stiffness at which device and hand stay quiet";
  chart.columns = static_cast<int>(sheets.size());
  chart.panelWidth = 300;
  chart.panelHeight = 260;
  const auto panelOf = [&](size_t d, const std::string& title, ChartAxis x, auto&& bare, auto&& controlled,
                           auto&& rateOf, size_t points, auto&& place) {
    ChartPanel panel;
    panel.title = title;
    panel.x = std::move(x);
    panel.y = {d == 0 ? "stiffness, N/mm" : "", true, 0.5, 250.0, {}};
    ChartSeries cb = series("2b/T (Colgate, Brown)", 0, Line::dashed, Mark::none),
                quant = series("2c/Δ (Diolaiti)", 0, Line::dotted, Mark::none);
    ChartSeries coupled = series("what Argil couples at", 3, Line::solid, Mark::triangle);
    ChartSeries bareHeld = series("held, without control", 2, Line::dashed, Mark::dot),
                heldLine = series("held, with passivity control", 2, Line::solid, Mark::dot);
    ChartSeries bareGlide = series("gliding, without control", 1, Line::dashed, Mark::square);
    ChartSeries glide = series("gliding, with passivity control", 1, Line::solid, Mark::square);
    for (size_t i = 0; i < points; ++i) {
      const double at = place(i), period = 1 / rateOf(i);
      const haptics::DeviceSheet sheet = atRate(sheets[d], rateOf(i));
      const haptics::CouplingBounds bounds = haptics::couplingBounds(sheet, period);
      cb.points.push_back({at, bounds.colgateBrownNmm});
      quant.points.push_back({at, bounds.quantizationNmm});
      coupled.points.push_back({at, haptics::coupleTo(sheet, period).stiffnessNmm});
      bareHeld.points.push_back({at, bare(i, true)});
      bareGlide.points.push_back({at, bare(i, false)});
      heldLine.points.push_back({at, controlled(i, true)});
      glide.points.push_back({at, controlled(i, false)});
    }
    panel.series = {cb, quant, bareGlide, glide, bareHeld, heldLine, coupled};
    chart.panels.push_back(std::move(panel));
  };
  const auto one = [&](size_t d, size_t r, size_t h, size_t b, bool controlled, bool held) {
    return held ? map.held(d, r, h, b, controlled) : map.gliding(d, r, h, b, controlled);
  };
  for (size_t h = 0; h < kHands; ++h)
    for (size_t d = 0; d < sheets.size(); ++d) {
      ChartAxis x{"rate, kHz", false, {}, {}, {"1", "2", "4"}};
      panelOf(
          d, fmt::format("{}, hand: {}", sheets[d].name, haptics::stabilityHands()[h].name), x,
          [&](size_t i, bool held) { return one(d, i, h, 0, false, held); },
          [&](size_t i, bool held) { return one(d, i, h, kCoupled, true, held); }, [](size_t i) { return kRates[i]; },
          kRates.size(), [](size_t i) { return static_cast<double>(i); });
    }
  for (size_t d = 0; d < sheets.size(); ++d) {
    ChartAxis x{"damping, parts of the sheet's top", false, -0.05, 1.05, {}};
    panelOf(
        d, fmt::format("{}, 1 kHz, light hand", sheets[d].name), x,
        [&](size_t i, bool held) { return one(d, 0, 1, i, false, held); },
        [&](size_t i, bool held) { return one(d, 0, 1, i, true, held); }, [](size_t) { return kRates[0]; },
        kDampings.size(), [](size_t i) { return kDampings[i]; });
  }
  chart.caption = {
      "Quiet: over the last 0.4 s of a task the tool swings by no more than 10 µm across the clay and the force "
      "changes by no more than 1 % of the peak in a tick (gliding: and one encoder step's worth).",
      "Held: the least of grasping, tapping three times, and 1 mm of clay growing under the tool, pressed midway "
      "between two encoder steps. Gliding: 20 mm/s along flat clay. Real servo tick, virtual time.",
      "Upper three rows: without control no damping, with control that of the coupling. Made by: argil bench stability "
      "--figure FILE"};
  return chart;
}

// Delays and rates: at what it is coupled, and in how many cases (tasks and hands) that is stable. `threaded`: through
// the device's thread, servo at 1 kHz, which measures the delay by itself; a delay is then how long an exchange takes.
void delays(BenchReport& report, std::span<const haptics::DeviceSheet> sheets, bool threaded, Job* job) {
  report.heading(
      threaded ? "stability through the device's thread: exchanges of 0 to 5 ms, at 125 to 8000 Hz, servo at 1 kHz"
               : "stability at the coupling: delays of 0 to 5 ms, at 125 to 8000 Hz");
  fmt::print("  N/mm (stable of all cases), for {} ms\n", fmt::join(kDelaysMs, ", "));
  for (const haptics::DeviceSheet& sheet : sheets)
    for (const double rate : kAllRates) {
      std::string line = fmt::format("  {:<10} {:>5.0f} Hz", sheet.name, rate);
      for (const double delayMs : kDelaysMs) {
        if (job) job->step(0);
        int stable = 0, all = 0;
        double stiffness = 0;
        for (const haptics::StabilityTask task : haptics::kStabilityTasks)
          for (const haptics::StabilityHand& hand : haptics::stabilityHands()) {
            if (task == haptics::StabilityTask::glide && !(hand.model.stiffnessNmm > 0)) continue;
            haptics::StabilityCase c;
            c.sheet = atRate(sheet, rate);
            c.hand = hand.model;
            c.task = task;
            c.delayS = delayMs * 1e-3;
            if (threaded) {
              c.exchangesHz = rate;
            } else {
              c.rateHz = rate;
              c.coupling = haptics::coupleTo(c.sheet, 1 / rate, c.delayS);
            }
            const haptics::StabilityFigures f = haptics::runStability(c);
            stable += f.stable();
            ++all;
            stiffness = std::max(stiffness, f.stiffnessNmm);
          }
        line += fmt::format("  {:5.2f} ({:2}/{})", stiffness, stable, all);
        const std::string name =
            fmt::format("stability/{}/{:g}Hz/{:g}ms/{}", sheet.name, rate, delayMs, threaded ? "threaded" : "direct");
        keep(report, name + "/coupling", "N/mm", stiffness);
        keep(report, name + "/stable", "cases", stable, static_cast<uint64_t>(all));
      }
      fmt::print("{}\n", line);
    }
}

void energies(BenchReport& report, std::span<const haptics::DeviceSheet> sheets) {
  report.heading(fmt::format("stability: {} taps of each device in a light hand, at its coupling, 1 kHz", kContacts));
  double given = 0, work = 0;
  for (const haptics::DeviceSheet& sheet : sheets) {
    haptics::StabilityCase c;
    c.sheet = sheet;
    c.hand = haptics::stabilityHands()[1].model;
    c.coupling = haptics::coupleTo(sheet, 1e-3);
    const haptics::ContactEnergy on = haptics::energyOfContacts(c, kContacts);
    c.controlled = false;
    c.coupling.dampingNsmm = 0;
    const haptics::ContactEnergy off = haptics::energyOfContacts(c, kContacts);
    fmt::print(
        "  {:<10} work of the motor {:9.1f} mJ, worst of one tap {:7.4f} mJ, given to the hand {:.4f} mJ; without "
        "control {:9.1f}, {:7.4f}, {:.4f} mJ\n",
        sheet.name, on.workNmm, on.worstNmm, on.givenNmm, off.workNmm, off.worstNmm, off.givenNmm);
    keep(report, fmt::format("stability/{}/energy-of-contacts", sheet.name), "mJ", on.workNmm, on.contacts);
    keep(report, fmt::format("stability/{}/energy-given-to-the-hand", sheet.name), "mJ", on.givenNmm, on.contacts);
    given += on.givenNmm;
    work += on.workNmm;
  }
  fmt::print("  {:<10} work of the motor {:9.1f} mJ, given to the hand {:.4f} mJ in {} taps\n", "all", work, given,
             kContacts * sheets.size());
}

}  // namespace

void benchStability(BenchReport& report, const BenchOptions& options) {
  const std::span<const haptics::DeviceSheet> sheets = haptics::deviceSheets();
  Map map(sheets);
  report.heading(fmt::format("stability: largest quiet stiffness of {} combinations", map.size()));
  const Stopwatch watch;
  map.measure(options.job);
  table(report, map, sheets);
  fmt::print("  {:.0f} s\n", watch.us() * 1e-6);
  energies(report, sheets);
  delays(report, sheets, false, options.job);
  delays(report, sheets, true, options.job);
  if (options.figure.empty()) return;
  const std::string svg = figure(map, sheets).svg();
  io::AtomicFile out(options.figure);
  out.write(std::as_bytes(std::span(svg)));
  out.commit();
}

}  // namespace argil::bench
