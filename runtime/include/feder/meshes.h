// Triangles of OBJ, glTF and GLB files, for lua::HostOptions::load_mesh. In the library feder::meshes
// (find_package(feder COMPONENTS meshes)). Keeps nothing between calls; safe for any bytes.
#pragma once
#include "feder/lua.h"

namespace feder::meshes {

// All triangles of the file as one mesh, by the end of its name: .obj, .gltf, .glb. Polygons are cut into triangles;
// nodes of a glTF file place what they show. Lengths are taken as metres. Triangles with a vertex twice are left out.
// Throws SceneError that names the file and the line, or the part of a glTF file, and what is wrong with it: syntax,
// numbers that are not finite, vertices that do not exist, parts that lie outside of their buffers, no triangles.
lua::TriangleMesh read(const lua::MeshFile& file);

}  // namespace feder::meshes
