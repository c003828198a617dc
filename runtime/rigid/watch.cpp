// Watchdog over the kinetic energy of rigid bodies, see step/watch.h. Every step compares each body's kinetic energy
// per mass with that of the step before (sleep.cpp computes it); where one jumped, islands are found and their energies
// compared. Velocities at the start of the step are those of the colliders. All work is bounded from above.
#include <algorithm>
#include <cmath>
#include <limits>

#include "forces/forces.h"
#include "rigid/impl.h"

namespace feder {
namespace {

constexpr const char* kCure = "take more substeps, the other rigid solver, or softer springs and lighter joints";

double to_double(Real x) { return static_cast<double>(x); }

}  // namespace

// Kinetic energy of body i with these velocities, J.
double Rigid::Impl::kinetic_energy(std::uint32_t i, const Quat& rotation, const Vec3& v,
                                   const Vec3& angular_velocity) const {
  const Vec3 w = rotate_inverse(rotation, angular_velocity);
  return 0.5 * (to_double(bodies.mass[i]) * to_double(dot(v, v)) + to_double(dot(w, Vec3(bodies.inertia[i] * w))));
}

// Without sleep nothing else measures motion: the speed of the farthest point is enough.
void Rigid::Impl::measure_pace(const StepContext& c) {
  const Real least = static_cast<Real>(quiet_energy(c));
  for (const std::uint32_t i : moving) {
    if (bodies.type[i] != BodyType::dynamic) continue;
    const Vec3 &v = bodies.velocity[i], &w = bodies.angular_velocity[i];
    const Real extent = bodies.extent[i];
    if (jumps(i, Real(0.5) * (dot(v, v) + extent * extent * dot(w, w)), least)) jumpers.push_back(i);
  }
}

// Upper bound of the work of weight, scripts and generators on one body in this step, J.
double Rigid::Impl::work_on(std::uint32_t i, const StepContext& c) {
  const std::uint32_t p = solver_bodies.index[bodies.solver_slot[i]] - 1;
  FEDER_ASSERT(p < applied_force.size() && bodies.first_collider[i] != kNone);
  const SolverBody& s = solver_bodies.state[p + 1];
  const double path = to_double(length(s.delta_position)), dt = to_double(c.dt);
  const double angle = dt * to_double(length(bodies.angular_velocity[i])) +
                       dt * to_double(length(colliders.angular_velocity[bodies.first_collider[i]]));
  double sum =
      to_double(bodies.mass[i]) * to_double(length(c.gravity)) * std::fabs(to_double(bodies.gravity_scale[i])) * path;
  sum += to_double(length(applied_torque[p])) * angle + to_double(length(applied_force[p])) * path;
  const Forces* forces = store.find<Forces>();
  if (force_count == 0 || !forces) return sum;
  for (const ForceEntry& f : forces->list) {
    if (!acts_on(f, bodies.object[i], objects.tags(bodies.object[i]))) continue;
    double potential[2], push = 0;
    for (int end = 0; end < 2; ++end) {
      MassPoint point{solver_bodies.mass[p + 1].center, colliders.velocity[bodies.first_collider[i]], bodies.mass[i],
                      area[i], volume[i]};
      if (end) point.position = bodies.position[i], point.velocity = bodies.velocity[i];
      Vec3 force = Vec3::Zero();
      potential[end] = f.force->potential(&point, 1);
      f.force->add(&point, 1, c.time + end * dt, &force);
      push = std::fmax(push, to_double(length(force)));
    }
    // the loss of potential, or, where there is none, force times path
    const bool none = potential[0] == 0 && potential[1] == 0;
    sum += none ? push * path : std::fmax(potential[0] - potential[1], 0.0);
  }
  return sum;
}

// Contacts: the energy that undoes an overlap within one substep, and the speed of kinematic partners.
void Rigid::Impl::watch_contacts(const StepContext& c) {
  for (const std::uint32_t slot : contacts.active) {
    const Contact& contact = contacts.slots[slot];
    const std::uint32_t a = colliders.body_of(contact.collider_a), b = colliders.body_of(contact.collider_b);
    const bool moves_a = a != kNone && bodies.type[a] == BodyType::dynamic,
               moves_b = b != kNone && bodies.type[b] == BodyType::dynamic;
    if (!moves_a && !moves_b) continue;
    const std::uint32_t at = islands.root(moves_a ? a : b);
    if (!accounted(at)) continue;
    const double mass = (moves_a ? to_double(bodies.mass[a]) : 0) + (moves_b ? to_double(bodies.mass[b]) : 0);
    for (int k = 0; k < contact.point_count; ++k) {
      const double depth = std::fmax(0.0, -to_double(contact.points[k].separation)) / to_double(c.h);
      energy_of(at).given += 0.5 * mass * depth * depth;
    }
    double speed = to_double(length(contact.surface_velocity));
    if (!moves_a && a != kNone) speed += outside_speed(a, b);
    if (!moves_b && b != kNone) speed += outside_speed(b, a);
    energy_of(at).drive = std::fmax(energy_of(at).drive, speed);
  }
}

// Speed of a kinematic body where it meets the other, m/s.
double Rigid::Impl::outside_speed(std::uint32_t i, std::uint32_t other) const {
  if (bodies.type[i] != BodyType::kinematic) return 0;
  const std::uint32_t k = bodies.first_collider[i];
  const double extent = other == kNone
                            ? to_double(bodies.extent[i])
                            : to_double(length(bodies.position[i] - bodies.position[other]) + bodies.extent[other]);
  return to_double(length(colliders.velocity[k])) + to_double(length(colliders.angular_velocity[k])) * extent;
}

// Joints: springs, motors, and the misfit after an edit by a script.
void Rigid::Impl::watch_joints(const StepContext& c) {
  const auto window = static_cast<std::uint64_t>(kScriptWindow / to_double(c.dt)) + 1;
  for (const std::uint32_t j : active_joints) {
    const JointRecord& r = records[j];
    if (!r.alive || !joints[j].active) continue;
    const bool moves_a = bodies.moves(r.body_a), moves_b = bodies.moves(r.body_b);
    if (!moves_a && !moves_b) continue;
    const std::uint32_t at = islands.root(moves_a ? r.body_a : r.body_b);
    if (!accounted(at)) continue;
    if (r.body_a != kNone) energy_of(at).drive = std::fmax(energy_of(at).drive, outside_speed(r.body_a, r.body_b));
    if (r.body_b != kNone) energy_of(at).drive = std::fmax(energy_of(at).drive, outside_speed(r.body_b, r.body_a));
    bool edited = false;
    for (const std::uint32_t i : {r.body_a, r.body_b})
      edited = edited || (i != kNone && c.step < edited_step[i] + window);
    energy_of(at).given += joint_given(j, edited, c);
  }
}

// Upper bound of the energy that joint j can give in this step, J.
double Rigid::Impl::joint_given(std::uint32_t j, bool edited, const StepContext& c) {
  const JointRecord& r = records[j];
  const auto start = [&](std::uint32_t i, std::uint32_t slot) {
    if (slot == kNone || i == kNone) return Pose{};
    const SolverMass& m = solver_bodies.mass[solver_bodies.index[slot]];
    return solver_bodies.index[slot] == 0 ? bodies.com_pose(i) : Pose{m.center, m.start_rotation};
  };
  // rows at the start of the step
  JointInput in = joint_input(j);
  in.a = start(r.body_a, joints[j].slot_a), in.b = start(r.body_b, joints[j].slot_b);
  fill_rows(j, in);
  double sum = 0, size = std::numeric_limits<double>::infinity();
  for (const std::uint32_t i : {r.body_a, r.body_b})
    if (i != kNone && bodies.type[i] == BodyType::dynamic) size = std::fmin(size, to_double(bodies.extent[i]));
  for (const Row& row : rows) {
    // effective mass along the row: inverse, and its upper bound
    double compliance = 0, mass = 0;
    for (const bool first : {true, false}) {
      const double k =
          to_double(row_compliance(first ? r.body_a : r.body_b, row.linear, first ? row.angular_a : row.angular_b));
      compliance += k;
      if (k > 0) mass += 1 / k;
    }
    if (!(compliance > 0)) continue;
    const double value = to_double(row.value);
    if (row.velocity_only) {
      // motor: its force times the path, at most the energy that brings all bodies of the island to its speed
      const double most = std::fmax(std::fabs(to_double(row.lower)), std::fabs(to_double(row.upper)));
      const double speed = to_double(row.speed);
      double path = 0, all = 0;
      for (const std::uint32_t i : {r.body_a, r.body_b})
        if (i != kNone) path += to_double(length(bodies.angular_velocity[i])) + to_double(length(bodies.velocity[i]));
      const std::uint32_t at =
          islands.root(r.body_a != kNone && bodies.type[r.body_a] == BodyType::dynamic ? r.body_a : r.body_b);
      for (const std::uint32_t i : moving) {
        if (bodies.type[i] != BodyType::dynamic || islands.root(i) != at) continue;
        const Vec3 arm = bodies.position[i] - in.a.position;
        all += to_double(bodies.mass[i]) * (1 + to_double(dot(arm, arm))) + to_double(bodies.inertia[i].trace());
      }
      sum += std::fmin(most * (path + std::fabs(speed)) * to_double(c.dt), 2 * all * speed * speed);
    } else if (row.hertz > 0) {
      const double omega = 2 * to_double(kPi * row.hertz);
      sum += 0.5 * omega * omega / compliance * value * value;
    } else if (edited) {
      // edited: rows are linear and say nothing of a misfit as large as the bodies
      const bool linear = !row.linear.isZero(0);
      if (std::fabs(value) > (linear ? size : 1.0)) return std::numeric_limits<double>::infinity();
      sum += 0.5 * mass * value * value / to_double(c.h * c.h);
    }
  }
  return sum;
}

// Sums by island, at its root: kinetic energies before and after, work, overlap and strain. Of islands with some of
// these bodies; null: of all.
void Rigid::Impl::account(const StepContext& c, const Array<std::uint32_t>* of) {
  FEDER_ASSERT(edited_step.size() == bodies.size());
  join_islands();
  island_numbers = c.scratch->take<std::uint32_t>(bodies.size());
  std::fill_n(island_numbers, bodies.size(), kNone);
  island_count = 0;
  for (const std::uint32_t i : of ? *of : moving) {
    if (bodies.type[i] != BodyType::dynamic) continue;
    std::uint32_t& number = island_numbers[islands.root(i)];
    if (number == kNone) number = island_count++;
  }
  island_energies = c.scratch->take<IslandEnergy>(island_count);
  std::fill_n(island_energies, island_count, IslandEnergy{});
  for (const std::uint32_t i : moving) {
    if (bodies.type[i] != BodyType::dynamic || solver_bodies.index[bodies.solver_slot[i]] == 0) continue;
    const std::uint32_t at = islands.root(i), k = bodies.first_collider[i];
    if (!accounted(at)) continue;
    const SolverMass& m = solver_bodies.mass[solver_bodies.index[bodies.solver_slot[i]]];
    energy_of(at).before += kinetic_energy(i, m.start_rotation, colliders.velocity[k], colliders.angular_velocity[k]);
    energy_of(at).after += kinetic_energy(i, bodies.rotation[i], bodies.velocity[i], bodies.angular_velocity[i]);
    energy_of(at).given += work_on(i, c);
    energy_of(at).mass += to_double(bodies.mass[i]);
  }
  watch_contacts(c);
  watch_joints(c);
  for (IslandEnergy& e : std::span(island_energies, island_count))
    e.given += 2 * e.mass * e.drive * e.drive;  // a kinematic body throws others at up to twice its speed
}

void Rigid::Impl::watch(const StepContext& c) {
  account(c, &jumpers);
  jumpers.clear();
  const double least = quiet_energy(c);
  for (const std::uint32_t i : moving) {
    if (bodies.type[i] != BodyType::dynamic || islands.root(i) != i || !accounted(i)) continue;
    const IslandEnergy& own = energy_of(i);
    const double before = own.before + least * own.mass;
    if (!Watch::jumped(before, own.given, own.after)) continue;
    std::uint32_t worst = i;
    double most = -1;
    for (const std::uint32_t k : moving) {
      if (bodies.type[k] != BodyType::dynamic || islands.root(k) != i) continue;
      const double energy = kinetic_energy(k, bodies.rotation[k], bodies.velocity[k], bodies.angular_velocity[k]);
      if (energy > most || !(energy <= 1e300)) worst = k, most = energy;
    }
    watched.suspects.push_back({kName, bodies.object[worst], before, own.after, own.given, own.mass, false, kCure});
  }
}

// Reports a non-finite body.
void Rigid::Impl::suspect(std::uint32_t i) {
  const std::uint32_t k = bodies.first_collider[i];
  FEDER_ASSERT(k != kNone && colliders.owner_index[k] == i);
  watched.suspects.push_back(
      {kName, bodies.object[i],
       0.5 * to_double(bodies.mass[i]) * to_double(dot(colliders.velocity[k], colliders.velocity[k])), NAN, 0, 0, false,
       kCure});
}

double Rigid::held(const StepContext& c) {
  Impl& s = *impl_;
  if (s.body_count == 0) return 0;
  s.account(c, nullptr);
  double sum = 0;
  for (const IslandEnergy& e : std::span(s.island_energies, s.island_count)) sum += e.before + e.given;
  return sum;
}

double Rigid::drive(const StepContext&) {
  const Impl& s = *impl_;
  double most = 0;
  for (std::uint32_t i = 0; i < s.bodies.size(); ++i) {
    if (s.bodies.type[i] == BodyType::free) continue;
    most = std::fmax(most, s.outside_speed(i, kNone));
    s.each_collider(i, [&](std::uint32_t k) {
      most = std::fmax(most, to_double(length(s.colliders.surface_velocity[k])));
      if (s.bodies.type[i] == BodyType::dynamic) return;
      for (const ShapeSurface& own : s.colliders.shape[k]->surfaces())  // of a mesh's triangles
        most = std::fmax(most, to_double(length(own.velocity)));
    });
  }
  return most;
}

}  // namespace feder
