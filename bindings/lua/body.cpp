// The methods of bodies: check, call, push.
#include <cmath>

#include "lua/rigid_part.h"
#include "lua/world_options.h"
#include "state/bodies.h"
#include "state/colliders.h"

namespace feder::lua {
namespace {

struct Body {
  Self self;
  Rigid& rigid;
  std::uint32_t i;  // in Bodies
  const Bodies& all() const { return rigid.bodies(); }
  bool planar() const { return self.record.planar(); }
};

Body body(lua_State* L) {
  Self self = check_self(L);
  Rigid& rigid = lua::rigid(self.record);
  return {self, rigid, rigid.index(self.id)};
}

int push_quat(lua_State* L, const Quat& q) {
  lua_pushnumber(L, q.x), lua_pushnumber(L, q.y), lua_pushnumber(L, q.z), lua_pushnumber(L, q.w);
  return 4;
}

// x, y, z, w as numbers from `index`, or one table in the forms of the rotation option.
Quat rotation_argument(lua_State* L, int index) {
  if (lua_type(L, index) != LUA_TTABLE) {
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
  return check_rotation(L, index, function_name(L));
}

bool flag_argument(lua_State* L, int index) {
  if (lua_type(L, index) != LUA_TBOOLEAN) fail_here(L, "expected true or false, got " + describe(L, index));
  return lua_toboolean(L, index) != 0;
}

Real number_argument(lua_State* L, int index, const Range& range) {
  return static_cast<Real>(check_number(L, index, function_name(L), range));
}

int body_position(lua_State* L) {
  const Body b = body(L);
  return push_vector(L, b.all().origin(b.i));
}

int body_set_position(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_pose(b.self.id, {vector_argument(L, 2, b.planar()), b.all().rotation[b.i]});
  return return_self(L);
}

int body_rotation(lua_State* L) {
  const Body b = body(L);
  return push_quat(L, b.all().rotation[b.i]);
}

int body_set_rotation(lua_State* L) {
  const Body b = body(L);
  const Quat q = rotation_argument(L, 2);
  b.rigid.set_pose(b.self.id, {b.all().origin(b.i), q});
  return return_self(L);
}

int body_velocity(lua_State* L) {
  const Body b = body(L);
  return push_vector(L, b.all().velocity[b.i]);
}

int body_set_velocity(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_velocity(b.self.id, vector_argument(L, 2, b.planar()));
  return return_self(L);
}

int body_angular_velocity(lua_State* L) {
  const Body b = body(L);
  return push_vector(L, b.all().angular_velocity[b.i]);
}

int body_set_angular_velocity(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_angular_velocity(b.self.id, vector_argument(L, 2, false));
  return return_self(L);
}

int body_mass(lua_State* L) {
  const Body b = body(L);
  lua_pushnumber(L, b.rigid.mass(b.self.id));
  return 1;
}

int body_inertia(lua_State* L) {
  const Body b = body(L);
  const Mat3 m = b.rigid.inertia(b.self.id);
  for (int k = 0; k < 3; ++k) lua_pushnumber(L, m(k, k));
  lua_pushnumber(L, m(0, 1)), lua_pushnumber(L, m(0, 2)), lua_pushnumber(L, m(1, 2));
  return 6;
}

int body_center_of_mass(lua_State* L) {
  const Body b = body(L);
  return push_vector(L, b.all().position[b.i]);
}

int body_world_point(lua_State* L) {
  const Body b = body(L);
  return push_vector(L, to_world(b.all().origin_pose(b.i), vector_argument(L, 2, b.planar())));
}

int body_local_point(lua_State* L) {
  const Body b = body(L);
  return push_vector(L, to_local(b.all().origin_pose(b.i), vector_argument(L, 2, b.planar())));
}

int body_velocity_at(lua_State* L) {
  const Body b = body(L);
  return push_vector(L, b.all().velocity_at(b.i, vector_argument(L, 2, b.planar())));
}

using Push = void (Rigid::*)(ObjectId, const Vec3&, const Vec3*);

template <Push Apply>
int body_push(lua_State* L) {
  const Body b = body(L);
  int next = 0;
  const Vec3 v = vector_argument(L, 2, b.planar(), &next);
  const bool has_point = !lua_isnoneornil(L, next);
  const Vec3 point = has_point ? vector_argument(L, next, b.planar()) : Vec3(Vec3::Zero());
  (b.rigid.*Apply)(b.self.id, v, has_point ? &point : nullptr);
  return return_self(L);
}

int body_apply_torque(lua_State* L) {
  const Body b = body(L);
  b.rigid.apply_torque(b.self.id, vector_argument(L, 2, false));
  return return_self(L);
}

int body_apply_angular_impulse(lua_State* L) {
  const Body b = body(L);
  b.rigid.apply_angular_impulse(b.self.id, vector_argument(L, 2, false));
  return return_self(L);
}

int body_awake(lua_State* L) {
  const Body b = body(L);
  lua_pushboolean(L, b.all().awake[b.i]);
  return 1;
}

int body_wake(lua_State* L) {
  const Body b = body(L);
  b.rigid.wake(b.self.id);
  return return_self(L);
}

int body_sleep(lua_State* L) {
  const Body b = body(L);
  b.rigid.sleep(b.self.id);
  return return_self(L);
}

int body_type(lua_State* L) {
  const Body b = body(L);
  lua_pushstring(L, body_type_name(b.all().type[b.i]));
  return 1;
}

int body_set_type(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_type(b.self.id, body_type_from_name(L, 2));
  return return_self(L);
}

int body_move_to(lua_State* L) {
  const Body b = body(L);
  if (b.all().type[b.i] != BodyType::kinematic)
    fail_here(L, "expected a kinematic body, got a " + std::string(body_type_name(b.all().type[b.i])) + " one");
  int next = 0;
  Pose pose;
  pose.position = vector_argument(L, 2, b.planar(), &next);
  pose.rotation = lua_isnoneornil(L, next) ? b.all().rotation[b.i] : rotation_argument(L, next);
  b.rigid.move_to(b.self.id, pose);
  return return_self(L);
}

int body_contacts(lua_State* L) {
  const Body b = body(L);
  lua_newtable(L);
  Collide* collide = b.self.world.query<Collide>();
  if (!collide) return 1;
  std::vector<Collide::ContactInfo> list;
  collide->contacts_of(b.self.id, list);
  lua_Integer n = 0;
  for (const auto& c : list) {
    lua_createtable(L, 0, 9);
    push_handle(L, b.self.record, c.other);
    lua_setfield(L, -2, "other");
    static const char* const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    for (int k = 0; k < 3; ++k) {
      lua_pushnumber(L, c.point[k]);
      lua_setfield(L, -2, names[k]);
      lua_pushnumber(L, c.normal[k]);
      lua_setfield(L, -2, names[k + 3]);
    }
    lua_pushnumber(L, c.separation);
    lua_setfield(L, -2, "separation");
    lua_pushnumber(L, c.impulse);
    lua_setfield(L, -2, "impulse");
    lua_rawseti(L, -2, ++n);
  }
  return 1;
}

int body_set_friction(lua_State* L) {
  const Body b = body(L);
  Real fixed = 0, dynamic = 0;
  if (lua_type(L, 2) == LUA_TTABLE) {
    Options o(L, 2, function_name(L));
    friction_table(o, fixed, dynamic);
  } else {
    fixed = number_argument(L, 2, kNotNegative);
    dynamic = lua_isnoneornil(L, 3) ? fixed : number_argument(L, 3, kNotNegative);
  }
  b.rigid.set_friction(b.self.id, fixed, dynamic);
  return return_self(L);
}

int body_set_restitution(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_restitution(b.self.id, number_argument(L, 2, Range{0, 1}));
  return return_self(L);
}

int body_set_surface_velocity(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_surface_velocity(b.self.id, vector_argument(L, 2, b.planar()));
  return return_self(L);
}

int body_set_damping(lua_State* L) {
  const Body b = body(L);
  const Real linear = number_argument(L, 2, kNotNegative);
  b.rigid.set_damping(b.self.id, linear,
                      lua_isnoneornil(L, 3) ? b.all().angular_damping[b.i] : number_argument(L, 3, kNotNegative));
  return return_self(L);
}

int body_set_gravity_scale(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_gravity_scale(b.self.id, number_argument(L, 2, kGravityScale));
  return return_self(L);
}

struct Filter {
  std::uint32_t group = 1, mask = 0xffffffffu;
};

constexpr Option<Filter> kSetFilter[] = {field<&Filter::group>("group", "", kBits),
                                         field<&Filter::mask>("mask", "", kBits)};

// set_filter{ group =, mask = } or set_filter(group, mask).
int body_set_filter(lua_State* L) {
  const Body b = body(L);
  const Colliders& colliders = b.self.world.need<Collide>().colliders();
  const std::uint32_t first = b.all().first_collider[b.i];
  std::int64_t group = first == kNone ? 1 : colliders.group[first],
               mask = first == kNone ? 0xffffffffll : colliders.mask[first];
  if (lua_type(L, 2) == LUA_TTABLE) {
    Filter filter{static_cast<std::uint32_t>(group), static_cast<std::uint32_t>(mask)};
    Options o(L, 2, function_name(L));
    o.read(kSetFilter, filter);
    group = filter.group, mask = filter.mask;
  } else {
    group = check_integer(L, 2, std::string(function_name(L)) + ".group", 0, 0xffffffffll);
    mask = check_integer(L, 3, std::string(function_name(L)) + ".mask", 0, 0xffffffffll);
  }
  b.rigid.set_filter(b.self.id, static_cast<std::uint32_t>(group), static_cast<std::uint32_t>(mask));
  return return_self(L);
}

int body_is_sensor(lua_State* L) {
  const Body b = body(L);
  const std::uint32_t first = b.all().first_collider[b.i];
  lua_pushboolean(L, first != kNone && b.self.world.need<Collide>().colliders().sensor[first]);
  return 1;
}

int body_set_sensor(lua_State* L) {
  const Body b = body(L);
  b.rigid.set_sensor(b.self.id, flag_argument(L, 2));
  return return_self(L);
}

const Method kBodyMethods[] = {
    {"position", guard<body_position>, "body:position() -> x, y, z", "of the body's origin, m"},
    {"set_position", guard<body_set_position>, "body:set_position(x, y, z) -> self",
     "puts it there at once; contacts end and begin"},
    {"rotation", guard<body_rotation>, "body:rotation() -> x, y, z, w", "unit quaternion, body to world"},
    {"set_rotation", guard<body_set_rotation>, "body:set_rotation(x, y, z, w) -> self",
     "or one table: {axis=, angle=}, {euler=}"},
    {"velocity", guard<body_velocity>, "body:velocity() -> x, y, z", "of the centre of mass, m/s"},
    {"set_velocity", guard<body_set_velocity>, "body:set_velocity(x, y, z) -> self", "m/s; wakes it"},
    {"angular_velocity", guard<body_angular_velocity>, "body:angular_velocity() -> x, y, z", "world axes, rad/s"},
    {"set_angular_velocity", guard<body_set_angular_velocity>, "body:set_angular_velocity(x, y, z) -> self",
     "rad/s; wakes it"},
    {"mass", guard<body_mass>, "body:mass() -> number", "kg; 0 for static and kinematic bodies"},
    {"inertia", guard<body_inertia>, "body:inertia() -> ixx, iyy, izz, ixy, ixz, iyz",
     "about the centre of mass, body axes, kg m^2"},
    {"center_of_mass", guard<body_center_of_mass>, "body:center_of_mass() -> x, y, z", "world, m"},
    {"world_point", guard<body_world_point>, "body:world_point(x, y, z) -> x, y, z",
     "a point of the body frame in the world"},
    {"local_point", guard<body_local_point>, "body:local_point(x, y, z) -> x, y, z",
     "a point of the world in the body frame"},
    {"velocity_at", guard<body_velocity_at>, "body:velocity_at(x, y, z) -> x, y, z",
     "of the body's matter at a world point, m/s"},
    {"apply_force", guard<body_push<&Rigid::apply_force>>, "body:apply_force(x, y, z, [px, py, pz]) -> self",
     "during the next step, N; at a world point"},
    {"apply_impulse", guard<body_push<&Rigid::apply_impulse>>, "body:apply_impulse(x, y, z, [px, py, pz]) -> self",
     "at once, N s; at a world point"},
    {"apply_torque", guard<body_apply_torque>, "body:apply_torque(x, y, z) -> self", "during the next step, N m"},
    {"apply_angular_impulse", guard<body_apply_angular_impulse>, "body:apply_angular_impulse(x, y, z) -> self",
     "at once, N m s"},
    {"awake", guard<body_awake>, "body:awake() -> boolean", "does it take part in the step?"},
    {"wake", guard<body_wake>, "body:wake() -> self", "wakes it and its island"},
    {"sleep", guard<body_sleep>, "body:sleep() -> self", "puts it to sleep"},
    {"type", guard<body_type>, "body:type() -> string", "\"dynamic\", \"static\" or \"kinematic\""},
    {"set_type", guard<body_set_type>, "body:set_type(name) -> self", "\"dynamic\", \"static\" or \"kinematic\""},
    {"move_to", guard<body_move_to>, "body:move_to(x, y, z, [qx, qy, qz, qw]) -> self",
     "kinematic: the pose at the end of the next step"},
    {"contacts", guard<body_contacts>, "body:contacts() -> {{other, x, y, z, nx, ny, nz, separation, impulse}, ...}",
     "contact points now; normals point away from it"},
    {"set_friction", guard<body_set_friction>, "body:set_friction(static, [dynamic]) -> self",
     "or { static =, dynamic = }"},
    {"set_restitution", guard<body_set_restitution>, "body:set_restitution(e) -> self", "0 to 1"},
    {"set_surface_velocity", guard<body_set_surface_velocity>, "body:set_surface_velocity(x, y, z) -> self",
     "conveyor: body frame, m/s"},
    {"set_damping", guard<body_set_damping>, "body:set_damping(linear, [angular]) -> self", "1/s"},
    {"set_gravity_scale", guard<body_set_gravity_scale>, "body:set_gravity_scale(s) -> self", "1: as the world says"},
    {"set_filter", guard<body_set_filter>, "body:set_filter{ group =, mask = } -> self",
     "32-bit numbers; a pair meets when each group is in the other's mask", [] { return describe_rows(kSetFilter); }},
    {"is_sensor", guard<body_is_sensor>, "body:is_sensor() -> boolean", "does it only notice?"},
    {"set_sensor", guard<body_set_sensor>, "body:set_sensor(on) -> self", "sensors notice and do not push"},
};

}  // namespace

std::span<const Method> body_methods() { return kBodyMethods; }

}  // namespace feder::lua
