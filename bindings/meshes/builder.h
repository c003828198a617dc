// One mesh from the parts of a file.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "feder/lua.h"

namespace feder::meshes {

constexpr std::size_t kMaxMeshVertices = 10000000, kMaxMeshTriangles = 10000000;  // of a file, as a shape may have

// Throws SceneError "file: message", or "file:line: message" with a line.
[[noreturn]] void fail_file(const lua::MeshFile& file, const std::string& message, std::size_t line = 0);

class Builder {
 public:
  explicit Builder(const lua::MeshFile& file) : file_(file) {}

  std::size_t vertex_count() const { return mesh_.vertices.size(); }
  const Vec3& vertex(std::size_t i) const { return mesh_.vertices[i]; }
  // The numbers are finite; SceneError above kMaxMeshVertices.
  void add_vertex(const Vec3& at);
  // Vertices that exist; left out when two are the same. SceneError above kMaxMeshTriangles.
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  // A plane polygon, convex or not, by ear clipping.
  void add_polygon(std::span<const std::uint32_t> corners);
  // Welds, if the file is to be; SceneError for a mesh without triangles.
  lua::TriangleMesh finish();

 private:
  void weld();

  const lua::MeshFile& file_;
  lua::TriangleMesh mesh_;
};

// Readers of one format each; `builder` has nothing yet.
void read_obj(const lua::MeshFile& file, Builder& builder);
void read_gltf(const lua::MeshFile& file, bool binary, Builder& builder);

}  // namespace feder::meshes
