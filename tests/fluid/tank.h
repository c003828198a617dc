// Worlds with a fluid in a box of planes.
#pragma once
#include <string>
#include <vector>

#include "couple/fluid_rigid.h"
#include "feder/fluid.h"
#include "feder/query.h"
#include "feder/rigid.h"
#include "feder/world.h"

namespace feder {

inline Catalog fluid_catalog() {
  static const SystemDescriptor* const list[] = {&Collide::descriptor(), &Rigid::descriptor(), &Fluid::descriptor(),
                                                 &FluidRigid::descriptor()};
  return list;
}

inline WorldDesc fluid_world(int dimension = 3, int threads = 1) {
  WorldDesc d;
  d.dimension = dimension, d.threads = threads;
  d.sleeping = false;  // it would hide what water does
  return d;
}

// One substep of 1/240 s.
inline WorldDesc one_substep(int threads = 1) {
  WorldDesc d = fluid_world(3, threads);
  d.dt = Real(1) / 240, d.substeps = 1;
  return d;
}

// Nothing weighs.
inline WorldDesc weightless(WorldDesc d) {
  d.gravity = Vec3::Zero();
  return d;
}

inline void add_plane(World& w, const Vec3& normal, Real distance) {
  BodyDesc b;
  b.type = BodyType::fixed;
  b.shape = make_plane(normal, distance);
  w.need<Rigid>().add_body(b);
}

// Walls at 0 and `size` along x (and z in 3D), a floor at 0.
inline void add_tank(World& w, const Vec3& size) {
  add_plane(w, vec3(0, 1, 0), 0);
  add_plane(w, vec3(1, 0, 0), 0), add_plane(w, vec3(-1, 0, 0), -size[0]);
  if (w.desc().dimension == 2) return;
  add_plane(w, vec3(0, 0, 1), 0), add_plane(w, vec3(0, 0, -1), -size[2]);
}

// Fills the box from the origin to `size`.
inline ObjectId add_water(World& w, FluidDesc d, const Vec3& size, const Vec3& from = Vec3::Zero()) {
  Fluid& f = w.need<Fluid>();
  const ObjectId id = f.add_fluid(d);
  const bool flat = w.desc().dimension == 2;
  const ShapePtr box = make_box(size[0], size[1], flat ? Real(1) : size[2]);
  Pose pose;
  pose.position = from + size / 2;
  if (flat) pose.position[2] = 0;
  f.fill(id, flat ? *box->section() : *box, pose, Vec3::Zero());
  return id;
}

inline void run(World& w, double seconds) {
  const int steps = static_cast<int>(seconds / w.desc().dt + 0.5);
  for (int k = 0; k < steps; ++k) w.step();
}

inline std::vector<Vec3> places(World& w, ObjectId id) {
  std::vector<Vec3> x;
  w.need<Fluid>().positions(id, x);
  return x;
}

#ifdef FEDER_SANITIZED
inline constexpr double kShare = 0.05;  // of the simulated time: sanitizers look at memory, not at physics
#else
inline constexpr double kShare = 1;
#endif
inline constexpr bool kFull = kShare == 1;
// The double build, three times as slow, leaves out what is long only because it has many particles.
inline constexpr bool kLarge = kFull && sizeof(Real) == sizeof(float);

}  // namespace feder
