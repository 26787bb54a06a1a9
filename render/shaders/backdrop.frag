#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 colour;  // display-linear

void main() { colour = vec4(dithered(backdrop(ndc), gl_FragCoord.xy), 1.0); }
