#version 460
// A rectangle that holds the cursor's ball; the fragment shader meets the ball itself.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) out vec3 ray;  // rel point on the rectangle

void main() {
  const vec2 corners[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));
  vec2 corner = corners[gl_VertexIndex];
  // Across the ball, facing the eye; in perspective the outline is a little larger than the radius.
  vec3 sightline = frame.ball.xyz - eye().place.xyz;
  float away = length(sightline);
  float grow = 1.05;
  vec3 x = eye().right.xyz, y = eye().up.xyz;
  if (kPerspective) {
    vec3 to = sightline / max(away, 1e-9);
    x = normalize(cross(to, abs(to.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0)));
    y = cross(x, to);
    float s = clamp(frame.ball.w / max(away, 1e-9), 0.0, 0.95);
    grow = 1.05 * inversesqrt(1.0 - s * s);
  }
  ray = frame.ball.xyz + (x * corner.x + y * corner.y) * frame.ball.w * grow;
  gl_Position = toClip(ray);
}
