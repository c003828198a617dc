// The layers of a picture: what they keep in the driver, how they upload their
// part of a frame, and how they draw it. The renderer sets the passes up and calls them in order.
#pragma once
#include <memory>
#include <vector>

#include "view/gl.h"

namespace feder::view {

enum class Stage { shadow, opaque, translucent, overlay };

struct Pass {
  const Gl& gl;
  Stage stage;
  DrawStats& stats;

  void draw_squares(std::size_t count) const {
    gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(count));
    ++stats.draw_calls;
  }
  void draw_triangles(std::size_t index_count, std::size_t first_index, std::size_t instances) const {
    gl.DrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(index_count), GL_UNSIGNED_INT,
                             reinterpret_cast<const void*>(sizeof(std::uint32_t) * first_index),
                             static_cast<GLsizei>(instances));
    ++stats.draw_calls;
  }
};

// A program whose uniform block `Shared` is at binding 0 and whose shadow map, if it has one, is texture unit 0.
std::unique_ptr<Program> make_program(const Gl& gl, const char* name, std::string_view vertex,
                                      std::string_view fragment, bool lit);

// Instances and dynamic meshes.
class ShapeLayer {
 public:
  explicit ShapeLayer(const Gl& gl);
  void upload(const Frame& frame, Float3 eye);
  void draw(const Frame& frame, const Pass& pass);
  const Buffer& mesh_vertices() const { return mesh_vertices_; }  // Frame::vertices
  const Buffer& mesh_indices() const { return mesh_indices_; }

 private:
  struct Stored {
    std::shared_ptr<const Geometry> geometry;  // keeps its address its own
    std::unique_ptr<VertexArray> array;
    std::unique_ptr<Buffer> vertices, indices;
  };
  void store(std::size_t id, const std::shared_ptr<const Geometry>& geometry);
  // A translucent instance whose triangles are drawn in the order that its eye asks for, in pieces.
  struct Sorted {
    std::uint32_t instance, first_index, index_count;
  };
  void sort(const Frame& frame, Float3 eye);
  void sort(const Instance& instance, std::uint32_t number, const Shape& shape, Float3 eye);
  void draw_sorted(const Pass& pass) const;
  void aim(const VertexArray& array, std::uint32_t first) const;  // at the instances from `first` on

  const Gl& gl_;
  std::unique_ptr<Program> lit_, depth_;
  GLint two_sided_;
  std::vector<Stored> stored_;
  Buffer instances_, mesh_vertices_, mesh_indices_, sorted_vertices_, sorted_indices_;
  VertexArray mesh_array_, sorted_array_;
  std::vector<Sorted> sorted_;
  std::vector<Vertex> vertices_;        // of those
  std::vector<std::uint32_t> indices_;  // of those
};

class PointLayer {
 public:
  explicit PointLayer(const Gl& gl);
  void upload(const Frame& frame);
  void draw(const Frame& frame, const Pass& pass);
  void aim(const VertexArray& array, std::uint32_t first) const;  // at the points from `first` on, one per instance

 private:
  const Gl& gl_;
  std::unique_ptr<Program> lit_, depth_;
  GLint plain_, range_, orthographic_;
  Buffer points_;
  VertexArray array_;
};

class LineLayer {
 public:
  explicit LineLayer(const Gl& gl);
  void upload(const Frame& frame);
  void draw(const Frame& frame, const Pass& pass);

 private:
  void draw(const std::vector<Line>& lines, const Buffer& buffer, const Pass& pass) const;

  const Gl& gl_;
  std::unique_ptr<Program> program_;
  Buffer lines_, outlines_, overlay_;
  VertexArray array_;
};

// The sky and the planes.
class BackdropLayer {
 public:
  explicit BackdropLayer(const Gl& gl);
  void draw_sky(const Pass& pass);
  void draw_grounds(const Frame& frame, const Camera& camera, const Pass& pass);

 private:
  const Gl& gl_;
  std::unique_ptr<Program> sky_, ground_;
  VertexArray array_;
};

// Labels, upright on the screen at the places they name.
class TextLayer {
 public:
  explicit TextLayer(const Gl& gl);
  void upload(const Frame& frame, const Camera& camera, const Target& target, float scale);
  void draw(const Pass& pass);

 private:
  struct Glyph {
    float box[4], uv[4];
    Color color;
  };
  void add(std::string_view text, float x, float y, float scale, Color color);

  const Gl& gl_;
  std::unique_ptr<Program> program_;
  GlObject atlas_;
  Buffer glyphs_;
  VertexArray array_;
  std::vector<Glyph> list_;
};

}  // namespace feder::view
