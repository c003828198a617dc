// Scenes as files of other programs: a moment as OBJ or PLY, a run as animated glTF 2.0.
#pragma once
#include <filesystem>
#include <memory>

#include "feder/object.h"
#include "view/frame.h"

namespace feder::view {

// Triangles with normals, one group per object, colours in a .mtl beside it. SceneError when a file cannot be written.
void write_obj(const Frame& frame, const Objects& objects, const std::filesystem::path& file);
// Binary little-endian PLY with normals and colours; points that are no part of a face (fluid particles) as vertices.
void write_ply(const Frame& frame, const std::filesystem::path& file);

// glTF: every instance is a node whose translation and rotation are animated; what appears later or goes away has scale
// 0 meanwhile. Meshes that move by vertex (faces and springs of nets) get a morph target per sample. Up to
// kMaxAnimatedPoints points become little balls; larger clouds are left out (left_out() says how many).
inline constexpr std::size_t kMaxAnimatedPoints = 2000;

class GltfWriter {
 public:
  GltfWriter();
  ~GltfWriter();
  void add(const Frame& frame, const Objects& objects);  // the next sample, at frame.time
  std::size_t left_out() const;                          // points
  void write(const std::filesystem::path& file);         // .gltf (one file, buffers inside) or .glb. SceneError.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder::view
