#include "view/shaders.h"

namespace feder::view {

// Light: a warm sun with a soft shadow, and ambient light that is blue from the sky and warm from the ground, as in
// hemisphere lighting. Colours are linear until `shown`, which rounds highlights off and encodes sRGB.
const std::string_view kSharedSource = R"(#version 330 core
layout(std140) uniform Shared {
  mat4 view_projection;
  mat4 shadow_matrix;   // world to shadow map, 0..1
  vec4 eye;             // w: 1 in a planar world
  vec4 sun;             // towards the sun; w: 1 with shadows
  vec4 viewport;        // width, height, line scale, shadow texel
  vec4 right, up, back; // camera axes; right.w: tan(fov / 2) * aspect, up.w: tan(fov / 2), back.w: distance
  vec4 planes;          // x, y: at depth d along the eye's axis, clip space has z / w = y / d - x
};

vec3 linear(vec3 s) { return s * (s * (s * 0.305306011 + 0.682171111) + 0.012522878); }
vec3 shown(vec3 c) {
  c = c / (1.0 + max(c - 0.8, 0.0) * 0.6);
  return pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2));
}
vec3 sky(vec3 direction) {
  float h = direction.y;
  vec3 horizon = vec3(0.80, 0.845, 0.88), zenith = vec3(0.36, 0.52, 0.72), below = vec3(0.60, 0.61, 0.62);
  return h > 0.0 ? mix(horizon, zenith, pow(min(h * 1.1, 1.0), 0.7)) : mix(horizon, below, smoothstep(0.0, 0.6, -h));
}
)";

// Needs `shadow_map`. 16 bilinear comparisons: an edge about five texels wide. The receiver is lifted by a few texels
// along its normal against self-shadowing.
const std::string_view kLightSource = R"(
float eye_texel() { return 2.5 * viewport.w / length(vec3(shadow_matrix[0][0], shadow_matrix[1][0], shadow_matrix[2][0])); }
uniform sampler2DShadow shadow_map;
float sunlight(vec3 at, vec3 n) {
  float facing = dot(n, sun.xyz);
  if (facing <= 0.0) return 0.0;
  if (sun.w < 0.5) return facing;
  float texel = viewport.w;
  vec3 s = (shadow_matrix * vec4(at + n * eye_texel(), 1.0)).xyz;
  if (any(lessThan(s.xy, vec2(0.0))) || any(greaterThan(s.xy, vec2(1.0))) || s.z > 1.0) return facing;
  float sum = 0.0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      sum += texture(shadow_map, vec3(s.xy + texel * 1.3 * (vec2(i, j) - 1.5), s.z));
  vec2 rim = smoothstep(vec2(0.5), vec2(0.46), abs(s.xy - 0.5));
  return facing * mix(1.0, sum / 16.0, rim.x * rim.y);
}
vec3 lit(vec3 albedo, vec3 at, vec3 n, float gloss) {
  vec3 ambient = mix(vec3(0.30, 0.28, 0.26), vec3(0.50, 0.55, 0.62), 0.5 + 0.5 * n.y);
  // faces that look at the viewer get a little of their own, so that none is flat
  vec3 to_eye = normalize(eye.xyz - at);
  ambient *= 0.82 + 0.18 * max(dot(n, to_eye), 0.0);
  float sunny = sunlight(at, n);
  vec3 color = albedo * (ambient + 1.02 * vec3(1.0, 0.955, 0.88) * sunny);
  vec3 halfway = normalize(to_eye + sun.xyz);
  float shine = pow(max(dot(n, halfway), 0.0), 48.0) * step(0.0, dot(n, sun.xyz));
  return color + gloss * shine * min(sunny * 4.0, 1.0);
}
)";

const std::string_view kShapeVertex = R"(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec2 a_side_edge;
layout(location = 3) in vec3 i_position;
layout(location = 4) in vec4 i_rotation;
layout(location = 5) in vec4 i_scale_stretch;
layout(location = 6) in vec4 i_color;
out vec3 at;
out vec3 normal;
out vec4 color;
out float edge;
vec3 turned(vec3 v) { return v + 2.0 * cross(i_rotation.xyz, cross(i_rotation.xyz, v) + i_rotation.w * v); }
void main() {
  vec3 local = a_position * i_scale_stretch.xyz + vec3(0.0, a_side_edge.x * i_scale_stretch.w, 0.0);
  at = i_position + turned(local);
  normal = turned(a_normal / i_scale_stretch.xyz);
  color = vec4(linear(i_color.rgb), i_color.a);
  edge = a_side_edge.y;
  gl_Position = view_projection * vec4(at, 1.0);
}
)";

