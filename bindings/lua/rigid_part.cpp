// The part "rigid": makers, queries, forces of scripts on bodies, and its lists in YAML.
#include "lua/rigid_part.h"

#include "constrain/joint.h"
#include "lua/yaml_scene.h"
#include "state/bodies.h"

namespace feder::lua {
namespace {

struct BodiesFilter {
  std::vector<std::string> tag;
  bool moved = false;
};

constexpr Option<BodiesFilter> kBodiesFilter[] = {field<&BodiesFilter::tag>("tag"),
                                                  field<&BodiesFilter::moved>("moved")};

int world_bodies(lua_State* L) {
  WorldRecord& r = check_world(L);
  const Objects& objects = r.world->objects();
  bool filtered = false;
  TagMask tags = 0;
  BodiesFilter filter;
  if (!lua_isnoneornil(L, 2)) {
    Options o(L, 2, function_name(L));
    o.read(kBodiesFilter, filter);
    filtered = o.has("tag");
    for (const std::string& w : filter.tag) tags |= objects.known_tag(w);
  }
  std::vector<ObjectId> found;
  const auto take = [&](ObjectId id) {
    if (!r.special.count(id) && (!filtered || (objects.tags(id) & tags))) found.push_back(id);
  };
  if (!filter.moved) objects.for_each(kBodyKind, take);
  if (Rigid* rigid = filter.moved ? r.world->find<Rigid>() : nullptr)
    for (const ObjectId id : rigid->moved())
      if (objects.alive(id)) take(id);
  push_list(L, found, [&](ObjectId id) { push_handle(L, r, id); });
  return 1;
}

Real world_max_penetration(WorldRecord& r) {
  Collide* collide = r.world->query<Collide>();
  return collide ? collide->max_penetration() : Real(0);
}

std::vector<ObjectId> destroy_body(WorldRecord& record, ObjectId id, const std::string& where) {
  Rigid& bodies = system_of<Rigid>(record);
  std::vector<ObjectId> joints;  // go with their bodies
  if (bodies.joint_count() > 0) {
    record.world->objects().for_each(kJointKind, [&](ObjectId joint) {
      const Rigid::JointInfo info = bodies.joint_info(joint);
      if (info.a == id || info.b == id) joints.push_back(joint);
    });
  }
  bodies.destroy_body(id, where);
  return joints;
}

Pose body_pose(WorldRecord& record, ObjectId id) { return system_of<Rigid>(record).pose(id); }

void gravity_changed(World& world) {
  if (Rigid* bodies = world.find<Rigid>()) bodies->wake_all(WakeCause::script);
}

void apply_forces(ForceRun& run) {
  World& world = *run.record().world;
  Rigid* bodies = world.find<Rigid>();
  if (!bodies) return;
  const Objects& objects = world.objects();
  for (std::size_t k = 0; k < run.forces().size(); ++k) {
    for (std::uint32_t i = 0; i < bodies->bodies().size() && !run.failed(k); ++i) {
      const Bodies& b = bodies->bodies();
      const ObjectId id = b.object[i];
      if (b.type[i] != BodyType::dynamic || !run.acts(k, id)) continue;
      Vec3 force = Vec3::Zero();
      if (!run.ask(k, b.position[i], b.velocity[i], b.mass[i], force) || !objects.alive(id)) continue;
      Vec3& held = run.forces()[k].held.try_emplace(i, force).first->second;
      // a sleeping body stays asleep under a force that it fell asleep with
      if (!bodies->bodies().awake[i] && length(force - held) <= Real(1e-3) * length(held)) continue;
      held = force;
      if (dot(force, force) > 0) bodies->apply_force(id, force, nullptr);
    }
  }
}

struct Repeat {
  lua_Integer count = 1;
  Vec3 step = Vec3::Zero();  // m
};

constexpr Option<Repeat> kRepeat[] = {field<&Repeat::count>("count", "", {0, 1000000}),
                                      field<&Repeat::step>("step", "m")};

// repeat: { count:, step: }: how many, and how far apart. Takes it out of the options.
Repeat read_repeat(lua_State* L, int options) {
  Repeat repeat;
  if (lua_getfield(L, options, "repeat") != LUA_TNIL) {
    Options o(L, -1, "repeat");
    o.read(kRepeat, repeat);
    if (!o.has("count")) o.wrong("count", kRepeat[0].row.range.whole());
    lua_pushnil(L);
    lua_setfield(L, options, "repeat");
  }
  lua_pop(L, 1);
  return repeat;
}

// Of the options on top, those of copy i: a name with its number, a position some steps on.
void move_copy(lua_State* L, lua_Integer i, const Vec3& step) {
  const int copy = lua_gettop(L);
  if (lua_getfield(L, copy, "name") == LUA_TSTRING) {
    lua_pushfstring(L, "%s%I", lua_tostring(L, -1), i + 1);
    lua_setfield(L, copy, "name");
  }
  const bool placed = lua_getfield(L, copy, "position") == LUA_TTABLE;
  const int position = lua_gettop(L);
  lua_newtable(L);
  for (int k = 1; k <= 3; ++k) {
    const bool given = placed && lua_rawgeti(L, position, k) != LUA_TNIL;
    const double x = given ? check_number(L, -1, "position") : 0;
    push(L, x + static_cast<double>(i) * static_cast<double>(step[k - 1]));
    lua_rawseti(L, position + 1, k);
    lua_settop(L, position + 1);
  }
  lua_setfield(L, copy, "position");
  lua_settop(L, copy);
}

void make_bodies(lua_State* L, int world, const char* maker) {
  const int options = lua_gettop(L);
  if (lua_type(L, options) != LUA_TTABLE) fail(L, "bodies: expected a list of tables, got " + describe(L, options));
  const Repeat repeat = read_repeat(L, options);
  make_shape_field(L, options);
  for (lua_Integer i = 0; i < repeat.count; ++i) {
    lua_newtable(L);
    copy_locations(L, options, -1);
    copy_fields(L, options);
    if (repeat.count > 1) move_copy(L, i, repeat.step);
    make_object(L, world, maker);
  }
  lua_settop(L, options - 1);
}

// a and b are names.
void make_joint(lua_State* L, int world) {
  const int options = lua_gettop(L);
  resolve_name(L, world, options, "a"), resolve_name(L, world, options, "b");
  make_object(L, world, "joint");
}

const Method kWorld[] = {
    {"body", method<world_body>, "world:body{ shape =, ... } -> body", "a rigid body", body_rows},
    {"joint", method<world_joint>, "world:joint{ type =, a =, b =, ... } -> joint",
     "joins two bodies, or one and the world", joint_rows},
    {"region", method<world_region>, "world:region{ box = {min, max} | shape =, position = } -> region",
     "sensor_enter and sensor_leave events", region_rows},
    {"bodies", guard<world_bodies>, "world:bodies([{ tag =, moved = }]) -> {body, ...}",
     "all bodies, those with a tag, those that the last step moved", rows_of<kBodiesFilter>},
    {"max_penetration", method<world_max_penetration>, "world:max_penetration() -> number",
     "of touching contacts now, m"},
};

// Of worlds: makers, then queries.
std::vector<Method> world_rows() {
  std::vector<Method> all(std::begin(kWorld), std::end(kWorld));
  const std::span<const Method> queries = query_methods();
  all.insert(all.end(), queries.begin(), queries.end());
  return all;
}

std::vector<OptionInfo> repeat_rows() {
  return {{.row = {.name = "repeat"}, .type = "table", .fallback = "", .choices = "", .inner = rows_of<kRepeat>()}};
}

const YamlList kYaml[] = {
    {"bodies", [](lua_State* L, int world) { make_bodies(L, world, "body"); }, "body", repeat_rows},
    {"regions", [](lua_State* L, int world) { make_bodies(L, world, "region"); }, "region", repeat_rows},
    {"joints", make_joint, "joint"}};

}  // namespace

template <>
Rigid& system_of<Rigid>(WorldRecord& record) {
  Rigid& r = record.world->need<Rigid>();
  if (record.has_pairs) return r;
  record.has_pairs = true;
  Collide& collide = record.world->need<Collide>();
  for (const NamedMaterialPair& p : record.settings.material_pairs)
    collide.set_material_pair(
        {collide.material(p.a), collide.material(p.b), p.friction_static, p.friction_dynamic, p.restitution});
  return r;
}

const Part& rigid_part() {
  static const std::vector<Method> world = world_rows();
  static const ObjectClass classes[] = {
      {.name = "body", .methods = body_methods(), .destroy = &destroy_body, .takes_forces = true, .pose = &body_pose},
      {.name = "joint", .methods = joint_methods(), .destroy = destroy_alone<&Rigid::destroy_joint>},
      {.name = "region", .methods = region_methods(), .destroy = &destroy_body}};
  static const Part part = {.name = "rigid",
                            .world = world,
                            .classes = classes,
                            .yaml = kYaml,
                            .gravity_changed = &gravity_changed,
                            .apply_forces = &apply_forces};
  return part;
}

}  // namespace feder::lua
