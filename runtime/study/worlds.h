// Worlds of studies and maps: how they are described, and what is read from them. Private to the module.
#pragma once
#include "feder/net.h"
#include "feder/world.h"

namespace feder {

// Nets alone.
inline Catalog net_catalog() {
  static const SystemDescriptor* const catalog[] = {&Springs::descriptor()};
  return catalog;
}

// Nothing sleeps: rest is to be reached, not declared. `gravity`, m/s^2, downwards; `dt`, s.
inline WorldDesc awake_world(double gravity, double dt = 1.0 / 60, int substeps = 4) {
  WorldDesc d;
  d.gravity = Vec3(0, static_cast<Real>(-gravity), 0), d.dt = dt, d.substeps = substeps, d.sleeping = false;
  return d;
}

inline double total_energy(const World& w) {  // J
  const Energy e = w.energy();
  return e.kinetic + e.potential + e.elastic;
}

// What a run warned of last.
struct WarningRecord {
  std::string last;

  void read(World& w) {
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning) last = w.events().warning_message(e);
  }
};

}  // namespace feder
