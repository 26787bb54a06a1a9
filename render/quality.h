#pragma once
// Where the renderer trades speed for looks.

namespace argil::render {

struct Quality {
  int supersample = 2;      ///< Samples per pixel along each axis: 1 to 4. 1 is for moving pictures.
  bool keyShadow = true;    ///< Clay shades itself and the ground; costs one more pass over the triangles.
  int shadowPixels = 2048;  ///< Edge of the shadow map: 256 to 8192.
};

}  // namespace argil::render
