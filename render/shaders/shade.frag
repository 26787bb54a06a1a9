#version 460
// Light on clay, the ground with its lines, the background, and what the cursor throws on them.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(set = 0, binding = 1) uniform sampler2D depthMap;
layout(set = 0, binding = 2) uniform sampler2D normalMap;
layout(set = 0, binding = 3) uniform sampler2D cavityMap;
layout(set = 0, binding = 4) uniform sampler2DShadow shadowMap;
layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 colour;  // display-linear

const vec3 kClay = vec3(0.44, 0.200, 0.122);
const vec3 kKey = vec3(1.0, 0.93, 0.82) * 1.55;
const vec3 kFill = vec3(0.62, 0.78, 1.0) * 0.22;
const vec3 kSky = vec3(0.60, 0.70, 0.86) * 0.40;
const vec3 kGroundLight = vec3(0.50, 0.38, 0.30) * 0.20;

float interleavedNoise(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }

// Part of the key light that the clay lets through, 0…1.
float keyVisible(vec3 rel, vec3 n) {
  if (frame.keyLight.w < 0.5) return 1.0;
  vec2 texel = 1.0 / vec2(textureSize(shadowMap, 0));
  // Step off the surface by a few texels of the map, more where light grazes.
  float texelMm = 2.0 * texel.x / length(frame.shadowX.xyz);
  float slope = 1.0 - clamp(dot(n, frame.keyLight.xyz), 0.0, 1.0);
  vec4 p = vec4(rel + n * texelMm * (1.5 + 3.0 * slope), 1.0);
  vec3 s = vec3(dot(frame.shadowX, p), dot(frame.shadowY, p), dot(frame.shadowZ, p));
  if (any(greaterThan(abs(s.xy), vec2(1.0)))) return 1.0;
  s.z = min(s.z, 1.0);  // beyond the clay, where the map is empty, nothing shades
  float lit = 0.0, turn = interleavedNoise(gl_FragCoord.xy) * 6.2831853;
  for (int i = 0; i < 8; ++i) {
    float angle = turn + 2.39996323 * float(i), r = 4.5 * sqrt((float(i) + 0.5) / 8.0);
    lit += texture(shadowMap, vec3(s.xy * 0.5 + 0.5 + texel * r * vec2(cos(angle), sin(angle)), s.z));
  }
  return lit / 8.0;
}

// Part of the key light that the cursor's ball and shaft let through.
float cursorVisible(vec3 rel) {
  if (frame.ball.w <= 0.0) return 1.0;
  vec3 toLight = frame.keyLight.xyz;
  float R = frame.ball.w;
  vec3 o = frame.ball.xyz - rel;
  float along = dot(o, toLight);
  float aside = length(o - along * toLight);
  float soft = 0.12 * R + 0.06 * max(along, 0.0);
  float ball = (1.0 - smoothstep(R - soft, R + soft, aside)) * smoothstep(0.0, 0.5 * R, along);

  // Closest approach of the light ray to the shaft's axis.
  vec3 axis = frame.shaft.xyz;
  float b = dot(toLight, axis), denominator = max(1.0 - b * b, 1e-4);
  float s = clamp((b * dot(toLight, o) - dot(axis, o)) / denominator, 0.0, frame.shaft.w);
  vec3 q = o + axis * s;
  float t = dot(q, toLight);
  float thick = mix(frame.shaftRadii.x, frame.shaftRadii.y, smoothstep(0.0, 0.35, s / frame.shaft.w));
  float softness = 0.25 * thick + 0.05 * max(t, 0.0);
  float gap = length(q - toLight * t);
  float rod = (1.0 - smoothstep(thick - softness, thick + softness, gap)) * smoothstep(0.0, thick, t) *
              clamp(thick / softness, 0.0, 1.0);
  return (1.0 - 0.92 * ball) * (1.0 - 0.75 * rod);
}

// Sky that the ball hides from a point (a sphere's form factor).
float ballOcclusion(vec3 rel, vec3 n) {
  if (frame.ball.w <= 0.0) return 0.0;
  vec3 o = frame.ball.xyz - rel;
  float d2 = max(dot(o, o), frame.ball.w * frame.ball.w);
  return clamp(dot(n, o) * inversesqrt(d2), 0.0, 1.0) * frame.ball.w * frame.ball.w / d2;
}

