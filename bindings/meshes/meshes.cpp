#include "feder/error.h"
#include "feder/lua.h"
#include "meshes/builder.h"

namespace feder::meshes {

lua::TriangleMesh read(const lua::MeshFile& file) {
  Builder builder(file);
  if (file.name.ends_with(".obj"))
    read_obj(file, builder);
  else if (file.name.ends_with(".gltf") || file.name.ends_with(".glb"))
    read_gltf(file, file.name.ends_with(".glb"), builder);
  else
    fail_file(file, "expected the name of an .obj, .gltf or .glb file");
  return builder.finish();
}

}  // namespace feder::meshes
