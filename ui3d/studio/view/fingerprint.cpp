#include "ui3d/studio/view/fingerprint.h"

#include <bit>
#include <cstring>
#include <type_traits>

namespace argil::studio {
namespace {

// FNV-1a by words of eight bytes: pictures are compared sixty times a second.
class Mix {
 public:
  void word(uint64_t value) { hash_ = (hash_ ^ value) * 0x100000001b3ull, hash_ ^= hash_ >> 29; }
  void operator()(double value) { word(std::bit_cast<uint64_t>(value)); }
  void operator()(const Vec3d& v) {
    for (int i = 0; i < 3; ++i) (*this)(v[i]);
  }
  void operator()(const render::Colour& colour) { bytes(&colour, sizeof colour); }
  void bytes(const void* data, size_t size) {
    const char* p = static_cast<const char*>(data);
    for (; size >= 8; p += 8, size -= 8) {
      uint64_t value;
      std::memcpy(&value, p, 8);
      word(value);
    }
    uint64_t rest = size;
    std::memcpy(&rest, p, size);
    word(rest);
  }
  [[nodiscard]] uint64_t value() const { return hash_; }

 private:
  uint64_t hash_ = 0xcbf29ce484222325ull;
};
static_assert(std::has_unique_object_representations_v<render::UiVertex> || sizeof(render::UiVertex) == 20);
static_assert(sizeof(render::Colour) == 4 * sizeof(float));

}  // namespace

uint64_t fingerprint(const render::Shot& shot, const render::Quality& quality) {
  Mix mix;
  const render::View& view = shot.view;
  mix(view.position);
  mix(view.target);
  mix(view.up);
  mix.word(uint64_t(view.projection));
  mix(view.openingDegrees);
  const render::Look& look = shot.look;
  const bool flags[] = {look.cavity,          look.keyShadow,
                        look.cursorShadow,    look.beam,
                        look.depthFade,       look.grid,
                        look.scaleBar,        look.xray,
                        look.lightBackground, look.section.has_value(),
                        shot.stereo.swapEyes, shot.overlays.cursor.has_value(),
                        quality.keyShadow,    quality.cavity};
  for (const bool flag : flags) mix.word(flag);
  mix.word(uint64_t(look.shading));
  mix.word(uint64_t(look.matcap));
  mix(look.cavityStrength);
  mix(look.depthFadeStrength);
  if (look.section) {
    mix(look.section->pointMm);
    mix(look.section->normal);
  }
  mix.word(uint64_t(shot.stereo.mode));
  mix(shot.stereo.eyeDistancePart);
  mix(shot.stereo.convergencePart);
  if (const auto& c = shot.overlays.cursor) {
    mix(c->positionMm);
    mix(c->shaft);
    mix(c->radiusMm);
    mix(c->drop);
    mix(c->forceN);
    mix(c->fullForceN);
    mix(c->tint);
    mix.word(c->contact);
    mix.word(c->flat);
    mix.word(c->footprint.has_value());
    if (c->footprint) {
      mix(c->footprint->pointMm);
      mix(c->footprint->normal);
    }
  }
  for (const render::Fill& fill : shot.overlays.fills) {
    mix.bytes(fill.trianglesMm.data(), fill.trianglesMm.size() * sizeof(Vec3d));
    mix(fill.colour);
    mix.word(uint64_t(fill.depth));
  }
  for (const render::Polyline& line : shot.overlays.polylines) {
    mix.bytes(line.pointsMm.data(), line.pointsMm.size() * sizeof(Vec3d));
    mix(line.colour);
    mix(double(line.widthPixels));
    mix.word(uint64_t(line.depth));
  }
  for (const render::PlaneMark& plane : shot.overlays.planes) {
    mix(plane.pointMm);
    mix(plane.normal);
    mix(plane.line);
    mix(plane.beyond);
    mix(double(plane.widthPixels));
    mix.word(plane.dimmedToo);
  }
  mix.word(uint64_t(quality.supersample));
  mix.word(uint64_t(quality.shadowPixels));
  mix(quality.detailPixels);
  return mix.value();
}

uint64_t fingerprint(const render::UiFrame& panels) {
  Mix mix;
  mix(double(panels.width));
  mix(double(panels.height));
  mix.bytes(panels.vertices.data(), panels.vertices.size() * sizeof(render::UiVertex));
  mix.bytes(panels.indices.data(), panels.indices.size() * sizeof(uint16_t));
  for (const render::UiCommand& command : panels.commands) {
    mix.bytes(command.clip.data(), sizeof command.clip);
    mix.word(command.texture);
    mix.word(uint64_t(command.firstIndex) << 32 | command.indexCount);
    mix.word(command.firstVertex);
  }
  return mix.value();
}

}  // namespace argil::studio
