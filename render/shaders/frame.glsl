// What every pass of one picture knows. Mirrors FrameUniforms (render/frame.h). Positions are in mm relative to the eye
// along the world's axes ("rel"), so that floats suffice far from the origin.
layout(set = 0, binding = 0, std140) uniform Frame {
  vec4 cameraRight;    // xyz
  vec4 cameraUp;       // xyz
  vec4 cameraForward;  // xyz
  vec4 scale;          // x, y: clip = view · scale; z: 1 for perspective; w: mm per pixel at distance 1 (or everywhere)
  vec4 depth;          // clip z = x · z + y, clip w = z · z + w  of the distance z along the view
  vec4 size;           // pixels of the pass's full-size targets; z: samples a pixel along an axis; w: interface scale
  vec4 keyLight;       // xyz: unit, to the light; w: 1 when there is a shadow map
  vec4 shadowX, shadowY, shadowZ;  // rows: rel, 1 → shadow map −1…1, −1…1, 0…1
  vec4 ground;         // xyz: a crossing of major lines, rel; w: 1 lines on the ground, 2 lines facing the viewer, 0 none
  vec4 gridU, gridV;   // xyz: unit axes of the lines; w of U: minor spacing, of V: major spacing in mm
  vec4 gridFade;       // xyz: rel centre of the fade; w: its radius
  vec4 ball;           // xyz rel centre, w radius (0: no cursor)
  vec4 shaft;          // xyz unit direction, w length
  vec4 shaftRadii;     // x at the ball, y at the end; z: 1 in contact; w: visible softness
  vec4 drop;           // xyz unit direction of the beam, w its length (0: none)
  vec4 marker;         // x: dot radius, y: ring's half width in mm; z: cavity strength; w: clay present
} frame;

const vec3 kBeamFree = vec3(0.10, 0.62, 0.95);
const vec3 kBeamTouch = vec3(1.0, 0.46, 0.07);

vec3 toView(vec3 rel) {
  return vec3(dot(frame.cameraRight.xyz, rel), dot(frame.cameraUp.xyz, rel), dot(frame.cameraForward.xyz, rel));
}
vec3 fromView(vec3 v) {
  return frame.cameraRight.xyz * v.x + frame.cameraUp.xyz * v.y + frame.cameraForward.xyz * v.z;
}
vec4 toClip(vec3 rel) {
  vec3 v = toView(rel);
  return vec4(v.x * frame.scale.x, -v.y * frame.scale.y, frame.depth.x * v.z + frame.depth.y,
              frame.depth.z * v.z + frame.depth.w);
}
// Distance along the view of a depth buffer's value (reversed: 1 near, 0 nothing).
float distanceOf(float d) {
  return (frame.depth.y - d * frame.depth.w) / (d * frame.depth.z - frame.depth.x);
}
// Point in view axes at a picture position (−1…1, y down) and a distance along the view.
vec3 viewAt(vec2 ndc, float z) {
  float w = frame.depth.z * z + frame.depth.w;
  return vec3(ndc.x * w / frame.scale.x, -ndc.y * w / frame.scale.y, z);
}
// mm that one sample covers at a distance along the view.
float mmPerSample(float z) {
  return frame.scale.w * (frame.scale.z > 0.5 ? max(z, 1e-9) : 1.0);
}

vec2 packOctahedral(vec3 n) {
  vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
  if (n.z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
  return p;
}
vec3 unpackOctahedral(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return normalize(n);
}

// Filmic curve (Narkowicz 2015, a fit of ACES) to display-linear 0…1.
vec3 toneMap(vec3 x) {
  return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}
