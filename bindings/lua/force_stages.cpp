// Forces of scripts that are asked at every stage of the integrators (stages = true): a generator that calls its Lua
// function on the stepping thread, points in order. The world is between two states then and only answers questions.
// An error ends the force for the step and is raised behind it, because nothing may unwind a step.
#include <utility>

#include "lua/objects.h"

namespace feder::lua {
namespace {

constexpr int kSlots = 16;  // of the Lua stack, for one call

class StageForce final : public Force {
 public:
  StageForce(WorldRecord& record, int function, std::size_t profile)
      : record_(record), function_(function), profile_(profile) {}

  void add(const MassPoint* points, std::size_t count, double time, Vec3* out) const override {
    lua_State* L = record_.stepping;
    if (!L || record_.world->step_count() == failed_step_) return;
    State& s = state(L);
    // a budget of its own, taken from that of the call that steps: its error must not unwind the step
    const int depth = std::exchange(s.depth, 0);
    const std::uint64_t left = s.budget;
    const double start = s.lua_start;
    record_.read_only = true;
    for (std::size_t i = 0; i < count; ++i) {
      Failure failure;
      if (ask(L, points[i], time, out[i], failure)) continue;
      failed_step_ = record_.world->step_count();
      record_.stage_failures.push_back(failure);
      break;
    }
    record_.read_only = false;
    s.depth = depth;
    if (depth > 0) s.budget = left, s.lua_start = start;
  }
  bool on_stepping_thread() const override { return true; }

 private:
  bool ask(lua_State* L, const MassPoint& p, double time, Vec3& out, Failure& failure) const {
    state(L).profile[profile_].calls += 1;
    Vec3 force = Vec3::Zero();
    if (!ask_force(L, record_, function_, profile_, p, time, force, failure)) return false;
    out += force;
    return true;
  }

  WorldRecord& record_;
  int function_;
  std::size_t profile_;
  mutable std::uint64_t failed_step_ = ~std::uint64_t{0};
};

}  // namespace

std::unique_ptr<Force> make_stage_force(WorldRecord& record, int function, std::size_t profile) {
  return std::make_unique<StageForce>(record, function, profile);
}

void begin_stages(lua_State* L, WorldRecord& record) {
  luaL_checkstack(L, kSlots, "forces");
  record.stepping = L;
}

void end_stages(lua_State* L, WorldRecord& record) {
  record.stepping = nullptr;
  const std::vector<Failure> failures = std::exchange(record.stage_failures, {});
  for (const Failure& f : failures) state(L).report(f);
}

bool answers_in_step(const char* function) {
  static constexpr std::string_view kQuestions =
      " alive angle angular_velocity awake bodies center_of_mass count dimension dt enabled gravity inertia is_sensor "
      "kind"
      " length local_point mass name pinned point position positions rotation spring spring_limits step_count strain "
      "tags"
      " time type velocity velocity_at world_point ";
  const std::string whole(function);
  return kQuestions.find(" " + whole.substr(whole.rfind(':') + 1) + " ") != kQuestions.npos;
}

}  // namespace feder::lua
