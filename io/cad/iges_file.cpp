#include "io/cad/iges_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/work_part.h"

namespace argil::io {

namespace {

constexpr size_t kChunk = 1 << 20;
constexpr size_t kMostLines = 9'999'999;  // numbers of lines have seven digits
constexpr size_t kTextWidth = 72, kDataWidth = 64;
constexpr int kLast = clay::kPatchPoints - 1;  // index of a side's last control point

std::string ascii(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7f)
      out += c;
    else if (byte >= 0xc0)
      out += '_';  // the first byte of a letter; those that follow are left out
  }
  return out;
}

std::string hollerith(const std::string& text) {
  const std::string plain = ascii(text);
  return plain.empty() ? std::string() : fmt::format("{}H{}", plain.size(), plain);
}

// What the directory says of an entity.
struct Entry {
  int type = 0, form = 0;
  bool dependent = true;  // belongs to another, and is not shown by itself
  size_t colour = 0;      // of its directory entry; 0: none
};

// The parameters of all entities, as lines; the first time they are only counted, since the directory comes before them
// in the file and says where they are.
class Parameters {
 public:
  // `file`: null to count.
  explicit Parameters(AtomicFile* file) : file_(file) {}

  // Gives the number of the entity's directory entry: odd, from 1.
  size_t begin(const Entry& entry) {
    entries_.push_back({entry, lines_ + 1, 0});
    add(fmt::format("{}", entry.type));
    return 2 * entries_.size() - 1;
  }
  void add(const std::string& value) {
    if (!first_) line(",");
    first_ = false;
    line(value);
  }
  void add(size_t number) { add(fmt::format("{}", number)); }
  void add(double real) {
    number_.clear();
    appendReal(number_, real);
    add(number_);
  }
  void end() {
    line(";");
    flush();
    entries_.back().lines = lines_ + 1 - entries_.back().first;
    first_ = true;
  }
  [[nodiscard]] size_t lines() const { return lines_; }
  void write() {
    file_->write(std::as_bytes(std::span(made_)));
    made_.clear();
  }

  struct Listed {
    Entry entry;
    size_t first, lines;
  };
  [[nodiscard]] const std::vector<Listed>& entries() const { return entries_; }

 private:
  // A value is not parted, but for text that is longer than a line.
  void line(std::string_view part) {
    if (text_.size() + part.size() > kDataWidth && part != "," && part != ";") flush();
    if (text_.size() + part.size() > kDataWidth) {
      for (; text_.size() + part.size() > kDataWidth; flush()) {
        const size_t fits = kDataWidth - text_.size();
        text_ += part.substr(0, fits);
        part.remove_prefix(fits);
      }
    }
    text_ += part;
  }
  void flush() {
    if (text_.empty()) return;
    if (++lines_ > kMostLines) throw Error("IGES numbers no more than 9999999 lines: ask for fewer faces, or for STEP");
    if (file_)
      fmt::format_to(std::back_inserter(made_), "{:<64} {:>7}P{:>7}\n", text_, 2 * entries_.size() - 1, lines_);
    text_.clear();
    if (made_.size() >= kChunk) write();
  }

  AtomicFile* file_;
  std::string text_, number_, made_;
  std::vector<Listed> entries_;
  size_t lines_ = 0;
  bool first_ = true;
};

// 0 0 0 0 1 1 2 2 … n n n n.
void addKnots(Parameters& out) {
  for (int i = 0; i <= clay::kPatchSpans; ++i)
    for (int k = 0; k < (i == 0 || i == clay::kPatchSpans ? 4 : 2); ++k) out.add(double(i));
}

size_t writeCurve(Parameters& out, const std::vector<Vec3d>& points) {
  const size_t entry = out.begin({126});
  out.add(size_t{kLast});
  for (const size_t each : {3, 0, 0, 1, 0}) out.add(each);  // degree; not plane, not closed, polynomial, not periodic
  addKnots(out);
  for (size_t i = 0; i < points.size(); ++i) out.add(1.0);
  for (const Vec3d& p : points)
    for (int k = 0; k < 3; ++k) out.add(p[k]);
  out.add(0.0);
  out.add(double(clay::kPatchSpans));
  for (const double each : {0.0, 0.0, 0.0}) out.add(each);
  out.end();
  return entry;
}

