#pragma once
// How the picture is shaded and which cues for depth it has. Chosen by the person, kept with the view.

#include <optional>
#include <span>
#include <string_view>

#include "clay/base/vec.h"
#include "render/view/colour.h"

namespace argil::render {

enum class Shading : uint8_t {
  matcap,    ///< A material seen on a ball, looked up by the view's normal: form at a glance, no lights to place.
  lit,       ///< Key, fill and dome light on the piece's colour.
  material,  ///< Lit with the piece's roughness and gloss (Cook-Torrance, GGX), for how it would look made.
};

/// Materials for Shading::matcap, computed, no pictures. Clay and wax take the piece's colour, the others have their
/// own.
enum class Matcap : uint8_t { clay, wax, porcelain, steel, rubber, normals };

/// A plane that cuts the picture open: clay on the side of the normal is not drawn and throws no shadow, cut faces are
/// one flat colour. What is open (parts) shows its inner side instead.
struct Section {
  Vec3d pointMm = Vec3d::Zero(), normal = Vec3d::UnitZ();
};

struct Look {
  Shading shading = Shading::lit;
  Matcap matcap = Matcap::clay;
  bool cavity = true;              ///< Darker hollows, lighter ridges, ambient occlusion of what is near.
  double cavityStrength = 1;       ///< 0 to 2.
  bool keyShadow = true;           ///< Clay shades itself and the ground. Also needs Quality::keyShadow.
  bool cursorShadow = true;        ///< The tool's shadow on clay and ground.
  bool beam = true;                ///< From the tool to where it would land.
  bool depthFade = false;          ///< What is farther away fades towards the background.
  double depthFadeStrength = 0.6;  ///< Of the farthest point of the clay: 0 to 1.
  bool grid = true;                ///< Ground at the lowest point of the clay, lines at round numbers of mm.
  bool scaleBar = true;            ///< A labelled length, true in the plane through the view's target.
  bool xray = true;                ///< Guides and widgets show faintly through clay.
  bool lightBackground = false;
  std::optional<Section> section;
};

/// Names for people and files, in the order of the enumerations: "matcap", "lit", "material"; "clay" … "normals".
[[nodiscard]] std::span<const std::string_view> shadingNames();
[[nodiscard]] std::span<const std::string_view> matcapNames();
[[nodiscard]] std::optional<Shading> shadingNamed(std::string_view name);
[[nodiscard]] std::optional<Matcap> matcapNamed(std::string_view name);

/// Throws Error (input) that names the member that is out of range.
void check(const Look& look);

}  // namespace argil::render
