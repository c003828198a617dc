// The parts of the cloth system that its files share. Private to the module.
#pragma once
#include <memory>
#include <vector>

#include "base/double3.h"
#include "cloth/sheet.h"
#include "feder/force.h"
#include "forces/work_bound.h"
#include "state/cloth_vertices.h"
#include "state/command_log.h"
#include "state/surface.h"
#include "step/watch.h"

namespace feder {

struct Cloth::Impl {
  explicit Impl(SystemSetup& setup);

  Arena& arena;
  ClothVertices& vertices;
  Store& store;
  Watch& watched;
  Objects& objects;
  CommandLog& commands;
  Events& events;
  bool* structure_changed;
  const Real air_density;  // kg/m^3, of still air
  Cloth* owner = nullptr;
  std::vector<std::unique_ptr<Sheet>> sheets;  // by object index
  std::vector<Attachment> attachments;         // in the order of their making

  // of a step, by vertex
  Surfaces& surfaces;
  Array<Row4>&delta_position, &before, &velocity;  // members of `surfaces`
  Array<Vec3> acceleration{&arena};                // gravity, script, wind
  Array<Vec3> force{&arena};                       // work memory of forces.cpp, N
  Array<Vec3> air{&arena};                         // likewise: of still air, N
  Array<MassPoint> points{&arena};
  Array<Double3> gas_force{&arena};  // work memory of pressure.cpp, N
  struct Carried {
    std::uint32_t attachment;  // in the group
    Real mass;                 // share of the body's, kg
    Vec3 velocity;             // of the body's point, m/s
  };
  Array<Carried> hauled{&arena};               // of a solver substep and cloth, see ties.cpp
  Array<Real> carried_mass{&arena};            // kg
  bool carried_afloat = false;                 // nothing else holds it
  Double3 carried_momentum{0, 0, 0};           // of the cloth alone before its solver moves it, kg m/s
  Array<unsigned char> edited_vertex{&arena};  // of suspects(), by vertex of a cloth
  struct Neighborhood {
    Vec3 sum = Vec3::Zero();  // of the neighbours' positions, m
    Real rest = 0;            // of the edges to them, m
    std::uint32_t count = 0;
  };
  Array<Neighborhood> neighborhoods{&arena};  // of farthest(), by vertex of a cloth
  struct Place {
    std::array<double, 3> at;  // rounded
    std::uint32_t sheet = 0, vertex = 0;
  };
  Array<Place> places{&arena};               // of warn_of_coincident()
  Array<std::uint32_t> other_sheet{&arena};  // by vertex: of which another vertex lies in the same place
  bool any_active = false;
  std::size_t force_count = 0;  // forces known when the rows were made
  bool gravity_known = false;
  Vec3 gravity = Vec3::Zero();  // of the last step: a change wakes all cloths

  mutable Array<std::uint32_t> marks{&arena};  // of validate(), by vertex

  Sheet& sheet(ObjectId id) const {
    FEDER_ASSERT(objects.alive(id) && objects.kind(id) == kClothKind);
    return *sheets[objects.index(id)];
  }
  std::uint32_t vertex(ObjectId id, std::size_t i) const;  // index in ClothVertices; SceneError when there is none
  ClothView view(Sheet& s);
  void attach_solver(Sheet& s, const std::string& name, const Params& options);
  void measure_paths(Sheet& s);
  void make_ties(Sheet& s);
  void place_ties(Sheet& s);
  std::uint32_t farthest(const Sheet& s, Real& distance, Vec3& mean);  // put_back.cpp
  void put_back(Sheet& s, StepContext& c);
  void warn_of_coincident(StepContext& c);
  Aabb suspects(const Sheet& s);
  void show_tangles(const Sheet& s, Surface& f);
  static bool untangles(const Sheet& s);
  void read_tangles(StepContext& c);
  Real pins_apart(const Sheet& s) const;
  void declare_surfaces();
  void show(const Sheet& s);  // adds its surface
  void solve_body_ties(StepContext& c);
  void carry_bodies(Sheet& s, const SurfaceGroup& g, ClothView& v);
  template <class F>
  Double3 momentum_of(const Sheet& s, F&& velocity_of) const;
  void hand_over(const Sheet& s, const SurfaceGroup& g);
  void wake(Sheet& s, WakeCause cause, ObjectId other);
  void put_to_sleep(Sheet& s);

