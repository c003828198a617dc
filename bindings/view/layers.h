// The layers of a picture, one file each (draw_shapes.cpp ...): what they keep in the driver, how they upload their
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
};

// A program whose uniform block `Shared` is at binding 0 and whose shadow map, if it has one, is texture unit 0.
std::unique_ptr<Program> make_program(const Gl& gl, const char* name, std::string_view vertex,
                                      std::string_view fragment, bool lit);

// Instances and dynamic meshes.
class ShapeLayer {
 public:
  explicit ShapeLayer(const Gl& gl);
  void upload(const Frame& frame, DrawStats& stats);
  void draw(const Frame& frame, const Pass& pass);

 private:
  struct Stored {
    std::shared_ptr<const Geometry> geometry;  // keeps its address its own
    std::unique_ptr<VertexArray> array;
    std::unique_ptr<Buffer> vertices, indices;
  };
  void store(std::size_t id, const std::shared_ptr<const Geometry>& geometry, DrawStats& stats);
  void aim(const Stored& stored, std::uint32_t first) const;  // at the instances from `first` on

  const Gl& gl_;
  std::unique_ptr<Program> lit_, depth_;
  GLint two_sided_;
  std::vector<Stored> stored_;
  Buffer instances_, mesh_vertices_, mesh_indices_;
  VertexArray mesh_array_;
};

class PointLayer {
 public:
  explicit PointLayer(const Gl& gl);
  void upload(const Frame& frame, DrawStats& stats);
  void draw(const Frame& frame, const Pass& pass);

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
  void upload(const Frame& frame, DrawStats& stats);
  void draw(const Frame& frame, const Pass& pass);

 private:
  const Gl& gl_;
  std::unique_ptr<Program> program_;
  Buffer lines_, overlay_;
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
  ~TextLayer();
  void upload(const Frame& frame, const Camera& camera, const Target& target, float scale, DrawStats& stats);
  void draw(const Pass& pass);

 private:
  struct Glyph {
    float box[4], uv[4];
    Color color;
  };
  void add(std::string_view text, float x, float y, float scale, Color color);

  const Gl& gl_;
  std::unique_ptr<Program> program_;
  GLuint atlas_ = 0;
  Buffer glyphs_;
  VertexArray array_;
  std::vector<Glyph> list_;
};

}  // namespace feder::view
