#include "lua/shape_surfaces.h"

#include <algorithm>

#include "lua/shapes.h"
#include "lua/stack.h"
#include "lua/world_options.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxTriangles = 10000000, kMaxParts = 4096;

void read_friction(Options& o, const OptionRow& row, ShapeSurface& s) {
  friction_option(o, row.name, s.numbers.friction_static, s.numbers.friction_dynamic);
}

template <Real SurfaceNumbers::*Value>
void read_number(Options& o, const OptionRow& row, ShapeSurface& s) {
  o.real(row.name, s.numbers.*Value, row.range);
}

void read_velocity(Options& o, const OptionRow& row, ShapeSurface& s) {
  s.has_velocity = o.vector(row.name, s.velocity);
}

void read_material(Options& o, const OptionRow& row, ShapeSurface& s) {
  if (o.text(row.name, s.material) && s.material.empty()) o.wrong(row.name, "the name of a material");
}

constexpr Option<ShapeSurface> kSurface[] = {
    {{.name = "friction"}, "number or table", read_friction, nullptr, friction_rows},
    {{.name = "restitution", .range = kUnitRange}, "number", read_number<&SurfaceNumbers::restitution>},
    {{.name = "rolling_friction", .unit = "m", .range = kNotNegative},
     "number",
     read_number<&SurfaceNumbers::rolling_friction>},
    special("surface_velocity", "vector", read_velocity, "m/s"),
    special("material", "string", read_material),
};

void read_part(Options& o, const OptionRow&, CompoundPart& p) {
  if (!shape_option(o, "shape", p.shape)) o.wrong("shape", "a shape (feder.box(1, 1, 1) ...)");
  o.vector("position", p.pose.position);
  o.rotation("rotation", p.pose.rotation);
}

constexpr Option<CompoundPart> kPart[] = {
    special("shape", "shape", read_part),
    later<CompoundPart>("position", "vector", "m"),
    later<CompoundPart>("rotation", "rotation"),
};

using Surfaces = std::vector<ShapeSurface>;

void read_surfaces(Options& o, const OptionRow& row, MeshOptions& m) {
  if (!o.push(row.name, LUA_TTABLE, "a list of { friction =, ... }")) return;
  m.surfaces = check_surfaces(o.L(), -1, o.path(row.name));
  lua_pop(o.L(), 1);
}

constexpr Option<MeshOptions> kMesh[] = {
    {{.name = "surfaces"}, "list of {friction =, ...}", read_surfaces, nullptr, rows_of<kSurface>},
    field<&MeshOptions::index>("index").of(mesh_index_names).unset(),
    field<&MeshOptions::volume>("volume").of(bounding_volume_names).unset(),
    field<&MeshOptions::build>("build").of(tree_build_names).unset(),
    field<&MeshOptions::leaf>("leaf", "", {1, 64}).unset(),
};

bool states(const ShapeSurface& s) {
  bool any = s.has_velocity || !s.material.empty();
  SurfaceNumbers::each_field(s.numbers, [&](Real x) { any = any || x >= 0; });
  return any;
}

std::string item(const std::string& list, lua_Integer i) { return list + "[" + std::to_string(i) + "]"; }

}  // namespace

std::vector<ShapeSurface> check_surfaces(lua_State* L, int index, const std::string& what) {
  const auto count = lua_rawlen(L, index);
  if (count > kMaxSurfaces)
    fail(L, what + ": expected at most " + std::to_string(kMaxSurfaces) + " surfaces, got " + std::to_string(count));
  Surfaces all;
  each_entry(L, index, [&](lua_Integer i) { Options(L, -1, item(what, i), true).read(kSurface, all.emplace_back()); });
  return all;
}

MeshOptions check_mesh_options(lua_State* L, int index) {
  MeshOptions all;
  if (!lua_isnoneornil(L, index)) Options(L, index, function_name(L)).read(kMesh, all);
  return all;
}

std::vector<CompoundPart> check_parts(lua_State* L, int index, std::vector<ShapeSurface>& surfaces) {
  const std::string name = function_name(L);
  if (lua_type(L, index) != LUA_TTABLE)
    fail_here(L, "expected a list of { shape =, position =, rotation = }, got " + describe(L, index));
  const auto count = lua_rawlen(L, index);
  if (count == 0 || count > kMaxParts) fail_here(L, "expected 1 to 4096 parts, got " + std::to_string(count));
  std::vector<CompoundPart> parts;
  each_entry(L, index, [&](lua_Integer i) {
    Options o(L, -1, item(name, i), true);
    ShapeSurface surface;
    o.read_some(kSurface, surface);
    o.read(kPart, parts.emplace_back());
    if (!states(surface)) return;
    surfaces.push_back(std::move(surface));
    parts.back().surface = static_cast<SurfaceNumber>(surfaces.size());
  });
  return parts;
}

std::vector<std::uint32_t> check_triangles(lua_State* L, int index, std::size_t vertices, std::size_t surfaces,
                                           std::vector<SurfaceNumber>& of) {
  const std::string name = std::string(function_name(L)) + ".triangles";
  if (lua_type(L, index) != LUA_TTABLE) fail(L, name + ": expected a list of {i, j, k}, got " + describe(L, index));
  const auto count = lua_rawlen(L, index);
  if (count > kMaxTriangles)
    fail(L, name + ": expected at most " + std::to_string(kMaxTriangles) + " triangles, got " + std::to_string(count));
  std::vector<std::uint32_t> out;
  if (surfaces > 0) of.assign(count, 0);
  each_entry(L, index, [&](lua_Integer t) {
    const std::string what = item(name, t);
    const bool fourth = lua_type(L, -1) == LUA_TTABLE && lua_rawlen(L, -1) == 4;
    if (!fourth) return check_indices(L, -1, what, "{i, j, k}", 3, 3, vertices, out);
    if (surfaces == 0) fail(L, what + ": names a surface, but { surfaces = } is missing behind the triangles");
    for (int k = 1; k <= 4; ++k) {
      lua_rawgeti(L, -1, k);
      if (k < 4)
        out.push_back(check_index(L, -1, what, vertices));
      else
        of[static_cast<std::size_t>(t - 1)] =
            static_cast<SurfaceNumber>(check_index(L, -1, what + ": its surface", surfaces) + 1);
      lua_pop(L, 1);
    }
  });
  return out;
}

std::vector<OptionInfo> (*shape_rows(const ShapeKind& kind))() {
  for (const ShapeArgument& a : kind.arguments) {
    if (a.type == ShapeArgumentType::parts)
      return [] { return join_rows(describe_rows(kPart), describe_rows(kSurface)); };
    if (a.type == ShapeArgumentType::surfaces) return rows_of<kMesh>;
  }
  return nullptr;
}

std::vector<std::string> materials_of(const Shape& shape) {
  std::vector<std::string> names;
  const auto add = [&](const Shape& from) {
    for (const ShapeSurface& s : from.surfaces())
      if (!s.material.empty() && std::find(names.begin(), names.end(), s.material) == names.end())
        names.push_back(s.material);
  };
  add(shape);
  for (const CompoundPart& part : shape.parts()) add(*part.shape);
  return names;
}

}  // namespace feder::lua
