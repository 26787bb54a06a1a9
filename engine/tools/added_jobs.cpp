#include "engine/tools/added_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "clay/base/error.h"

namespace argil::engine {

namespace {

// A parameter's functions know their number alone.
struct Access {
  double (*get)(const PieceArguments&);
  void (*set)(PieceArguments&, double);
};
template <size_t i>
constexpr Access accessOf() {
  return {[](const PieceArguments& a) { return a.get<AddedValues>().own[i]; },
          [](PieceArguments& a, double v) { a.change<AddedValues>().own[i] = v; }};
}
constexpr std::array<Access, 8> kAccess{accessOf<0>(), accessOf<1>(), accessOf<2>(), accessOf<3>(),
                                        accessOf<4>(), accessOf<5>(), accessOf<6>(), accessOf<7>()};

}  // namespace

struct AddedJobs::Kept {
  AddedJob job;
  std::vector<Parameter<PieceArguments>> parameters;
};

AddedJobs::AddedJobs() : rows_(new PieceJob[kMost]) {
  size_t count = 0;
  for (const auto part : {combineJobs(), shapeJobs(), printJobs(), placeJobs(), deformJobs(), maskJobs()})
    for (const PieceJob& row : part) rows_[count++] = row;
  count_ = count;
}

void AddedJobs::add(const AddedJob& job) {
  const std::lock_guard lock(mutex_);
  for (const PieceJob& each : all()) {
    if (each.id != job.id) continue;
    if (each.added && each.added->origin.checksum == job.origin.checksum) return;
    throw Error(fmt::format("there is another operation with the id \"{}\"", job.id));
  }
  const size_t at = count_.load(std::memory_order_relaxed);
  if (at == kMost) throw Error(fmt::format("more than {} operations", kMost));
  if (job.numbers.size() > kAccess.size())
    throw Error(fmt::format("{}: {} numbers: {} is the most", job.id, job.numbers.size(), kAccess.size()));
  auto kept = std::make_unique<Kept>(Kept{job, {}});
  for (size_t i = 0; i < kept->job.numbers.size(); ++i) {
    const AddedTool::Number& number = kept->job.numbers[i];
    Parameter<PieceArguments> row;
    row.id = number.id;
    row.name = number.name;
    row.help = number.help;
    row.unit = number.unit;
    row.low = number.low;
    row.high = number.high;
    row.standard = number.standard;
    row.logarithmic = number.logarithmic;
    row.get = kAccess[i].get;
    row.set = kAccess[i].set;
    kept->parameters.push_back(row);
  }
  PieceJob row;
  row.id = kept->job.id;
  row.name = kept->job.name;
  row.help = kept->job.help;
  row.doing = kept->job.doing;
  row.group = "Plugins";
  row.parameters = kept->parameters;
  row.added = &kept->job;
  kept_.push_back(std::move(kept));
  rows_[at] = row;
  count_.store(at + 1, std::memory_order_release);
}

AddedJobs& addedJobs() {
  static AddedJobs jobs;
  return jobs;
}

PieceResult runAdded(const AddedJob& added, const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = *document.piece(arguments.pieces[0]);
  std::vector<float> values;
  for (size_t i = 0; i < added.numbers.size(); ++i)
    values.push_back(static_cast<float>(arguments.get<AddedValues>().own[i]));
  PieceResult result;
  clay::Version version = added.run(piece.version, values, job);
  if (version == piece.version) return result;
  result.changed.push_back(piece);
  result.changed.back().version = std::move(version);
  return result;
}

}  // namespace argil::engine
