#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 viewNormal;
layout(location = 1) in float cut;           // above zero: beyond the section plane
layout(location = 2) in vec3 colour;         // display-linear
layout(location = 3) in flat float material; // its code, negative for open meshes
layout(location = 4) in float onCrease;
layout(location = 5) in vec3 viewPosition;
layout(location = 0) out vec2 packedNormal;  // along the axes of the eye between both
layout(location = 1) out vec4 albedo;

void main() {
  // A vertex on a crease has a normal for each face, which is about that of its triangle.
  // Towards the eye: rows of the picture go down, and the third axis goes away from the eye. Derivatives are known only
  // where all pixels of a quad ask for them.
  vec3 facet = cross(dFdx(viewPosition), dFdy(viewPosition));
  vec3 n = viewNormal;
  if (onCrease > 0.0) {
    vec3 own = normalize(gl_FrontFacing ? facet : -facet);
    // A sliver beside a crease may face anywhere: what its other corners say of the face then counts.
    float others = 1.0 - onCrease;
    float trust = others > 0.001 ? smoothstep(0.0, 0.3, dot(own, normalize(n))) : 1.0;
    n += onCrease * mix(n / max(others, 0.001), own, trust);
  }
  n = normalize(n);
  float code = abs(material);
  if (kSection && cut > 0.0) discard;
  if (!gl_FrontFacing) {
    if (material < 0.0) {
      n = -n;
    } else if (kSection) {
      // The inner side of what is closed stands for the cut face before it: cap.frag moves it there.
      n = toMiddle(frame.section.xyz);
      code = 0.0;
    }
  }
  packedNormal = packOctahedral(n);
  albedo = vec4(sqrt(colour), code);
}
