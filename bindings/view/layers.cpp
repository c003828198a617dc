#include "view/layers.h"

#include <cmath>
#include <cstddef>

#include "view/font.h"
#include "view/shaders.h"

namespace feder::view {
namespace {

constexpr float kSize = 15;     // pixels
constexpr float kClear = 0.7f;  // liquids more transparent cast no shadow

// Baked once for all renderers of the process: it never changes.
const Font& font() {
  static const Font baked(kSize);
  return baked;
}

}  // namespace

// Instanced shapes: one buffer of instances for the frame, one call per geometry. OpenGL 3.3 has no base instance, so
// the instance attributes are aimed anew before each call.
ShapeLayer::ShapeLayer(const Gl& gl)
    : gl_(gl), lit_(make_program(gl, "shapes", kShapeVertex, kShapeFragment, true)),
      depth_(make_program(gl, "shapes (depth)", kShapeVertex, kDepthFragment, false)),
      two_sided_(lit_->uniform("two_sided")), instances_(gl), mesh_vertices_(gl), mesh_indices_(gl),
      sorted_vertices_(gl), sorted_indices_(gl), mesh_array_(gl), sorted_array_(gl) {}

void ShapeLayer::store(std::size_t id, const std::shared_ptr<const Geometry>& geometry) {
  Stored& s = stored_[id];
  s = {geometry, std::make_unique<VertexArray>(gl_), std::make_unique<Buffer>(gl_), std::make_unique<Buffer>(gl_)};
  s.array->bind();
  s.vertices->fill(geometry->vertices, GL_STATIC_DRAW);
  s.array->attributes<Vertex>(
      {{0, 3, offsetof(Vertex, position)}, {1, 3, offsetof(Vertex, normal)}, {2, 2, offsetof(Vertex, side)}});
  s.indices->fill(geometry->indices, GL_STATIC_DRAW, GL_ELEMENT_ARRAY_BUFFER);
  gl_.BindVertexArray(0);
}

void ShapeLayer::aim(const VertexArray& array, std::uint32_t first) const {
  array.bind();
  instances_.bind();
  array.attributes<Instance>({{3, 3, offsetof(Instance, position)},
                              {4, 4, offsetof(Instance, rotation)},
                              {5, 4, offsetof(Instance, scale)},  // and the stretch behind it
                              {6, kColor, offsetof(Instance, color)}},
                             first, 1);
}

// In pieces, since triangles that cross one another have no order.
void ShapeLayer::sort(const Instance& instance, std::uint32_t number, const Shape& shape, Float3 eye) {
  const float* q = instance.rotation;
  const Pose pose{to_vec3(instance.position), Quat{Real(q[0]), Real(q[1]), Real(q[2]), Real(q[3])}};
  const auto first = static_cast<std::uint32_t>(indices_.size());
  const auto add = [](void* context, std::uint32_t, std::span<const Vec3> corners) {
    ShapeLayer& to = *static_cast<ShapeLayer*>(context);
    const auto v = static_cast<std::uint32_t>(to.vertices_.size());
    Vec3 across = Vec3::Zero();
    for (std::size_t k = 2; k < corners.size(); ++k)
      across += cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
    const Float3 normal = to_float3(normalized_or(across, vec3(0, 1, 0)));
    for (const Vec3& c : corners) to.vertices_.push_back({to_float3(c), normal, 0, 0});
    for (std::uint32_t k = 2; k < corners.size(); ++k) to.indices_.insert(to.indices_.end(), {v, v + k - 1, v + k});
  };
  shape.back_to_front(to_local(pose, to_vec3(eye)), add, this);
  sorted_.push_back({number, first, static_cast<std::uint32_t>(indices_.size()) - first});
}

void ShapeLayer::sort(const Frame& f, Float3 eye) {
  sorted_.clear(), vertices_.clear(), indices_.clear();
  for (const Batch& b : f.batches)
    if (const Shape* shape = f.geometries[b.geometry]->ordered.get(); shape && b.translucent)
      for (std::uint32_t i = b.first; i < b.first + b.count; ++i) sort(f.instances[i], i, *shape, eye);
  if (sorted_.empty()) return;
  sorted_array_.bind();
  sorted_vertices_.fill(vertices_, GL_STREAM_DRAW);
  sorted_array_.attributes<Vertex>(
      {{0, 3, offsetof(Vertex, position)}, {1, 3, offsetof(Vertex, normal)}, {2, 2, offsetof(Vertex, side)}});
  sorted_indices_.fill(indices_, GL_STREAM_DRAW, GL_ELEMENT_ARRAY_BUFFER);
  gl_.BindVertexArray(0);
}

void ShapeLayer::draw_sorted(const Pass& pass) const {
  gl_.Uniform1i(two_sided_, 1);
  gl_.Disable(GL_CULL_FACE);
  for (const Sorted& s : sorted_) {
    aim(sorted_array_, s.instance);
    pass.draw_triangles(s.index_count, s.first_index, 1);
  }
}

void ShapeLayer::upload(const Frame& f, Float3 eye) {
  static_assert(offsetof(Instance, stretch) == offsetof(Instance, scale) + 12);
  static_assert(offsetof(Vertex, edge) == offsetof(Vertex, side) + 4);
  stored_.resize(f.geometries.size());
  for (std::size_t id = 0; id < f.geometries.size(); ++id)
    if (stored_[id].geometry != f.geometries[id]) store(id, f.geometries[id]);
  instances_.fill(f.instances, GL_STREAM_DRAW);
  sort(f, eye);
  if (f.meshes.empty()) return;
  mesh_array_.bind();
  mesh_vertices_.fill(f.vertices, GL_STREAM_DRAW);
  mesh_indices_.fill(f.indices, GL_STREAM_DRAW, GL_ELEMENT_ARRAY_BUFFER);
  gl_.BindVertexArray(0);
}

void ShapeLayer::draw(const Frame& f, const Pass& pass) {
  if (pass.stage == Stage::overlay) return;
  const bool shadow = pass.stage == Stage::shadow;
  (shadow ? depth_ : lit_)->use();
  for (const Batch& b : f.batches) {
    if (b.translucent != (pass.stage == Stage::translucent)) continue;
    const Stored& s = stored_[b.geometry];
    if (b.translucent && s.geometry->ordered) continue;
    aim(*s.array, b.first);
    const bool open = s.geometry->two_sided;
    if (!shadow) gl_.Uniform1i(two_sided_, open ? 1 : 0);
    (open || shadow) ? gl_.Disable(GL_CULL_FACE) : gl_.Enable(GL_CULL_FACE);
    pass.draw_triangles(s.geometry->indices.size(), 0, b.count);
  }
  gl_.Disable(GL_CULL_FACE);
  if (pass.stage == Stage::translucent && !sorted_.empty()) draw_sorted(pass);
  if (f.meshes.empty() || pass.stage == Stage::translucent) return;
  mesh_array_.bind();
  if (!shadow) gl_.Uniform1i(two_sided_, 1);
  gl_.VertexAttrib4f(2, 0, 0, 0, 0), gl_.VertexAttrib4f(3, 0, 0, 0, 0);
  gl_.VertexAttrib4f(4, 0, 0, 0, 1), gl_.VertexAttrib4f(5, 1, 1, 1, 0);
  for (const DynamicMesh& m : f.meshes) {
    if (m.liquid != kNone && (!shadow || f.liquids[m.liquid].transparency > kClear)) continue;
    mesh_vertices_.bind();
    mesh_array_.attributes<MeshVertex>({{0, 3, offsetof(MeshVertex, position)}, {1, 3, offsetof(MeshVertex, normal)}},
                                       m.first_vertex);
    gl_.VertexAttrib4f(6, m.color.r / 255.0f, m.color.g / 255.0f, m.color.b / 255.0f, m.color.a / 255.0f);
    pass.draw_triangles(m.index_count, m.first_index, 1);
  }
}

// Points as spheres: a square for each, on which the fragments find the sphere and its depth.
PointLayer::PointLayer(const Gl& gl)
    : gl_(gl), lit_(make_program(gl, "points", kPointVertex, kPointFragment, true)),
      depth_(make_program(gl, "points (depth)", kPointVertex, kPointDepthFragment, false)),
      plain_(lit_->uniform("plain")), range_(lit_->uniform("range")), orthographic_(depth_->uniform("orthographic")),
      points_(gl), array_(gl) {}

void PointLayer::upload(const Frame& f) { points_.fill(f.points, GL_STREAM_DRAW); }

void PointLayer::aim(const VertexArray& array, std::uint32_t first) const {
  array.bind();
  points_.bind();
  array.attributes<Point>({{0, 4, offsetof(Point, position)}, {1, 1, offsetof(Point, value)}}, first, 1);
}

void PointLayer::draw(const Frame& f, const Pass& pass) {
  if (f.point_groups.empty() || (pass.stage != Stage::opaque && pass.stage != Stage::shadow)) return;
  const bool shadow = pass.stage == Stage::shadow;
  (shadow ? depth_ : lit_)->use();
  if (shadow) gl_.Uniform1i(orthographic_, 1);
  for (const PointGroup& g : f.point_groups) {
    if (g.liquid != kNone && (!shadow || f.liquids[g.liquid].transparency > kClear)) continue;
    if (shadow && !g.casts_shadow) continue;
    aim(array_, g.first);
    if (!shadow) {
      gl_.Uniform4f(plain_, g.color.r / 255.0f, g.color.g / 255.0f, g.color.b / 255.0f, g.scalar ? -1.0f : 1.0f);
      gl_.Uniform2f(range_, g.low, g.high);
    }
    pass.draw_squares(g.count);
  }
}

// Lines with a width in pixels: OpenGL 3.3 core has only thin ones, so each is a rectangle on the screen.
LineLayer::LineLayer(const Gl& gl)
    : gl_(gl), program_(make_program(gl, "lines", kLineVertex, kLineFragment, false)), lines_(gl), outlines_(gl),
      overlay_(gl), array_(gl) {}

void LineLayer::upload(const Frame& f) {
  lines_.fill(f.lines, GL_STREAM_DRAW);
  outlines_.fill(f.outlines, GL_STREAM_DRAW);
  overlay_.fill(f.overlay_lines, GL_STREAM_DRAW);
}

void LineLayer::draw(const Frame& f, const Pass& pass) {
  if (pass.stage == Stage::overlay) draw(f.overlay_lines, overlay_, pass);
  if (pass.stage == Stage::translucent) draw(f.lines, lines_, pass), draw(f.outlines, outlines_, pass);
}

void LineLayer::draw(const std::vector<Line>& lines, const Buffer& buffer, const Pass& pass) const {
  if (lines.empty()) return;
  program_->use();
  array_.bind();
  buffer.bind();
  array_.attributes<Line>({{0, 3, offsetof(Line, a)},
                           {1, 3, offsetof(Line, b)},
                           {2, kColor, offsetof(Line, color_a)},
                           {3, kColor, offsetof(Line, color_b)},
                           {4, 1, offsetof(Line, width)}},
                          0, 1);
  pass.draw_squares(lines.size());
}

// Sky and ground. A plane is one large square about the point below the camera's target; its grid keeps a readable
// spacing (a power of ten of metres) and it fades into the sky, so that its end is not seen.
BackdropLayer::BackdropLayer(const Gl& gl)
    : gl_(gl), sky_(make_program(gl, "sky", kBackgroundVertex, kBackgroundFragment, false)),
      ground_(make_program(gl, "ground", kGroundVertex, kGroundFragment, true)), array_(gl) {}

void BackdropLayer::draw_sky(const Pass& pass) {
  sky_->use();
  array_.bind();
  pass.draw_squares(1);
}

void BackdropLayer::draw_grounds(const Frame& f, const Camera& camera, const Pass& pass) {
  if (f.grounds.empty()) return;
  ground_->use();
  array_.bind();
  const bool planar = f.dimension == 2;
  const Real reach = Real(camera.distance) * (planar ? Real(3) : Real(9));
  const Vec3 target = to_vec3(camera.target), eye = to_vec3(camera.eye());
  const auto spacing =
      static_cast<float>(std::pow(10.0, std::floor(std::log10(0.25 * static_cast<double>(camera.distance)))));
  for (const Ground& g : f.grounds) {
    const Vec3 n = to_vec3(g.normal);
    const Real height = dot(n, target) - Real(g.distance);
    if (!planar && dot(n, eye) < Real(g.distance)) continue;  // from inside the ground all is seen
    Vec3 origin = target - height * n, along, over, u = vec3(1, 0, 0), v = vec3(0, 0, 1);
    if (planar) {
      // the cut face, in front of the bodies' middle like their own front faces
      along = reach * cross(vec3(0, 0, 1), n), over = Real(-0.5) * reach * n;
      origin += over + vec3(0, 0, Real(kPrismDepth / 2));
      v = vec3(0, 1, 0);
    } else {
      if (std::abs(n[1]) < Real(0.999)) tangent_frame(n, u, v);
      along = reach * u, over = -reach * cross(n, u);
    }
    const Float3 albedo{g.color.r / 255.0f, g.color.g / 255.0f, g.color.b / 255.0f};
    const std::pair<const char*, Float3> vectors[] = {
        {"origin", to_float3(origin)}, {"along", to_float3(along)}, {"over", to_float3(over)}, {"axis_u", to_float3(u)},
        {"axis_v", to_float3(v)},      {"plane_normal", g.normal},  {"albedo", albedo}};
    for (const auto& [name, v3] : vectors) gl_.Uniform3f(ground_->uniform(name), v3.x, v3.y, v3.z);
    gl_.Uniform1f(ground_->uniform("spacing"), spacing);
    gl_.Uniform1f(ground_->uniform("reach"), static_cast<float>(reach));
    pass.draw_squares(1);
  }
}

// Labels: glyphs as textured squares in pixels, placed where the camera sees their points.
TextLayer::TextLayer(const Gl& gl)
    : gl_(gl), program_(make_program(gl, "text", kTextVertex, kTextFragment, false)),
      atlas_(gl.GenTextures, gl.DeleteTextures), glyphs_(gl), array_(gl) {
  gl_.BindTexture(GL_TEXTURE_2D, atlas_.id());
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, font().atlas_width(), font().atlas_height(), 0, GL_RED, GL_UNSIGNED_BYTE,
                 font().atlas().data());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl_.BindTexture(GL_TEXTURE_2D, 0);
}

