#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 viewNormal;
layout(location = 0) out vec2 packedNormal;

void main() { packedNormal = packOctahedral(normalize(viewNormal)); }
