// world:joint{ ... } and the methods of joints.
#include "lua/rigid_part.h"

namespace feder::lua {
namespace {

const JointKind& kind_option(Options& o, std::string& type) {
  if (!o.text("type", type)) o.wrong("type", "the name of a joint");
  std::vector<std::string> known;
  for (const JointKind& k : joint_kinds()) {
    if (type == k.name) return k;
    known.emplace_back(k.name);
  }
  // named in the API, to come
  static const char* const later[] = {"slider", "rope", "wheel",  "cone_twist", "six_dof",
                                      "gear",   "rack", "pulley", "motor",      "mouse"};
  for (const char* name : later)
    if (type == name) o.raise("type", "this build has no joint type '" + type + "'; known: " + join(known));
  const std::string near = nearest_name(type, known);
  o.raise("type", "unknown joint type '" + type + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?") +
                      "; known: " + join(known));
}

void body_option(Options& o, const char* key, WorldRecord& r, ObjectId& out) {
  if (!o.push_any(key)) return;
  out = check_object(o.L(), -1, r, o.path(key), "body");
  lua_pop(o.L(), 1);
}

// Does the kind understand the option? An unused one is a mistake, not a wish.
bool used(Options& o, const JointKind& kind, unsigned uses, const char* key) {
  if (kind.uses & uses) return true;
  if (o.has(key)) o.raise(key, std::string("a ") + kind.name + " joint has no such thing");
  return false;
}

void read_spring_option(Options& o, JointOptions& j) {
  if (!o.push("spring", LUA_TTABLE, "{ hertz =, damping_ratio = }")) return;
  Options s(o.L(), -1, o.path("spring"));
  if (!s.real("hertz", j.spring_hertz, kPositive)) s.wrong("hertz", kPositive.text());
  s.real("damping_ratio", j.spring_damping, kNotNegative);
  s.finish();
  lua_pop(o.L(), 1);
}

void read_motor(Options& o, JointOptions& j) {
  if (!o.push("motor", LUA_TTABLE, "{ speed =, max_force = }")) return;
  Options m(o.L(), -1, o.path("motor"));
  j.has_motor = true;
  m.real("speed", j.motor_speed);
  if (!m.real("max_force", j.motor_max, kNotNegative) && !m.real("max_torque", j.motor_max, kNotNegative))
    m.wrong("max_force", kNotNegative.text());
  m.has("max_torque");
  m.finish();
  lua_pop(o.L(), 1);
}

void read_limits(Options& o, JointOptions& j) {
  if (!o.push("limits", LUA_TTABLE, "{lo, hi}")) return;
  lua_State* L = o.L();
  if (lua_rawlen(L, -1) != 2)
    o.raise("limits", "expected {lo, hi}, got a table of " + std::to_string(lua_rawlen(L, -1)) + " values");
  lua_rawgeti(L, -1, 1), lua_rawgeti(L, -2, 2);
  j.lower = static_cast<Real>(check_number(L, -2, o.path("limits") + ".lo"));
  j.upper = static_cast<Real>(check_number(L, -1, o.path("limits") + ".hi"));
  if (j.lower > j.upper)
    o.raise("limits", "expected lo at most hi, got {" + print_number(j.lower) + ", " + print_number(j.upper) + "}");
  j.has_limits = true;
  lua_pop(L, 3);
}

// Kinds with one anchor: `anchor`, else midway between the bodies' origins (a's, against the world).
// Kinds with two: anchor_a (a's origin) and anchor_b (b's origin; against the world `anchor` says where).
void read_anchors(Options& o, const JointKind& kind, WorldRecord& r, JointDesc& desc) {
  const Vec3 at_a = lua::rigid(r).pose(desc.a).position;
  const Vec3 at_b = desc.b ? lua::rigid(r).pose(desc.b).position : at_a;
  Vec3 anchor = Vec3::Zero();
  const bool has_anchor = o.vector("anchor", anchor);
  if (!(kind.uses & kUsesTwoAnchors)) {
    for (const char* key : {"anchor_a", "anchor_b"}) used(o, kind, kUsesTwoAnchors, key);
    desc.anchor_a = desc.anchor_b = has_anchor ? anchor : Vec3((at_a + at_b) * Real(0.5));
    return;
  }
  desc.anchor_a = at_a, desc.anchor_b = at_b;
  if (has_anchor) (desc.b ? desc.anchor_a : desc.anchor_b) = anchor;
  const bool has_b = o.vector("anchor_b", desc.anchor_b);
  o.vector("anchor_a", desc.anchor_a);
  if (!desc.b && !has_b && !has_anchor)
    o.raise("anchor", "expected the point of the world that holds the joint, got nil");
}

int joint_vector(lua_State* L, Vec3 (Rigid::*get)(ObjectId) const) {
  Self self = check_self(L);
  return push_vector(L, (lua::rigid(self.record).*get)(self.id));
}

int joint_force(lua_State* L) { return joint_vector(L, &Rigid::joint_force); }
int joint_torque(lua_State* L) { return joint_vector(L, &Rigid::joint_torque); }

// Makes sure that the kind has what is asked for.
void need_use(lua_State* L, Self& self, unsigned uses, const char* what) {
  const JointKind& kind = *lua::rigid(self.record).joint_info(self.id).kind;
  if (!(kind.uses & uses)) fail_here(L, std::string("a ") + kind.name + " joint has no " + what);
}

int joint_angle(lua_State* L) {
  Self self = check_self(L);
  need_use(L, self, kUsesAxis, "angle");
  lua_pushnumber(L, lua::rigid(self.record).joint_coordinate(self.id));
  return 1;
}

int joint_length(lua_State* L) {
  Self self = check_self(L);
  need_use(L, self, kUsesTwoAnchors, "length");
  lua_pushnumber(L, lua::rigid(self.record).joint_coordinate(self.id));
  return 1;
}

int joint_set_motor(lua_State* L) {
  Self self = check_self(L);
  need_use(L, self, kUsesMotor, "motor");
  double speed = 0, force = 0;
  if (lua_type(L, 2) == LUA_TTABLE) {
    Options o(L, 2, function_name(L));
    o.number("speed", speed);
    if (!o.number("max_force", force, kNotNegative)) o.wrong("max_force", kNotNegative.text());
    o.finish();
  } else {
    speed = check_number(L, 2, std::string(function_name(L)) + ".speed");
    force = check_number(L, 3, std::string(function_name(L)) + ".max_force", kNotNegative);
  }
  lua::rigid(self.record).set_motor(self.id, static_cast<Real>(speed), static_cast<Real>(force));
  return return_self(L);
}

int joint_set_limits(lua_State* L) {
  Self self = check_self(L);
  need_use(L, self, kUsesLimits, "limits");
  if (lua_type(L, 2) == LUA_TTABLE) {
    lua_settop(L, 2);
    lua_rawgeti(L, 2, 1), lua_rawgeti(L, 2, 2);
    lua_remove(L, 2);
  }
  const double lo = check_number(L, 2, std::string(function_name(L)) + ".lo");
  const double hi = check_number(L, 3, std::string(function_name(L)) + ".hi");
  if (lo > hi) fail_here(L, "expected lo at most hi, got " + print_number(lo) + ", " + print_number(hi));
  lua::rigid(self.record).set_limits(self.id, static_cast<Real>(lo), static_cast<Real>(hi));
  return return_self(L);
}

int joint_type(lua_State* L) {
  Self self = check_self(L);
  lua_pushstring(L, lua::rigid(self.record).joint_info(self.id).kind->name);
  return 1;
}

int joint_bodies(lua_State* L) {
  Self self = check_self(L);
  const Rigid::JointInfo joint = lua::rigid(self.record).joint_info(self.id);
  push_handle(L, self.record, joint.a);
  push_handle(L, self.record, joint.b);
  return 2;
}

const Method kJointMethods[] = {
    {"force", guard<joint_force>, "joint:force() -> x, y, z", "on b in the last step, N"},
    {"torque", guard<joint_torque>, "joint:torque() -> x, y, z", "on b in the last step, N m"},
    {"angle", guard<joint_angle>, "joint:angle() -> number", "of a hinge since it was made, rad"},
    {"length", guard<joint_length>, "joint:length() -> number", "between the anchors now, m"},
    {"set_motor", guard<joint_set_motor>, "joint:set_motor(speed, max_force) -> self",
     "or { speed =, max_force = }; rad/s, N m"},
    {"set_limits", guard<joint_set_limits>, "joint:set_limits(lo, hi) -> self", "rad or m"},
    {"type", guard<joint_type>, "joint:type() -> string", "\"ball\", \"hinge\" ..."},
    {"bodies", guard<joint_bodies>, "joint:bodies() -> a, b", "b is nil for the world"},
};

}  // namespace

std::span<const Method> joint_methods() { return kJointMethods; }

int world_joint(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  JointDesc desc;
  const JointKind& kind = kind_option(o, desc.type);
  o.text("name", desc.name);
  body_option(o, "a", r, desc.a);
  body_option(o, "b", r, desc.b);
  if (!desc.a) o.wrong("a", "a body");
  if (desc.a == desc.b) o.raise("b", "expected another body than a");
  read_anchors(o, kind, r, desc);
  if (used(o, kind, kUsesAxis, "axis")) o.unit("axis", desc.axis);
  if (used(o, kind, kUsesLimits, "limits")) read_limits(o, desc.options);
  if (used(o, kind, kUsesMotor, "motor")) read_motor(o, desc.options);
  if (used(o, kind, kUsesSpring, "spring")) read_spring_option(o, desc.options);
  if (used(o, kind, kUsesTwoAnchors, "rest_length")) o.real("rest_length", desc.options.rest_length, kNotNegative);
  o.real("break_force", desc.break_force, kPositive);
  o.flag("collide", desc.collide);
  o.has("tags");
  o.finish();
  desc.tags = tag_option(o, r);
  const ObjectId id = lua::rigid(r).add_joint(desc);
  push_handle(L, r, id);
  return 1;
}

}  // namespace feder::lua
