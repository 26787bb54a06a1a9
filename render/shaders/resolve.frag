#version 460
// Averages the samples of a pixel and puts both eyes' pictures together. The target's format encodes sRGB.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(set = 0, binding = 5) uniform sampler2DArray picture;
layout(location = 0) out vec4 colour;

// Mean of a block of samples of one eye.
vec3 mean(ivec2 base, ivec2 count, int eye) {
  vec3 sum = vec3(0.0);
  for (int y = 0; y < count.y; ++y)
    for (int x = 0; x < count.x; ++x) sum += texelFetch(picture, ivec3(base + ivec2(x, y), eye), 0).rgb;
  return sum / float(count.x * count.y);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  const ivec2 n = ivec2(kSamples);
  vec3 c;
  if (kStereoMode == 1) {
    // Dubois' least-squares mix for red and cyan filters on a screen with sRGB primaries (site.uottawa.ca/~edubois/anaglyph).
    const mat3 left = mat3(0.437, -0.062, -0.048, 0.449, -0.062, -0.050, 0.164, -0.024, -0.017);
    const mat3 right = mat3(-0.011, 0.377, -0.026, -0.032, 0.761, -0.093, -0.007, 0.009, 1.234);
    c = left * mean(at * n, n, 0) + right * mean(at * n, n, 1);
  } else if (kStereoMode == 2) {
    int half_ = textureSize(picture, 0).x / (2 * kSamples);
    bool second = at.x >= half_;
    int x = min(2 * (second ? at.x - half_ : at.x), textureSize(picture, 0).x / kSamples - 2);
    c = mean(ivec2(x, at.y) * n, n * ivec2(2, 1), second ? 1 : 0);
  } else if (kStereoMode == 3) {
    int half_ = textureSize(picture, 0).y / (2 * kSamples);
    bool second = at.y >= half_;
    int y = min(2 * (second ? at.y - half_ : at.y), textureSize(picture, 0).y / kSamples - 2);
    c = mean(ivec2(at.x, y) * n, n * ivec2(1, 2), second ? 1 : 0);
  } else {
    c = mean(at * n, n, 0);
  }
  colour = vec4(clamp(dithered(clamp(c, 0.0, 1.0), gl_FragCoord.xy), 0.0, 1.0), 1.0);
}
