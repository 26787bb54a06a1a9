#version 460
// The ground with its lines, and the shadows on it. Blended as premultiplied alpha.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "light.glsl"

layout(location = 0) in vec3 rel;
layout(location = 0) out vec4 colour;

// Coverage of lines `spacing` apart at a coordinate in mm; `footprint` is the mm that one sample spans.
float lines(float x, float spacing, float footprint, float width) {
  float away = abs(fract(x / spacing + 0.5) - 0.5) * spacing;
  float halfWidth = 0.5 * width * footprint;
  return clamp((halfWidth - away) / footprint + 0.5, 0.0, 1.0) * clamp(1.6 - 5.0 * footprint * width / spacing, 0.0, 1.0);
}

void over(inout vec4 c, vec3 tint, float cover) { c = vec4(mix(c.rgb, tint, cover), mix(c.a, 1.0, cover)); }

void main() {
  vec2 p = vec2(dot(frame.gridU.xyz, rel - frame.ground.xyz), dot(frame.gridV.xyz, rel - frame.ground.xyz));
  vec2 footprint = max(fwidth(p), vec2(1e-12));
  vec3 normal = cross(frame.gridU.xyz, frame.gridV.xyz);
  bool below = kPerspective ? dot(normal, rel - eye().place.xyz) > 0.0 : dot(normal, eye().forward.xyz) > 0.0;
  float fade = kFacingGrid ? 1.0 : 1.0 - smoothstep(0.35, 1.0, length(rel - frame.gridFade.xyz) / frame.gridFade.w);
  if (kDepthFade && !kFacingGrid) fade *= 1.0 - fadeAt(dot(eye().forward.xyz, rel - eye().place.xyz));
  bool solid = !kFacingGrid && !below;
  vec4 c = vec4(0.0);
  if (solid) {
    over(c, frame.groundColour.xyz, frame.groundColour.w * fade);
    float light = keyVisible(rel, normal) * cursorVisible(rel);
    float shade = clamp((1.0 - light) * 0.55 + 0.35 * ballOcclusion(rel, normal), 0.0, 0.8);
    c = vec4(c.rgb * (1.0 - shade), mix(c.a, 1.0, shade));
  }
  float px = frame.size.z * frame.size.w;  // samples a line of one interface pixel
  float minor = max(lines(p.x, frame.gridU.w, footprint.x, px), lines(p.y, frame.gridU.w, footprint.y, px));
  float major = max(lines(p.x, frame.gridV.w, footprint.x, 1.5 * px), lines(p.y, frame.gridV.w, footprint.y, 1.5 * px));
  float strength = fade * (below && !kFacingGrid ? 0.35 : 1.0);
  over(c, frame.minorLine.xyz, frame.minorLine.w * minor * strength);
  over(c, frame.majorLine.xyz, frame.majorLine.w * major * strength);
  if (solid) {
    float beneath;
    vec4 mark = landing(rel, normal, beneath);
    c = vec4(c.rgb * beneath, 1.0 - (1.0 - c.a) * beneath);
    c = vec4(c.rgb * (1.0 - mark.w) + mark.rgb, 1.0 - (1.0 - c.a) * (1.0 - mark.w));
  }
  colour = vec4(c.a > 0.0 ? dithered(c.rgb, gl_FragCoord.xy) : vec3(0.0), c.a);
}