const std::string_view kShapeFragment = R"(
in vec3 at;
in vec3 normal;
in vec4 color;
in float edge;
uniform int two_sided;
out vec4 result;
void main() {
  vec3 n = normalize(normal);
  if (two_sided == 1 && dot(n, eye.xyz - at) < 0.0) n = -n;
  // edges of flat faces, a pixel and a half wide
  float width = fwidth(edge);
  float line = width > 0.0 ? 1.0 - smoothstep(0.6, 1.8, (1.0 - edge) / width) : 0.0;
  vec3 albedo = color.rgb * (1.0 - 0.38 * line * (1.0 - smoothstep(0.15, 0.5, width)));
  result = vec4(shown(lit(albedo, at, n, 0.10)), color.a);
}
)";

const std::string_view kDepthFragment = R"(
void main() {}
)";

// A square that faces the eye, large enough for the sphere's outline in perspective; the fragment finds the sphere.
const std::string_view kPointVertex = R"(
layout(location = 0) in vec4 i_point;
layout(location = 1) in float i_value;
uniform vec4 plain;   // colour, or a < 0: by value
uniform vec2 range;
uniform int orthographic;
out vec3 at;
flat out vec4 ball;
flat out vec3 color;
vec3 ramp(float t) {
  t = clamp(t, 0.0, 1.0) * 4.0;
  vec3 c0 = vec3(0.145, 0.271, 0.561), c1 = vec3(0.141, 0.471, 0.690), c2 = vec3(0.153, 0.651, 0.643),
       c3 = vec3(0.435, 0.769, 0.478), c4 = vec3(0.914, 0.867, 0.416);
  return t < 1.0 ? mix(c0, c1, t) : t < 2.0 ? mix(c1, c2, t - 1.0) : t < 3.0 ? mix(c2, c3, t - 2.0) : mix(c3, c4, t - 3.0);
}
void main() {
  vec2 corner = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID >> 1) * 2 - 1);
  ball = i_point;
  vec3 towards = orthographic == 1 ? sun.xyz : normalize(eye.xyz - i_point.xyz);
  vec3 side = normalize(cross(abs(towards.y) < 0.99 ? vec3(0, 1, 0) : vec3(1, 0, 0), towards));
  vec3 over = cross(towards, side);
  float d = orthographic == 1 ? 1e9 : length(eye.xyz - i_point.xyz);
  float grow = orthographic == 1 ? 1.0 : d / sqrt(max(d * d - i_point.w * i_point.w, 1e-6 * d * d));
  at = i_point.xyz + i_point.w * (grow * (corner.x * side + corner.y * over));
  color = linear(plain.a >= 0.0 ? plain.rgb : ramp((i_value - range.x) / max(range.y - range.x, 1e-20)));
  gl_Position = view_projection * vec4(at, 1.0);
}
)";

const std::string_view kPointFragment = R"(
in vec3 at;
flat in vec4 ball;
flat in vec3 color;
out vec4 result;
void main() {
  vec3 d = normalize(at - eye.xyz), o = eye.xyz - ball.xyz;
  float b = dot(d, o), inside = b * b - dot(o, o) + ball.w * ball.w;
  if (inside < 0.0) discard;
  vec3 hit = eye.xyz + (-b - sqrt(inside)) * d;
  vec4 clip = view_projection * vec4(hit, 1.0);
  gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
  result = vec4(shown(lit(color, hit, (hit - ball.xyz) / ball.w, 0.15)), 1.0);
}
)";

const std::string_view kPointDepthFragment = R"(
in vec3 at;
flat in vec4 ball;
void main() {
  if (length(at - ball.xyz) > ball.w) discard;
}
)";

