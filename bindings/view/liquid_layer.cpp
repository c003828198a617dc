// The passes of a liquid: a copy of the picture so far, the way through the liquid at every pixel, its surface over
// that. The surface is a mesh, or the balls of its points with their depths smoothed (van der Laan, Green & Sainz,
// "Screen Space Fluid Rendering with Curvature Flow", I3D 2009), or in a plane the level line of a sum of bumps.
#include "view/liquid_layer.h"

#include <array>
#include <cmath>

#include "view/shaders.h"

namespace feder::view {
namespace {

enum Unit : GLenum { kBehind = 1, kBehindDepth, kWays, kDepths };  // texture units; 0 has the shadow map

// Of balls in spacings, given points of half a spacing. Their volume is 2.1 times what a particle has.
constexpr float kBallGrow = 1.6f, kBallShare = 0.47f, kSmoothing = 5.0f;
constexpr float kBumpGrow = 4, kLevel = 0.6f;  // bumps of a flat sheet add up to 3.1
constexpr float kSheet = 0.7f;                 // depths of the liquid
constexpr float kAbsorption = 0.8f, kTurbidity = 1.6f, kFarthest = 0.5f;

float linear_part(std::uint8_t s) { return std::pow(static_cast<float>(s) / 255, 2.2f); }

// -log of the colour, as if light had come through once the depth; and what scatters, without end when opaque.
struct Extinction {
  explicit Extinction(const Liquid& l) : tint{linear_part(l.color.r), linear_part(l.color.g), linear_part(l.color.b)} {
    const float depth = std::max(l.depth, 1e-6f), clear = std::clamp(l.transparency, 0.0f, 1.0f);
    const auto along = [&](float part) { return kAbsorption * -std::log(std::clamp(part, 0.01f, 1.0f)) / depth; };
    // at its clearest it has a little colour still
    const float colored = 0.5f + 2 * (1 - clear);
    absorption = {colored * along(tint.x), colored * along(tint.y), colored * along(tint.z)};
    turbidity = clear > 0 ? std::min(kTurbidity * (1 - clear) / clear / depth, 1e6f / depth) : 1e6f / depth;
  }
  Float3 tint, absorption;
  float turbidity;
};

}  // namespace

PixelTarget::PixelTarget(const Gl& gl, GLenum format, bool with_depth, int w, int h)
    : frame(gl.GenFramebuffers, gl.DeleteFramebuffers), color(gl.GenTextures, gl.DeleteTextures),
      depth(gl.GenTextures, gl.DeleteTextures), width(w), height(h) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame.id());
  const auto attach = [&](const GlObject& texture, GLenum inside, GLenum outside, GLenum type, GLenum point,
                          GLint filter) {
    gl.BindTexture(GL_TEXTURE_2D, texture.id());
    gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(inside), w, h, 0, outside, type, nullptr);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, texture.id(), 0);
  };
  const bool shades = format == GL_RGBA8;
  attach(color, format, shades ? GL_RGBA : GL_RED, shades ? GL_UNSIGNED_BYTE : GL_FLOAT, GL_COLOR_ATTACHMENT0,
         shades ? GL_LINEAR : GL_NEAREST);
  if (with_depth)
    attach(depth, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, GL_DEPTH_ATTACHMENT, GL_NEAREST);
  gl.BindTexture(GL_TEXTURE_2D, 0);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GlError("OpenGL: no framebuffer for liquids of " + std::to_string(w) + " x " + std::to_string(h) + " pixels");
}

LiquidLayer::LiquidLayer(const Gl& gl, const ShapeLayer& shapes, const PointLayer& points)
    : gl_(gl), shapes_(shapes), points_(points),
      way_(make_program(gl, "liquid (way)", kLiquidVertex, kThicknessFragment, false)),
      mesh_(make_program(gl, "liquid", kLiquidVertex, std::string(kWaterSource) + std::string(kLiquidFragment), true)),
      ball_depth_(make_program(gl, "splats (depth)", kSplatVertex, kBallDepthFragment, false)),
      ball_way_(make_program(gl, "splats (way)", kSplatVertex, kBallWayFragment, false)),
      smooth_(make_program(gl, "splats (smooth)", kWholeVertex, kSmoothFragment, false)),
      splat_(make_program(gl, "splats", kWholeVertex, std::string(kWaterSource) + std::string(kSplatFragment), true)),
      sheet_(make_program(gl, "sheet", kWholeVertex, std::string(kWaterSource) + std::string(kSheetFragment), true)),
      foam_(gl), mesh_array_(gl), point_array_(gl) {
  const std::pair<const char*, Unit> samplers[] = {
      {"behind", kBehind}, {"behind_depth", kBehindDepth}, {"ways", kWays}, {"depths", kDepths}};
  for (const Program* p :
       {way_.get(), mesh_.get(), ball_depth_.get(), ball_way_.get(), smooth_.get(), splat_.get(), sheet_.get()}) {
    p->use();
    for (const auto& [name, unit] : samplers) gl_.Uniform1i(p->uniform(name), static_cast<GLint>(unit));
  }
  gl_.UseProgram(0);
}

