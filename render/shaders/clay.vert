#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "chunk.glsl"

layout(location = 0) in ivec3 position;
layout(location = 1) in vec2 normal;
layout(location = 2) in vec4 paint;  // PackedPaint (render/surface/surface_layout.h)
layout(location = 0) out vec3 viewNormal;
layout(location = 1) out float cut;
layout(location = 2) out vec3 colour;
layout(location = 3) out flat float material;
layout(location = 4) out float onCrease;     // the lowest bit of PackedNormal::v
layout(location = 5) out vec3 viewPosition;  // as viewNormal

void main() {
  vec3 rel = piecePosition(position, normal);
  onCrease = float(int(round(normal.y * 32767.0)) & 1);
  viewNormal = (1.0 - onCrease) * toMiddle(pieceNormal(normal));
  viewPosition = toMiddle(rel);
  cut = dot(frame.section, vec4(rel, 1.0));
  colour = piece.surface.rgb * paint.a + paint.rgb * paint.rgb;
  material = piece.surface.a;
  gl_Position = toClip(rel);
}
