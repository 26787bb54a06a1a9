#version 460
layout(location = 0) in vec4 tint;
layout(location = 1) in vec2 place;
layout(location = 2) in flat vec3 lengthWidthEnds;
layout(location = 0) out vec4 colour;

void main() {
  float len = lengthWidthEnds.x, width = lengthWidthEnds.y, ends = lengthWidthEnds.z;
  float away = length(vec2(place.x - clamp(place.x, 0.0, len), place.y));
  float cover = clamp(0.5 * width - away + 0.5, 0.0, 1.0);
  if (mod(ends, 2.0) > 0.5) cover = min(cover, clamp(place.x + 0.5, 0.0, 1.0));
  if (ends > 1.5) cover = min(cover, clamp(len - place.x + 0.5, 0.0, 1.0));
  if (cover * tint.a <= 0.0) discard;
  colour = vec4(tint.rgb, tint.a * cover);
}
