// The clay that an offset inwards leaves, while it is asked about: worked out beside the studio whenever something
// changed.

#include <algorithm>
#include <exception>
#include <thread>

#include "clay/base/error.h"
#include "clay/surface/surface.h"
#include "clay/whole/offset.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

constexpr int kMostThreads = 64;  // clay::Surface takes no more.

void stop(Memory& memory) {
  if (!memory.offset.job) return;
  memory.offset.job->job().cancel();
  memory.ending.push_back(std::move(memory.offset.job));
}

void begin(OffsetPreview& preview, clay::Grade grade) {
  preview.result = std::make_shared<OffsetPreview::Result>();
  preview.job = std::make_unique<engine::BackgroundJob>(
      [result = preview.result, version = preview.of, mm = preview.mm, grade](Job& job) {
        try {
          const clay::Version left = clay::offset(version, mm, 0, &job);
          clay::Surface surface(false, grade);
          surface.update(left, std::clamp(int(std::thread::hardware_concurrency()), 1, kMostThreads));
          if (!job.cancelled()) result->shape = std::make_shared<const clay::TriangleMesh>(surface.toMesh());
        } catch (const Cancelled&) {
          throw;
        } catch (const std::exception& error) {
          result->problem = error.what();
        }
      });
}

}  // namespace

std::string followOffset(Context& context, Memory& memory, const engine::Piece* piece) {
  const Operation& operation = memory.operation;
  const double mm = operation.row && operation.row->growsMm && operation.arguments.pieces.size() == 1
                        ? operation.row->growsMm(operation.arguments)
                        : 0;
  OffsetPreview& preview = memory.offset;
  if (!(mm < 0) || !piece || !piece->version) {
    stop(memory);
    preview = {};
    return {};
  }
  if (preview.of != piece->version || preview.mm != mm) {
    stop(memory);
    if (preview.of != piece->version) preview.shape.reset();
    preview.of = piece->version;
    preview.mm = mm;
    begin(preview, context.state.surface);
  }
  if (preview.job && !preview.job->done()) {
    memory.moves = true;  // Until it is there.
    kit::dimText("Working out what is left…");
    return {};
  }
  preview.job.reset();
  preview.shape = preview.result->shape;
  if (preview.shape) kit::dimText("The picture shows what is left.");  // As high as the line before.
  return preview.result->problem;
}

}  // namespace argil::studio
