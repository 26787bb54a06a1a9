#pragma once
// Meshes that stay quads: few vertices of other than four quads, and as near to the clay as flat quads come.

#include <memory>
#include <optional>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/cage/cage_maker.h"
#include "clay/cage/mirrored_quads.h"
#include "clay/cage/quad_mesh.h"
#include "clay/store/version.h"

namespace argil::clay {

struct FlatQuads {
  QuadMesh mesh;
  std::unique_ptr<CageMaker> maker;   ///< Has the surface and the creases that they lie on.
  int halvings = 0;                   ///< How often the quads of a coarser cage were halved.
  std::optional<MirrorPlane> mirror;  ///< The quads on both sides of it are images of each other, to the bit:
  std::vector<uint32_t> image;        ///< then of each vertex its image, or itself in the plane.
  /// As many quads as were asked for would lie so far off the clay, mm, infinite where they do not go around it: more
  /// were drawn. 0: not so.
  double tooFarMm = 0;
  WishesMet met;
};

/// At most `most` quads around a clay, of its shape: the best of two or four layouts, which differ in irregular
/// vertices, bad corners and distances. Where a cage of a quarter or a sixteenth of them, and of 500 and more, has good
/// corners, its quads are halved: that leaves its irregular vertices alone, which are fewer, and takes a fraction of
/// the time. Of up to 5 000 quads those that lay off by more than others become smaller, without another layout.
/// `mirrored`: of a clay that a plane normal to an axis mirrors within two voxels one half is drawn and
/// mirrored, if that can be. Throws as CageMaker. Cost: some seconds, mirrored twice as many. The same for any count of
/// threads. Where these do not go around the clay, leave a part of it out by more than the length of an even edge, or
/// lie as far off it (thin walls, limbs, many handles), up to four times as many are drawn until none do.
[[nodiscard]] FlatQuads flatQuads(const Version& version, size_t most, bool mirrored, int threads, const WorkPart& part,
                                  const CageWishes& wishes = {});

}  // namespace argil::clay
