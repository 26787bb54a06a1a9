#version 460
// Light on clay. Drawn where there is clay alone: the depth test sees to that.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "light.glsl"
#include "materials.glsl"

layout(set = 0, binding = 1) uniform sampler2DArray depthMap;
layout(set = 0, binding = 2) uniform sampler2DArray normalMap;
layout(set = 0, binding = 3) uniform sampler2DArray cavityMap;
layout(set = 0, binding = 6) uniform sampler2DArray albedoMap;
layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 colour;  // display-linear

// Cavity is computed at the picture's size, this pass is finer: average what lies on the same piece of surface.
vec2 cavityAt(float z) {
  ivec2 size = textureSize(cavityMap, 0).xy;
  vec2 at = (ndc * 0.5 + 0.5) * vec2(size) - 0.5;
  ivec2 base = ivec2(floor(at));
  vec2 sum = vec2(0.0);
  float weights = 1e-6;
  for (int y = -1; y <= 2; ++y) {
    for (int x = -1; x <= 2; ++x) {
      ivec2 tap = clamp(base + ivec2(x, y), ivec2(0), size - 1);
      ivec2 deep = clamp(ivec2((vec2(tap) + 0.5) / vec2(size) * frame.size.xy), ivec2(0), ivec2(frame.size.xy) - 1);
      float d = texelFetch(depthMap, ivec3(deep, eyeIndex()), 0).r;
      if (d <= 0.0) continue;
      float away = abs(distanceOf(d) - z) / (mmPerSample(z) * 12.0 * frame.size.z);
      float w = max(1.0 - away, 0.001);
      sum += w * texelFetch(cavityMap, ivec3(tap, eyeIndex()), 0).rg;
      weights += w;
    }
  }
  return sum / weights;
}

// Mirrors surfaceOf (render/renderer/pipelines.h).
void readCode(float code, inout Point p, out bool dimmed) {
  float k = max(round(code * 255.0) - 1.0, 0.0);
  dimmed = k >= 121.0;
  k -= dimmed ? 121.0 : 0.0;
  float level = floor((k + 0.5) / 11.0);
  p.roughness = level * 0.1;
  p.gloss = (k - 11.0 * level) * 0.1;
}

// Lines where the clay meets planes, and tints beyond these. The line's distance is measured in the picture: along the
// surface, as the sight's ray moves over it.
vec3 planesShown(vec3 c, vec3 rel, vec3 n, vec3 toEye, float z, bool dimmed) {
  if (frame.planeSizes[0].z == 0.0) return c;
  vec3 sight = -toEye;
  float facing = dot(n, sight);
  facing = facing < 0.0 ? min(facing, -0.08) : max(facing, 0.08);
  vec3 across = frame.cameraRight.xyz - sight * (dot(n, frame.cameraRight.xyz) / facing);
  vec3 upwards = frame.cameraUp.xyz - sight * (dot(n, frame.cameraUp.xyz) / facing);
  float pixels = frame.size.z * frame.size.w;  // samples
  for (int i = 0; i < int(frame.planeSizes[0].z); ++i) {
    if (dimmed && frame.planeSizes[i].y == 0.0) continue;
    float away = dot(frame.planes[i], vec4(rel, 1.0));
    if (away > 0.0) c = mix(c, frame.planeTints[i].rgb, frame.planeTints[i].a);
    vec2 slope = vec2(dot(frame.planes[i].xyz, across), dot(frame.planes[i].xyz, upwards)) * mmPerSample(z);
    float samples = abs(away) / max(length(slope), 1e-9);
    float cover = clamp(frame.planeSizes[i].x * pixels + 0.5 - samples, 0.0, 1.0);
    c = mix(c, frame.planeLines[i].rgb, frame.planeLines[i].a * cover);
  }
  return c;
}

void main() {
  ivec3 at = ivec3(gl_FragCoord.xy, eyeIndex());
  float z = distanceOf(texelFetch(depthMap, at, 0).r);
  vec4 surface = texelFetch(albedoMap, at, 0);
  vec3 n = unpackOctahedral(texelFetch(normalMap, at, 0).rg);

  vec3 from, to;
  sight(ndc, from, to);
  vec3 rel = from + to * z;

  Point p;
  p.albedo = surface.rgb * surface.rgb;
  p.n = fromMiddle(n);
  p.toEye = -normalize(to);
  bool dimmed;
  readCode(surface.a, p, dimmed);
  vec2 cavity = kCavity ? cavityAt(z) * frame.marker.z : vec2(0.0);
  p.hollow = 1.0 - exp(-2.2 * cavity.x);
  p.ridge = cavity.y;
  p.cursor = cursorVisible(rel);
  p.sky = 1.0 - 0.75 * ballOcclusion(rel, p.n);
  vec3 c;
  if (kShading == 0) {
    float shadow = kKeyShadow ? mix(0.80, 1.0, keyVisible(rel, p.n)) : 1.0;
    c = matcap(vec3(n.xy, -n.z), p.albedo);
    c *= mix(vec3(1.0), vec3(0.30, 0.24, 0.22), p.hollow) * (1.0 + 0.45 * p.ridge) * (shadow * mix(0.45, 1.0, p.cursor) * p.sky);
  } else {
    p.shadow = keyVisible(rel, p.n) * p.cursor;
    c = toneMap((kShading == 1 ? litClay(p) : made(p)) * 0.62);
  }
  if (kSection && surface.a < 0.002) c = p.albedo * vec3(0.50, 0.33, 0.30) * mix(0.5, 1.0, p.cursor);
  vec3 back = backdrop(ndc);
  // A quieter shade of the same clay.
  if (dimmed) c = mix(mix(vec3(dot(c, vec3(0.2126, 0.7152, 0.0722))), c, 0.85), back, 0.34);
  c = planesShown(c, rel, p.n, p.toEye, z, dimmed);
  if (kDepthFade) c = mix(c, back, fadeAt(z));
  colour = vec4(dithered(c, gl_FragCoord.xy), 1.0);
}
