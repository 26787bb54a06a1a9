// The key light's shadows, and what the cursor throws on clay and ground.
layout(set = 0, binding = 4) uniform sampler2DShadow shadowMap;

// Part of the key light that the clay lets through, 0…1.
float keyVisible(vec3 rel, vec3 n) {
  if (!kKeyShadow) return 1.0;
  vec2 texel = 1.0 / vec2(textureSize(shadowMap, 0));
  // Step off the surface by a few texels of the map, more where light grazes.
  float texelMm = 2.0 * texel.x / length(frame.shadowX.xyz);
  float slope = 1.0 - clamp(dot(n, frame.keyLight.xyz), 0.0, 1.0);
  vec4 p = vec4(rel + n * texelMm * (1.5 + 3.0 * slope), 1.0);
  vec3 s = vec3(dot(frame.shadowX, p), dot(frame.shadowY, p), dot(frame.shadowZ, p));
  s.z = min(s.z, 1.0);  // beyond the clay, where the map is empty, nothing shades
  float lit = 0.0, turn = interleavedNoise(gl_FragCoord.xy) * 6.2831853;
  for (int i = 0; i < 8; ++i) {
    float angle = turn + 2.39996323 * float(i), r = 4.5 * sqrt((float(i) + 0.5) / 8.0);
    lit += texture(shadowMap, vec3(s.xy * 0.5 + 0.5 + texel * r * vec2(cos(angle), sin(angle)), s.z));
  }
  return any(greaterThan(abs(s.xy), vec2(1.0))) ? 1.0 : lit / 8.0;
}

// Part of the key light that the cursor's ball and shaft let through.
float cursorVisible(vec3 rel) {
  if (!kCursorShadow) return 1.0;
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
  if (!kCursorShadow) return 0.0;
  vec3 o = frame.ball.xyz - rel;
  float d2 = max(dot(o, o), frame.ball.w * frame.ball.w);
  return clamp(dot(n, o) * inversesqrt(d2), 0.0, 1.0) * frame.ball.w * frame.ball.w / d2;
}
