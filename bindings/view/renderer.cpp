// The passes of a picture: shadow map, then opaque, translucent and overlay into a multisampled framebuffer of the
// renderer's own, which is resolved into the target.
#include "view/renderer.h"

#include <cmath>
#include <optional>

#include "feder/types.h"
#include "view/layers.h"
#include "view/liquid_layer.h"
#include "view/shaders.h"

namespace feder::view {
namespace {

constexpr Float3 kSun{-0.42f, 0.80f, 0.48f};  // towards the sun; made unit below

struct Float4 {
  Float3 xyz;
  float w = 0;
};

// The uniform block of shaders.cpp, std140.
struct Shared {
  Matrix4 view_projection, shadow_matrix;
  Float4 eye, sun, viewport, right, up, back, planes;
};

Float3 unit_sun() { return kSun / length(kSun); }

// Looks along the sun's rays at a sphere about what moves. Deep enough for casters far above and receivers below.
Matrix4 sun_matrix(const Frame& f, const Camera& camera) {
  Bounds b = f.moving.empty() ? f.bounds : f.moving;
  if (b.empty()) b.include(camera.target, camera.distance / 2);
  const Float3 size = b.high - b.low;
  // neither more than the eye can see, nor so little that the surroundings have no shadows
  const float radius = std::clamp(1.5f * std::sqrt(dot(size, size) / 4), 0.05f * camera.distance, 4 * camera.distance);
  Camera sun;
  sun.look_at(b.center() + 4 * radius * unit_sun(), b.center());
  const float n = 0, far = 8 * radius;
  const Matrix4 orthographic = {
      {1 / radius, 0, 0, 0, 0, 1 / radius, 0, 0, 0, 0, -2 / (far - n), 0, 0, 0, -(far + n) / (far - n), 1}};
  return orthographic * sun.view();
}

const Matrix4 kHalf = {{0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0, 0.5f, 0.5f, 0.5f, 1}};

// What is drawn into, before it is resolved into the host's framebuffer.
struct ColorTarget {
  ColorTarget(const Gl& gl, int w, int h, int sample_count)
      : frame(gl.GenFramebuffers, gl.DeleteFramebuffers), color(gl.GenRenderbuffers, gl.DeleteRenderbuffers),
        depth(gl.GenRenderbuffers, gl.DeleteRenderbuffers), width(w), height(h), samples(sample_count) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame.id());
    attach_renderbuffer(gl, color, GL_RGBA8, GL_COLOR_ATTACHMENT0, w, h, samples > 1 ? samples : 0);
    attach_renderbuffer(gl, depth, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT, w, h, samples > 1 ? samples : 0);
    gl.BindRenderbuffer(GL_RENDERBUFFER, 0);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      throw GlError("OpenGL: no framebuffer of " + std::to_string(w) + " x " + std::to_string(h) + " pixels");
  }
  GlObject frame, color, depth;
  int width, height, samples;
};

// Depths as the sun sees them.
struct ShadowTarget {
  ShadowTarget(const Gl& gl, int texels)
      : frame(gl.GenFramebuffers, gl.DeleteFramebuffers), map(gl.GenTextures, gl.DeleteTextures), size(texels) {
    gl.BindTexture(GL_TEXTURE_2D, map.id());
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
    const std::pair<GLenum, GLint> parameters[] = {{GL_TEXTURE_MIN_FILTER, GL_LINEAR},
                                                   {GL_TEXTURE_MAG_FILTER, GL_LINEAR},
                                                   {GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE},
                                                   {GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE},
                                                   {GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE},
                                                   {GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL}};
    for (const auto& [name, value] : parameters) gl.TexParameteri(GL_TEXTURE_2D, name, value);
    gl.BindTexture(GL_TEXTURE_2D, 0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame.id());
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, map.id(), 0);
    const GLenum none = GL_NONE;
    gl.DrawBuffers(1, &none), gl.ReadBuffer(GL_NONE);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) throw GlError("OpenGL: no shadow map");
  }
  GlObject frame, map;
  int size;
};

}  // namespace

std::unique_ptr<Program> make_program(const Gl& gl, const char* name, std::string_view vertex,
                                      std::string_view fragment, bool lit) {
  const std::string shared(kSharedSource);
  auto program = std::make_unique<Program>(gl, name, shared + std::string(vertex),
                                           shared + std::string(lit ? kLightSource : "") + std::string(fragment));
  program->bind_block("Shared", 0);
  return program;
}

struct Renderer::Impl {
  explicit Impl(const GlLoader& load)
      : gl(load), shapes(gl), points(gl), lines(gl), liquids(gl, shapes, points), backdrop(gl), text(gl), shared(gl) {
    gl.GetIntegerv(GL_MAX_SAMPLES, &max_samples);
  }

  void make_targets(int width, int height, int samples, int shadow_size);
  void fill_shared(const Frame& f, const Camera& camera, const DrawOptions& options, const Target& target);
  void draw_shadow(const Frame& f);
  void draw_color(const Frame& f, const Camera& camera, const DrawOptions& options, const Target& target);
  void layers(const Frame& f, Stage stage) {
    const Pass pass{gl, stage, stats};
    shapes.draw(f, pass), points.draw(f, pass), lines.draw(f, pass);
  }

  Gl gl;
  ShapeLayer shapes;
  PointLayer points;
  LineLayer lines;
  LiquidLayer liquids;
  BackdropLayer backdrop;
  TextLayer text;
  Buffer shared;
  Shared block;
  DrawStats stats;
  GLint max_samples = 1;
  std::optional<ColorTarget> color;
  std::optional<ShadowTarget> shadow;
};

