// The state of an object as plain arrays, for files that other programs read. One StateReader per kind of object
// (states_<system>.cpp); objects of other kinds have no place. Reads the world; its hash stays.
#pragma once
#include <span>
#include <vector>

#include "feder/world.h"

namespace feder::report {

struct ObjectState {
  // bodies
  Pose pose;                             // of the body's origin
  Vec3 velocity = Vec3::Zero();          // of the centre of mass, m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  // what is made of points; empty where there is no such thing
  std::vector<Vec3> positions, velocities;      // m, m/s
  std::vector<Real> masses, radii;              // kg, m; masses empty: all equal
  std::vector<Real> densities, pressures;       // of fluids, kg/m^3 (dimension 2: kg/m^2), Pa
  std::vector<std::uint32_t> lines, triangles;  // two, three point numbers each

  void clear();  // keeps the memory
};

struct StateReader {
  ObjectKind kind;
  bool rigid;                                                 // has a pose; else it has points
  void (*read)(World& world, ObjectId id, ObjectState& out);  // into a cleared state; densities and pressures left out
  void (*read_fields)(World& world, ObjectId id, ObjectState& out) = nullptr;  // those
};

std::span<const StateReader> state_readers();
// Null where the object has no place.
const StateReader* state_reader(const World& world, ObjectId object);

// Mean over the points by mass, and the box around them.
struct PointSummary {
  double center[3] = {}, velocity[3] = {};  // m, m/s
  double low[3] = {}, high[3] = {};         // m
};
PointSummary summarize_points(const ObjectState& state);  // of one point at least

}  // namespace feder::report
