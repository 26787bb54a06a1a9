#version 460
// Moves what stands for a cut face to the section plane.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(set = 0, binding = 6) uniform sampler2DArray albedoMap;
layout(location = 0) in vec2 ndc;

void main() {
  if (texelFetch(albedoMap, ivec3(gl_FragCoord.xy, eyeIndex()), 0).a > 0.002) discard;
  vec3 from, to;
  sight(ndc, from, to);
  float z = -dot(frame.section, vec4(from, 1.0)) / dot(frame.section.xyz, to);
  gl_FragDepth = clamp((frame.depth.x * z + frame.depth.y) / (frame.depth.z * z + frame.depth.w), 0.0, 1.0);
}
