#version 460
// Faces of guides and widgets.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(push_constant) uniform Mode { float onScreen, strength; } mode;

layout(location = 0) in vec3 rel;
layout(location = 1) in vec4 colour;  // display-linear, alpha
layout(location = 0) out vec4 tint;

void main() {
  tint = vec4(colour.rgb, colour.a * mode.strength);
  gl_Position = toClip(rel);
}
