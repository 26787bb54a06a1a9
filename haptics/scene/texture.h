#pragma once
// What a surface is made of, finer than its clay: heights that displace what is felt.

#include <cstdint>
#include <variant>
#include <vector>

#include "clay/base/vec.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

// Shapes of textures. Wavelengths 1e-3 to 1e4 mm; amplitudes, half of the way from the lowest to the highest place,
// above 0 to 10 mm.

/// Sine ridges; on surfaces that face along `across` they are flat.
struct Ridges {
  double wavelengthMm = 1, amplitudeMm = 0.05;
  Vec3d across = Vec3d::UnitX();
};
/// An egg-crate of bumps and dents.
struct Bumps {
  double wavelengthMm = 1, amplitudeMm = 0.05;
};
/// Grain without a pattern: 1 to 6 octaves, each with half the wavelength and half the height of the one before.
struct Grain {
  double wavelengthMm = 1, amplitudeMm = 0.05;
  int octaves = 2;
  uint32_t seed = 1;
};
/// An image: 0 lowest, 1 highest, row by row; repeated in mirror images, so that no seam is felt where it ends. 2 to
/// 4096 pixels along an edge, 1e-3 to 1e3 mm each. Details of less than about eight pixels are softened.
struct HeightMap {
  int width = 0, height = 0;
  std::vector<float> grey;
  double mmPerPixel = 0.1, amplitudeMm = 0.05;
};

/// An immutable texture in the frame of the piece that wears it. Bumps and images are projected along the three axes
/// and blended by the surface's direction; ridges and grain fill space. Heights are engraved: 0 at the top of the
/// highest detail, −2 amplitudes at the bottom of the lowest, so that contact begins where the clay begins and no force
/// jumps there.
class Texture {
 public:
  /// Throws Error for a number out of range.
  explicit Texture(const Ridges& shape);
  explicit Texture(const Bumps& shape);
  explicit Texture(const Grain& shape);
  explicit Texture(const HeightMap& shape);

  /// Height in mm at a place of the surface with that unit normal, both in the piece's frame, and in `slope` its
  /// gradient along the surface (mm per mm). Details shorter than `finestMm` are not there, those up to twice as long
  /// fade smoothly; what is faded leaves its mean. Any thread. Cost: 0.05 to 0.2 µs.
  double height(const Vec3d& at, const Vec3d& normal, double finestMm, Vec3d* slope) const ARGIL_REALTIME;

  [[nodiscard]] double rangeMm() const noexcept { return 2 * amplitude_; }  ///< From the lowest to the highest place.
  [[nodiscard]] double finestMm() const noexcept { return finest_; }        ///< The shortest wavelength in it.

 private:
  struct Level {  // Of an image's pyramid.
    int width = 0, height = 0;
    double pitchX = 0, pitchY = 0;  // mm
    size_t first = 0;               // Into pixels.
  };
  struct Image {
    std::vector<Level> levels;
    std::vector<float> pixels;  // −1 to 1.
    float mean = 0;
    double pitch = 0;
  };
  double ridges(const Ridges& r, const Vec3d& at, double finestMm, Vec3d& slope) const ARGIL_REALTIME;
  double grain(const Grain& g, const Vec3d& at, double finestMm, Vec3d& slope) const ARGIL_REALTIME;
  double projected(const Vec3d& at, const Vec3d& normal, double finestMm, Vec3d& slope) const ARGIL_REALTIME;
  double plane(double u, double v, double finestMm, double& du, double& dv) const ARGIL_REALTIME;
  double level(const Image& image, const Level& level, double u, double v, double& du, double& dv) const ARGIL_REALTIME;

  std::variant<Ridges, Bumps, Grain, Image> shape_;
  double amplitude_ = 0, finest_ = 0;
};

}  // namespace argil::haptics
