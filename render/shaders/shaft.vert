#version 460
// The stylus: a cone that leaves the ball, then a barrel. Rings of quads, made from the vertex number alone.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) out vec3 relOut;
layout(location = 1) out vec3 normalOut;
layout(location = 2) out float alongOut;

const int kSides = 28;
const int kRings = 6;

void main() {
  int quad = gl_VertexIndex / 6, corner = gl_VertexIndex % 6;
  int side = quad % kSides, ring = quad / kSides;
  const ivec2 corners[6] = ivec2[](ivec2(0, 0), ivec2(1, 0), ivec2(1, 1), ivec2(0, 0), ivec2(1, 1), ivec2(0, 1));
  side += corners[corner].x;
  ring += corners[corner].y;
  // Along the axis and thickness at each ring; the last one closes the end.
  const vec2 profile[kRings + 1] = vec2[](vec2(0.0, 0.0), vec2(0.10, 0.12), vec2(0.30, 0.85), vec2(0.36, 1.0),
                                          vec2(0.97, 1.0), vec2(1.0, 0.86), vec2(1.0, 0.0));
  vec2 at = profile[ring];
  float radius = ring == kRings ? 0.0 : mix(frame.shaftRadii.x, frame.shaftRadii.y, at.y);
  vec3 axis = frame.shaft.xyz;
  vec3 x = normalize(cross(axis, abs(axis.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0)));
  vec3 y = cross(axis, x);
  float angle = 6.2831853 * float(side) / float(kSides);
  vec3 outward = x * cos(angle) + y * sin(angle);
  relOut = frame.ball.xyz + axis * frame.shaft.w * at.x + outward * radius;
  normalOut = ring >= kRings ? axis : outward;
  alongOut = at.x;
  gl_Position = toClip(relOut);
}
