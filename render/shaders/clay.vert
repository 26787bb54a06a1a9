#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "chunk.glsl"

layout(location = 0) in ivec3 position;
layout(location = 1) in vec2 normal;
layout(location = 0) out vec3 viewNormal;

void main() {
  viewNormal = toView(unpackOctahedral(normal));
  gl_Position = toClip(chunkPosition(position));
}
