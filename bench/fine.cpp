// argil bench fine: the fine surface beside the draft of the same clay: where creases are, and where there are none.

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/surface/surface.h"

namespace argil::bench {

void benchFine(BenchReport& report, const BenchOptions& options) {
  report.heading("fine: the whole surface with normals, on one thread; the peer is the draft of the same clay");
  for (const double size : benchSizes(options.largest))
    for (const bool cube : {false, true}) {
      const BenchModel model = cube ? benchCube(size) : benchSphere(size);
      const int runs = size < 5 ? 15 : 5;
      Samples draft, fine;
      uint64_t triangles = 0, hash = 0;
      for (int run = 0; run < runs; ++run) {
        if (options.job) options.job->step(0);
        for (const clay::Grade grade : {clay::Grade::draft, clay::Grade::fine}) {
          clay::Surface surface(true, grade);
          const Stopwatch watch;
          surface.update(model.version);
          (grade == clay::Grade::fine ? fine : draft).add(watch.us());
          triangles = 2 * surface.quadCount();
          if (grade == clay::Grade::fine && run == 0) hash = surface.hash();
        }
      }
      BenchResult r = fine.result(fmt::format("fine/{}/{}", cube ? "cube" : "sphere", model.name));
      r.peer = draft.median();
      r.peerName = "draft";
      r.triangles = triangles;
      r.hash = hash;
      report.add(r);
    }
  benchFineError(report, options);
}

}  // namespace argil::bench
