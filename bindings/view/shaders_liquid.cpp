// How liquids look: Fresnel's reflection of the sky (Schlick 1994), what lies behind along the bent ray, and Beer's law
// for the way through; foam and what is turbid is lit as anything else.
#include "view/shaders.h"

namespace feder::view {

// Needs kLightSource. Extinctions are per metre.
const std::string_view kWaterSource = R"(
uniform sampler2D behind, behind_depth;
uniform vec3 absorption, tint;
uniform float turbidity, farthest;  // m, that a bent ray is followed
float view_depth(float z) { return planes.y / (2.0 * z - 1.0 + planes.x); }
float depth_value(float d) { return 0.5 + 0.5 * (planes.y / d - planes.x); }
vec3 unshown(vec3 c) {
  vec3 s = pow(c, vec3(2.2));
  return mix(s, 0.52 * s / (1.0 - 0.6 * s), step(0.8, s));
}
// One comparison: shadows on a liquid are faint.
float sun_on(vec3 at, vec3 n) {
  float facing = max(dot(n, sun.xyz), 0.0);
  if (eye.w > 0.5 || sun.w < 0.5 || facing == 0.0) return facing;
  vec3 s = (shadow_matrix * vec4(at + n * eye_texel(), 1.0)).xyz;
  bool outside = any(lessThan(s.xy, vec2(0.0))) || any(greaterThan(s.xy, vec2(1.0))) || s.z > 1.0;
  return outside ? facing : facing * texture(shadow_map, s);
}
vec3 water(vec3 at, vec3 n, float thickness, float foam) {
  vec3 d = normalize(at - eye.xyz);
  n = normalize(n - d * max(0.04 + dot(n, d), 0.0));
  float mirrored = 0.02 + 0.98 * pow(1.0 - max(dot(-d, n), 0.0), 5.0);
  // where the bent ray comes out, as the eye sees that place; not what stands in front
  float own = dot(at - eye.xyz, -back.xyz);
  vec4 out_at = view_projection * vec4(at + refract(d, n, 0.75) * min(thickness, farthest), 1.0);
  vec2 here = gl_FragCoord.xy / viewport.xy, there = clamp(0.5 + 0.5 * out_at.xy / out_at.w, 0.001, 0.999);
  if (view_depth(texture(behind_depth, there).r) < own) there = here;
  vec3 seen = unshown(texture(behind, there).rgb) * exp(-(absorption + turbidity) * thickness);
  float sunny = sun_on(at, n);
  vec3 light = mix(vec3(0.34, 0.34, 0.34), vec3(0.54, 0.58, 0.64), 0.5 + 0.5 * n.y) + vec3(1.0, 0.955, 0.88) * sunny;
  vec3 body = seen + tint * light * (1.0 - exp(-turbidity * thickness));
  vec3 away = reflect(d, n);
  float glint = pow(max(dot(away, sun.xyz), 0.0), 240.0) * min(4.0 * sunny, 1.0);
  vec3 color = mix(body, sky(away), mirrored) + glint * vec3(1.4, 1.34, 1.2);
  return shown(mix(color, 0.92 * light, foam));
}
)";

const std::string_view kLiquidVertex = R"(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in float a_foam;
out vec3 at;
out vec3 normal;
out float foam;
void main() {
  at = a_position, normal = a_normal, foam = a_foam;
  gl_Position = view_projection * vec4(at, 1.0);
}
)";

// Back faces less front faces, of what stands before things: summed up, the way through along the eye's axis.
const std::string_view kThicknessFragment = R"(
uniform sampler2D behind_depth;
out float result;
void main() {
  float wall = planes.y / (2.0 * texelFetch(behind_depth, ivec2(gl_FragCoord.xy), 0).r - 1.0 + planes.x);
  float d = min(1.0 / gl_FragCoord.w, wall);
  result = gl_FrontFacing ? -d : d;
}
)";

const std::string_view kLiquidFragment = R"(
in vec3 at;
in vec3 normal;
in float foam;
uniform sampler2D ways;
uniform float grain;  // m, of the foam's bubbles
out vec4 result;
float noise(vec3 p) {
  vec3 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  vec4 corner = vec4(0.0, 1.0, 57.0, 58.0) + dot(i, vec3(1.0, 57.0, 113.0));
  vec4 low = fract(sin(corner) * 43758.5453), high = fract(sin(corner + 113.0) * 43758.5453);
  vec4 s = mix(low, high, f.z);
  return mix(mix(s.x, s.y, f.x), mix(s.z, s.w, f.x), f.y);
}
void main() {
  float along = length(at - eye.xyz) / dot(at - eye.xyz, -back.xyz);
  float thickness = max(texelFetch(ways, ivec2(gl_FragCoord.xy), 0).r, 0.0) * along;
  float white = 0.0;
  if (foam > 0.01) white = 0.75 * smoothstep(0.3, 0.8, foam + 0.5 * (noise(at / grain) - 0.5)) * smoothstep(0.0, 0.2, foam);
  result = vec4(water(at, normalize(normal), thickness, white), 1.0);
}
)";

// Squares about points, `grow` times as large: as balls face the eye, or in the plane of the picture.
const std::string_view kSplatVertex = R"(
layout(location = 0) in vec4 i_point;
uniform float grow;
out vec3 at;
out vec2 corner;
flat out vec4 ball;
void main() {
  corner = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID >> 1) * 2 - 1);
  ball = vec4(i_point.xyz, i_point.w * grow);
  vec3 side = right.xyz, over = up.xyz;
  float wide = ball.w;
  if (eye.w < 0.5) {
    vec3 away = eye.xyz - ball.xyz;
    float d = length(away);
    side = normalize(cross(up.xyz, away)), over = cross(away / d, side);
    wide *= d / sqrt(max(d * d - wide * wide, 1e-6 * d * d));
  }
  at = ball.xyz + wide * (corner.x * side + corner.y * over);
  gl_Position = view_projection * vec4(at, 1.0);
}
)";

