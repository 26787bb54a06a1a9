#include "engine/document/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "clay/base/error.h"

namespace argil::engine {

namespace {

using std::string_view;
using Row = Parameter<Quality>;

// The member at the end of a way of members.
template <class Owner, class Member, class... More>
constexpr auto& at(Owner& owner, Member member, More... more) {
  if constexpr (sizeof...(more) == 0)
    return owner.*member;
  else
    return at(owner.*member, more...);
}
template <auto first, auto... more>
double get(const Quality& q) {
  return static_cast<double>(at(q, first, more...));
}
template <auto first, auto... more>
void set(Quality& q, double value) {
  auto& to = at(q, first, more...);
  using Number = std::remove_reference_t<decltype(to)>;
  if constexpr (std::is_same_v<Number, bool>)
    to = value >= 0.5;
  else if constexpr (std::is_floating_point_v<Number>)
    to = static_cast<Number>(value);
  else
    to = static_cast<Number>(std::lround(value));
}
template <auto... way>
constexpr Row row(string_view id, string_view name, string_view help, string_view unit, double low, double high,
                  double standard, bool logarithmic = false) {
  return {.id = id,
          .name = name,
          .help = help,
          .unit = unit,
          .low = low,
          .high = high,
          .standard = standard,
          .logarithmic = logarithmic,
          .get = &get<way...>,
          .set = &set<way...>};
}

constexpr std::array<string_view, 3> kGrades{"draft", "crisp", "fine"};
template <auto member>
constexpr Row grade(string_view id, string_view name, string_view help, double standard) {
  Row made = row<member>(id, name, help, "", 0, 2, standard);
  made.choices = kGrades;
  return made;
}

using Q = Quality;
using C = ClayQuality;
using S = StrokeQuality;
using K = clay::Quality;
using T = haptics::Quality;
constexpr std::array<QualityAxis, 18> kAxes{
    QualityAxis{QualityPart::clay,
                row<&Q::clay, &C::voxelsAcross>("voxels-across", "Voxels across",
                                                "Along the longest side of new clay, where no voxel size is given.", "",
                                                50, 800, 256, true)},
    QualityAxis{QualityPart::clay,
                row<&Q::clay, &C::band>("band", "Band", "Half width, in voxels, of what is known about distances.", "",
                                        2, 6, 3)},
    QualityAxis{QualityPart::clay, row<&Q::clay, &C::halfMemory>(
                                       "half-memory", "Half the memory",
                                       "16 bits a distance instead of 32: steps of 0.0001 voxel.", "on", 0, 1, 0)},
    QualityAxis{QualityPart::strokes, row<&Q::strokes, &S::spacing>("spacing", "Stamp spacing",
                                                                    "From a stamp to the next, in radii of the tool.",
                                                                    "", 0.01, 1, 0.1, true)},
    QualityAxis{QualityPart::strokes,
                row<&Q::strokes, &S::minSpacingVoxels>("min-spacing", "Least spacing",
                                                       "And never less than so many voxels.", "", 0.05, 8, 0.5, true)},
    QualityAxis{
        QualityPart::strokes,
        row<&Q::strokes, &S::clay, &K::tolerance>(
            "tolerance", "Tolerance", "Voxels that a distance may be off and stay as it is.", "", 0.01, 1, 0.1, true)},
    QualityAxis{QualityPart::strokes,
                row<&Q::strokes, &S::clay, &K::passes>(
                    "passes", "Passes", "Of redistancing; 0: as many as the whole band needs.", "", 0, 16, 0)},
    QualityAxis{
        QualityPart::strokes,
        row<&Q::strokes, &S::clay, &K::drift>(
            "drift", "Drift", "Voxels that a brick may change by before it is renewed at once.", "", 0.25, 2, 1, true)},
    QualityAxis{QualityPart::strokes,
                row<&Q::strokes, &S::clay, &K::trail>("trail", "Trail", "Stamps by which redistancing trails the tool.",
                                                      "", 1, 32, 2, true)},
    QualityAxis{QualityPart::strokes,
                row<&Q::strokes, &S::clay, &K::together>(
                    "together", "Stamps together", "Voxels of moved clay that are computed at once.", "", 0, 48, 12)},
    QualityAxis{QualityPart::strokes, row<&Q::strokes, &S::clay, &K::flowStep>(
                                          "flow-step", "Flow step", "Radii that moved clay is followed in one step.",
                                          "", 0.02, 1, 0.12, true)},
    QualityAxis{QualityPart::strokes, row<&Q::strokes, &S::clay, &K::levelRounds>(
                                          "level-rounds", "Means of planes",
                                          "Looks at the surface that a plane is taken from.", "", 1, 8, 3)},
    QualityAxis{QualityPart::touch,
                row<&Q::touch, &T::contactSteps>("contact-steps", "Contact steps",
                                                 "Straight parts of the tool's way in a tick: more hold fast hands.",
                                                 "", 1, 64, 8, true)},
    QualityAxis{QualityPart::touch, row<&Q::touch, &T::contactSearches>(
                                        "contact-searches", "Contact searches",
                                        "Nearest-point searches in a tick: bounds its cost.", "", 4, 200, 20, true)},
    QualityAxis{QualityPart::touch,
                row<&Q::touch, &T::smoothNormals>("smooth-normals", "Smooth feel",
                                                  "Forces along smooth normals instead of facets.", "on", 0, 1, 1)},
    QualityAxis{QualityPart::touch, row<&Q::servoHz>("servo-hz", "Servo rate", "Ticks of the touch a second.", "Hz",
                                                     250, 4000, 1000, true)},
    QualityAxis{QualityPart::surface,
                grade<&Q::surface>("surface", "Surface seen", "How creases of the shown surface are drawn.", 1)},
    QualityAxis{QualityPart::surface, grade<&Q::exported>("exported", "Surface written", "The same of files.", 2)},
};

Quality with(std::initializer_list<std::pair<string_view, double>> values) {
  Quality quality;
  for (const auto& [id, value] : values) findQualityAxis(id)->row.set(quality, value);
  return quality;
}

}  // namespace

void StrokeQuality::check() const {
  if (!(spacing >= 0.01 && spacing <= 1) || !(minSpacingVoxels >= 0.05 && minSpacingVoxels <= 8))
    throw Error(fmt::format("stamp spacing of {:g} radii and {:g} voxels: give 0.01 to 1 and 0.05 to 8", spacing,
                            minSpacingVoxels));
  clay.check();
}

string_view nameOf(QualityPart part) {
  constexpr std::array<string_view, 4> kNames{"clay", "strokes", "touch", "surface"};
  return kNames[static_cast<size_t>(part)];
}

std::span<const QualityAxis> qualityAxes() {
  return kAxes;
}

const QualityAxis* findQualityAxis(string_view id) {
  const auto it = std::find_if(kAxes.begin(), kAxes.end(), [&](const QualityAxis& axis) { return axis.row.id == id; });
  return it == kAxes.end() ? nullptr : &*it;
}

std::span<const QualityPreset> qualityPresets() {
  static const std::array<QualityPreset, 3> presets{
      QualityPreset{"draft", "Draft", "For a first shape, large brushes and slow machines.",
                    with({{"voxels-across", 96}, {"spacing", 0.2}, {"surface", 0}})},
      QualityPreset{"balanced", "Balanced", "Where a per cent of time stops buying a per cent of accuracy.",
                    with({{"spacing", 0.2}})},
      QualityPreset{"fine", "Fine", "For the last hour before the printer.",
                    with({{"voxels-across", 512}, {"spacing", 0.05}, {"tolerance", 0.01}})},
  };
  return presets;
}

const QualityPreset* findQualityPreset(string_view id) {
  for (const QualityPreset& preset : qualityPresets())
    if (preset.id == id) return &preset;
  return nullptr;
}

std::string presetNames() {
  std::string names;
  for (const QualityPreset& each : qualityPresets()) names += (names.empty() ? "" : ", ") + std::string(each.id);
  return names;
}

const QualityPreset* presetOf(const Quality& quality, QualityPart part) {
  for (const QualityPreset& preset : qualityPresets())
    if (std::all_of(kAxes.begin(), kAxes.end(), [&](const QualityAxis& axis) {
          return axis.part != part || axis.row.get(preset.quality) == axis.row.get(quality);
        }))
      return &preset;
  return nullptr;
}

Quality readQuality(string_view text) {
  Quality quality = findQualityPreset("balanced")->quality;
  const auto fail = [&](std::string what) {
    std::string axes;
    for (const QualityAxis& each : kAxes) axes += (axes.empty() ? "" : ", ") + std::string(each.row.id);
    throw Error(fmt::format("quality: {}; give {}, and behind it AXIS=VALUE of {}", what, presetNames(), axes));
  };
  for (size_t from = 0; from <= text.size();) {
    const size_t end = std::min(text.find(',', from), text.size());
    const string_view item = text.substr(from, end - from);
    const size_t equals = item.find('=');
    if (equals == string_view::npos) {
      const QualityPreset* preset = findQualityPreset(item);
      if (!preset || from > 0) fail(fmt::format("{:?} is no preset", std::string(item)));
      quality = preset->quality;
    } else {
      const QualityAxis* axis = findQualityAxis(item.substr(0, equals));
      if (!axis) fail(fmt::format("{:?} is no axis", std::string(item.substr(0, equals))));
      const string_view value = item.substr(equals + 1);
      const auto choice = std::find(axis->row.choices.begin(), axis->row.choices.end(), value);
      double number = choice - axis->row.choices.begin();
      if (axis->row.choices.empty()) {
        const auto [rest, error] = std::from_chars(value.data(), value.data() + value.size(), number);
        if (error != std::errc() || rest != value.data() + value.size() || !(number >= axis->row.low) ||
            !(number <= axis->row.high))
          fail(fmt::format("{} takes {:g} to {:g}, not {:?}", axis->row.id, axis->row.low, axis->row.high,
                           std::string(value)));
      } else if (choice == axis->row.choices.end()) {
        fail(
            fmt::format("{} takes {}, not {:?}", axis->row.id, fmt::join(axis->row.choices, ", "), std::string(value)));
      }
      axis->row.set(quality, number);
    }
    from = end + 1;
  }
  quality.strokes.check();
  return quality;
}

}  // namespace argil::engine
