// The parts of the rope system that its files share. Private to the module.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "feder/error.h"
#include "feder/force.h"
#include "feder/rope.h"
#include "forces/work_bound.h"
#include "rope/chain.h"
#include "state/arrays.h"
#include "state/command_log.h"
#include "state/surface.h"
#include "state/surface_links.h"
#include "step/watch.h"

namespace feder {

// What decides a rope's motion beside its points; plain data, saved as it is.
struct RopeSettings {
  Real radius = 0, density = 0, stretch = 0, bend = 0;  // m, kg/m^3, N, N m^2
  Real damping = 0;                                     // s
  Real drag = 0, friction = 0, gravity_scale = 1;
  std::uint32_t group = 1, mask = 0xffffffffu;
  std::uint32_t self_collision = 1;
  std::int32_t substeps = 0;
};

// What changes from step to step; saved too.
struct RopeState {
  // m/s^2: gravity while the last step was free fall, else 0: velocities are then those at the end of a solver
  // substep, where the method's own are half of one behind
  Real flight[3] = {0, 0, 0};
  Real sleep_energy = kInfinity;  // moving average of kinetic energy per mass, m^2/s^2
  std::uint32_t sleep_steps = 0;
  std::uint32_t fresh = 1, frozen = 0, asleep = 0;  // 1: not stepped yet; quarantined; asleep
  std::int32_t substeps = 1;                        // as last chosen
  std::uint32_t warned = 0;                         // 1: Newton's method missed its tolerance
  std::uint32_t clamped[2] = {0, 0};
  Real direction[2][3] = {};  // of the clamped ends' segments, unit
};

// Of a rope whose energy jumped.
inline constexpr const char* kRopeCure = "take more substeps or weaker forces";

struct Line {
  explicit Line(Arena& a) : arena(a) {}

  Arena& arena;
  ObjectId object;
  RopeSettings settings;
  RopeState state;
  Array<Vec3> position{&arena}, velocity{&arena};  // m, world; m/s
  Array<Vec3> script_force{&arena};                // N
  Array<Real> mass{&arena}, inv_mass{&arena};      // kg; 1/kg, 0: pinned
  Array<Real> rest_length{&arena};                 // m, by segment
  // Contact forces of the last solver substep on the rope at points, and between the ends of segments, N.
  Array<Vec3> point_force{&arena}, segment_force{&arena};

  // follow from those
  Array<Vec3> rest{&arena};                           // straight, m
  Array<std::array<std::uint32_t, 2>> edges{&arena};  // segments
  Real total_mass = 0;                                // kg
  Real full_length = 0;                               // m
  // of a step
  Array<Vec3> acceleration{&arena};  // gravity, scripts, generators, m/s^2
  std::uint32_t surface = 0;         // in Surfaces::list
  std::uint32_t bad_point = kNone;
  bool any_pin = false, touched = false, linked = false;  // linked: held to something
  Vec3 gained_momentum = Vec3::Zero();                    // kg m^2/s: error of angular momentum in this substep
  double missed = 0;                                      // m
  Array<Vec3> began{&arena};                              // m: where the step began, for the watchdog
  double kinetic_before = 0;                              // J, then

  std::uint32_t size() const { return static_cast<std::uint32_t>(position.size()); }
  bool active() const { return !state.frozen && !state.asleep; }
  Vec3 flight() const { return Vec3(state.flight[0], state.flight[1], state.flight[2]); }
  void set_flight(const Vec3& a) {
    for (int k = 0; k < 3; ++k) state.flight[k] = a[k];
  }
  void derive();                                      // what follows from the rest
  double elastic_energy(const Array<Vec3>& x) const;  // of stretch and bending, J, with its points there
  double kinetic_energy() const;                      // J
  // Calls f(member) for what snapshots hold.
  template <class L, class F>
  static void each_saved(L& l, F&& f) {
    for_each_of(f, l.object, l.settings, l.state, l.position, l.velocity, l.script_force, l.mass, l.inv_mass,
                l.rest_length, l.point_force, l.segment_force);
  }
};

struct Rope::Impl {
  explicit Impl(SystemSetup& setup);

  Arena& arena;
  Store& store;
  Objects& objects;
  CommandLog& commands;
  Events& events;
  Watch& watched;
  bool* structure_changed;
  const Real air_density;  // kg/m^3, of still air
  Surfaces& surfaces;
  std::vector<std::unique_ptr<Line>> lines;  // by object index
  std::size_t force_count = 0;               // forces known when the passes were made
  bool gravity_known = false;
  Vec3 gravity = Vec3::Zero();  // of the last step: a change wakes all

  Chain chain{arena};
  Array<ChainContact> contacts{&arena};
  Array<ChainLoad> loads{&arena};
  Array<double> masses{&arena};  // kg, as the chain sees them
  Array<MassPoint> points{&arena};
  Array<Vec3> forces{&arena};  // N
  // By solver index: velocity where the substep begins, without and with the push of gravity over all of it, m/s.
  Array<Vec3> body_start{&arena}, body_pushed{&arena};
  std::uint64_t solves = 0;  // Newton steps of the last step

  Line& line(ObjectId id) const {
    FEDER_ASSERT(objects.alive(id) && objects.kind(id) == kRopeKind);
    return *lines[objects.index(id)];
  }
  std::uint32_t point(ObjectId id, std::size_t i) const;  // SceneError when there is none
  void declare_surfaces();
  void wake(Line& l, WakeCause cause, ObjectId other);
  void put_to_sleep(Line& l);
  void drain_wakes();

  // passes
  void show(StepContext& c);
  void gather(StepContext& c);
  void remember_bodies(StepContext& c);
  void begin_substep(StepContext& c);
  void advance(StepContext& c);
  void read_velocities(StepContext& c);
  void wake_touched(StepContext& c);
  void commit(StepContext& c);

  int wanted_substeps(const Line& l, const StepContext& c, Real fastest) const;
  void add_forces(Line& l, StepContext& c);
  void add_air(const Line& l, Real h, bool blown, double time);
  void advance_line(Line& l, SurfaceGroup& g, StepContext& c);
  Vec3 body_velocity(std::uint32_t solver_index, const StepContext& c) const;
  void list_contacts(Line& l, SurfaceGroup& g, const StepContext& c);
  void list_loads(Line& l, SurfaceGroup& g, const StepContext& c);
  void hand_over(Line& l, SurfaceGroup& g);
  void hand_over_loads(Line& l, SurfaceGroup& g);
  void remove_gained_momentum(Line& l);
  void update_sleep(Line& l, StepContext& c);
  // watch.cpp
  double work(const Line& l, const StepContext& c) const;
  double given(const Line& l, const StepContext& c) const;
  void watch(const Line& l, const StepContext& c);

  SurfaceGroup& group(const StepContext& c) const { return *surfaces.groups[static_cast<std::size_t>(c.inner.group)]; }
  template <class F>
  void each_active(const SurfaceGroup& g, F&& f) {
    for (const std::uint32_t n : g.members)
      if (objects.kind(surfaces.list[n].object) == kRopeKind) {
        Line& l = line(surfaces.list[n].object);
        if (l.active()) f(l);
      }
  }
  template <class F>
  void each_force(const Line& l, F&& f) const {
    each_acting(store.find<Forces>(), l.object, objects.tags(l.object), f);
  }
  MassPoint mass_point(const Line& l, std::uint32_t i) const {
    const Real volume = l.mass[i] / l.settings.density;
    return {l.position[i], l.velocity[i], l.mass[i], 2 * volume / (Real(3.14159265) * l.settings.radius), volume};
  }
};

}  // namespace feder
