#version 460
// The ground with its lines, and the shadows on it. From above it is drawn over the background alone; from below it is blended over
// clay, as premultiplied alpha.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "light.glsl"

layout(location = 0) in vec3 rel;
layout(location = 0) out vec4 colour;

// Coverage of lines `spacing` apart at a coordinate in mm; `perMm` samples along it, lines `width` samples wide.
float lines(float x, float spacing, float perMm, float width) {
  float period = spacing * perMm;  // samples
  float away = abs(fract(x / spacing + 0.5) - 0.5) * period;
  return clamp(0.5 * width - away + 0.5, 0.0, 1.0) * clamp(1.6 - 5.0 * width / period, 0.0, 1.0);
}

void over(inout vec4 c, vec3 tint, float cover) { c = vec4(mix(c.rgb, tint, cover), mix(c.a, 1.0, cover)); }

void main() {
  vec2 p = vec2(dot(frame.gridU.xyz, rel - frame.ground.xyz), dot(frame.gridV.xyz, rel - frame.ground.xyz));
  vec2 perMm = 1.0 / max(fwidth(p), vec2(1e-12));
  vec3 normal = cross(frame.gridU.xyz, frame.gridV.xyz);
  float fade = kGround == 2 ? 1.0 : 1.0 - smoothstep(0.35, 1.0, length(rel - frame.gridFade.xyz) / frame.gridFade.w);
  if (kDepthFade && kGround != 2) fade *= 1.0 - fadeAt(dot(eye().forward.xyz, rel - eye().place.xyz));
  bool solid = kGround == 1;
  vec4 c = vec4(0.0);
  if (solid) {
    over(c, frame.groundColour.xyz, frame.groundColour.w * fade);
    float light = keyVisible(rel, normal) * cursorVisible(rel);
    float shade = clamp((1.0 - light) * 0.55 + 0.35 * ballOcclusion(rel, normal), 0.0, 0.8);
    c = vec4(c.rgb * (1.0 - shade), mix(c.a, 1.0, shade));
  }
  float px = frame.size.z * frame.size.w;  // samples a line of one interface pixel
  float minor = max(lines(p.x, frame.gridU.w, perMm.x, px), lines(p.y, frame.gridU.w, perMm.y, px));
  float major = max(lines(p.x, frame.gridV.w, perMm.x, 1.5 * px), lines(p.y, frame.gridV.w, perMm.y, 1.5 * px));
  float strength = fade * (kGround == 3 ? 0.35 : 1.0);
  over(c, frame.minorLine.xyz, frame.minorLine.w * minor * strength);
  over(c, frame.majorLine.xyz, frame.majorLine.w * major * strength);
  if (kGround != 3) c = vec4(c.rgb + backdrop(gl_FragCoord.xy / frame.size.xy * 2.0 - 1.0) * (1.0 - c.a), 1.0);
  colour = vec4(c.a > 0.0 ? dithered(c.rgb, gl_FragCoord.xy) : vec3(0.0), c.a);
}
