#include "engine/session/run.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "engine/session/hand_run.h"
#include "engine/text/lay.h"
#include "engine/tools/tool_table.h"
#include "haptics/base/clock.h"
#include "io/bytes/input.h"

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

// From the piece's millimetres to the world's, or back; bits stay where the piece is neither moved nor turned.
ScriptStroke moved(ScriptStroke stroke, const haptics::Pose& by) {
  if (by.translation == Vec3d::Zero() && by.rotation.coeffs() == Eigen::Quaterniond::Identity().coeffs()) return stroke;
  for (PathPoint& point : stroke.path) {
    point.mm = by.apply(point.mm);
    if (point.rotation) point.rotation = by.rotation * *point.rotation;
  }
  if (stroke.onto) stroke.onto->direction = by.rotation * stroke.onto->direction;
  return stroke;
}

haptics::Pose inverse(const haptics::Pose& pose) {
  return {pose.applyInverse(Vec3d::Zero()), pose.rotation.conjugate()};
}

std::vector<LaidStroke> layOn(const Piece& piece, const ScriptStroke& stroke) {
  return lay(piece.version, moved(stroke, inverse(piece.pose)));
}

// The hand plans its whole walk at once, on the clay as it is when it sets out. World mm.
struct HandStrokes {
  std::vector<LaidStroke> laid;
  std::vector<size_t> parts;  // how many of these each script stroke became

  HandStrokes(const Piece& piece, std::span<const ScriptStroke> strokes) {
    for (const ScriptStroke& stroke : strokes) {
      if (stroke.drive != Drive::hand) continue;
      std::vector<LaidStroke> some = layOn(piece, stroke);
      for (LaidStroke& each : some) {
        each.stroke = moved(std::move(each.stroke), piece.pose);
        if (each.from) each.from = piece.pose.apply(*each.from);
        if (each.to) each.to = piece.pose.apply(*each.to);
      }
      laid.insert(laid.end(), some.begin(), some.end());
      parts.push_back(some.size());
    }
  }
};

const Piece& pieceNamed(const Document& document, const std::string& name) {
  std::string known;
  for (const Piece& piece : document.pieces) {
    if (piece.name == name) return piece;
    known += (known.empty() ? "" : ", ") + piece.name;
  }
  throw Error(fmt::format("there is no piece {}; {}", io::shown(name),
                          known.empty() ? "there is none at all yet" : "there are " + known));
}

const Piece& pieceWorkedOn(const Document& document) {
  const Piece* piece = document.workedOn();
  if (!piece) throw Error("there is no piece to work on: make one first, visible and not locked");
  return *piece;
}

std::vector<std::string> operate(Session& session, const ScriptOperation& operation, Job* job) {
  const PieceJob* row = findPieceJob(operation.id);
  if (!row) throw Error(fmt::format("there is no operation {}", io::shown(operation.id)));
  const DocumentPtr before = session.document();
  PieceArguments arguments = operation.arguments;
  for (const std::string& name : operation.pieces) arguments.pieces.push_back(pieceNamed(*before, name).id);
  if (row->pieces == 1 && operation.pieces.empty()) arguments.pieces.push_back(pieceWorkedOn(*before).id);
  for (const Piece& piece : before->pieces) {
    if (piece.name == operation.name)
      throw Error(fmt::format("there is a piece {} already; name the new one otherwise", io::shown(operation.name)));
  }
  PieceResult result = runPieceJob(*row, *before, arguments, job);
  if (row->makesNew()) {
    for (Piece& piece : result.added) {
      if (!operation.name.empty()) piece.name = operation.name;
      piece.pose.translation = operation.centreMm;
      piece.pose.rotation = haptics::rotationBetween(Vec3d::UnitZ(), operation.axis);
    }
  }
  if (!result.changed.empty() || !result.added.empty() || !result.removed.empty())
    session.change(std::string(row->name), [&](Document& document) { applyPieceResult(result, *before, document); });
  return std::move(result.notes);
}

// What is wrong is told with the step's place in the script.
template <class Do>
void atStep(size_t step, const Do& what) {
  try {
    what();
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    throw Error(fmt::format("strokes[{}]: {}", step, error.what()), error.kind());
  }
}

// Keeps what was done: the session's strokes with the piece that each worked on, operations between them.
class Recorder {
 public:
  explicit Recorder(const Session& session) : session_(session), taken_(session.recording().strokes.size()) {}
  // Before another piece is worked on or its place changes, and at the end.
  void takeStrokes(Script& to) {
    const std::vector<ScriptStroke> all = session_.recording().strokes;
    const DocumentPtr document = session_.document();
    const Piece* piece = document->piece(document->active);
    for (; taken_ < all.size(); ++taken_) {
      to.strokes.push_back(piece ? moved(all[taken_], piece->pose) : all[taken_]);
      if (piece && document->pieces.size() > 1) to.strokes.back().piece = piece->name;
    }
  }

 private:
  const Session& session_;
  size_t taken_;
};

