// world:joint{ ... } and the methods of joints.
#include "constrain/joint.h"

#include <algorithm>

#include "lua/rigid_part.h"

namespace feder::lua {
namespace {

struct JointReading : JointDesc {
  WorldRecord* record = nullptr;
  const JointKind* kind = nullptr;
};

std::string joint_names() { return variant_names(joint_kinds()); }

void read_kind(Options& o, const OptionRow&, JointReading& j) {
  std::string& type = j.type;
  if (!o.text("type", type)) o.wrong("type", "the name of a joint");
  std::vector<std::string> known;
  for (const JointKind& k : joint_kinds()) {
    if (type == k.name) j.kind = &k;
    known.emplace_back(k.name);
  }
  if (j.kind) return;
  // named in the API, to come
  static constexpr std::string_view later[] = {"slider", "rope", "wheel",  "cone_twist", "six_dof",
                                               "gear",   "rack", "pulley", "motor",      "mouse"};
  if (std::ranges::find(later, type) != std::end(later))
    o.raise("type", "this build has no joint type '" + type + "'; known: " + join(known));
  o.raise("type", "unknown joint type '" + type + "'" + did_you_mean(type, known) + "; known: " + join(known));
}

ObjectId body_option(Options& o, const char* key, WorldRecord& record) {
  if (!o.push_any(key)) return {};
  const ObjectId body = check_object(o.L(), -1, record, o.path(key), "body");
  lua_pop(o.L(), 1);
  return body;
}

void read_a(Options& o, const OptionRow&, JointReading& j) {
  j.a = body_option(o, "a", *j.record);
  if (!j.a) o.wrong("a", "a body");
}

void read_b(Options& o, const OptionRow&, JointReading& j) {
  j.b = body_option(o, "b", *j.record);
  if (j.a == j.b) o.raise("b", "expected another body than a");
}

// Does the kind understand the option? An unused one is a mistake, not a wish.
bool used(Options& o, const JointKind& kind, unsigned uses, const char* key) {
  if (kind.uses & uses) return true;
  if (o.has(key)) o.raise(key, std::string("a ") + kind.name + " joint has no such thing");
  return false;
}

constexpr Option<JointOptions> kSpring[] = {
    field<&JointOptions::spring_hertz>("hertz", "Hz", kPositive).unset(),
    field<&JointOptions::spring_damping>("damping_ratio", "", kNotNegative),
};

void read_spring_option(Options& o, const OptionRow&, JointReading& j) {
  if (!used(o, *j.kind, kUsesSpring, "spring") || !o.push("spring", LUA_TTABLE, "{ hertz =, damping_ratio = }")) return;
  Options s(o.L(), -1, o.path("spring"));
  s.read(kSpring, j.options);
  if (!s.has("hertz")) s.wrong("hertz", kPositive.text());
  lua_pop(o.L(), 1);
}

constexpr Option<JointOptions> kMotor[] = {
    field<&JointOptions::motor_speed>("speed", "m/s or rad/s"),
    field<&JointOptions::motor_max>("max_torque", "N m", kNotNegative).unset(),
    field<&JointOptions::motor_max>("max_force", "N", kNotNegative).unset(),
};

void read_motor(Options& m, JointOptions& j) {
  j.has_motor = true;
  m.read(kMotor, j);
  if (!m.has("max_force") && !m.has("max_torque")) m.wrong("max_force", kNotNegative.text());
}

void read_motor_option(Options& o, const OptionRow&, JointReading& j) {
  if (!used(o, *j.kind, kUsesMotor, "motor") || !o.push("motor", LUA_TTABLE, "{ speed =, max_force = }")) return;
  Options m(o.L(), -1, o.path("motor"));
  read_motor(m, j.options);
  lua_pop(o.L(), 1);
}

void read_limits(Options& o, const OptionRow&, JointReading& reading) {
  if (!used(o, *reading.kind, kUsesLimits, "limits") || !o.push("limits", LUA_TTABLE, "{lo, hi}")) return;
  JointOptions& j = reading.options;
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
void read_anchors(Options& o, const OptionRow&, JointReading& desc) {
  WorldRecord& r = *desc.record;
  const Vec3 at_a = system_of<Rigid>(r).pose(desc.a).position;
  const Vec3 at_b = desc.b ? system_of<Rigid>(r).pose(desc.b).position : at_a;
  Vec3 anchor = Vec3::Zero();
  const bool has_anchor = o.vector("anchor", anchor);
  if (!(desc.kind->uses & kUsesTwoAnchors)) {
    for (const char* key : {"anchor_a", "anchor_b"}) used(o, *desc.kind, kUsesTwoAnchors, key);
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

void read_axis(Options& o, const OptionRow&, JointReading& j) {
  if (used(o, *j.kind, kUsesAxis, "axis")) o.unit("axis", j.axis);
}

void read_rest_length(Options& o, const OptionRow& row, JointReading& j) {
  if (used(o, *j.kind, kUsesTwoAnchors, "rest_length")) o.real("rest_length", j.options.rest_length, row.range);
}

constexpr Option<JointReading> kJoint[] = {
    {{.name = "type"}, "string", read_kind, nullptr, nullptr, joint_names},
    field<&JointDesc::name>("name"),
    special("a", "body", read_a),
    special("b", "body", read_b),
    special("anchor", "vector", read_anchors, "m"),
    later<JointReading>("anchor_a", "vector", "m"),
    later<JointReading>("anchor_b", "vector", "m"),
    special("axis", "direction", read_axis),
    special("limits", "{lo, hi}", read_limits, "m or rad"),
    {{.name = "motor"}, "table", read_motor_option, nullptr, rows_of<kMotor>},
    {{.name = "spring"}, "table", read_spring_option, nullptr, rows_of<kSpring>},
    {{.name = "rest_length", .unit = "m", .range = kNotNegative}, "number", read_rest_length},
    field<&JointDesc::break_force>("break_force", "N", kPositive),
    field<&JointDesc::collide>("collide"),
    later<JointReading>("tags", kWordsType),
};

using Joint = Object<Rigid>;

// Makes sure that the kind has what is asked for.
void need_use(lua_State* L, const Joint& j, unsigned uses, const char* what) {
  const JointKind& kind = *j.system.joint_info(j.id).kind;
  if (!(kind.uses & uses)) fail_here(L, std::string("a ") + kind.name + " joint has no " + what);
}

Real joint_angle(const Joint& j, lua_State* L) {
  need_use(L, j, kUsesAxis, "angle");
  return j.system.joint_coordinate(j.id);
}

Real joint_length(const Joint& j, lua_State* L) {
  need_use(L, j, kUsesTwoAnchors, "length");
  return j.system.joint_coordinate(j.id);
}

void joint_set_motor(const Joint& j, lua_State* L) {
  need_use(L, j, kUsesMotor, "motor");
  JointOptions motor;
  if (lua_type(L, 2) == LUA_TTABLE) {
    Options o(L, 2, function_name(L));
    read_motor(o, motor);
  } else {
    const std::string name = function_name(L);
    motor.motor_speed = static_cast<Real>(check_number(L, 2, name + ".speed"));
    motor.motor_max = static_cast<Real>(check_number(L, 3, name + ".max_force", kNotNegative));
  }
  j.system.set_motor(j.id, motor.motor_speed, motor.motor_max);
}

void joint_set_limits(const Joint& j, lua_State* L) {
  need_use(L, j, kUsesLimits, "limits");
  if (lua_type(L, 2) == LUA_TTABLE) {
    lua_settop(L, 2);
    lua_rawgeti(L, 2, 1), lua_rawgeti(L, 2, 2);
    lua_remove(L, 2);
  }
  const double lo = check_number(L, 2, std::string(function_name(L)) + ".lo");
  const double hi = check_number(L, 3, std::string(function_name(L)) + ".hi");
  if (lo > hi) fail_here(L, "expected lo at most hi, got " + print_number(lo) + ", " + print_number(hi));
  j.system.set_limits(j.id, static_cast<Real>(lo), static_cast<Real>(hi));
}

const char* joint_type(const Joint& j) { return j.system.joint_info(j.id).kind->name; }

int joint_bodies(lua_State* L) {
  const Joint j(L);
  const Rigid::JointInfo joint = j.system.joint_info(j.id);
  push_handle(L, j.record, joint.a);
  push_handle(L, j.record, joint.b);
  return 2;
}

const Method kJointMethods[] = {
    {"force", method<&Rigid::joint_force>, "joint:force() -> x, y, z", "on b in the last step, N"},
    {"torque", method<&Rigid::joint_torque>, "joint:torque() -> x, y, z", "on b in the last step, N m"},
    {"angle", method<joint_angle>, "joint:angle() -> number", "of a hinge since it was made, rad"},
    {"length", method<joint_length>, "joint:length() -> number", "between the anchors now, m"},
    {"set_motor", method<joint_set_motor>, "joint:set_motor(speed, max_force) -> self",
     "or { speed =, max_force = }; rad/s, N m"},
    {"set_limits", method<joint_set_limits>, "joint:set_limits(lo, hi) -> self", "rad or m"},
    {"type", method<joint_type>, "joint:type() -> string", "\"ball\", \"hinge\" ..."},
    {"bodies", guard<joint_bodies>, "joint:bodies() -> a, b", "b is nil for the world"},
};

}  // namespace

std::span<const Method> joint_methods() { return kJointMethods; }

std::vector<OptionInfo> joint_rows() { return describe_rows(kJoint); }

ObjectId world_joint(WorldRecord& r, lua_State* L) {
  const JointReading joint = read_description(L, r, kJoint);
  return system_of<Rigid>(r).add_joint(joint);
}

}  // namespace feder::lua
