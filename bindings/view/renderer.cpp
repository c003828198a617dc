// The passes of a picture: shadow map, then opaque, translucent and overlay into a multisampled framebuffer of the
// renderer's own, which is resolved into the target.
#include "view/renderer.h"

#include <cmath>
#include <cstring>

#include "feder/types.h"
#include "view/layers.h"
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
  Float4 eye, sun, viewport, right, up, back;
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
      : gl(load), shapes(gl), points(gl), lines(gl), backdrop(gl), text(gl), shared(gl) {
    gl.GetIntegerv(GL_MAX_SAMPLES, &max_samples);
  }
  ~Impl() {
    drop_color();
    drop_shadow();
  }

  void make_color(int width, int height, int samples);
  void make_shadow(int size);
  void drop_color();
  void drop_shadow();
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
  BackdropLayer backdrop;
  TextLayer text;
  Buffer shared;
  Shared block;
  DrawStats stats;
  GLint max_samples = 1;
  GLuint color_frame = 0, color = 0, depth = 0;
  int color_width = 0, color_height = 0, color_samples = -1;
  GLuint shadow_frame = 0, shadow_map = 0;
  int shadow_size = 0;
};

void Renderer::Impl::drop_color() {
  gl.DeleteFramebuffers(1, &color_frame), gl.DeleteRenderbuffers(1, &color), gl.DeleteRenderbuffers(1, &depth);
  color_frame = color = depth = 0;
}

void Renderer::Impl::drop_shadow() {
  gl.DeleteFramebuffers(1, &shadow_frame), gl.DeleteTextures(1, &shadow_map);
  shadow_frame = shadow_map = 0;
}

void Renderer::Impl::make_color(int width, int height, int samples) {
  if (color_frame && width == color_width && height == color_height && samples == color_samples) return;
  drop_color();
  gl.GenFramebuffers(1, &color_frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, color_frame);
  const auto attach = [&](GLuint& buffer, GLenum format, GLenum at) {
    gl.GenRenderbuffers(1, &buffer);
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, at, GL_RENDERBUFFER, buffer);
  };
  attach(color, GL_RGBA8, GL_COLOR_ATTACHMENT0), attach(depth, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  gl.BindRenderbuffer(GL_RENDERBUFFER, 0);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GlError("OpenGL: no framebuffer of " + std::to_string(width) + " x " + std::to_string(height) + " pixels");
  color_width = width, color_height = height, color_samples = samples;
}

void Renderer::Impl::make_shadow(int size) {
  if (shadow_frame && size == shadow_size) return;
  drop_shadow();
  gl.GenTextures(1, &shadow_map);
  gl.BindTexture(GL_TEXTURE_2D, shadow_map);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  gl.BindTexture(GL_TEXTURE_2D, 0);
  gl.GenFramebuffers(1, &shadow_frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, shadow_frame);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow_map, 0);
  const GLenum none = GL_NONE;
  gl.DrawBuffers(1, &none), gl.ReadBuffer(GL_NONE);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) throw GlError("OpenGL: no shadow map");
  shadow_size = size;
}

void Renderer::Impl::fill_shared(const Frame& f, const Camera& camera, const DrawOptions& options,
                                 const Target& target) {
  const float aspect = static_cast<float>(target.width) / static_cast<float>(target.height);
  const float tall = std::tan(camera.fov / 2), wide = tall * aspect;
  const auto width = static_cast<float>(target.width), height = static_cast<float>(target.height);
  const auto [right, up, back] = camera.axes();
  block.view_projection = camera.projection(aspect) * camera.view();
  block.shadow_matrix = kHalf * sun_matrix(f, camera);
  block.eye = {camera.eye(), f.dimension == 2 ? 1.0f : 0.0f};
  block.sun = {unit_sun(), options.shadow_size > 0 ? 1.0f : 0.0f};
  block.viewport = {{width, height, options.line_scale}, 1.0f / static_cast<float>(std::max(options.shadow_size, 1))};
  block.right = {right, wide}, block.up = {up, tall}, block.back = {back, camera.distance};
}

void Renderer::Impl::draw_shadow(const Frame& f) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, shadow_frame);
  gl.Viewport(0, 0, shadow_size, shadow_size);
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
  gl.BindFramebuffer(GL_FRAMEBUFFER, color_frame);
  gl.Viewport(0, 0, target.width, target.height);
  shared.fill(&block, sizeof block, GL_STREAM_DRAW, GL_UNIFORM_BUFFER);
  shared.bind_block(0);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, shadow_map);
  gl.DepthMask(GL_TRUE), gl.Disable(GL_DEPTH_TEST);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  const Pass opaque{gl, Stage::opaque, stats}, overlay{gl, Stage::overlay, stats};
  backdrop.draw_sky(opaque);
  gl.Enable(GL_DEPTH_TEST);
  layers(f, Stage::opaque);
  backdrop.draw_grounds(f, camera, opaque);
  gl.Enable(GL_BLEND), gl.DepthMask(GL_FALSE);
  gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
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
  r.make_color(target.width, target.height, std::min(options.samples, static_cast<int>(r.max_samples)));
  r.make_shadow(std::max(options.shadow_size, 1));  // the lit programs sample it in any case
  r.shapes.upload(frame, r.stats), r.points.upload(frame, r.stats), r.lines.upload(frame, r.stats);
  if (options.labels) r.text.upload(frame, camera, target, options.line_scale, r.stats);
  r.fill_shared(frame, camera, options, target);
  if (options.shadow_size > 0) r.draw_shadow(frame);
  r.draw_color(frame, camera, options, target);

  r.gl.BindFramebuffer(GL_READ_FRAMEBUFFER, r.color_frame);
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
