// The parts of the fluid system that its files share. Private to the module.
#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "fluid/solver.h"
#include "state/command_log.h"
#include "step/watch.h"

namespace feder {

// Checks one number of a description of `thing`.
inline void check_pose(const Pose& pose, const char* owner) {
  const Quat& q = pose.rotation;
  if (!is_finite(pose.position) || !is_finite(q.vec()) || !is_finite(q.w) || !is_unit(q))
    throw SceneError(std::string(owner) + ": expected a finite position, and a rotation of length 1");
}

struct Need {
  const char* thing;
  void operator()(bool ok, const char* what, const std::string& expected, double got) const {
    if (!ok)
      throw SceneError(std::string(thing) + ": " + what + ": expected " + expected + ", got " + std::to_string(got));
  }
};

// Plain data, saved as bytes; nozzle sites follow from the settings.
struct FluidEmitter {
  ObjectId object, fluid, body;
  Vec3 position = Vec3::Zero(), direction = Vec3::Zero();
  Vec3 local_position = Vec3::Zero(), local_direction = Vec3::Zero();  // in the frame of the body
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();       // of the nozzle with the body, m/s, rad/s
  Real speed = 0, radius = 0, rate = 0;                                // rate: particles per second, 0 a full jet
  std::uint64_t limit = 0, made = 0;
  double clock = 0;  // s, for which it has been running
  std::uint32_t running = 1, done = 0;
};

struct FluidDrain {
  ObjectId object, fluid, body;
  std::uint32_t shape = 0;  // in Impl::shapes
  std::uint32_t stopped = 0;
  Pose pose;
  Pose local;  // in the frame of the body
  std::uint64_t taken = 0;
};

// Tension between two fluids, N/m. Plain data, saved as bytes.
struct FluidInterface {
  ObjectId a, b;
  Real tension = 0;
  Real warned_of = 0;  // a tension, N/m
};

struct Fluid::Impl {
  explicit Impl(SystemSetup& setup);

  Arena& arena;
  const Store& store;
  Objects& objects;
  CommandLog& commands;
  Events& events;
  Watch& watched;
  Boundary& boundary;
  int dimension;
  bool* structure_changed;
  std::vector<std::unique_ptr<FluidPool>> pools;      // by object index
  std::vector<std::unique_ptr<FluidPool>> mixtures;   // mixture.cpp; none where no two fluids may touch
  std::vector<std::unique_ptr<FluidSolver>> solvers;  // by row of fluid_solvers(); null while no pool uses it
  std::vector<FluidEmitter> emitters;                 // by object index
  std::vector<FluidDrain> drains;
  std::vector<FluidInterface> interfaces;
  std::vector<ShapePtr> shapes;               // of drains, never removed: a snapshot may need them
  Array<std::uint8_t> marked{&arena};         // work: particles to remove
  Array<Aabb> swept{&arena};                  // work: by pool of a solver
  Array<std::uint32_t> group_number{&arena};  // likewise
  std::uint64_t lost = 0;                     // particles removed because they went non-finite

  FluidPool& pool(ObjectId id) const {
    FEDER_ASSERT(objects.alive(id) && objects.kind(id) == kFluidKind);
    return *pools[objects.index(id)];
  }
  FluidEmitter& emitter(ObjectId id) {
    FEDER_ASSERT(objects.alive(id) && objects.kind(id) == kEmitterKind);
    return emitters[objects.index(id)];
  }
  FluidSolver& solver_of(const FluidPool& p);
  void validate_sources() const;  // validate.cpp
  // Removes an object from its list: later ones move down.
  template <class List>
  void destroy(List& list, ObjectId id, std::string where) {
    const std::uint32_t index = objects.index(id);
    FEDER_ASSERT(index < list.size() && object_of(list[index]) == id);
    list.erase(list.begin() + index);
    for (std::uint32_t k = index; k < list.size(); ++k) objects.set_index(object_of(list[k]), k);
    objects.remove(id, std::move(where));
    *structure_changed = true;
  }
  static ObjectId object_of(const std::unique_ptr<FluidPool>& p) { return p->object; }
  template <class Source>
  static ObjectId object_of(const Source& s) {
    return s.object;
  }
  void group_pools();
  void make_room();  // outside steps: for particles of the emitters
  // The sites of an emitter's nozzle: a lattice over its circle (2D: segment), those of its first half-layer
  // and then those of its second. Calls f(offset in m, second half), until it returns false.
  template <class F>
  static void each_site(const FluidEmitter& e, const FluidPool& p, F&& f);
  static std::uint64_t site_count(const FluidEmitter& e, const FluidPool& p);
  double full_rate(const FluidEmitter& e, const FluidPool& p) const;

  // Removes the particles at positions x for which gone(x), and says how many. step.cpp
  template <class F>
  std::uint32_t take_out(FluidPool& p, const StepContext& c, F&& gone);

