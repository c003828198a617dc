// Forces: the kinds of the runtime, and Lua functions evaluated before each step.
#pragma once
#include <map>
#include <vector>

#include "feder/force.h"
#include "feder/object.h"
#include "feder/types.h"
#include "feder/world.h"
#include "lua/state.h"

namespace feder::lua {

struct ScriptForce {
  ObjectId object;   // the force's handle
  int function = 0;  // key in the world's callbacks
  bool all = false;
  TagMask tags = 0;
  ObjectId target;
  std::vector<std::uint32_t> points;  // of `target`, ascending; empty: all
  std::size_t profile = 0;
  std::map<std::uint32_t, Vec3> held;  // by index in a system: the force when it was last awake
};

// The functions of a step, for the parts that hand what they say to their objects. A function that fails is not asked
// again in the step. It may destroy anything: who walks over objects checks that they are still alive.
class ForceRun {
 public:
  ForceRun(lua_State* L, WorldRecord& record, std::vector<ScriptForce> forces);
  WorldRecord& record() { return record_; }
  std::vector<ScriptForce>& forces() { return forces_; }
  bool acts(std::size_t k, ObjectId object) const;
  bool any(ObjectId object) const;
  // Force k at a point, N: false, and zero, when it fails or has failed.
  bool ask(std::size_t k, const Vec3& position, const Vec3& velocity, Real mass, Vec3& out);
  bool failed(std::size_t k) const { return failed_[k] != 0; }
  // The sum over those that act on a point (which counts from 0) of an object.
  Vec3 sum(ObjectId object, std::uint32_t point, const Vec3& position, const Vec3& velocity, Real mass);

 private:
  lua_State* L_;
  WorldRecord& record_;
  std::vector<ScriptForce> forces_;
  std::vector<char> failed_;
};

// For a system whose objects of a kind have points: each point's sum becomes its script force.
template <class System>
void apply_to_points(ForceRun& run, World& world, ObjectKind kind, std::size_t (System::*count)(ObjectId) const) {
  System* system = world.find<System>();
  if (!system) return;
  system->clear_script_forces();
  const Objects& objects = world.objects();
  std::vector<ObjectId> all;
  objects.for_each(kind, [&](ObjectId id) { all.push_back(id); });
  for (const ObjectId id : all) {
    if (!objects.alive(id) || !run.any(id)) continue;
    for (std::size_t i = 0; objects.alive(id) && i < (system->*count)(id); ++i) {
      const Vec3 force = run.sum(id, static_cast<std::uint32_t>(i), system->point(id, i), system->velocity(id, i),
                                 system->point_mass(id, i));
      if (objects.alive(id) && dot(force, force) > 0) system->set_script_force(id, i, force);
    }
  }
}

template <class System>
void clear_script_forces(World& world) {
  if (System* system = world.find<System>()) system->clear_script_forces();
}

// One evaluation of a script's force, N. False: the function failed, or answered something else than three finite
// numbers; `failure` says so, and `out` may be written in part.
bool ask_force(lua_State* L, WorldRecord& record, int function, std::size_t profile, const MassPoint& p, double time,
               Vec3& out, Failure& failure);

// Evaluates the functions for every point and body they act on, and hands the sums to the systems.
void apply_script_forces(lua_State* L, WorldRecord& record);

// Forces asked at every stage (force_stages.cpp): before and after World::step.
std::unique_ptr<Force> make_stage_force(WorldRecord& record, int function, std::size_t profile);
void begin_stages(lua_State* L, WorldRecord& record);
void end_stages(lua_State* L, WorldRecord& record);
// May a script call this API function ("net:point") while a stage asks it? Those that only report the state.
bool answers_in_step(const char* function);

int world_force(lua_State* L);
std::vector<OptionInfo> force_rows();
std::span<const Method> force_methods();

}  // namespace feder::lua