void TextLayer::add(std::string_view text, float x, float y, float scale, Color color) {
  for (const char c : text) {
    const Font::Glyph& g = font().glyph(c);
    list_.push_back({{x + scale * g.left, y + scale * g.top, x + scale * g.right, y + scale * g.bottom},
                     {g.u0, g.v0, g.u1, g.v1},
                     color});
    x += scale * g.advance;
  }
}

void TextLayer::upload(const Frame& f, const Camera& camera, const Target& target, float scale) {
  list_.clear();
  for (const Label& label : f.labels) {
    float x = 0, y = 0;
    if (!camera.project(label.position, target.width, target.height, x, y)) continue;
    const std::string_view text = label.text;
    x = std::floor(x - 0.5f * scale * font().width(text)), y = std::floor(y - 0.5f * scale * font().line_height());
    // a pale rim first, so that text is read on any colour
    const Color rim{255, 255, 255, 150};
    for (const auto& [dx, dy] : {std::pair{-1.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, -1.0f}, {0.0f, 1.0f}})
      add(text, x + scale * dx, y + scale * dy, scale, rim);
    add(text, x, y, scale, label.color);
  }
  glyphs_.fill(list_, GL_STREAM_DRAW);
}

void TextLayer::draw(const Pass& pass) {
  if (list_.empty()) return;
  program_->use();
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, atlas_.id());
  array_.bind();
  glyphs_.bind();
  array_.attributes<Glyph>(
      {{0, 4, offsetof(Glyph, box)}, {1, 4, offsetof(Glyph, uv)}, {2, kColor, offsetof(Glyph, color)}}, 0, 1);
  pass.draw_squares(list_.size());
  gl_.BindTexture(GL_TEXTURE_2D, 0);
}

}  // namespace feder::view
