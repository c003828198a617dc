// Instanced shapes: one buffer of instances for the frame, one call per geometry. OpenGL 3.3 has no base instance, so
// the instance attributes are aimed anew before each call.
#include <cstddef>

#include "view/layers.h"
#include "view/shaders.h"

namespace feder::view {

ShapeLayer::ShapeLayer(const Gl& gl)
    : gl_(gl), lit_(make_program(gl, "shapes", kShapeVertex, kShapeFragment, true)),
      depth_(make_program(gl, "shapes (depth)", kShapeVertex, kDepthFragment, false)),
      two_sided_(lit_->uniform("two_sided")), instances_(gl), mesh_vertices_(gl), mesh_indices_(gl), mesh_array_(gl) {}

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

void ShapeLayer::aim(const Stored& s, std::uint32_t first) const {
  s.array->bind();
  instances_.bind();
  s.array->attributes<Instance>({{3, 3, offsetof(Instance, position)},
                                 {4, 4, offsetof(Instance, rotation)},
                                 {5, 4, offsetof(Instance, scale)},  // and the stretch behind it
                                 {6, kColor, offsetof(Instance, color)}},
                                first, 1);
}

void ShapeLayer::upload(const Frame& f) {
  static_assert(offsetof(Instance, stretch) == offsetof(Instance, scale) + 12);
  static_assert(offsetof(Vertex, edge) == offsetof(Vertex, side) + 4);
  stored_.resize(f.geometries.size());
  for (std::size_t id = 0; id < f.geometries.size(); ++id)
    if (stored_[id].geometry != f.geometries[id]) store(id, f.geometries[id]);
  instances_.fill(f.instances, GL_STREAM_DRAW);
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
    aim(s, b.first);
    const bool open = s.geometry->two_sided;
    if (!shadow) gl_.Uniform1i(two_sided_, open ? 1 : 0);
    (open || shadow) ? gl_.Disable(GL_CULL_FACE) : gl_.Enable(GL_CULL_FACE);
    pass.draw_triangles(s.geometry->indices.size(), 0, b.count);
  }
  gl_.Disable(GL_CULL_FACE);
  if (f.meshes.empty() || pass.stage == Stage::translucent) return;
  mesh_array_.bind();
  if (!shadow) gl_.Uniform1i(two_sided_, 1);
  gl_.VertexAttrib4f(2, 0, 0, 0, 0), gl_.VertexAttrib4f(3, 0, 0, 0, 0);
  gl_.VertexAttrib4f(4, 0, 0, 0, 1), gl_.VertexAttrib4f(5, 1, 1, 1, 0);
  for (const DynamicMesh& m : f.meshes) {
    mesh_vertices_.bind();
    mesh_array_.attributes<MeshVertex>({{0, 3, offsetof(MeshVertex, position)}, {1, 3, offsetof(MeshVertex, normal)}},
                                       m.first_vertex);
    gl_.VertexAttrib4f(6, m.color.r / 255.0f, m.color.g / 255.0f, m.color.b / 255.0f, m.color.a / 255.0f);
    pass.draw_triangles(m.index_count, m.first_index, 1);
  }
}

}  // namespace feder::view