void LiquidLayer::upload(const Frame& frame) {
  if (!frame.foam.empty()) foam_.fill(frame.foam, GL_STREAM_DRAW);
}

void LiquidLayer::make_targets(const Target& size, bool splats) {
  const auto make = [&](std::optional<PixelTarget>& target, GLenum format, bool with_depth) {
    if (target && target->width == size.width && target->height == size.height) return;
    target.reset();
    target.emplace(gl_, format, with_depth, size.width, size.height);
  };
  make(behind_, GL_RGBA8, true), make(ways_, GL_R32F, false);
  if (splats) make(depths_, GL_R32F, true), make(smoothed_, GL_R32F, false);
}

void LiquidLayer::copy(const Target& from) const {
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, from.framebuffer);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, behind_->frame.id());
  gl_.BlitFramebuffer(0, 0, from.width, from.height, 0, 0, from.width, from.height,
                      GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

void LiquidLayer::read(GLenum unit, const GlObject& texture) const {
  gl_.ActiveTexture(GL_TEXTURE0 + unit);
  gl_.BindTexture(GL_TEXTURE_2D, texture.id());
}

// Binds it, and makes it zero; depths far.
void LiquidLayer::clear(const PixelTarget& target, bool with_depth) const {
  const GLfloat zero[4] = {0, 0, 0, 0}, far = 1;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target.frame.id());
  gl_.ClearBufferfv(GL_COLOR, 0, zero);
  if (!with_depth) return;
  gl_.DepthMask(GL_TRUE);  // or nothing is cleared
  gl_.ClearBufferfv(GL_DEPTH, 0, &far);
}

void LiquidLayer::aim_mesh(const DynamicMesh& mesh, std::uint32_t first_foam) const {
  mesh_array_.bind();
  shapes_.mesh_vertices().bind();
  mesh_array_.attributes<MeshVertex>({{0, 3, offsetof(MeshVertex, position)}, {1, 3, offsetof(MeshVertex, normal)}},
                                     mesh.first_vertex);
  shapes_.mesh_indices().bind(GL_ELEMENT_ARRAY_BUFFER);
  gl_.DisableVertexAttribArray(2);
  gl_.VertexAttrib4f(2, 0, 0, 0, 0);
  if (first_foam == kNone) return;
  foam_.bind();
  mesh_array_.attributes<float>({{2, 1, 0}}, first_foam);
}

void LiquidLayer::begin_water(const Drawing& d, const Program& program, const Liquid& liquid) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, d.into.framebuffer);
  program.use();
  const Extinction e(liquid);
  gl_.Uniform3f(program.uniform("absorption"), e.absorption.x, e.absorption.y, e.absorption.z);
  gl_.Uniform3f(program.uniform("tint"), e.tint.x, e.tint.y, e.tint.z);
  gl_.Uniform1f(program.uniform("turbidity"), e.turbidity);
  gl_.Uniform1f(program.uniform("farthest"), d.frame.dimension == 2 ? 0 : kFarthest * liquid.depth);
  gl_.DepthMask(GL_TRUE), gl_.Enable(GL_DEPTH_TEST), gl_.Disable(GL_BLEND);
}