  // Passes: of the step, of the substep, of the loop of solver substeps, of the step.
  void prepare(StepContext& c);
  void gather_again(StepContext& c);
  void begin_substep(StepContext& c);
  void advance(StepContext& c);
  void read_velocities(StepContext& c);
  void damp(StepContext& c);
  void wake_touched(StepContext& c);
  void commit(StepContext& c);

  SurfaceGroup& group(const StepContext& c) const { return *surfaces.groups[static_cast<std::size_t>(c.inner.group)]; }
  const SurfaceGroup& group_of(const Sheet& s) const {
    return *surfaces.groups[surfaces.group_of(objects.index(s.object))];
  }
  // The cloths of a group come first among its members.
  template <class F>
  void each_active(const SurfaceGroup& g, F&& f) {
    for (const std::uint32_t n : g.members)
      if (n < sheets.size() && sheets[n]->active()) f(*sheets[n]);
  }

  // Calls f(entry) for the generators that act on the cloth.
  template <class F>
  void each_force(const Sheet& s, F&& f) const {
    each_acting(store.find<Forces>(), s.object, objects.tags(s.object), f);
  }
  // A vertex as generators see it, at the position and velocity of ClothVertices.
  MassPoint mass_point(const Sheet& s, std::uint32_t i) const {
    const Real area = vertices.mass[i] / s.settings.area_density;
    return {vertices.position[i], vertices.velocity[i], vertices.mass[i], area, area * s.settings.thickness};
  }

  void drain_wakes();
  void measure_gained_momentum(Sheet& s, Real h);
  void remove_gained_momentum(Sheet& s);
  void choose_steps(StepContext& c);
  double swing(const Sheet& s) const;
  void check_damping(Sheet& s, StepContext& c);
  void check_shortfall(Sheet& s, StepContext& c);
  void prepare_solver(Sheet& s, StepContext& c);
  void gather(Sheet& s, Real h);
  void add_forces(StepContext& c);
  void add_wind(Sheet& s, double time, Real h);
  void meet_still_air(Sheet& s, StepContext& c);
  void quarantine(StepContext& c);
  void update_sleep(StepContext& c);
  // watch.cpp
  double kinetic_energy(const Sheet& s) const;
  double work(const Sheet& s, const StepContext& c) const;
  double given(const Sheet& s, const StepContext& c) const;
  void watch(StepContext& c);
  void suspect(const Sheet& s);
  void tear(StepContext& c);
  std::uint32_t tear_at(Sheet& s, std::uint32_t link, StepContext& c);
  std::uint32_t split_vertex(Sheet& s, std::uint32_t vertex, const std::vector<std::uint32_t>& triangles);
  void lump_mass(Sheet& s);
  void share_mass(Sheet& s);
  // pressure.cpp
  void check_pressure(Sheet& s, StepContext& c);
  void measure_gas(Sheet& s);
  double gas_substeps(const Sheet& s, Real h) const;
  void begin_pressure(Sheet& s, StepContext& c);
  void push_gas(Sheet& s, Real h);
  void keep_momentum(Sheet& s, Real h);
  // plastic.cpp
  void flow(StepContext& c);
  struct FlowBefore {
    std::vector<ClothLink> links;
    std::vector<ClothHinge> hinges;
  };
  void keep_flow(Sheet& s, const FlowBefore& old, std::uint32_t old_points, std::uint32_t split);
  // validate.cpp
  void validate_sheet(std::uint32_t n) const;
  void validate_mesh(const Sheet& s) const;
  void validate_motion(const Sheet& s) const;
  void validate_ties(const Sheet& s) const;
  Vec3 current_position(std::uint32_t vertex) const { return vertices.position[vertex] + delta_position[vertex].vec(); }
  Sheet& sheet_of(std::uint32_t vertex) const {
    FEDER_ASSERT(vertex < vertices.size());
    return *sheets[objects.index(vertices.cloth[vertex])];
  }
};

}  // namespace feder