// The nearest ball: its depth along the eye's axis.
const std::string_view kBallDepthFragment = R"(
in vec3 at;
flat in vec4 ball;
out float result;
void main() {
  vec3 d = normalize(at - eye.xyz), o = eye.xyz - ball.xyz;
  float b = dot(d, o), inside = b * b - dot(o, o) + ball.w * ball.w;
  if (inside < 0.0) discard;
  result = max(dot((-b - sqrt(inside)) * d, -back.xyz), 1e-4);
  gl_FragDepth = 0.5 + 0.5 * (planes.y / result - planes.x);
}
)";

// The way through balls that overlap as those of a liquid at rest do; a bump for planar ones. Summed up.
const std::string_view kBallWayFragment = R"(
in vec2 corner;
flat in vec4 ball;
uniform sampler2D behind_depth;
uniform float share;  // of a ball's volume; 0: the bump
out float result;
void main() {
  float left = 1.0 - dot(corner, corner);
  if (left <= 0.0) discard;
  float wall = planes.y / (2.0 * texelFetch(behind_depth, ivec2(gl_FragCoord.xy), 0).r - 1.0 + planes.x);
  if (share > 0.0 && dot(ball.xyz - eye.xyz, -back.xyz) > wall) discard;
  result = share > 0.0 ? 2.0 * share * ball.w * sqrt(left) : left * left * left;
}
)";

// The mean depth of the neighbours along one axis of the picture, but for those on another surface.
const std::string_view kSmoothFragment = R"(
uniform sampler2D ways;
uniform vec2 axis;
uniform float size;  // m
out float result;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float middle = texelFetch(ways, here, 0).r;
  result = 0.0;
  if (middle <= 0.0) return;
  float pixels = clamp(size * viewport.y / (2.0 * up.w * middle), 1.0, 24.0), stride = max(1.0, pixels / 8.0);
  float sum = middle, weight = 1.0;
  for (float i = stride; i <= pixels; i += stride) {
    float w = exp(-2.0 * i * i / (pixels * pixels));
    for (int s = -1; s <= 1; s += 2) {
      float d = texelFetch(ways, here + ivec2(axis * floor(i) * float(s)), 0).r;
      if (d <= 0.0 || abs(d - middle) > size) continue;
      sum += w * d, weight += w;
    }
  }
  result = sum / weight;
}
)";

const std::string_view kWholeVertex = R"(
uniform float at_depth;  // 0: at the far end
out vec2 p;
void main() {
  p = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID >> 1) * 2 - 1);
  gl_Position = vec4(p, at_depth > 0.0 ? planes.y / at_depth - planes.x : 0.0, 1.0);
}
)";

// Depths as a surface.
const std::string_view kSplatFragment = R"(
in vec2 p;
uniform sampler2D depths, ways;
out vec4 result;
vec3 place(ivec2 at, float d) {
  vec2 q = 2.0 * (vec2(at) + 0.5) / viewport.xy - 1.0;
  return eye.xyz + d * (q.x * right.w * right.xyz + q.y * up.w * up.xyz - back.xyz);
}
// Towards the neighbour that is nearer in depth.
vec3 slope(ivec2 here, ivec2 by, vec3 at, float middle) {
  float a = texelFetch(depths, here - by, 0).r, b = texelFetch(depths, here + by, 0).r;
  bool ahead = a <= 0.0 || (b > 0.0 && abs(b - middle) < abs(a - middle));
  if (ahead ? b <= 0.0 : a <= 0.0) return vec3(0.0);
  return ahead ? place(here + by, b) - at : at - place(here - by, a);
}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float d = texelFetch(depths, here, 0).r;
  if (d <= 0.0) discard;
  vec3 at = place(here, d);
  vec3 n = cross(slope(here, ivec2(1, 0), at, d), slope(here, ivec2(0, 1), at, d));
  n = dot(n, n) > 0.0 ? normalize(n) : back.xyz;
  result = vec4(water(at, n, texelFetch(ways, here, 0).r, 0.0), 1.0);
  gl_FragDepth = depth_value(d);
}
)";

// Where bumps add up to more than the level, a sheet whose rim is round.
const std::string_view kSheetFragment = R"(
in vec2 p;
uniform sampler2D ways;
uniform float at_depth, level, rim, sheet;  // rim and thickness of the sheet, m
out vec4 result;
float field(ivec2 at) { return texelFetch(ways, clamp(at, ivec2(0), ivec2(viewport.xy) - 1), 0).r; }
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float f = field(here);
  if (f <= 0.1 * level) discard;
  vec2 slope = 0.5 * vec2(field(here + ivec2(1, 0)) - field(here - ivec2(1, 0)),
                          field(here + ivec2(0, 1)) - field(here - ivec2(0, 1)));
  float steep = max(length(slope), 1e-6), pixel = 2.0 * up.w * at_depth / viewport.y;
  float cover = clamp(0.5 + (f - level) / steep, 0.0, 1.0);
  if (cover <= 0.0) discard;
  float inwards = clamp((f - level) / steep * pixel / rim, 0.0, 1.0), tilt = 1.0 - inwards;
  vec2 lean = -slope / steep * tilt * tilt * 0.9;
  vec3 n = normalize(lean.x * right.xyz + lean.y * up.xyz + back.xyz);
  vec3 at = eye.xyz + at_depth * (p.x * right.w * right.xyz + p.y * up.w * up.xyz - back.xyz);
  result = vec4(water(at, n, sheet * (1.0 + 0.8 * tilt), 0.0), cover);
}
)";

}  // namespace feder::view
