#version 460
// Averages the samples of a pixel, encodes sRGB, and spreads rounding so that gradients do not band.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(set = 0, binding = 5) uniform sampler2D picture;
layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 colour;

void main() {
  int n = int(frame.size.z);
  ivec2 base = ivec2(gl_FragCoord.xy) * n;
  vec3 sum = vec3(0.0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) sum += texelFetch(picture, base + ivec2(x, y), 0).rgb;
  vec3 c = clamp(sum / float(n * n), 0.0, 1.0);
  vec3 encoded = mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, c * 12.92, lessThan(c, vec3(0.0031308)));
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  colour = vec4(encoded + noise / 255.0, 1.0);
}
