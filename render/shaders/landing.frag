#version 460
// The dot where the beam lands and the ring of the ball's size around it, painted on clay or ground; the ring fades where the
// surface runs along the beam and would draw it out. Blended as premultiplied alpha, within a rectangle that holds them.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(set = 0, binding = 1) uniform sampler2DArray depthMap;
layout(set = 0, binding = 2) uniform sampler2DArray normalMap;
layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 colour;

void main() {
  ivec3 at = ivec3(gl_FragCoord.xy, eyeIndex());
  float d = texelFetch(depthMap, at, 0).r;
  float z = d > 0.0 ? distanceOf(d) : 3.0e38;
  vec3 from, to;
  sight(ndc, from, to);
  vec3 n = fromMiddle(unpackOctahedral(texelFetch(normalMap, at, 0).rg));
  if (kGround == 1) {
    vec3 up = cross(frame.gridU.xyz, frame.gridV.xyz);
    float slope = dot(up, to);
    float t = slope < 0.0 ? dot(up, frame.ground.xyz - from) / slope : -1.0;
    if (t > 0.0 && t < z) {
      z = t;
      n = up;
    }
  }
  vec3 o = from + to * z - frame.ball.xyz;
  float along = dot(o, frame.drop.xyz), edge = frame.marker.y;
  if (z > 1.0e38 || abs(along - frame.drop.w) > 1.5 * frame.ball.w + 2.0 * frame.marker.x) discard;
  float aside = length(o - along * frame.drop.xyz), away = length(o - frame.drop.w * frame.drop.xyz);
  float point = 1.0 - smoothstep(frame.marker.x - edge, frame.marker.x + edge, away);
  float halo = 1.0 - smoothstep(frame.marker.x + edge, frame.marker.x + 3.0 * edge, away);
  float facing = smoothstep(0.10, 0.45, -dot(n, frame.drop.xyz));
  float ring = 0.6 * facing * (1.0 - smoothstep(0.6 * edge, 1.6 * edge, abs(aside - frame.ball.w)));
  // A dark halo, the ring over it, the point with its white heart over both.
  vec3 tint = frame.tint.xyz;
  float left = (1.0 - 0.325 * halo) * (1.0 - ring) * (1.0 - point);
  colour = vec4(mix(tint * ring, mix(tint, vec3(1.0), 0.35), point), 1.0 - left);
}