void LiquidLayer::draw_mesh(const Drawing& d, const Liquid& liquid) {
  const DynamicMesh& m = d.frame.meshes[liquid.mesh];
  aim_mesh(m, liquid.first_foam);
  clear(*ways_, false);
  way_->use();
  gl_.Disable(GL_DEPTH_TEST), gl_.Enable(GL_BLEND), gl_.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
  d.pass(gl_).draw_triangles(m.index_count, m.first_index, 1);
  begin_water(d, *mesh_, liquid);
  gl_.Uniform1f(mesh_->uniform("grain"), 0.02f * liquid.depth);
  gl_.Enable(GL_CULL_FACE);
  d.pass(gl_).draw_triangles(m.index_count, m.first_index, 1);
  gl_.Disable(GL_CULL_FACE);
}

void LiquidLayer::sum_ways(const Drawing& d, const PointGroup& group, float grow, float share) {
  clear(*ways_, false);
  ball_way_->use();
  gl_.Uniform1f(ball_way_->uniform("grow"), grow), gl_.Uniform1f(ball_way_->uniform("share"), share);
  gl_.Disable(GL_DEPTH_TEST), gl_.Enable(GL_BLEND), gl_.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
  d.pass(gl_).draw_squares(group.count);
}

void LiquidLayer::draw_splats(const Drawing& d, const Liquid& liquid) {
  const PointGroup& g = d.frame.point_groups[liquid.group];
  points_.aim(point_array_, g.first);
  sum_ways(d, g, kBallGrow, kBallShare);
  clear(*depths_, true);
  gl_.Disable(GL_BLEND), gl_.Enable(GL_DEPTH_TEST), gl_.DepthMask(GL_TRUE);
  ball_depth_->use();
  gl_.Uniform1f(ball_depth_->uniform("grow"), kBallGrow);
  d.pass(gl_).draw_squares(g.count);
  gl_.Disable(GL_DEPTH_TEST);
  smooth_->use();
  gl_.Uniform1f(smooth_->uniform("size"), kSmoothing * d.frame.points[g.first].radius);
  for (const bool second : {false, true}) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, (second ? depths_ : smoothed_)->frame.id());
    read(kWays, (second ? smoothed_ : depths_)->color);
    gl_.Uniform2f(smooth_->uniform("axis"), second ? 0.0f : 1.0f, second ? 1.0f : 0.0f);
    d.pass(gl_).draw_squares(1);
  }
  read(kWays, ways_->color), read(kDepths, depths_->color);
  begin_water(d, *splat_, liquid);
  d.pass(gl_).draw_squares(1);
}

void LiquidLayer::draw_sheet(const Drawing& d, const Liquid& liquid) {
  const PointGroup& g = d.frame.point_groups[liquid.group];
  const Point& first = d.frame.points[g.first];
  points_.aim(point_array_, g.first);
  sum_ways(d, g, kBumpGrow, 0);
  begin_water(d, *sheet_, liquid);
  const float depth = -dot(first.position - d.camera.eye(), d.camera.axes().back);
  const std::pair<const char*, float> numbers[] = {
      {"at_depth", depth}, {"level", kLevel}, {"rim", 3 * first.radius}, {"sheet", kSheet * liquid.depth}};
  for (const auto& [name, value] : numbers) gl_.Uniform1f(sheet_->uniform(name), value);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (depth > 0) d.pass(gl_).draw_squares(1);
}

void LiquidLayer::draw(const Frame& frame, const Camera& camera, const Target& into, DrawStats& stats) {
  if (frame.liquids.empty()) return;
  const Drawing d{frame, camera, into, stats};
  bool splats = false;
  for (const Liquid& l : frame.liquids) splats |= l.mesh == kNone && frame.dimension == 3;
  gl_.ActiveTexture(GL_TEXTURE0 + kBehind);  // making targets binds textures
  make_targets(into, splats);
  read(kBehind, behind_->color), read(kBehindDepth, behind_->depth), read(kWays, ways_->color);
  for (const Liquid& l : frame.liquids) {
    copy(into);
    if (l.mesh != kNone)
      draw_mesh(d, l);
    else if (frame.dimension == 3)
      draw_splats(d, l);
    else
      draw_sheet(d, l);
  }
  for (const Unit unit : {kBehind, kBehindDepth, kWays, kDepths}) {
    gl_.ActiveTexture(GL_TEXTURE0 + unit);
    gl_.BindTexture(GL_TEXTURE_2D, 0);
  }
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, into.framebuffer);
  gl_.Disable(GL_BLEND), gl_.Enable(GL_DEPTH_TEST), gl_.DepthMask(GL_TRUE);
}

}  // namespace feder::view