// However a run is left, no stroke stays open.
struct EndStroke {
  Session& session;
  ~EndStroke() {
    if (session.inStroke()) session.endStroke();
  }
};

}  // namespace

RunReport runScript(Session& session, clay::Surface& surface, const Script& script, const RunOptions& given) {
  RunOptions options = given;
  if (script.quality) options.rateHz = script.quality->servoHz;
  RunReport report;
  const EndStroke endStroke{session};
  session.record();
  const Session::Counts before = session.counts();
  const int64_t begin = haptics::nowNs();
  const DocumentPtr first = session.document();
  if (const Piece* piece = first->workedOn();
      piece && (!(script.material == haptics::Material()) || !script.materials.empty())) {
    session.change("Material", [&, id = piece->id](Document& document) {
      document.piece(id)->material = script.material;
      document.piece(id)->materials = script.materials;
    });
  }
  const auto follow = [&](bool tell) {
    const clay::Version version = session.version();
    if (!version) return;
    const clay::SurfaceDelta delta = surface.update(version, options.surfaceThreads);
    if (tell && options.onSurface) options.onSurface(delta);
  };
  follow(false);
  const auto latency = std::make_unique<haptics::Histogram>();
  Recorder recorder(session);
  std::optional<HandStrokes> handStrokes;
  // each with a servo and a simulated hand for all strokes up to the next operation or piece
  std::vector<std::unique_ptr<HandRun>> hands;
  size_t handEnd = 0, handDone = 0;  // strokes before handEnd are planned; so many of them are walked
  const auto& strokes = script.strokes;
  const auto& operations = script.operations;
  size_t operated = 0;
  // Strokes from `from` on that were done; nobody is to take them for work where the clay is as it was.
  const auto noteIdle = [&](size_t from, size_t to, size_t stepsBefore) {
    if (session.undoSteps() != stepsBefore) return;
    report.idle += to - from;
    const std::string which = to - from > 1 ? fmt::format("strokes[{}] to [{}]", from + operated, to - 1 + operated)
                                            : fmt::format("strokes[{}]", from + operated);
    report.notes.push_back(fmt::format("{}: {} changed nothing: it met no clay that it can change there.", which,
                                       rowOf(strokes[from].tool).name));
  };
  const auto fraction = [&](size_t done) {
    return double(done + operated) / double(strokes.size() + operations.size());
  };
  for (size_t i = 0;;) {
    const bool operatesHere = operated < operations.size() && (operations[operated].before <= i || i == strokes.size());
    if (!operatesHere && i == strokes.size()) break;
    if (options.job) options.job->step(fraction(i));
    if (operatesHere) {
      recorder.takeStrokes(report.recorded);
      atStep(i + operated, [&] {
        for (std::string& note : operate(session, operations[operated], options.job))
          report.notes.push_back(std::move(note));
      });
      report.recorded.operations.push_back(operations[operated]);
      report.recorded.operations.back().before = report.recorded.strokes.size();
      ++operated;
      follow(true);
      continue;
    }
    const DocumentPtr now = session.document();
    if (const std::string& name = strokes[i].piece; !name.empty()) {
      atStep(i + operated, [&] {
        const Id id = pieceNamed(*now, name).id;
        if (id == now->active) return;
        recorder.takeStrokes(report.recorded);
        session.change("Work on " + name, [&](Document& document) { document.active = id; });
        follow(true);
      });
    }
    if (strokes[i].drive == Drive::tip) {
      const size_t steps = session.undoSteps();
      atStep(i + operated, [&] {
        for (const LaidStroke& laid : layOn(pieceWorkedOn(*session.document()), strokes[i]))
          runTip(session, surface, laid.stroke, options, *latency, report);
      });
      noteIdle(i, i + 1, steps);
      ++i;
      continue;
    }
    const auto goesOn = [&](size_t stroke) {
      return stroke < strokes.size() && (operated == operations.size() || operations[operated].before > stroke) &&
             (strokes[stroke].piece.empty() || strokes[stroke].piece == strokes[i].piece);
    };
    atStep(i + operated, [&] {
      if (i >= handEnd) {
        for (handEnd = i + 1; goesOn(handEnd);) ++handEnd;
        handStrokes.emplace(pieceWorkedOn(*session.document()), std::span(strokes).subspan(i, handEnd - i));
        hands.push_back(std::make_unique<HandRun>(session, surface, handStrokes->laid, script, options, *latency));
        handDone = 0;
      }
      size_t last = i, parts = 0;
      for (; last < handEnd && strokes[last].drive == Drive::hand; ++last) parts += handStrokes->parts[handDone++];
      const size_t steps = session.undoSteps();
      if (parts > 0) hands.back()->walk(parts, fraction(i), fraction(last));
      noteIdle(i, last, steps);
      i = last;
    });
  }
  recorder.takeStrokes(report.recorded);
  if (options.job) options.job->step(1);
  if (!hands.empty()) report.servo = HandRun::report(hands);
  for (const auto& hand : hands) report.versions += hand->versions();
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
