#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 rel;
layout(location = 1) in vec3 normalIn;
layout(location = 2) in float along;
layout(location = 0) out vec4 colour;

void main() {
  vec3 n = normalize(normalIn);
  vec3 toEye = kPerspective ? normalize(eye().place.xyz - rel) : -eye().forward.xyz;
  if (dot(n, toEye) < 0.0) n = -n;
  float lit = clamp(dot(n, frame.keyLight.xyz) * 0.7 + 0.3, 0.0, 1.0);
  vec3 h = normalize(frame.keyLight.xyz + toEye);
  float shine = pow(clamp(dot(n, h), 0.0, 1.0), 40.0);
  vec3 tint = frame.tint.xyz;
  vec3 metal = vec3(0.62, 0.64, 0.67), barrel = vec3(0.085, 0.09, 0.10);
  vec3 base = mix(metal, barrel, smoothstep(0.27, 0.29, along));
  base = mix(base, tint * 0.8, smoothstep(0.385, 0.39, along) - smoothstep(0.415, 0.42, along));
  float rim = pow(1.0 - clamp(dot(n, toEye), 0.0, 1.0), 3.0);
  colour = vec4(toneMap(base * (0.35 + 1.1 * lit) + shine * 0.35 + rim * 0.10), 1.0);
}
