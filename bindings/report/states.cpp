#include "report/states.h"

#include <algorithm>

namespace feder::report {

using Row = StateReader;
#include "states_declare.inc"

std::span<const StateReader> state_readers() {
  static const std::initializer_list<StateReader> table = {
#include "states_rows.inc"
  };
  return {table.begin(), table.size()};
}

const StateReader* state_reader(const World& world, ObjectId object) {
  if (!world.objects().alive(object)) return nullptr;
  for (const StateReader& reader : state_readers())
    if (world.objects().kind(object) == reader.kind) return &reader;
  return nullptr;
}

void ObjectState::clear() {
  pose = {}, velocity = angular_velocity = Vec3::Zero();
  positions.clear(), velocities.clear();
  for (auto* numbers : {&masses, &radii, &densities, &pressures}) numbers->clear();
  lines.clear(), triangles.clear();
}

PointSummary summarize_points(const ObjectState& state) {
  PointSummary s;
  double mass = 0;
  for (std::size_t i = 0; i < state.positions.size(); ++i) {
    const double m = state.masses.empty() ? 1 : static_cast<double>(state.masses[i]);
    mass += m;
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<double>(state.positions[i][k]);
      s.center[k] += m * x;
      s.velocity[k] += m * static_cast<double>(state.velocities[i][k]);
      s.low[k] = i == 0 ? x : std::min(s.low[k], x);
      s.high[k] = i == 0 ? x : std::max(s.high[k], x);
    }
  }
  for (int k = 0; k < 3; ++k) s.center[k] /= mass, s.velocity[k] /= mass;
  return s;
}

}  // namespace feder::report
