'use strict';
// Triangles are pulled from textures by number, so that points are sent once, every triangle has a mark
// that can be changed by itself, and its number is known where it is picked.

const PULL = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
uniform sampler2D points;      // x, y, z, thickness
uniform usampler2D corners;    // three points a triangle
uniform usampler2D marks;      // one a triangle
uniform mat4 both;
ivec2 place(uint n) { return ivec2(int(n & 2047u), int(n >> 11)); }
uint triangle() { return uint(gl_VertexID) / 3u; }
vec4 pull() {
  uvec3 all = texelFetch(corners, place(triangle()), 0).xyz;
  int k = gl_VertexID % 3;
  return texelFetch(points, place(k == 0 ? all.x : k == 1 ? all.y : all.z), 0);
}
`;

const FACE_VERTEX = PULL + `
out vec3 at;
out vec3 corner;
out float value;
flat out uint mark;
void main() {
  vec4 p = pull();
  int k = gl_VertexID % 3;
  at = p.xyz;
  value = p.w;
  corner = vec3(k == 0, k == 1, k == 2);
  mark = texelFetch(marks, place(triangle()), 0).x;
  gl_Position = both * vec4(p.xyz, 1.0);
}`;

const FACE_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
in vec3 at;
in vec3 corner;
in float value;
flat in uint mark;
out vec4 color;
uniform mat4 view;
uniform vec4 plane;            // cut away where dot(plane.xyz, at) > plane.w
uniform int what;              // 0 part, 1 sheets, 2 thickness
uniform float glass;           // 1 translucent
uniform float wire;            // strength of the edges
uniform float picked;          // number of the mark to stand out, -1 for none
uniform vec3 palette[9];
uniform vec3 ramp[5];
uniform vec2 range;            // thickness of the ramp's ends
uniform vec3 tints[4];         // wall, coping, preview, cut
vec3 shade(float s) {
  float x = clamp((s - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0) * 4.0;
  int k = min(int(x), 3);
  return mix(ramp[k], ramp[k + 1], x - float(k));
}
void main() {
  vec3 across = cross(dFdx(at), dFdy(at));
  vec3 spread = fwidth(corner);
  if (dot(plane.xyz, at) > plane.w) discard;
  vec3 normal = mat3(view) * normalize(across);
  float light = 0.44 + 0.4 * max(dot(normal, vec3(0.32, 0.48, 0.82)), 0.0) + 0.26 * abs(normal.z);
  vec3 base;
  float alpha = 1.0;
  if (what == 0) {
    bool coping = (mark & 1u) != 0u;
    bool preview = (mark & 2u) != 0u;
    base = coping ? tints[1] : tints[0];
    if (preview) base = mix(base, tints[2], 0.65);
    float rim = pow(1.0 - abs(normal.z), 2.5);
    if (glass > 0.5) alpha = (coping || preview) ? mix(0.4, 0.8, rim) : mix(0.09, 0.5, rim);
    else if (!gl_FrontFacing && plane.xyz != vec3(0.0)) { base = tints[3]; light = 0.95; }
  } else {
    base = what == 1 ? palette[int(mark & 15u)] : shade(value);
    if (picked >= 0.0 && (mark & 128u) == 0u) base = mix(base, vec3(dot(base, vec3(0.33))), 0.75);
  }
  vec3 lit = base * light;
  vec3 edge = smoothstep(vec3(0.0), spread * 1.25, corner);
  float line = (1.0 - min(min(edge.x, edge.y), edge.z)) * wire;
  lit = mix(lit, lit * 0.25, line);
  alpha = max(alpha, line * 0.5);
  color = vec4(lit, alpha);
}`;

const PICK_VERTEX = PULL + `
uniform uint bias;             // tells part from mid-surface
out vec3 at;
out float value;
flat out uint id;
void main() {
  vec4 p = pull();
  at = p.xyz;
  value = p.w;
  id = triangle() + 1u + bias;
  gl_Position = both * vec4(p.xyz, 1.0);
}`;

const PICK_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
in vec3 at;
in float value;
flat in uint id;
out uvec4 picked;              // id, thickness, depth
uniform vec4 plane;
void main() {
  if (dot(plane.xyz, at) > plane.w) discard;
  picked = uvec4(id, floatBitsToUint(value), floatBitsToUint(gl_FragCoord.z), 0u);
}`;

// Segments as strips of even width on the screen, one instance each.
const LINE_VERTEX = `#version 300 es
precision highp float;
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in float kind;
uniform mat4 both;
uniform vec2 screen;           // pixels
uniform float width;
uniform float lift;            // toward the eye, in shares of the depth
uniform float widths[4];
uniform vec3 colors[4];
out vec3 at;
out vec3 tint;
void main() {
  vec4 a = both * vec4(from, 1.0), b = both * vec4(to, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * screen;
  along = length(along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  bool end = (gl_VertexID & 1) == 1;
  float side = (gl_VertexID & 2) == 2 ? 1.0 : -1.0;
  int k = int(kind);
  vec2 off = (vec2(-along.y, along.x) * side + along * (end ? 1.0 : -1.0)) * 0.5 * width * widths[k];
  vec4 p = end ? b : a;
  at = end ? to : from;
  tint = colors[k];
  p.xy += off / screen * 2.0 * p.w;
  p.z -= lift * p.w;
  gl_Position = p;
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 at;
in vec3 tint;
out vec4 color;
uniform vec4 plane;
void main() {
  if (dot(plane.xyz, at) > plane.w) discard;
  color = vec4(tint, 1.0);
}`;
