// The methods of bodies: check, call, push.
#include "lua/rigid_part.h"
#include "lua/shapes.h"
#include "lua/world_options.h"
#include "state/bodies.h"
#include "state/colliders.h"

namespace feder::lua {
namespace {

using Body = Object<Rigid>;

// x, y, z, w as numbers from `index`, or one table in the forms of the rotation option.
Quat rotation_argument(lua_State* L, int index) {
  if (lua_type(L, index) == LUA_TTABLE) return check_rotation(L, index, function_name(L));
  lua_createtable(L, 4, 0);
  static const char* const names[] = {".x", ".y", ".z", ".w"};
  for (int k = 0; k < 4; ++k) {
    check_number(L, index + k, std::string(function_name(L)) + names[k]);
    lua_pushvalue(L, index + k);
    lua_rawseti(L, -2, k + 1);
  }
  const Quat q = check_rotation(L, -1, function_name(L));
  lua_pop(L, 1);
  return q;
}

Vec3 body_position(const Body& b) { return b.system.pose(b.id).position; }

void body_set_position(const Body& b, const Vec3& position) {
  b.system.set_pose(b.id, {position, b.system.pose(b.id).rotation});
}

std::array<Real, 4> body_rotation(const Body& b) {
  const Quat q = b.system.pose(b.id).rotation;
  return {q.x, q.y, q.z, q.w};
}

void body_set_rotation(const Body& b, lua_State* L) {
  const Quat q = rotation_argument(L, 2);
  b.system.set_pose(b.id, {b.system.pose(b.id).position, q});
}

std::array<Real, 6> body_inertia(const Body& b) {
  const Mat3 m = b.system.inertia(b.id);
  return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
}

Vec3 body_world_point(const Body& b, const Vec3& local) { return to_world(b.system.pose(b.id), local); }
Vec3 body_local_point(const Body& b, const Vec3& world) { return to_local(b.system.pose(b.id), world); }
Vec3 body_velocity_at(const Body& b, const Vec3& world) {
  return b.system.bodies().velocity_at(b.system.index(b.id), world);
}

// Axes of rotation have three numbers in 2D too.
template <void (Rigid::*Set)(ObjectId, const Vec3&)>
void set_axial(const Body& b, lua_State* L) {
  (b.system.*Set)(b.id, vector_argument(L, 2, false));
}

template <void (Rigid::*Set)(ObjectId, Real), const Range& kRange>
void set_number(const Body& b, lua_State* L) {
  (b.system.*Set)(b.id, number_argument(L, 2, kRange));
}

// A force or impulse, at a point when there are more numbers.
template <void (Rigid::*Apply)(ObjectId, const Vec3&, const Vec3*)>
void apply_at(const Body& b, lua_State* L) {
  int next = 0;
  const Vec3 v = vector_argument(L, 2, b.record.planar(), &next);
  const bool has_point = !lua_isnoneornil(L, next);
  const Vec3 point = has_point ? vector_argument(L, next, b.record.planar()) : Vec3(Vec3::Zero());
  (b.system.*Apply)(b.id, v, has_point ? &point : nullptr);
}

bool body_awake(const Body& b) { return b.system.bodies().awake[b.system.index(b.id)]; }
void body_wake(const Body& b) { b.system.wake(b.id); }
const char* body_type(const Body& b) { return body_type_name(b.system.type(b.id)); }
void body_set_type(const Body& b, lua_State* L) { b.system.set_type(b.id, body_type_from_name(L, 2)); }

void body_move_to(const Body& b, lua_State* L) {
  if (b.system.type(b.id) != BodyType::kinematic)
    fail_here(L, std::string("expected a kinematic body, got a ") + body_type(b) + " one");
  int next = 0;
  Pose pose = b.system.pose(b.id);
  pose.position = vector_argument(L, 2, b.record.planar(), &next);
  if (!lua_isnoneornil(L, next)) pose.rotation = rotation_argument(L, next);
  b.system.move_to(b.id, pose);
}

int body_contacts(lua_State* L) {
  const Body b(L);
  std::vector<Collide::ContactInfo> list;
  if (Collide* collide = b.world.query<Collide>()) collide->contacts_of(b.id, list);
  push_list(L, list, [&](const Collide::ContactInfo& c) {
    lua_createtable(L, 0, 9);
    push_handle(L, b.record, c.other);
    lua_setfield(L, -2, "other");
    set_point_and_normal(L, c.point, c.normal);
    set_field(L, "separation", c.separation);
    set_field(L, "impulse", c.impulse);
  });
  return 1;
}

void body_set_friction(const Body& b, lua_State* L) {
  Real fixed = 0, dynamic = 0;
  if (lua_type(L, 2) == LUA_TTABLE) {
    Options o(L, 2, function_name(L));
    friction_table(o, fixed, dynamic);
  } else {
    fixed = number_argument(L, 2, kNotNegative);
    dynamic = lua_isnoneornil(L, 3) ? fixed : number_argument(L, 3, kNotNegative);
  }
  b.system.set_friction(b.id, fixed, dynamic);
}

void body_set_damping(const Body& b, lua_State* L) {
  const Real linear = number_argument(L, 2, kNotNegative);
  const Real angular = lua_isnoneornil(L, 3) ? b.system.bodies().angular_damping[b.system.index(b.id)]
                                             : number_argument(L, 3, kNotNegative);
  b.system.set_damping(b.id, linear, angular);
}

struct Tool {
  ShapePtr shape = nullptr;
  Pose place = {};  // world
};

void read_tool(Options& o, const OptionRow&, Tool& t) {
  if (!shape_option(o, "shape", t.shape)) o.wrong("shape", "a shape (feder.box(1, 1, 1) ...)");
}

constexpr Option<Tool> kTool[] = {
    special("shape", "shape", read_tool),
    special(
        "position", "vector", +[](Options& o, const OptionRow& row, Tool& t) { o.vector(row.name, t.place.position); },
        "m"),
    special(
        "rotation", "rotation",
        +[](Options& o, const OptionRow& row, Tool& t) { o.rotation(row.name, t.place.rotation); }),
};

// carve{ shape =, position = }, in world coordinates.
template <void (Rigid::*Edit)(ObjectId, const ShapePtr&, const Pose&)>
void body_edit(const Body& b, lua_State* L) {
  Tool t;
  Options(L, 2, function_name(L)).read(kTool, t);
  const Pose body = b.system.pose(b.id);
  const Pose place{to_local(body, t.place.position), conjugate(body.rotation) * t.place.rotation};
  state(L).outside_lua([&] { (b.system.*Edit)(b.id, t.shape, place); });
}

struct Filter {
  std::uint32_t group = 1, mask = 0xffffffffu;
};

constexpr Option<Filter> kSetFilter[] = {field<&Filter::group>("group", "", kBits),
                                         field<&Filter::mask>("mask", "", kBits)};

// set_filter{ group =, mask = } or set_filter(group, mask).
void body_set_filter(const Body& b, lua_State* L) {
  Filter filter;
  if (lua_type(L, 2) == LUA_TTABLE) {
    const Colliders& colliders = b.world.need<Collide>().colliders();
    const std::uint32_t first = b.system.bodies().first_collider[b.system.index(b.id)];
    if (first != kNone) filter = {colliders.group[first], colliders.mask[first]};
    Options o(L, 2, function_name(L));
    o.read(kSetFilter, filter);
  } else {
    const std::string name = function_name(L);
    filter.group = static_cast<std::uint32_t>(check_integer(L, 2, name + ".group", 0, 0xffffffffll));
    filter.mask = static_cast<std::uint32_t>(check_integer(L, 3, name + ".mask", 0, 0xffffffffll));
  }
  b.system.set_filter(b.id, filter.group, filter.mask);
}

bool body_is_sensor(const Body& b) {
  const std::uint32_t first = b.system.bodies().first_collider[b.system.index(b.id)];
  return first != kNone && b.world.need<Collide>().colliders().sensor[first];
}

void body_set_sensor(const Body& b, lua_State* L) {
  const bool all = lua_type(L, 2) == LUA_TSTRING && text_at(L, 2) == kSensorAll;
  if (!all && lua_type(L, 2) != LUA_TBOOLEAN)
    fail_here(L, std::string("expected ") + kSensorValues + ", got " + describe(L, 2));
  b.system.set_sensor(b.id, lua_toboolean(L, 2) != 0, all);
}

const Method kBodyMethods[] = {
    {"position", method<body_position>, "body:position() -> x, y, z", "of the body's origin, m"},
    {"set_position", method<body_set_position>, "body:set_position(x, y, z) -> self",
     "puts it there at once; contacts end and begin"},
    {"rotation", method<body_rotation>, "body:rotation() -> x, y, z, w", "unit quaternion, body to world"},
    {"set_rotation", method<body_set_rotation>, "body:set_rotation(x, y, z, w) -> self",
     "or one table: {axis=, angle=}, {euler=}"},
    {"velocity", method<&Rigid::velocity>, "body:velocity() -> x, y, z", "of the centre of mass, m/s"},
    {"set_velocity", method<&Rigid::set_velocity>, "body:set_velocity(x, y, z) -> self", "m/s; wakes it"},
    {"angular_velocity", method<&Rigid::angular_velocity>, "body:angular_velocity() -> x, y, z", "world axes, rad/s"},
    {"set_angular_velocity", method<set_axial<&Rigid::set_angular_velocity>>,
     "body:set_angular_velocity(x, y, z) -> self", "rad/s; wakes it"},
    {"mass", method<&Rigid::mass>, "body:mass() -> number", "kg; 0 for static and kinematic bodies"},
    {"inertia", method<body_inertia>, "body:inertia() -> ixx, iyy, izz, ixy, ixz, iyz",
     "about the centre of mass, body axes, kg m^2"},
    {"center_of_mass", method<&Rigid::center_of_mass>, "body:center_of_mass() -> x, y, z", "world, m"},
    {"world_point", method<body_world_point>, "body:world_point(x, y, z) -> x, y, z",
     "a point of the body frame in the world"},
    {"local_point", method<body_local_point>, "body:local_point(x, y, z) -> x, y, z",
     "a point of the world in the body frame"},
    {"velocity_at", method<body_velocity_at>, "body:velocity_at(x, y, z) -> x, y, z",
     "of the body's matter at a world point, m/s"},
    {"apply_force", method<apply_at<&Rigid::apply_force>>, "body:apply_force(x, y, z, [px, py, pz]) -> self",
     "during the next step, N; at a world point"},
    {"apply_impulse", method<apply_at<&Rigid::apply_impulse>>, "body:apply_impulse(x, y, z, [px, py, pz]) -> self",
     "at once, N s; at a world point"},
    {"apply_torque", method<set_axial<&Rigid::apply_torque>>, "body:apply_torque(x, y, z) -> self",
     "during the next step, N m"},
    {"apply_angular_impulse", method<set_axial<&Rigid::apply_angular_impulse>>,
     "body:apply_angular_impulse(x, y, z) -> self", "at once, N m s"},
    {"awake", method<body_awake>, "body:awake() -> boolean", "does it take part in the step?"},
    {"wake", method<body_wake>, "body:wake() -> self", "wakes it and its island"},
    {"sleep", method<&Rigid::sleep>, "body:sleep() -> self", "puts it to sleep"},
    {"type", method<body_type>, "body:type() -> string", "\"dynamic\", \"static\" or \"kinematic\""},
    {"set_type", method<body_set_type>, "body:set_type(name) -> self", "\"dynamic\", \"static\" or \"kinematic\""},
    {"carve", method<body_edit<&Rigid::carve>>, "body:carve{ shape =, position =, rotation = } -> self",
     "a solid at that place in the world is cut out; the shape becomes a field, parts that come off become bodies",
     rows_of<kTool>},
    {"weld_on", method<body_edit<&Rigid::weld_on>>, "body:weld_on{ shape =, position =, rotation = } -> self",
     "a solid at that place in the world becomes part of it; the shape becomes a field", rows_of<kTool>},
    {"move_to", method<body_move_to>, "body:move_to(x, y, z, [qx, qy, qz, qw]) -> self",
     "kinematic: the pose at the end of the next step"},
    {"contacts", guard<body_contacts>, "body:contacts() -> {{other, x, y, z, nx, ny, nz, separation, impulse}, ...}",
     "contact points now; normals point away from it"},
    {"set_friction", method<body_set_friction>, "body:set_friction(static, [dynamic]) -> self",
     "or { static =, dynamic = }"},
    {"set_restitution", method<set_number<&Rigid::set_restitution, kUnitRange>>, "body:set_restitution(e) -> self",
     "0 to 1"},
    {"set_surface_velocity", method<&Rigid::set_surface_velocity>, "body:set_surface_velocity(x, y, z) -> self",
     "conveyor: body frame, m/s"},
    {"set_damping", method<body_set_damping>, "body:set_damping(linear, [angular]) -> self", "1/s"},
    {"set_gravity_scale", method<set_number<&Rigid::set_gravity_scale, kGravityScale>>,
     "body:set_gravity_scale(s) -> self", "1: as the world says"},
    {"set_filter", method<body_set_filter>, "body:set_filter{ group =, mask = } -> self",
     "32-bit numbers; a pair meets when each group is in the other's mask", rows_of<kSetFilter>},
    {"is_sensor", method<body_is_sensor>, "body:is_sensor() -> boolean", "does it only notice?"},
    {"set_sensor", method<body_set_sensor>, "body:set_sensor(on) -> self",
     "sensors notice and do not push; \"all\": static bodies too"},
};

}  // namespace

std::span<const Method> body_methods() { return kBodyMethods; }

}  // namespace feder::lua
