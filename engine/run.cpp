#include "engine/run.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/hand_run.h"
#include "engine/lay.h"
#include "haptics/clock.h"

namespace argil::engine {

Timing Timing::of(const haptics::Histogram& h) {
  if (h.count() == 0) return {};
  return {h.count(), h.quantileUs(0.5), h.quantileUs(0.99), h.quantileUs(0.999), h.maxUs()};
}

namespace {

void runTip(Session& session, clay::Surface& surface, const ScriptStroke& stroke, const RunOptions& options,
            haptics::Histogram& latency, RunReport& report) {
  const auto show = [&](const clay::Version& version, int64_t since) {
    const clay::SurfaceDelta delta = surface.update(version, options.surfaceThreads);
    if (options.onSurface) options.onSurface(delta);
    latency.add(haptics::nowNs() - since);
    ++report.versions;
  };
  session.beginStroke(stroke.tool, stroke.images);
  int64_t since = haptics::nowNs();
  size_t waiting = 0;
  for (const PathPoint& point : stroke.path) {
    if (waiting == 0) since = haptics::nowNs();
    session.addPoint(point);
    if (++waiting < options.pointsPerVersion) continue;
    if (options.job && options.job->cancelled()) throw Cancelled();
    show(session.publish(), since);
    waiting = 0;
  }
  if (waiting == 0) since = haptics::nowNs();
  show(session.endStroke(), since);
}

// The hand plans its whole walk at once, on the clay as it is when it sets out.
struct HandStrokes {
  std::vector<LaidStroke> laid;
  std::vector<size_t> parts;  // how many of these each script stroke became

  HandStrokes(const clay::Version& version, std::span<const ScriptStroke> strokes) {
    for (const ScriptStroke& stroke : strokes) {
      if (stroke.drive != Drive::hand) continue;
      const std::vector<LaidStroke> some = lay(version, stroke);
      laid.insert(laid.end(), some.begin(), some.end());
      parts.push_back(some.size());
    }
  }
};

// However a run is left, no stroke stays open.
struct EndStroke {
  Session& session;
  ~EndStroke() {
    if (session.inStroke()) session.endStroke();
  }
};

}  // namespace

RunReport runScript(Session& session, clay::Surface& surface, const Script& script, const RunOptions& options) {
  RunReport report;
  const EndStroke endStroke{session};
  const Session::Counts before = session.counts();
  const int64_t begin = haptics::nowNs();
  const DocumentPtr first = session.document();
  if (const Piece* piece = first->workedOn(); piece && !(piece->material == script.material)) {
    session.change("Material", [&, id = piece->id](Document& document) { document.piece(id)->material = script.material; });
  }
  surface.update(session.version(), options.surfaceThreads);
  const auto latency = std::make_unique<haptics::Histogram>();
  std::optional<HandStrokes> handStrokes;
  std::optional<HandRun> hand;  // one servo and one simulated hand for all of the script
  size_t handDone = 0;
  const auto& strokes = script.strokes;
  const auto fraction = [&](size_t done) { return double(done) / double(strokes.size()); };
  for (size_t i = 0; i < strokes.size();) {
    if (options.job) options.job->step(fraction(i));
    if (strokes[i].drive == Drive::tip) {
      for (const LaidStroke& laid : lay(session.version(), strokes[i])) {
        runTip(session, surface, laid.stroke, options, *latency, report);
      }
      ++i;
      continue;
    }
    if (!hand) {
      handStrokes.emplace(session.version(), std::span(strokes).subspan(i));
      hand.emplace(session, surface, handStrokes->laid, script, options, *latency);
    }
    size_t last = i, parts = 0;
    for (; last < strokes.size() && strokes[last].drive == Drive::hand; ++last) parts += handStrokes->parts[handDone++];
    if (parts > 0) hand->walk(parts, fraction(i), fraction(last));
    i = last;
  }
  if (options.job) options.job->step(1);
  if (hand) {
    report.servo = hand->report();
    report.versions += hand->versions();
  }
  const Session::Counts& after = session.counts();
  report.strokes = after.strokes - before.strokes;
  report.points = after.points - before.points;
  report.stamps = after.stamps - before.stamps;
  report.clay.bricksMade = after.clay.bricksMade - before.clay.bricksMade;
  report.clay.nodesMade = after.clay.nodesMade - before.clay.nodesMade;
  report.edit = Timing::of(*latency);
  report.seconds = double(haptics::nowNs() - begin) * 1e-9;
  return report;
}

}  // namespace argil::engine
