#version 460
// What the section cuts away throws no shadow.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in float cut;

void main() {
  if (kSection && cut > 0.0) discard;
}
