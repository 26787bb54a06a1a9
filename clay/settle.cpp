#include "clay/settle.h"

#include <algorithm>
#include <vector>

#include "clay/redistance.h"

namespace argil::clay {

void redistanceByRegion(Editor& editor, std::span<const Coord> bricks, Job* job, double jobFrom) {
  std::vector<Coord> byRegion(bricks.begin(), bricks.end());
  std::sort(byRegion.begin(), byRegion.end(), [](Coord a, Coord b) { return a >> 3 != b >> 3 ? a >> 3 < b >> 3 : a < b; });
  for (size_t begin = 0; begin < byRegion.size();) {
    size_t end = begin;
    while (end < byRegion.size() && byRegion[end] >> 3 == byRegion[begin] >> 3) ++end;
    redistance(editor, std::span(byRegion).subspan(begin, end - begin));
    begin = end;
    if (job) job->step(jobFrom + (1 - jobFrom) * double(end) / double(byRegion.size()));
  }
}

}  // namespace argil::clay
