// What every pass of one picture knows. Mirrors FrameUniforms (render/renderer/frame.h). Positions are in mm relative to the eye
// between both eyes, along the world's axes ("rel"), so that floats suffice far from the origin.
#extension GL_EXT_multiview : require

// Mirrors Variant (render/renderer/pipelines.h): what a picture does not use is not even compiled.
layout(constant_id = 0) const int kEye = 0;  // whose picture; 2: both, a view each
layout(constant_id = 1) const bool kPerspective = true;
layout(constant_id = 2) const int kShading = 1;  // as Shading
layout(constant_id = 3) const int kMatcap = 0;   // as Matcap
layout(constant_id = 4) const bool kKeyShadow = false;
layout(constant_id = 5) const bool kCavity = false;
layout(constant_id = 6) const bool kCursorShadow = false;
layout(constant_id = 7) const bool kDepthFade = false;
layout(constant_id = 8) const bool kSection = false;
layout(constant_id = 9) const int kGround = 0;  // as FramePlan::Ground
layout(constant_id = 10) const int kStereoMode = 0;       // as StereoMode
layout(constant_id = 11) const int kSamples = 1;          // a pixel along an axis

struct Eye {
  vec4 right, up, forward;  // xyz
  vec4 place;               // xyz: rel; w: shift of the picture, −1…1 across it
};

layout(set = 0, binding = 0, std140) uniform Frame {
  vec4 cameraRight;    // xyz; of the eye between both, which light, materials and labels follow
  vec4 cameraUp;       // xyz
  vec4 cameraForward;  // xyz
  Eye eyes[2];         // without stereo the first is the one
  vec4 scale;          // x, y: clip = view · scale; z: 1 for perspective; w: mm per sample at distance 1 (or everywhere)
  vec4 depth;          // clip z = x · z + y, clip w = z · z + w  of the distance z along the view
  vec4 size;           // pixels of the pass's full-size targets; z: samples a pixel along an axis; w: interface scale
  vec4 keyLight;       // xyz: unit, to the light; w: 1 when there is a shadow map
  vec4 shadowX, shadowY, shadowZ;  // rows: rel, 1 → shadow map −1…1, −1…1, 0…1
  vec4 ground;         // xyz: a crossing of major lines, rel; w: 1 lines on the ground, 2 lines facing the viewer, 0 none
  vec4 gridU, gridV;   // xyz: unit axes of the lines; w of U: minor spacing, of V: major spacing in mm
  vec4 gridFade;       // xyz: rel centre of the fade; w: its radius
  vec4 ball;           // xyz rel centre, w radius (0: no cursor)
  vec4 shaft;          // xyz unit direction, w length
  vec4 shaftRadii;     // x at the ball, y at the end
  vec4 drop;           // xyz unit direction of the beam, w its length (0: none)
  vec4 marker;         // x: dot radius, y: ring's half width in mm; z: cavity strength; w: clay present
  vec4 tint;           // xyz: the tool's colour, display-linear
  vec4 section;        // cut away where dot(xyz, rel) + w > 0
  vec4 fade;           // x: distance where the clay begins, y: 1 / its depth, z: strength of the depth fade
  vec4 backTop, backBottom;   // xyz: the background; w of top: how much darker its corners are
  vec4 groundColour;          // w: cover
  vec4 minorLine, majorLine;  // w: cover
  vec4 planes[4];      // planes that the clay shows: xyz unit normal, dot(xyz, rel) + w is the distance
  vec4 planeLines[4];  // colour of the line where the clay meets them; w: cover, 0 none
  vec4 planeTints[4];  // colour on the side of the normal; w: cover, 0 none
  vec4 planeSizes[4];  // x: half the line's width in pixels at a height of 720; y: 0 where dimmed pieces show nothing; z of the first: how many planes there are
} frame;

int eyeIndex() { return kEye == 2 ? gl_ViewIndex : kEye; }
// Chosen by value: an index that is not constant makes some drivers gather.
Eye eye() {
  Eye e = frame.eyes[0];
  if (kEye == 1 || (kEye == 2 && gl_ViewIndex == 1)) e = frame.eyes[1];
  return e;
}

// Along the axes of the eye between both.
vec3 toMiddle(vec3 direction) {
  return vec3(dot(frame.cameraRight.xyz, direction), dot(frame.cameraUp.xyz, direction), dot(frame.cameraForward.xyz, direction));
}
vec3 fromMiddle(vec3 v) {
  return frame.cameraRight.xyz * v.x + frame.cameraUp.xyz * v.y + frame.cameraForward.xyz * v.z;
}
vec3 fromView(vec3 v) {
  Eye e = eye();
  return e.right.xyz * v.x + e.up.xyz * v.y + e.forward.xyz * v.z;
}
vec4 toClip(vec3 rel) {
  Eye e = eye();
  vec3 p = rel - e.place.xyz;
  float z = dot(e.forward.xyz, p);
  float w = frame.depth.z * z + frame.depth.w;
  return vec4(dot(e.right.xyz, p) * frame.scale.x + e.place.w * w, -dot(e.up.xyz, p) * frame.scale.y, frame.depth.x * z + frame.depth.y, w);
}
// Distance along the view of a depth buffer's value (reversed: 1 near, 0 nothing).
float distanceOf(float d) {
  return (frame.depth.y - d * frame.depth.w) / (d * frame.depth.z - frame.depth.x);
}
// Point in the eye's axes at a picture position (−1…1, y down) and a distance along the view.
vec3 viewAt(vec2 ndc, float z) {
  float w = frame.depth.z * z + frame.depth.w;
  return vec3((ndc.x - eye().place.w) * w / frame.scale.x, -ndc.y * w / frame.scale.y, z);
}
// The ray of sight through a picture position: rel = from + to · distance along the view.
void sight(vec2 ndc, out vec3 from, out vec3 to) {
  Eye e = eye();
  from = e.place.xyz;
  if (kPerspective) {
    to = fromView(viewAt(ndc, 1.0));
  } else {
    from += fromView(viewAt(ndc, 0.0));
    to = e.forward.xyz;
  }
}
// mm that one sample covers at a distance along the view.
float mmPerSample(float z) {
  return frame.scale.w * (kPerspective ? max(z, 1e-9) : 1.0);
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

float interleavedNoise(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }
// Spreads the rounding to 8 bits of sRGB, so that gradients do not band: half a step either way.
vec3 dithered(vec3 c, vec2 place) {
  return c + sqrt(max(c, 0.0015)) * ((interleavedNoise(place) - 0.5) * (2.0 / 255.0));
}

// The background at a picture position.
vec3 backdrop(vec2 ndc) {
  vec3 c = mix(frame.backTop.xyz, frame.backBottom.xyz, smoothstep(-1.0, 1.0, ndc.y));
  vec2 corner = ndc * vec2(0.8, 0.6);
  return c * (1.0 - frame.backTop.w * dot(corner, corner));
}
// Part of what is seen at a distance along the view that gives way to the background.
float fadeAt(float z) {
  return kDepthFade ? frame.fade.z * clamp((z - frame.fade.x) * frame.fade.y, 0.0, 1.0) : 0.0;
}
