#version 460
// A segment as a rectangle with room for round ends; six vertices an instance.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(push_constant) uniform Mode { float onScreen, strength; } mode;  // onScreen 1: positions are samples from the top left corner

layout(location = 0) in vec4 a;       // xyz rel (or screen xy), w: width in samples
layout(location = 1) in vec4 b;       // xyz, w: 1: flat at a, 2: flat at b, 3: both, else round; 4 more: does not fade
layout(location = 2) in vec4 colour;  // display-linear, alpha
layout(location = 0) out vec4 tint;
layout(location = 1) out vec2 place;          // samples from the segment's start: along, aside
layout(location = 2) out flat vec3 lengthWidthEnds;

// One way through for all: with a branch and an early return, a driver (NVIDIA 580.159) leaves the second eye of a
// multiview pass without the positions of lines on the screen.
void main() {
  const bool onScreen = mode.onScreen > 0.5;
  // A few samples nearer, so that a path on the clay is not half inside it.
  vec3 forward = eye().forward.xyz;
  float za = dot(forward, a.xyz), zb = dot(forward, b.xyz);
  vec4 ca = toClip(a.xyz - forward * (4.0 * mmPerSample(za))), cb = toClip(b.xyz - forward * (4.0 * mmPerSample(zb)));
  float strength = mode.strength * (onScreen || b.w >= 4.0 ? 1.0 : 1.0 - fadeAt(0.5 * (za + zb)));
  if (onScreen) ca = vec4(a.xy / frame.size.xy * 2.0 - 1.0, 0.0, 1.0);
  if (onScreen) cb = vec4(b.xy / frame.size.xy * 2.0 - 1.0, 0.0, 1.0);
  // Cut at a plane before the eye, where the projection turns over.
  float least = 1e-4 * max(abs(ca.w), abs(cb.w));
  const bool behind = ca.w < least && cb.w < least;
  if (ca.w < least && !behind) ca = mix(cb, ca, (cb.w - least) / (cb.w - ca.w));
  if (cb.w < least && !behind) cb = mix(ca, cb, (ca.w - least) / (ca.w - cb.w));
  vec2 sa = ca.xy / ca.w * 0.5 * frame.size.xy, sb = cb.xy / cb.w * 0.5 * frame.size.xy;
  float len = length(sb - sa);
  vec2 along = len > 1e-6 ? (sb - sa) / len : vec2(1.0, 0.0);
  vec2 aside = vec2(-along.y, along.x);
  float reach = 0.5 * a.w + 1.0;
  const vec2 corners[6] = vec2[](vec2(0, -1), vec2(1, -1), vec2(1, 1), vec2(0, -1), vec2(1, 1), vec2(0, 1));
  vec2 corner = corners[gl_VertexIndex];
  vec4 c = corner.x > 0.5 ? cb : ca;
  vec2 offset = along * (corner.x > 0.5 ? reach : -reach) + aside * corner.y * reach;
  gl_Position = behind ? vec4(2.0, 2.0, 2.0, 1.0) : c + vec4(offset / (0.5 * frame.size.xy) * c.w, 0.0, 0.0);
  place = vec2(corner.x > 0.5 ? len + reach : -reach, corner.y * reach);
  lengthWidthEnds = vec3(len, a.w, mod(b.w, 4.0));
  tint = vec4(colour.rgb, colour.a * strength);
}
