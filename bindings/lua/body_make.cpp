// world:body{ ... }
#include <algorithm>

#include "lua/rigid_part.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

const std::vector<std::string> kTypes = {"dynamic", "static", "kinematic"};

std::uint8_t lock_option(Options& o) {
  static const std::vector<std::string> names = {"x", "y", "z", "rx", "ry", "rz"};
  std::vector<std::string> words;
  o.words("lock", words);
  std::uint8_t bits = 0;
  for (const std::string& w : words) {
    const auto found = std::find(names.begin(), names.end(), w);
    if (found == names.end()) o.raise("lock", "expected some of x, y, z, rx, ry, rz, got '" + w + "'");
    bits = static_cast<std::uint8_t>(bits | 1u << (found - names.begin()));
  }
  return bits;
}

// A colour that was given, by the body or its material.
struct Paint {
  bool given = false;
  std::uint32_t rgb = 0;
};

// The material's numbers are defaults of the body's own.
void material_option(Options& o, const WorldRecord& record, BodyDesc& desc, Paint& paint) {
  if (!o.text("material", desc.material)) return;
  const auto& materials = record.settings.materials;
  const auto found = materials.find(desc.material);
  if (found == materials.end()) {
    std::vector<std::string> known;
    for (const auto& m : materials) known.push_back(m.first);
    o.raise("material", "unknown material '" + desc.material + "'; " +
                            (known.empty() ? "the world has no materials" : "known: " + join(known)));
  }
  const Material& m = found->second;
  if (m.has_friction) desc.friction_static = m.friction_static, desc.friction_dynamic = m.friction_dynamic;
  if (m.has_restitution) desc.restitution = m.restitution;
  if (m.has_density) desc.density = m.density;
  if (m.has_rolling) desc.rolling_friction = m.rolling_friction;
  if (m.has_color) paint = {true, m.color};
}

void filter_options(Options& o, BodyDesc& desc) {
  std::int64_t bits = 0;
  if (o.integer("group", bits, 0, 0xffffffffll)) desc.group = static_cast<std::uint32_t>(bits);
  if (o.integer("mask", bits, 0, 0xffffffffll)) desc.mask = static_cast<std::uint32_t>(bits);
}

void read_body(Options& o, WorldRecord& record, BodyDesc& desc, Paint& paint) {
  int type = 0;
  o.text("name", desc.name);
  o.choice("type", kTypes, type);
  desc.type = type == 0 ? BodyType::dynamic : type == 1 ? BodyType::fixed : BodyType::kinematic;
  if (!shape_option(o, "shape", desc.shape)) o.wrong("shape", "a shape (feder.box(1, 1, 1) ...)");
  o.vector("position", desc.position);
  o.rotation("rotation", desc.rotation);
  o.vector("velocity", desc.velocity);
  o.vector("angular_velocity", desc.angular_velocity);
  material_option(o, record, desc, paint);
  if (o.color("color", paint.rgb)) paint.given = true;
  const bool has_density = o.real("density", desc.density, kPositive);
  if (o.real("mass", desc.mass, kPositive) && has_density) o.raise("mass", "expected density or mass, got both");
  desc.has_center = o.vector("center_of_mass", desc.center_of_mass);
  friction_option(o, desc.friction_static, desc.friction_dynamic);
  o.real("restitution", desc.restitution, Range{0, 1});
  o.real("rolling_friction", desc.rolling_friction, kNotNegative);
  o.vector("surface_velocity", desc.surface_velocity);
  o.real("linear_damping", desc.linear_damping, kNotNegative);
  o.real("angular_damping", desc.angular_damping, kNotNegative);
  o.real("gravity_scale", desc.gravity_scale);
  o.flag("bullet", desc.bullet);
  o.flag("can_sleep", desc.can_sleep);
  o.flag("sleeping", desc.sleeping);
  desc.lock = lock_option(o);
  filter_options(o, desc);
  o.flag("sensor", desc.sensor);
  o.has("tags");
  o.finish();
  desc.tags = tag_option(o, record);
}

}  // namespace

bool friction_option(Options& o, Real& fixed, Real& dynamic) {
  if (!o.push_any("friction")) return false;
  if (lua_type(o.L(), -1) == LUA_TTABLE) {
    Options f(o.L(), -1, o.path("friction"));
    Real s = fixed, d = dynamic;
    const bool has_static = f.real("static", s, kNotNegative), has_dynamic = f.real("dynamic", d, kNotNegative);
    f.finish();
    if (!has_static && !has_dynamic)
      f.raise(nullptr, "expected a number or { static =, dynamic = }, got an empty table");
    fixed = has_static ? s : d;
    dynamic = has_dynamic ? d : s;
  } else {
    o.real("friction", fixed, kNotNegative);
    dynamic = fixed;
  }
  lua_pop(o.L(), 1);
  return true;
}

const char* body_type_name(BodyType type) {
  return type == BodyType::dynamic ? "dynamic" : type == BodyType::kinematic ? "kinematic" : "static";
}

BodyType body_type_from_name(lua_State* L, int index) {
  const std::string name = lua_type(L, index) == LUA_TSTRING ? lua_tostring(L, index) : "";
  if (name == "dynamic") return BodyType::dynamic;
  if (name == "static") return BodyType::fixed;
  if (name == "kinematic") return BodyType::kinematic;
  fail_here(L, "expected one of " + join(kTypes) + ", got " + describe(L, index));
}

int world_body(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  BodyDesc desc;
  Paint paint;
  read_body(o, r, desc, paint);
  const ObjectId id = lua::rigid(r).add_body(desc);
  if (paint.given) r.look.colors[id] = paint.rgb;
  push_handle(L, r, id);
  return 1;
}

}  // namespace feder::lua
