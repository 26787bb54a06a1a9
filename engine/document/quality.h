#pragma once
// Speed against accuracy: every choice between them, as rows of one table, and presets that name points of it.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "clay/brush/quality.h"
#include "clay/kernels/brick.h"
#include "clay/surface/surface.h"
#include "engine/document/parameter.h"
#include "haptics/scene/scene.h"

namespace argil::engine {

/// Of strokes; goes with every tool, so that a stroke which is done again leaves the same clay.
struct StrokeQuality {
  /// Arc length from a stamp to the next, in tool radii: 0.01 to 1. A stamp is a swept segment, so wider spacing costs
  /// roundness in tight bends only: a right-angled corner is cut short by at most 0.36 of the spacing.
  double spacing = 0.1;
  /// And never less than this many voxels: finer stamps change nothing that the clay can hold. 0.05 to 8.
  double minSpacingVoxels = 0.5;
  clay::Quality clay = {};

  /// Throws Error for what is out of range or no number.
  void check() const;
  friend bool operator==(const StrokeQuality&, const StrokeQuality&) = default;
};

/// Of clay that is made from nothing or from a mesh.
struct ClayQuality {
  double voxelsAcross = 256;  ///< Along its longest side, where no voxel size is given: 50 to 800.
  double band = 3;            ///< Half width in voxels of what is known about distances: 2 to 6.
  bool halfMemory = false;    ///< Bricks of clay::Precision::fixed16.

  [[nodiscard]] clay::Precision precision() const {
    return halfMemory ? clay::Precision::fixed16 : clay::Precision::float32;
  }
  friend bool operator==(const ClayQuality&, const ClayQuality&) = default;
};

struct Quality {
  ClayQuality clay = {};
  StrokeQuality strokes = {};
  haptics::Quality touch = {};
  double servoHz = 1000;                     ///< 250 to 4000.
  clay::Grade surface = clay::Grade::crisp;  ///< That is seen.
  clay::Grade exported = clay::Grade::fine;  ///< That is written.
  friend bool operator==(const Quality&, const Quality&) = default;
};

/// What a row is a choice about: what it takes effect on, and which front of docs/tradeoff.md shows it.
enum class QualityPart : uint8_t { clay, strokes, touch, surface };
struct QualityAxis {
  QualityPart part = QualityPart::clay;
  Parameter<Quality> row;
};
[[nodiscard]] std::string_view nameOf(QualityPart part);
[[nodiscard]] std::span<const QualityAxis> qualityAxes();
/// Null: there is none of that id.
[[nodiscard]] const QualityAxis* findQualityAxis(std::string_view id);

/// Presets follow from docs/tradeoff.csv by the rule in docs/tradeoff.md; a test derives them again.
struct QualityPreset {
  std::string_view id, name, help;
  Quality quality;
};
/// draft, balanced, fine.
[[nodiscard]] std::span<const QualityPreset> qualityPresets();
/// Null: there is none of that id.
[[nodiscard]] const QualityPreset* findQualityPreset(std::string_view id);
/// "draft, balanced, fine".
[[nodiscard]] std::string presetNames();
/// The preset that a quality is, as far as `part` goes; null: none.
[[nodiscard]] const QualityPreset* presetOf(const Quality& quality, QualityPart part);

/// "fine", or "fine,spacing=0.05,band=4", or axes alone, which begin from balanced. Throws Error, one line that says
/// what there is, for anything else.
[[nodiscard]] Quality readQuality(std::string_view text);

}  // namespace argil::engine
