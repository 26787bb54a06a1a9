// A piece of clay or a part. Vertices are integers, counted in units from its own zero; an anchor near the eye is subtracted before
// anything is rounded.
layout(push_constant) uniform Piece {
  ivec3 anchor;     // in units
  float unit;       // mm a unit
  vec3 anchorRel;   // the anchor in mm, relative to the eye, along the world's axes
  float grown;      // mm along the normals: a preview of what becomes thicker
  vec4 rotation;    // unit quaternion, piece to world
  vec4 scale;       // along the world's axes, after the rotation
  vec4 surface;     // as clay.frag reads it
} piece;

vec3 turned(vec3 v) {
  return v + 2.0 * cross(piece.rotation.xyz, cross(piece.rotation.xyz, v) + piece.rotation.w * v);
}
// Of the piece's own axes, in the world; unit length.
vec3 pieceNormal(vec2 normal) {
  vec3 n = turned(unpackOctahedral(normal));
  return piece.scale.xyz == vec3(1.0) ? n : normalize(n / piece.scale.xyz);
}
vec3 piecePosition(ivec3 position, vec2 normal) {
  vec3 p = vec3(position - piece.anchor) * piece.unit;
  if (piece.grown != 0.0) p += piece.grown * unpackOctahedral(normal);
  return piece.scale.xyz * turned(p) + piece.anchorRel;
}
