#version 460
layout(location = 0) in vec4 tint;
layout(location = 1) in vec2 place;
layout(location = 2) in flat vec2 lengthWidth;
layout(location = 0) out vec4 colour;

void main() {
  float away = length(vec2(place.x - clamp(place.x, 0.0, lengthWidth.x), place.y));
  float cover = clamp(0.5 * lengthWidth.y - away + 0.5, 0.0, 1.0);
  if (cover * tint.a <= 0.0) discard;
  colour = vec4(tint.rgb, tint.a * cover);
}
