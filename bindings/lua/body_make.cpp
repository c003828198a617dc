// world:body{ ... }
#include <algorithm>

#include "feder/query.h"
#include "lua/rigid_part.h"
#include "lua/shape_surfaces.h"
#include "lua/shapes.h"
#include "lua/world_options.h"

namespace feder::lua {
namespace {

constexpr const char* kTypes = "static, kinematic, dynamic";  // BodyType, from fixed on

BodyType type_at(std::ptrdiff_t index) { return static_cast<BodyType>(static_cast<int>(BodyType::fixed) + index); }

struct BodyReading : Making<BodyDesc> {
  Real transparency = 0;  // 0: opaque, 1: not seen
};

void read_type(Options& o, const OptionRow& row, BodyReading& b) {
  int index = 0;
  if (o.choice("type", row.choices, index)) b.type = type_at(index);
}

std::string show_type(const BodyReading& b) { return print_value(std::string(body_type_name(b.type))); }

std::string unknown_material(const WorldSettings& settings, const std::string& name) {
  return "unknown material '" + name + "'; " +
         (settings.materials.empty() ? "the world has no materials" : "known: " + join(material_names(settings)));
}

void read_shape(Options& o, const OptionRow&, BodyReading& b) {
  if (!shape_option(o, "shape", b.shape)) o.wrong("shape", "a shape (feder.box(1, 1, 1) ...)");
  for (const std::string& name : materials_of(*b.shape))
    if (!b.record->settings.materials.count(name))
      o.raise("shape", "a surface of it has the " + unknown_material(b.record->settings, name));
}

// Materials that parts and triangles of the shape name, as the world has them.
void define_materials(WorldRecord& r, const Shape& shape) {
  for (const std::string& name : materials_of(shape)) {
    const Material& m = r.settings.materials.at(name);
    SurfaceNumbers numbers;
    if (m.has_friction) numbers.friction_static = m.friction_static, numbers.friction_dynamic = m.friction_dynamic;
    if (m.has_restitution) numbers.restitution = m.restitution;
    if (m.has_rolling) numbers.rolling_friction = m.rolling_friction;
    r.world->need<Collide>().define_material(name, numbers);
  }
}

void read_lock(Options& o, const OptionRow& row, BodyReading& b) {
  const std::vector<std::string_view> names = split_choices(row.choices);
  std::vector<std::string> words;
  o.words("lock", words);
  for (const std::string& w : words) {
    const auto found = std::find(names.begin(), names.end(), w);
    if (found == names.end()) o.raise("lock", std::string("expected some of ") + row.choices + ", got '" + w + "'");
    b.lock = static_cast<std::uint8_t>(b.lock | 1u << (found - names.begin()));
  }
}

// The material's numbers are defaults of the body's own.
void read_material(Options& o, const OptionRow&, BodyReading& b) {
  if (!o.text("material", b.material)) return;
  const auto& materials = b.record->settings.materials;
  const auto found = materials.find(b.material);
  if (found == materials.end()) o.raise("material", unknown_material(b.record->settings, b.material));
  const Material& m = found->second;
  if (m.has_friction) b.friction_static = m.friction_static, b.friction_dynamic = m.friction_dynamic;
  if (m.has_restitution) b.restitution = m.restitution;
  if (m.has_density) b.density = m.density;
  if (m.has_rolling) b.rolling_friction = m.rolling_friction;
  if (m.has_color) b.painted = true, b.color = m.color;
}

void read_mass(Options& o, const OptionRow& row, BodyReading& b) {
  if (o.real("mass", b.mass, row.range) && o.has("density")) o.raise("mass", "expected density or mass, got both");
}

// sensor = true | false | "all"
void read_sensor(Options& o, const OptionRow& row, BodyReading& b) {
  if (!o.push_any(row.name)) return;
  b.senses_fixed = lua_type(o.L(), -1) == LUA_TSTRING && text_at(o.L(), -1) == kSensorAll;
  if (!b.senses_fixed && lua_type(o.L(), -1) != LUA_TBOOLEAN) o.wrong(row.name, kSensorValues);
  b.sensor = lua_toboolean(o.L(), -1) != 0;
  lua_pop(o.L(), 1);
}

std::string show_sensor(const BodyReading& b) { return print_value(b.sensor); }

void read_center(Options& o, const OptionRow&, BodyReading& b) {
  b.has_center = o.vector("center_of_mass", b.center_of_mass);
}

void read_friction(Options& o, const OptionRow&, BodyReading& b) {
  friction_option(o, "friction", b.friction_static, b.friction_dynamic);
}

constexpr Option<BodyReading> kBody[] = {
    field<&BodyDesc::name>("name"),
    {{.name = "type", .choices = kTypes}, "string", read_type, show_type},
    special("shape", "shape", read_shape),
    field<&BodyDesc::position>("position", "m"),
    field<&BodyDesc::rotation>("rotation"),
    field<&BodyDesc::velocity>("velocity", "m/s"),
    field<&BodyDesc::angular_velocity>("angular_velocity", "rad/s"),
    special("material", "string", read_material),
    special("color", "color", read_color<BodyReading>),
    field<&BodyReading::transparency>("transparency", "", kUnitRange),
    field<&BodyDesc::density>("density", "kg/m3", kPositive),
    {{.name = "mass", .unit = "kg", .range = kPositive}, "number", read_mass},
    special("center_of_mass", "vector", read_center, "m"),
    {{.name = "friction"}, "number or table", read_friction, nullptr, friction_rows},
    field<&BodyDesc::restitution>("restitution", "", kUnitRange),
    field<&BodyDesc::rolling_friction>("rolling_friction", "m", kNotNegative),
    field<&BodyDesc::surface_velocity>("surface_velocity", "m/s"),
    field<&BodyDesc::linear_damping>("linear_damping", "1/s", kNotNegative),
    field<&BodyDesc::angular_damping>("angular_damping", "1/s", kNotNegative),
    field<&BodyDesc::gravity_scale>("gravity_scale", "", kGravityScale),
    field<&BodyDesc::bullet>("bullet"),
    field<&BodyDesc::can_sleep>("can_sleep"),
    field<&BodyDesc::sleep_threshold>("sleep_threshold", "m/s", kNotNegative),
    field<&BodyDesc::sleeping>("sleeping"),
    {{.name = "lock", .choices = "x, y, z, rx, ry, rz"}, "string or list of strings", read_lock},
    field<&BodyDesc::group>("group", "", kBits),
    field<&BodyDesc::mask>("mask", "", kBits),
    {{.name = "sensor"}, "boolean or string", read_sensor, show_sensor},
    later<BodyReading>("tags", kWordsType),
};

// Of meshes, which may take long: outside of the script's time, and by the host's way.
void make_solids(State& s, const Shape& shape) {
  s.outside_lua([&] { shape.solid(s.options.make_field); });
  for (const CompoundPart& part : shape.parts()) make_solids(s, *part.shape);
}

}  // namespace

std::vector<OptionInfo> body_rows() { return describe_rows(kBody); }

const char* body_type_name(BodyType type) {
  return type == BodyType::dynamic ? "dynamic" : type == BodyType::kinematic ? "kinematic" : "static";
}

BodyType body_type_from_name(lua_State* L, int index) {
  const std::vector<std::string_view> names = split_choices(kTypes);
  const std::string_view name = lua_type(L, index) == LUA_TSTRING ? lua_tostring(L, index) : "";
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) fail_here(L, std::string("expected one of ") + kTypes + ", got " + describe(L, index));
  return type_at(found - names.begin());
}

ObjectId world_body(WorldRecord& r, lua_State* L) {
  const BodyReading body = read_description(L, r, kBody);
  Rigid& rigid = system_of<Rigid>(r);
  define_materials(r, *body.shape);
  if (body.type == BodyType::dynamic) make_solids(state(L), *body.shape);
  const ObjectId id = rigid.add_body(body);
  if (body.painted) r.appearance.colors[id] = body.color;
  if (body.transparency > 0) r.appearance.transparencies[id] = static_cast<float>(body.transparency);
  return id;
}

}  // namespace feder::lua
