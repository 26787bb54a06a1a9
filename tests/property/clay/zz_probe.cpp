#include <chrono>
#include <cstdio>
#include "clay/primitives.h"
#include "clay/store.h"
#include "tests/property/clay/brush_checks.h"
namespace argil::clay {
namespace {
using namespace testing;
double ms(std::chrono::steady_clock::time_point a) { return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - a).count(); }
TEST(Probe, Layer) {
  for (const double R : {40.0, 60.0})
    for (const float h : {-3.0f, 3.0f, 6.0f, 12.0f, 20.0f})
      for (const Falloff f : {Falloff::smooth, Falloff::constant}) {
        const Version base = makeSphere(Store::make(), Grid{}, Vec3d(0.11, 0.07, 0.05), R / 2);
        auto brush = std::make_shared<Brush>(*Brush::of(Method::raise, h < 0 ? -1.f : 1.f));
        brush->operations[0].shape = f;
        brush->height = std::abs(h);
        brush->limited = true;
        const auto stamps = arc(R, 0, 1.5, 20);
        BrushStroke stroke(base, brush);
        double worst = 0, total = 0;
        int n = 0;
        for (int t = 0; t < 2; ++t)
          for (const Stamp& s : stamps) {
            const auto at = std::chrono::steady_clock::now();
            stroke.apply(s);
            const double took = ms(at);
            worst = std::max(worst, took), total += took, ++n;
          }
        const uint64_t touched = stroke.touched();
        const Version after = stroke.finish();
        double top = -100, bottom = 100;
        double plateau = 0;
        int count = 0;
        for (const Vec3d& p : closedSurface(after)) {
          const double rise = (p - Vec3d(0.22, 0.14, 0.1)).norm() - R;
          top = std::max(top, rise);
          bottom = std::min(bottom, rise);
          const double angle = std::atan2(p.y(), p.x());
          if (angle > 0.2 && angle < 1.3 && std::abs(p.z()) < 4) plateau += (rise - h) * (rise - h), ++count;
        }
        const FieldErrors e = fieldErrors(after);
        std::printf("R %g h %g falloff %d: top %.4f bottom %.4f plateau rms %.4f  phi rms %.4f worst %.3f (%lu)  %.3f ms a stamp, worst %.2f, bricks %.0f\n", R, h, int(f), top, bottom,
                    std::sqrt(plateau / count), e.rms, e.worst, e.voxels, total / n, worst, double(touched) / n);
        const FieldErrors b = fieldErrors(base);
        if (h == -3 && f == Falloff::smooth) std::printf("   base rms %.4f worst %.3f\n", b.rms, b.worst);
      }
}
}  // namespace
}  // namespace argil::clay
