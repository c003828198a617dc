// Force generators: from the state of one mass point to a force. Owners of mass points (bodies, nets, cloths, fluids)
// evaluate them, from several threads at once: `add` and the other const members must not change shared state.
// One file per kind, one feder_variant(forces <kind>) line. Gravity of the world is not among them.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "feder/object.h"
#include "feder/params.h"
#include "feder/types.h"

namespace feder {

struct MassPoint {
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();  // m, m/s, world
  Real mass = 0;                                          // kg
  Real area = 0;                                          // m^2, cross-section where known (drag, wind), else 0
  Real volume = 0;                                        // m^3 where known (buoyancy), else 0
  // Largest drag coefficient, kg/s: bound of force over relative velocity. Owners that keep the force constant for a
  // time h set mass/h, divided among all such forces: drag may stop the point within h and never reverses it.
  Real most_drag = kInfinity;
};

// Contract, checked for every kind by tests/forces/test_force_contract.cpp: finite for finite input, zero for zero
// mass when the kind is proportional to mass, the potential's gradient where there is one, and bounded by `most_drag`
// where it acts against a relative velocity.
class Force {
 public:
  virtual ~Force() = default;
  // Adds the forces on `count` points to `out` (N). One virtual call per force and evaluation, never per point.
  virtual void add(const MassPoint* points, std::size_t count, double time, Vec3* out) const = 0;
  // Potential energy of the points, J; 0 for forces without a potential.
  virtual double potential(const MassPoint*, std::size_t) const { return 0; }
  // False: methods with implicit damping need no derivative by the velocity.
  virtual bool depends_on_velocity() const { return true; }
  // Adds df/dx (or df/dv) of each point alone to `out`, N/m (N s/m). False: not known; owners take differences.
  virtual bool derivative(const MassPoint*, std::size_t, double /*time*/, bool /*by_velocity*/, Mat3*) const {
    return false;
  }
  // Evaluations so far that had no value and counted as 0; the world warns of the first (`force_domain`).
  virtual std::uint64_t faults() const { return 0; }
  // Must be evaluated on the thread that steps the world (it runs a script).
  virtual bool on_stepping_thread() const { return false; }
  // True for pressure on surfaces: owners of triangles evaluate one square metre normal to the flow, and orient the
  // result by the triangle's normal.
  virtual bool on_area() const { return false; }
};

std::span<const Variant<Force>> force_kinds();

// A force in a world, and its targets.
struct ForceEntry {
  ObjectId object;                         // the force's own handle
  std::shared_ptr<const Force> force;      // null for a scripted force
  bool all = false;                        // acts on everything
  TagMask tags = 0;                        // or on objects with one of these tags
  ObjectId target;                         // or on one object
  std::vector<std::uint32_t> points = {};  // of `target`, a net: on these only, ascending; empty: on all
  bool enabled = true;
  bool warned = false;  // of an evaluation without a value

  // Calls f(field) for what says whom it acts on.
  template <class E, class F>
  static void each_field(E& e, F&& f) {
    f(e.all), f(e.tags), f(e.target), f(e.points), f(e.enabled);
  }
};

}  // namespace feder
