// Surfaces of shapes from scripts: what parts of compounds and triangles of meshes state.
#pragma once
#include "feder/shape.h"
#include "lua/options.h"

namespace feder::lua {

// The list of tables at `index`; `what` is named in messages.
std::vector<ShapeSurface> check_surfaces(lua_State* L, int index, const std::string& what);
// Parts of a compound, and the surfaces that they name.
std::vector<CompoundPart> check_parts(lua_State* L, int index, std::vector<ShapeSurface>& surfaces);
// { surfaces =, index = ... }, behind the triangles of a mesh.
struct MeshOptions : MeshIndex {
  std::vector<ShapeSurface> surfaces;
};
MeshOptions check_mesh_options(lua_State* L, int index);
// Triangles {i, j, k} or {i, j, k, s}, counting from 1; `of`: a surface per triangle where there are surfaces.
std::vector<std::uint32_t> check_triangles(lua_State* L, int index, std::size_t vertices, std::size_t surfaces,
                                           std::vector<SurfaceNumber>& of);

// Rows of options of the maker of that kind; null for most.
std::vector<OptionInfo> (*shape_rows(const ShapeKind& kind))();

// Names of materials in the shape, each once.
std::vector<std::string> materials_of(const Shape& shape);

}  // namespace feder::lua