// A segment as a rectangle on the screen, cut at the near plane; `across` runs -1..1 over its width and a half pixel.
const std::string_view kLineVertex = R"(
layout(location = 0) in vec3 i_a;
layout(location = 1) in vec3 i_b;
layout(location = 2) in vec4 i_color_a;
layout(location = 3) in vec4 i_color_b;
layout(location = 4) in float i_width;
out vec4 color;
out float across;
flat out float half_width;
void main() {
  vec4 a = view_projection * vec4(i_a, 1.0), b = view_projection * vec4(i_b, 1.0);
  float near = 1e-4;
  if (a.w < near && b.w < near) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (a.w < near) a = mix(b, a, (b.w - near) / (b.w - a.w));
  if (b.w < near) b = mix(a, b, (a.w - near) / (a.w - b.w));
  vec2 along = (b.xy / b.w - a.xy / a.w) * viewport.xy;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
  int end = gl_VertexID >> 1;
  float side = float(gl_VertexID & 1) * 2.0 - 1.0;
  half_width = 0.5 * i_width * viewport.z;
  across = side * (half_width + 0.5);
  vec2 offset = vec2(-along.y, along.x) * across + along * (float(end) * 2.0 - 1.0) * 0.5;
  vec4 p = end == 0 ? a : b;
  p.xy += offset * 2.0 / viewport.xy * p.w;
  p.z -= 2e-4 * p.w;  // in front of the faces it runs along
  color = end == 0 ? i_color_a : i_color_b;
  gl_Position = p;
}
)";

const std::string_view kLineFragment = R"(
in vec4 color;
in float across;
flat in float half_width;
out vec4 result;
void main() {
  result = vec4(color.rgb, color.a * clamp(half_width + 0.5 - abs(across), 0.0, 1.0));
}
)";

// A large square of the plane about the target; planar worlds show the cut through the half-space instead.
const std::string_view kGroundVertex = R"(
uniform vec3 origin, along, over;  // the square's middle and half sides
out vec3 at;
void main() {
  vec2 corner = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID >> 1) * 2 - 1);
  at = origin + corner.x * along + corner.y * over;
  gl_Position = view_projection * vec4(at, 1.0);
}
)";

// Grid lines every `spacing` and, stronger, every ten of it; both fade with distance, and the plane into the sky.
const std::string_view kGroundFragment = R"(
in vec3 at;
uniform vec3 origin, along, over;
uniform vec3 albedo, plane_normal, axis_u, axis_v;
uniform float spacing, reach;
out vec4 result;
float grid(vec2 p, float every) {
  vec2 q = p / every, w = max(fwidth(q), 1e-6), d = abs(fract(q - 0.5) - 0.5) / w;
  vec2 line = (1.0 - smoothstep(0.4, 1.3, d)) * (1.0 - smoothstep(0.15, 0.45, w));
  return max(line.x, line.y);
}
void main() {
  vec2 p = vec2(dot(at, axis_u), dot(at, axis_v));
  float lines = max(0.10 * grid(p, spacing), 0.22 * grid(p, spacing * 10.0));
  vec3 base = linear(albedo) * (1.0 - lines);
  vec3 color = shown(eye.w > 0.5 ? base * 1.1 : lit(base, at, plane_normal, 0.0));
  float far = length(at - origin) / reach;
  vec3 away = eye.w > 0.5 ? vec3(0.0, (at.y - eye.y) / back.w * 0.6, -1.0) : at - eye.xyz;
  result = vec4(mix(color, shown(sky(normalize(away))), smoothstep(0.25, 1.0, far)), 1.0);
}
)";

const std::string_view kBackgroundVertex = R"(
out vec2 p;
void main() {
  p = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID >> 1) * 2 - 1);
  gl_Position = vec4(p, 1.0, 1.0);
}
)";

const std::string_view kBackgroundFragment = R"(
in vec2 p;
out vec4 result;
void main() {
  vec3 d = eye.w > 0.5 ? vec3(0.0, p.y * 0.6 * up.w, -1.0) : p.x * right.w * right.xyz + p.y * up.w * up.xyz - back.xyz;
  result = vec4(shown(sky(normalize(d))), 1.0);
}
)";

const std::string_view kTextVertex = R"(
layout(location = 0) in vec4 i_box;   // left, top, right, bottom in pixels
layout(location = 1) in vec4 i_uv;
layout(location = 2) in vec4 i_color;
out vec2 uv;
out vec4 color;
void main() {
  vec2 t = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec2 p = mix(i_box.xy, i_box.zw, t);
  uv = mix(i_uv.xy, i_uv.zw, t);
  color = i_color;
  gl_Position = vec4(2.0 * p.x / viewport.x - 1.0, 1.0 - 2.0 * p.y / viewport.y, 0.0, 1.0);
}
)";

const std::string_view kTextFragment = R"(
in vec2 uv;
in vec4 color;
uniform sampler2D glyphs;
out vec4 result;
void main() { result = vec4(color.rgb, color.a * texture(glyphs, uv).r); }
)";

}  // namespace feder::view
