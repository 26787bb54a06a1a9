#version 460
// Clay as the key light sees it.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "chunk.glsl"

layout(location = 0) in ivec3 position;
layout(location = 1) in vec2 normal;
layout(location = 0) out float cut;

void main() {
  vec4 rel = vec4(piecePosition(position, normal), 1.0);
  cut = dot(frame.section, rel);
  gl_Position = vec4(dot(frame.shadowX, rel), dot(frame.shadowY, rel), dot(frame.shadowZ, rel), 1.0);
}
