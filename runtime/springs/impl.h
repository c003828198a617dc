// State and functions of the springs system, shared by its source files. Private to the module.
#pragma once
#include <memory>
#include <vector>

#include "feder/error.h"
#include "forces/area.h"
#include "forces/forces.h"
#include "springs/net.h"
#include "state/colliders.h"
#include "state/command_log.h"
#include "state/particles.h"
#include "state/surface.h"
#include "step/watch.h"

namespace feder {

// Bad descriptions end as SceneError with the field's name; messages count from 1, as scripts do.
// `owner` is the net in words.
void check_net(const NetDesc& desc, const std::string& owner);
void check_spring(const SpringDesc& spring, std::size_t points, std::size_t k, const std::string& owner);
// The distance of the ends where the description leaves it open.
Real rest_length_of(const SpringDesc& spring, const Vec3& a, const Vec3& b, std::size_t k, const std::string& owner);

// "auto": the widest this processor has; "plain": the same bits, slower.
const SpringKernels& pick_kernels(bool wide);

// Stability number h*omega (or h times the decay) that is compared with the limit of a method.
double stability_number(const IntegratorInfo& method, double h, double frequency, double decay);
bool beyond_limit(const IntegratorInfo& method, double number);

struct Springs::Impl {
  explicit Impl(SystemSetup& setup)
      : kernels(pick_kernels(wide_kernels(setup.options))), arena(setup.store.arena(kName)),
        particles(setup.store.need<Particles>(kName)), watched(setup.store.need<Watch>("watch")), store(setup.store),
        objects(setup.objects), commands(setup.commands), structure_changed(setup.structure_changed),
        air_density(still_air_density(setup.world)), surface_end(&arena), surface_velocity(&arena) {}

  const SpringKernels& kernels;
  Arena& arena;
  Particles& particles;
  Watch& watched;
  Store& store;
  Objects& objects;
  CommandLog& commands;
  bool* structure_changed;
  const Real air_density;                  // kg/m^3, of still air
  std::vector<std::unique_ptr<Net>> nets;  // by the object's index
  std::vector<Attachment> attachments;     // in the order they were made
  std::vector<Removed> removed;            // since the last plan
  // of a substep, by point of the surfaces: where the integrator ends, and the velocity that leads there
  Array<Vec3> surface_end, surface_velocity;

  Net& net(ObjectId id) const {
    FEDER_ASSERT(objects.kind(id) == kNetKind && nets[objects.index(id)]->object == id);
    return *nets[objects.index(id)];
  }
  // Index in Particles; SceneError when there is no such point.
  std::uint32_t point(ObjectId id, std::size_t i) const;
  std::uint32_t spring(ObjectId id, std::size_t k) const;  // index within the net, likewise
  std::unique_ptr<Net> make_net();
  void attach_integrator(Net& n, const std::string& name, const Params& options);

  // passes
  void remember(StepContext& c);
  void integrate(StepContext& c);
  void finish(StepContext& c);
  void watch(StepContext& c);  // watch.cpp
  void suspect(const Net& n);
  // surface.cpp
  void declare_surfaces();
  void show_surfaces(StepContext& c);
  void mark_surfaces(StepContext& c);
  void coast_surfaces(StepContext& c);
  void follow_surfaces(StepContext& c);
  template <class F>
  void each_surface(F&& f);
  // validate.cpp
  void check_points(const Net& n) const;
  void check_colliders() const;

  void check_stiffness(StepContext& c);
  void warn_frozen_forces(const Forces& forces, Events& events);
  void break_springs(Net& n, Events& events);
  void warn_coincident(Net& n, Events& events);
  void quarantine(StepContext& c);
  bool any_bad() const {
    for (const auto& n : nets)
      if (n->bad()) return true;
    return false;
  }
};

}  // namespace feder