size_t writeSurface(Parameters& out, const CadBody& body, const clay::PatchSurface::Patch& patch, size_t colour) {
  const size_t entry = out.begin({128, 0, true, colour});
  for (const size_t each : {kLast, kLast}) out.add(each);
  for (const size_t each : {3, 3, 0, 0, 1, 0, 0}) out.add(each);  // degrees; not closed, polynomial, not periodic
  addKnots(out);
  addKnots(out);
  for (int i = 0; i < clay::kPatchPoints * clay::kPatchPoints; ++i) out.add(1.0);
  for (size_t b = 0; b < clay::kPatchPoints; ++b)
    for (size_t a = 0; a < clay::kPatchPoints; ++a) {
      const Vec3d p = body.pose * body.surface->points[patch[a][b]];
      for (int k = 0; k < 3; ++k) out.add(p[k]);
    }
  for (int i = 0; i < 2; ++i) {
    out.add(0.0);
    out.add(double(clay::kPatchSpans));
  }
  out.end();
  return entry;
}

void writeBody(Parameters& out, const CadBody& body, const clay::WorkPart& part) {
  const clay::PatchSurface& surface = *body.surface;
  const clay::QuadTopology topology(surface.cage.positions.size(), surface.cage.quads);
  size_t colour = 0, name = 0;
  if (body.colour) {
    colour = out.begin({314, 0, false});
    for (const float each : *body.colour) out.add(100 * double(each));
    out.end();
  }
  if (const std::string text = hollerith(body.name); !text.empty()) {
    name = out.begin({406, 15});
    out.add(size_t{1});
    out.add(text);
    out.end();
  }
  const size_t vertices = out.begin({502, 1});
  out.add(topology.vertexCount());
  for (size_t v = 0; v < topology.vertexCount(); ++v) {
    const Vec3d p = body.pose * surface.points[v];
    for (int k = 0; k < 3; ++k) out.add(p[k]);
  }
  out.end();
  std::vector<size_t> curves;
  for (const clay::QuadTopology::Edge& edge : topology.edges()) {
    std::vector<Vec3d> along;
    for (int p = 0; p < clay::kPatchPoints; ++p) {
      const auto [i, j] = clay::fromCorner(edge.side[0], p, 0, clay::kPatchPoints);
      along.push_back(body.pose * surface.points[surface.patches[edge.quad[0]][size_t(i)][size_t(j)]]);
    }
    curves.push_back(writeCurve(out, along));
    part.step(0.3 * double(curves.size()) / double(topology.edges().size()));
  }
  const size_t edges = out.begin({504, 1});
  out.add(curves.size());
  for (size_t i = 0; i < curves.size(); ++i) {
    const clay::QuadTopology::Edge& edge = topology.edges()[i];
    for (const size_t each : {curves[i], vertices, size_t{edge.from} + 1, vertices, size_t{edge.to} + 1}) out.add(each);
  }
  out.end();
  std::vector<size_t> faces;
  for (uint32_t f = 0; f < surface.patches.size(); ++f) {
    const size_t spline = writeSurface(out, body, surface.patches[f], colour);
    const size_t loop = out.begin({508, 1});
    out.add(size_t{4});
    for (int s = 0; s < 4; ++s) {
      const uint32_t edge = topology.edgeOf(f, s);
      const bool forward = topology.edges()[edge].quad[0] == f && topology.edges()[edge].side[0] == s;
      for (const size_t each : {size_t{0}, edges, size_t{edge} + 1, size_t{forward}, size_t{0}}) out.add(each);
    }
    out.end();
    faces.push_back(out.begin({510, 1, true, colour}));
    for (const size_t each : {spline, size_t{1}, size_t{1}, loop}) out.add(each);
    out.end();
    part.step(0.3 + 0.7 * double(f + 1) / double(surface.patches.size()));
  }
  const auto shell = [&](const std::vector<uint32_t>& quads) {
    const size_t entry = out.begin({514, 1});
    out.add(quads.size());
    for (const uint32_t f : quads) {
      out.add(faces[f]);
      out.add(size_t{1});
    }
    out.end();
    return entry;
  };
  for (const CadSolid& solid : solidsOf(surface, topology)) {
    const size_t outer = shell(solid.outer);
    std::vector<size_t> cavities;
    for (const std::vector<uint32_t>& each : solid.cavities) cavities.push_back(shell(each));
    (void)out.begin({186, 0, false, colour});
    for (const size_t each : {outer, size_t{1}, cavities.size()}) out.add(each);
    for (const size_t each : cavities) {
      out.add(each);
      out.add(size_t{1});
    }
    if (name != 0)
      for (const size_t each : {size_t{0}, size_t{1}, name}) out.add(each);  // no associations, one property
    out.end();
  }
}

