#version 460
// The ground as one rectangle, as large as its fade reaches.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) out vec3 rel;

void main() {
  const vec2 corners[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));
  vec2 corner = corners[gl_VertexIndex] * frame.gridFade.w;
  rel = frame.gridFade.xyz + frame.gridU.xyz * corner.x + frame.gridV.xyz * corner.y;
  gl_Position = toClip(rel);
}
