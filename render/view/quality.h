#pragma once
// Where the renderer trades speed for looks.

namespace argil::render {

struct Quality {
  int supersample = 2;      ///< Samples per pixel along each axis: 1 to 4. 1 is for moving pictures.
  bool keyShadow = true;    ///< Clay shades itself and the ground; costs one more pass over the triangles.
  int shadowPixels = 2048;  ///< Edge of the shadow map: 256 to 8192.
  bool cavity = true;       ///< The cavity pass, where the look asks for it.
  double detailPixels = 1;  ///< Triangles coarser than this may stand for finer ones: 0 (never) to 8 pixels.

  /// The stated rule: while the camera or a stroke moves, one sample a pixel, no key shadow, no cavity, detail of 2
  /// pixels (off by one at most); the full picture as soon as all has rested for a fifth of a second.
  [[nodiscard]] Quality moving() const {
    Quality q = *this;
    q.supersample = 1;
    q.keyShadow = q.cavity = false;
    q.detailPixels = detailPixels > 2 ? detailPixels : 2;
    return q;
  }
  friend bool operator==(const Quality&, const Quality&) = default;
};

}  // namespace argil::render
