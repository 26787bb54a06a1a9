#version 460
// A corner of a panel's triangle.
layout(push_constant) uniform Panels { vec2 size; } panels;  // interface units over the whole picture

layout(location = 0) in vec2 place;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 colour;  // sRGB, straight alpha: blended as it is
layout(location = 0) out vec2 texel;
layout(location = 1) out vec4 tint;

void main() {
  texel = uv;
  tint = colour;
  gl_Position = vec4(2.0 * place / panels.size - 1.0, 0.0, 1.0);
}