  // mixture.cpp
  void make_mixtures();  // outside steps
  void check_suits(const FluidPool& made) const;
  Real tension_between(const FluidPool& a, const FluidPool& b) const;
  void set_tensions(FluidPool& mixture) const;
  void find_touching(StepContext& c);
  void mix(StepContext& c);
  bool list_near(const FluidPool& p, const FluidPool& mixture, std::vector<const FluidPool*>& out) const;
  bool meets_others(const FluidPool& p) const;
  void find_mixed_ratios(FluidPool& p);  // where it meets others, for queries
  void unmix(StepContext& c);
  template <class F>
  void each_touching(const FluidPool& p, F&& f) const;
  bool all_calm(const FluidPool& p, Real time) const;                      // those that it touches
  double given_by_others(const FluidPool& p, const StepContext& c) const;  // energy that they may have, J

  // Passes.
  void begin_substep(StepContext& c);
  void make_groups(StepContext& c);
  void join_pools(const std::vector<FluidPool*>& members, StepContext& c);
  void emit(StepContext& c);
  void relax(StepContext& c);
  void project(StepContext& c);
  void drain(StepContext& c);
  void kill(StepContext& c);
  void check(StepContext& c);
  // external_forces.cpp: the world's forces and those of scripts.
  bool has_forces() const;
  bool is_forced(const FluidPool& p) const;  // by any of them
  bool has_wind();                           // and makes room for the surfaces that it acts on
  void find_surfaces(StepContext& c);
  void find_pressing(StepContext& c);
  void apply_forces(StepContext& c);
  void close_forces(StepContext& c);
  template <class F>
  void kick_by_forces(double time, StepContext& c, F&& seconds);
  template <class F>
  void each_force(const FluidPool& p, F&& f) const;  // calls f(entry) for the generators that act on the pool
  template <class F>
  void each_force_block(const FluidPool& p, std::uint32_t first, std::uint32_t last, double time, Real drag,
                        F&& f) const;
  JobPool* jobs_of_forces(const FluidPool& p, StepContext& c);
  void store_forces(const FluidPool& p, Row4* to, StepContext& c);
  double potential(const FluidPool& p) const;  // of them, J
  // sleep.cpp
  struct RestSums {
    double square = 0, most = 0;  // of the squared speeds, m^2/s^2
    double place[3] = {0, 0, 0};  // of the positions, m
  };
  void wake(FluidPool& p, WakeCause cause, ObjectId other);
  void wake_disturbed(StepContext& c);
  void update_sleep(FluidPool& p, const RestSums& sums, StepContext& c);
  std::uint64_t rest_key(FluidPool& p, const StepContext& c);
  // watch.cpp
  void watch(FluidPool& p, double square, StepContext& c);  // square: sum of the squared speeds, m^2/s^2
  void suspect(const FluidPool& p);
  void run_emitter(FluidEmitter& e, StepContext& c);
  // misfits.cpp
  void check_fluids_that_meet(StepContext& c);
  void check_interfaces(StepContext& c);
  void check_room(FluidPool& p, StepContext& c);
  void stop_lost_sources(StepContext& c);  // those whose body is no more

  struct PairCount {
    std::uint64_t close = 0, all = 0;  // closer than half a spacing; within the support
    double share() const { return all > 0 ? static_cast<double>(close) / static_cast<double>(all) : 0; }
  };
  // sample.cpp, for queries at the present positions. Pairs of at most about `most` particles, evenly taken.
  PairCount pairs_of(FluidPool& p, std::uint32_t most = kPairSample);
  static constexpr std::uint32_t kPairSample = 4096;  // of residuals, which are asked often
  // The next step goes on from the density ratios of the last substep, however often queries find them anew.
  struct KeptRatios {
    explicit KeptRatios(FluidPool& pool) : p(pool), ratio(pool.ratio.begin(), pool.ratio.begin() + pool.count) {}
    ~KeptRatios() { std::copy(ratio.begin(), ratio.end(), p.ratio.begin()); }
    KeptRatios(const KeptRatios&) = delete;
    KeptRatios& operator=(const KeptRatios&) = delete;
    FluidPool& p;
    std::vector<Real> ratio;
  };
  void refresh_near(FluidPool& p, const Vec3& at, const std::vector<std::uint32_t>& wanted);
  void find_ratios_now(FluidPool& p);
  void refresh(FluidPool& p);  // lists, contacts and density ratios at the present positions, for queries
  std::vector<std::uint32_t> by_id(const FluidPool& p) const;
  // value(i) of each particle, in the order of making.
  template <class T, class F>
  void list_by_id(const FluidPool& p, std::vector<T>& out, F&& value) const {
    out.clear();
    for (const std::uint32_t i : by_id(p)) out.push_back(value(i));
  }
  JobPool one_thread{1};
};

}  // namespace feder