// Lines of 72 letters of a section that is plain text.
std::string linesOf(std::string_view text, char section, size_t& count) {
  std::string out;
  for (count = 0; !text.empty(); text.remove_prefix(std::min(kTextWidth, text.size())))
    fmt::format_to(std::back_inserter(out), "{:<72}{}{:>7}\n", text.substr(0, kTextWidth), section, ++count);
  return out;
}

}  // namespace

void writeIges(AtomicFile& file, const std::string& name, std::span<const CadBody> bodies, Job* job) {
  if (bodies.empty()) throw Error("there is nothing to write");
  double farthest = 0;
  for (const CadBody& body : bodies)
    for (const Vec3d& p : body.surface->points) farthest = std::max(farthest, (body.pose * p).cwiseAbs().maxCoeff());
  const auto all = [&](Parameters& out, double from, double to) {
    for (size_t i = 0; i < bodies.size(); ++i) {
      const double each = (to - from) / double(bodies.size());
      writeBody(out, bodies[i], clay::WorkPart(job, from + each * double(i), from + each * double(i + 1)));
    }
  };
  Parameters counted(nullptr);
  all(counted, 0, 0.4);

  std::string text;
  size_t starts = 0, globals = 0;
  text += linesOf("Smooth solids by Argil", 'S', starts);
  std::string largest;
  appendReal(largest, farthest);
  // Separators; names; integers of 32 bits, single and double precision; scale 1, unit 2 (mm), widths of lines; no
  // time, so that equal clay gives equal files; resolution, largest number; author; version 11 (5.3).
  const std::string title = hollerith(name);
  text += linesOf(
      fmt::format("1H,,1H;,{0},{0},5HArgil,5HArgil,32,38,6,308,15,{0},1.,2,2HMM,1,0.1,{2},1.E-7,{1},,,11,0,{2};", title,
                  largest, hollerith("19800101.000000")),
      'G', globals);
  size_t line = 0;
  for (const Parameters::Listed& each : counted.entries()) {
    const Entry& e = each.entry;
    fmt::format_to(std::back_inserter(text), "{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:0>8}D{:>7}\n", e.type,
                   each.first, 0, 0, 0, 0, 0, 0, e.dependent ? "00010000" : "00000000", line + 1);
    fmt::format_to(std::back_inserter(text), "{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}D{:>7}\n", e.type, 0,
                   e.colour == 0 ? "0" : fmt::format("-{}", e.colour), each.lines, e.form, "", "", "", 0, line + 2);
    line += 2;
  }
  file.write(std::as_bytes(std::span(text)));
  Parameters out(&file);
  all(out, 0.4, 1);
  out.write();
  text = fmt::format("{:<72}T{:>7}\n", fmt::format("S{:>7}G{:>7}D{:>7}P{:>7}", starts, globals, line, out.lines()), 1);
  file.write(std::as_bytes(std::span(text)));
}

}  // namespace argil::io
