#version 460
// How much of each pixel's neighbourhood rises above (valley) or falls below (ridge) its tangent plane, at two sizes.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(set = 0, binding = 1) uniform sampler2DArray depthMap;
layout(set = 0, binding = 2) uniform sampler2DArray normalMap;
layout(location = 0) in vec2 ndc;
layout(location = 0) out vec2 cavity;  // valley, ridge

const int kTaps = 8;
const float kGolden = 2.39996323;

vec3 toEyeAxes(vec3 direction) {
  Eye e = eye();
  return vec3(dot(e.right.xyz, direction), dot(e.up.xyz, direction), dot(e.forward.xyz, direction));
}

void main() {
  cavity = vec2(0.0);
  ivec2 fullSize = textureSize(depthMap, 0).xy;
  ivec2 at = clamp(ivec2((ndc * 0.5 + 0.5) * vec2(fullSize)), ivec2(0), fullSize - 1);
  float d = texelFetch(depthMap, ivec3(at, eyeIndex()), 0).r;
  if (d <= 0.0) return;
  float z = distanceOf(d);
  vec2 here = (vec2(at) + 0.5) / vec2(fullSize) * 2.0 - 1.0;
  vec3 p = viewAt(here, z);
  vec3 n = toEyeAxes(fromMiddle(unpackOctahedral(texelFetch(normalMap, ivec3(at, eyeIndex()), 0).rg)));
  float turn = interleavedNoise(gl_FragCoord.xy) * 6.2831853;
  vec2 sum = vec2(0.0);
  for (int ring = 0; ring < 2; ++ring) {
    float radius = (ring == 0 ? 0.0065 : 0.026) * float(fullSize.y);  // samples
    float reach = radius * mmPerSample(z);
    for (int i = 0; i < kTaps; ++i) {
      float r = sqrt((float(i) + 0.5) / float(kTaps));
      float angle = turn + kGolden * float(i);
      ivec2 tap = at + ivec2(round(vec2(cos(angle), sin(angle)) * max(r * radius, 1.0)));
      if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, fullSize))) continue;
      float td = texelFetch(depthMap, ivec3(tap, eyeIndex()), 0).r;
      if (td <= 0.0) continue;
      vec3 v = viewAt((vec2(tap) + 0.5) / vec2(fullSize) * 2.0 - 1.0, distanceOf(td)) - p;
      float len = length(v);
      float rise = dot(n, v) / max(len, 1e-20);
      float close = clamp(1.0 - len / (3.0 * reach), 0.0, 1.0);
      // A few degrees of slack: facets are not creases.
      sum += (ring == 0 ? 0.55 : 0.75) * close * vec2(max(rise - 0.05, 0.0), max(-rise - 0.07, 0.0));
    }
  }
  cavity = clamp(sum * (2.2 / float(kTaps)), 0.0, 1.0);
}