// Of other sizes than the last picture's they are made anew.
void Renderer::Impl::make_targets(int width, int height, int samples, int shadow_size) {
  if (!color || width != color->width || height != color->height || samples != color->samples) {
    color.reset();
    color.emplace(gl, width, height, samples);
  }
  if (!shadow || shadow_size != shadow->size) {
    shadow.reset();
    shadow.emplace(gl, shadow_size);
  }
}

void Renderer::Impl::fill_shared(const Frame& f, const Camera& camera, const DrawOptions& options,
                                 const Target& target) {
  const float aspect = static_cast<float>(target.width) / static_cast<float>(target.height);
  const float tall = std::tan(camera.fov / 2), wide = tall * aspect;
  const auto width = static_cast<float>(target.width), height = static_cast<float>(target.height);
  const auto [right, up, back] = camera.axes();
  const Matrix4 projection = camera.projection(aspect);
  block.view_projection = projection * camera.view();
  block.shadow_matrix = kHalf * sun_matrix(f, camera);
  block.eye = {camera.eye(), f.dimension == 2 ? 1.0f : 0.0f};
  block.sun = {unit_sun(), options.shadow_size > 0 ? 1.0f : 0.0f};
  block.viewport = {{width, height, options.line_scale}, 1.0f / static_cast<float>(std::max(options.shadow_size, 1))};
  block.right = {right, wide}, block.up = {up, tall}, block.back = {back, camera.distance};
  block.planes = {{projection.m[10], projection.m[14], 0}, 0};
}

void Renderer::Impl::draw_shadow(const Frame& f) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, shadow->frame.id());
  gl.Viewport(0, 0, shadow->size, shadow->size);
  gl.Enable(GL_DEPTH_TEST), gl.DepthFunc(GL_LESS), gl.DepthMask(GL_TRUE);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  gl.Enable(GL_POLYGON_OFFSET_FILL), gl.PolygonOffset(1.5f, 2);
  Shared from_sun = block;
  const Matrix4 whole = {{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, -1, -1, -1, 1}};  // undoes kHalf
  from_sun.view_projection = whole * block.shadow_matrix;
  shared.fill(&from_sun, sizeof from_sun, GL_STREAM_DRAW, GL_UNIFORM_BUFFER);
  shared.bind_block(0);
  layers(f, Stage::shadow);
  gl.Disable(GL_POLYGON_OFFSET_FILL);
}

void Renderer::Impl::draw_color(const Frame& f, const Camera& camera, const DrawOptions& options,
                                const Target& target) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, color->frame.id());
  gl.Viewport(0, 0, target.width, target.height);
  shared.fill(&block, sizeof block, GL_STREAM_DRAW, GL_UNIFORM_BUFFER);
  shared.bind_block(0);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, shadow->map.id());
  gl.DepthMask(GL_TRUE), gl.Disable(GL_DEPTH_TEST);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  const Pass opaque{gl, Stage::opaque, stats}, overlay{gl, Stage::overlay, stats};
  backdrop.draw_sky(opaque);
  gl.Enable(GL_DEPTH_TEST);
  layers(f, Stage::opaque);
  backdrop.draw_grounds(f, camera, opaque);
  const auto blend = [this] {
    gl.Enable(GL_BLEND), gl.DepthMask(GL_FALSE);
    gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  };
  blend();
  if (!f.liquids.empty()) lines.draw(f, {gl, Stage::translucent, stats});  // those in a liquid shine through it
  liquids.draw(f, camera, {color->frame.id(), target.width, target.height}, stats);
  blend();
  layers(f, Stage::translucent);
  gl.Disable(GL_DEPTH_TEST);
  layers(f, Stage::overlay);
  if (options.labels) text.draw(overlay);
  gl.Disable(GL_BLEND), gl.DepthMask(GL_TRUE);
}

Renderer::Renderer(const GlLoader& load) : impl_(std::make_unique<Impl>(load)) { impl_->gl.check("nothing yet"); }
Renderer::~Renderer() = default;

void Renderer::draw(const Frame& frame, const Camera& camera, const DrawOptions& options, const Target& target) {
  Impl& r = *impl_;
  if (target.width <= 0 || target.height <= 0) return;
  r.stats = {};
  r.gl.Disable(GL_SCISSOR_TEST), r.gl.Disable(GL_BLEND), r.gl.Disable(GL_CULL_FACE);
  // the lit programs sample the shadow map in any case
  r.make_targets(target.width, target.height, std::min(options.samples, static_cast<int>(r.max_samples)),
                 std::max(options.shadow_size, 1));
  r.shapes.upload(frame, camera.eye()), r.points.upload(frame), r.lines.upload(frame), r.liquids.upload(frame);
  if (options.labels) r.text.upload(frame, camera, target, options.line_scale);
  r.fill_shared(frame, camera, options, target);
  if (options.shadow_size > 0) r.draw_shadow(frame);
  r.draw_color(frame, camera, options, target);

  r.gl.BindFramebuffer(GL_READ_FRAMEBUFFER, r.color->frame.id());
  r.gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
  r.gl.BlitFramebuffer(0, 0, target.width, target.height, 0, 0, target.width, target.height, GL_COLOR_BUFFER_BIT,
                       GL_NEAREST);
  r.gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  r.gl.UseProgram(0), r.gl.BindVertexArray(0), r.gl.BindTexture(GL_TEXTURE_2D, 0);
  r.gl.BindBuffer(GL_ARRAY_BUFFER, 0), r.gl.BindBuffer(GL_UNIFORM_BUFFER, 0);
  r.gl.Disable(GL_DEPTH_TEST);
  r.gl.check("a frame");
}

const DrawStats& Renderer::stats() const { return impl_->stats; }

}  // namespace feder::view