// Cavity is computed at the picture's size, this pass is finer: average what lies on the same piece of surface.
vec2 cavityAt(float z) {
  ivec2 size = textureSize(cavityMap, 0);
  vec2 at = (ndc * 0.5 + 0.5) * vec2(size) - 0.5;
  ivec2 base = ivec2(floor(at));
  vec2 sum = vec2(0.0);
  float weights = 1e-6;
  for (int y = -1; y <= 2; ++y) {
    for (int x = -1; x <= 2; ++x) {
      ivec2 tap = clamp(base + ivec2(x, y), ivec2(0), size - 1);
      ivec2 deep = clamp(ivec2((vec2(tap) + 0.5) / vec2(size) * frame.size.xy), ivec2(0), ivec2(frame.size.xy) - 1);
      float d = texelFetch(depthMap, deep, 0).r;
      if (d <= 0.0) continue;
      float away = abs(distanceOf(d) - z) / (mmPerSample(z) * 12.0 * frame.size.z);
      float w = max(1.0 - away, 0.001);
      sum += w * texelFetch(cavityMap, tap, 0).rg;
      weights += w;
    }
  }
  return sum / weights;
}

// The dot where the beam lands and the ring of the ball's size around it; the ring fades where the surface runs along the
// beam and would draw it out.
void landing(vec3 rel, vec3 n, inout vec3 c) {
  if (frame.ball.w <= 0.0 || frame.drop.w <= 0.0) return;
  vec3 o = rel - frame.ball.xyz;
  float along = dot(o, frame.drop.xyz);
  float aside = length(o - along * frame.drop.xyz);
  if (abs(along - frame.drop.w) > 1.5 * frame.ball.w + 2.0 * frame.marker.x) return;
  vec3 tint = frame.shaftRadii.z > 0.5 ? kBeamTouch : kBeamFree;
  float edge = frame.marker.y;
  float away = length(o - frame.drop.w * frame.drop.xyz);
  float point = 1.0 - smoothstep(frame.marker.x - edge, frame.marker.x + edge, away);
  float halo = 1.0 - smoothstep(frame.marker.x + edge, frame.marker.x + 3.0 * edge, away);
  float facing = smoothstep(0.10, 0.45, -dot(n, frame.drop.xyz));
  float ring = facing * (1.0 - smoothstep(0.6 * edge, 1.6 * edge, abs(aside - frame.ball.w)));
  c = mix(c, c * 0.35, 0.5 * halo);
  c = mix(c, tint, 0.6 * ring);
  c = mix(c, mix(tint, vec3(1.0), 0.35), point);
}

vec3 shadeClay(vec3 rel, vec3 n, vec3 toEye, float z) {
  vec3 toKey = frame.keyLight.xyz;
  float cursor = cursorVisible(rel);
  float shadow = keyVisible(rel, n) * cursor;
  float nk = dot(n, toKey), nv = clamp(dot(n, toEye), 0.0, 1.0);
  vec2 cavity = frame.marker.z > 0.0 ? cavityAt(z) * frame.marker.z : vec2(0.0);
  float hollow = 1.0 - exp(-2.2 * cavity.x);

  // Clay scatters a little under its skin: light wraps around the edge, and is redder there.
  vec3 wrap = vec3(0.22, 0.10, 0.06);
  vec3 key = clamp((vec3(nk) + wrap) / (1.0 + wrap), 0.0, 1.0) * shadow * kKey;
  vec3 toFill = normalize(frame.cameraRight.xyz * 0.85 + frame.cameraUp.xyz * 0.1 - frame.cameraForward.xyz * 0.55);
  vec3 fill = clamp(dot(n, toFill) * 0.75 + 0.25, 0.0, 1.0) * kFill;
  vec3 dome = mix(kGroundLight, kSky, n.z * 0.5 + 0.5) * (1.0 - 0.75 * ballOcclusion(rel, n));
  dome += 0.10 * nv;  // seen from below, clay still has a lit face
  // The cursor's shadow is a cue for depth: it darkens the rest of the light a little too.
  vec3 ambient = (fill + dome) * (1.0 - 0.75 * hollow) * mix(0.62, 1.0, cursor);

  vec3 albedo = kClay * mix(vec3(1.0), vec3(0.50, 0.36, 0.32), hollow) * (1.0 + 0.55 * cavity.y);
  vec3 c = albedo * (key * (1.0 - 0.45 * hollow) + ambient);

  // A broad soft highlight, and a thin bright rim.
  vec3 h = normalize(toKey + toEye);
  float gloss = pow(clamp(dot(n, h), 0.0, 1.0), 26.0) * 0.16 * shadow * step(0.0, nk);
  float fresnel = pow(1.0 - nv, 4.0);
  c += (gloss * kKey * 0.5 + fresnel * mix(kGroundLight, kSky, n.z * 0.5 + 0.5) * vec3(0.36, 0.29, 0.24)) * (1.0 - 0.6 * hollow);
  return toneMap(c * 0.90);
}

