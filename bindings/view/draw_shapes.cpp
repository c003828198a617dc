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

void ShapeLayer::store(std::size_t id, const std::shared_ptr<const Geometry>& geometry, DrawStats& stats) {
  Stored& s = stored_[id];
  s = {geometry, std::make_unique<VertexArray>(gl_), std::make_unique<Buffer>(gl_), std::make_unique<Buffer>(gl_)};
  s.array->bind();
  s.vertices->fill(geometry->vertices.data(), geometry->vertices.size() * sizeof(Vertex), GL_STATIC_DRAW);
  s.array->floats(0, 3, sizeof(Vertex), offsetof(Vertex, position));
  s.array->floats(1, 3, sizeof(Vertex), offsetof(Vertex, normal));
  s.array->floats(2, 2, sizeof(Vertex), offsetof(Vertex, side));
  s.indices->fill(geometry->indices.data(), geometry->indices.size() * 4, GL_STATIC_DRAW, GL_ELEMENT_ARRAY_BUFFER);
  gl_.BindVertexArray(0);
  stats.bytes_uploaded += geometry->vertices.size() * sizeof(Vertex) + geometry->indices.size() * 4;
}

void ShapeLayer::aim(const Stored& s, std::uint32_t first) const {
  const std::size_t at = first * sizeof(Instance);
  s.array->bind();
  instances_.bind();
  s.array->floats(3, 3, sizeof(Instance), at + offsetof(Instance, position), 1);
  s.array->floats(4, 4, sizeof(Instance), at + offsetof(Instance, rotation), 1);
  s.array->floats(5, 4, sizeof(Instance), at + offsetof(Instance, scale), 1);  // and the stretch behind it
  s.array->bytes(6, sizeof(Instance), at + offsetof(Instance, color), 1);
}

void ShapeLayer::upload(const Frame& f, DrawStats& stats) {
  static_assert(offsetof(Instance, stretch) == offsetof(Instance, scale) + 12);
  static_assert(offsetof(Vertex, edge) == offsetof(Vertex, side) + 4);
  stored_.resize(f.geometries.size());
  for (std::size_t id = 0; id < f.geometries.size(); ++id)
    if (stored_[id].geometry != f.geometries[id]) store(id, f.geometries[id], stats);
  if (!f.instances.empty()) {
    instances_.fill(f.instances.data(), f.instances.size() * sizeof(Instance), GL_STREAM_DRAW);
    stats.bytes_uploaded += f.instances.size() * sizeof(Instance);
  }
  if (f.meshes.empty()) return;
  mesh_array_.bind();
  mesh_vertices_.fill(f.vertices.data(), f.vertices.size() * sizeof(MeshVertex), GL_STREAM_DRAW);
  mesh_indices_.fill(f.indices.data(), f.indices.size() * 4, GL_STREAM_DRAW, GL_ELEMENT_ARRAY_BUFFER);
  gl_.BindVertexArray(0);
  stats.bytes_uploaded += f.vertices.size() * sizeof(MeshVertex) + f.indices.size() * 4;
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
    const auto count = static_cast<GLsizei>(s.geometry->indices.size());
    gl_.DrawElementsInstanced(GL_TRIANGLES, count, GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(b.count));
    ++pass.stats.draw_calls;
    pass.stats.triangles += s.geometry->indices.size() / 3 * b.count;
  }
  gl_.Disable(GL_CULL_FACE);
  if (f.meshes.empty() || pass.stage == Stage::translucent) return;
  mesh_array_.bind();
  if (!shadow) gl_.Uniform1i(two_sided_, 1);
  gl_.VertexAttrib4f(2, 0, 0, 0, 0), gl_.VertexAttrib4f(3, 0, 0, 0, 0);
  gl_.VertexAttrib4f(4, 0, 0, 0, 1), gl_.VertexAttrib4f(5, 1, 1, 1, 0);
  for (const DynamicMesh& m : f.meshes) {
    const std::size_t at = m.first_vertex * sizeof(MeshVertex);
    mesh_vertices_.bind();
    mesh_array_.floats(0, 3, sizeof(MeshVertex), at + offsetof(MeshVertex, position));
    mesh_array_.floats(1, 3, sizeof(MeshVertex), at + offsetof(MeshVertex, normal));
    gl_.VertexAttrib4f(6, m.color.r / 255.0f, m.color.g / 255.0f, m.color.b / 255.0f, m.color.a / 255.0f);
    gl_.DrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(m.index_count), GL_UNSIGNED_INT,
                              reinterpret_cast<const void*>(std::size_t(4) * m.first_index), 1);
    ++pass.stats.draw_calls;
    pass.stats.triangles += m.index_count / 3;
  }
}

}  // namespace feder::view
