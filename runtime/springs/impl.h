// The parts of the springs system that its files share. Private to the module.
#pragma once
#include <memory>
#include <vector>

#include "springs/net.h"

namespace feder {

struct Springs::Impl {
  explicit Impl(SystemSetup& setup)
      : arena(setup.store.arena(kName)), particles(setup.store.need<Particles>(kName)), store(setup.store),
        objects(setup.objects), structure_changed(setup.structure_changed) {}

  Arena& arena;
  Particles& particles;
  Store& store;
  Objects& objects;
  bool* structure_changed;
  std::vector<std::unique_ptr<Net>> nets;  // the object's index is the place here
  std::vector<Attachment> attachments;     // in the order they were made

  Net& net(ObjectId id) const { return *nets[objects.index(id)]; }
  // Index in Particles; SceneError when there is no such point.
  std::uint32_t point(ObjectId id, std::size_t i) const;
  std::uint32_t spring(ObjectId id, std::size_t k) const;  // index within the net, likewise
  void attach_integrator(Net& n, const std::string& name, const Params& options);

  // Rows.
  void remember(StepContext& c);
  void integrate(StepContext& c);
  void finish(StepContext& c);

  void check_stiffness(StepContext& c);
  void break_springs(Net& n, Events& events);
  void quarantine(StepContext& c);
};

}  // namespace feder
