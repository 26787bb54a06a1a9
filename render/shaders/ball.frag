#version 460
// The cursor's ball: tinted glass with a bright rim, so that the clay beneath shows.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(push_constant) uniform Mode { float ghost; } mode;  // 1: the part that clay hides, faintly

layout(location = 0) in vec3 ray;
layout(location = 0) out vec4 colour;

void main() {
  vec3 from = kPerspective ? eye().place.xyz : ray - eye().forward.xyz * (4.0 * frame.ball.w);
  vec3 to = normalize(ray - from);
  vec3 o = from - frame.ball.xyz;
  float b = dot(o, to), c = dot(o, o) - frame.ball.w * frame.ball.w;
  // The usual b² − c loses all digits far from a small ball; the distance from the axis does not.
  vec3 aside = o - b * to;
  float h = frame.ball.w * frame.ball.w - dot(aside, aside);
  float edge = fwidth(h);
  if (h < -edge) discard;
  float cover = clamp(h / max(edge, 1e-20) + 0.5, 0.0, 1.0);
  vec3 rel = from + to * (-b - sqrt(max(h, 0.0)));
  vec4 clip = toClip(rel);
  gl_FragDepth = clamp(clip.z / clip.w, 0.0, 1.0);

  vec3 n = normalize(rel - frame.ball.xyz);
  float nv = clamp(-dot(n, to), 0.0, 1.0);
  vec3 tint = frame.tint.xyz;
  vec3 half_ = normalize(frame.keyLight.xyz - to);
  float rim = pow(1.0 - nv, 2.5);
  float shine = pow(clamp(dot(n, half_), 0.0, 1.0), 90.0);
  float lit = clamp(dot(n, frame.keyLight.xyz) * 0.5 + 0.5, 0.0, 1.0);
  vec3 body = tint * (0.16 + 0.62 * lit * lit);
  vec3 result = mix(body, mix(tint, vec3(1.0), 0.25), rim) + shine * 0.9;
  float alpha = mix(0.80, 1.0, rim) + shine;
  if (mode.ghost > 0.5) {
    result = tint;
    alpha = 0.10 + 0.35 * rim;
  }
  colour = vec4(clamp(result, 0.0, 1.0), clamp(alpha, 0.0, 1.0) * cover);
}