// Coverage of lines `spacing` apart at a coordinate in mm; `footprint` is the mm that one sample spans.
float lines(float x, float spacing, float footprint, float width) {
  float away = abs(fract(x / spacing + 0.5) - 0.5) * spacing;
  float halfWidth = 0.5 * width * footprint;
  return clamp((halfWidth - away) / footprint + 0.5, 0.0, 1.0) * clamp(1.6 - 5.0 * footprint * width / spacing, 0.0, 1.0);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float d = texelFetch(depthMap, at, 0).r;
  float z = d > 0.0 ? distanceOf(d) : 3.0e38;

  float rise = ndc.y * 0.5 + 0.5;
  vec3 back = mix(vec3(0.058, 0.066, 0.080), vec3(0.020, 0.022, 0.026), smoothstep(0.0, 1.0, rise));
  back *= 1.0 - 0.22 * dot(ndc * vec2(0.8, 0.6), ndc * vec2(0.8, 0.6));
  vec3 c = back;

  vec3 rayFrom = frame.scale.z > 0.5 ? vec3(0.0) : fromView(viewAt(ndc, 0.0));
  vec3 rayTo = frame.scale.z > 0.5 ? fromView(viewAt(ndc, 1.0)) : frame.cameraForward.xyz;
  vec3 toEye = -normalize(rayTo);

  if (d > 0.0) {
    vec3 rel = rayFrom + rayTo * z;
    vec3 n = fromView(unpackOctahedral(texelFetch(normalMap, at, 0).rg));
    c = shadeClay(rel, n, toEye, z);
    landing(rel, n, c);
  }

  if (frame.ground.w > 0.5) {
    vec3 normal = cross(frame.gridU.xyz, frame.gridV.xyz);
    float slope = dot(normal, rayTo);
    float t = dot(normal, frame.ground.xyz - rayFrom) / (abs(slope) > 1e-9 ? slope : 1e-9);
    vec3 rel = rayFrom + rayTo * t;
    vec2 p = vec2(dot(frame.gridU.xyz, rel - frame.ground.xyz), dot(frame.gridV.xyz, rel - frame.ground.xyz));
    vec2 footprint = max(fwidth(p), vec2(1e-12));
    bool hit = t > 0.0 && t < z;
    if (hit) {
      bool facing = frame.ground.w > 1.5;
      bool below = !facing && slope > 0.0;
      float fade = 1.0 - smoothstep(0.35, 1.0, length(rel - frame.gridFade.xyz) / frame.gridFade.w);
      if (facing) fade = 1.0;
      if (!facing && !below) {
        float light = keyVisible(rel, normal) * cursorVisible(rel);
        float shade = (1.0 - light) * 0.55 + 0.35 * ballOcclusion(rel, normal);
        c = mix(c, vec3(0.074, 0.075, 0.079), 0.75 * fade);
        c *= 1.0 - clamp(shade, 0.0, 0.8);
      }
      float px = frame.size.z * frame.size.w;  // samples a line of one interface pixel
      float minor = max(lines(p.x, frame.gridU.w, footprint.x, px), lines(p.y, frame.gridU.w, footprint.y, px));
      float major = max(lines(p.x, frame.gridV.w, footprint.x, 1.5 * px), lines(p.y, frame.gridV.w, footprint.y, 1.5 * px));
      float strength = fade * (below ? 0.35 : 1.0);
      c = mix(c, vec3(0.30, 0.32, 0.35), 0.20 * minor * strength);
      c = mix(c, vec3(0.50, 0.53, 0.57), 0.34 * major * strength);
      if (!facing && !below) landing(rel, normal, c);
    }
  }
  colour = vec4(c, 1.0);
}
