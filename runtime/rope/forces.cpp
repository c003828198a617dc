// Forces on points, once per substep: gravity, scripts, the world's force generators, air. Generators that act on areas
// (wind) are evaluated per segment, and push by the part of the flow across it (forces/area.h). Air is still where no
// wind acts on the rope.
#include "forces/forces.h"

#include "forces/area.h"
#include "rope/impl.h"

namespace feder {

void Rope::Impl::add_forces(Line& l, StepContext& c) {
  const Surface& s = surfaces.list[l.surface];
  const double time = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  const Vec3 g = c.gravity * l.settings.gravity_scale;
  forces.assign(l.script_force.begin(), l.script_force.end());
  points.clear();
  bool blown = false;
  each_force(l, [&](const ForceEntry& f) {
    if (f.force->on_area()) {
      blown = true;
      return;
    }
    if (points.empty())
      for (std::uint32_t i = 0; i < l.size(); ++i) {
        MassPoint p = mass_point(l, i);
        p.position = surfaces.position[s.first + i] + surfaces.delta_position[s.first + i].vec();
        p.velocity = surfaces.velocity[s.first + i].vec();
        p.most_drag = store.get<Forces>().drag_share() * l.mass[i] / c.h;
        points.push_back(p);
      }
    f.force->add(points.data(), l.size(), time, forces.data());
  });
  if (l.settings.drag > 0 && (blown || air_density > 0)) add_air(l, c.h, blown, time);
  for (std::uint32_t i = 0; i < l.size(); ++i) l.acceleration[i] = g + forces[i] * l.inv_mass[i];
}

// Wind, or still air, half of a segment's to each of its ends.
void Rope::Impl::add_air(const Line& l, Real h, bool blown, double time) {
  const Surface& s = surfaces.list[l.surface];
  const Real drag = l.settings.drag, width = 2 * l.settings.radius;
  const Real share = blown ? store.get<Forces>().drag_share() : Real(1);
  for (std::uint32_t i = 0; i + 1 < l.size(); ++i) {
    const std::uint32_t a = s.first + i, b = a + 1;
    const Vec3 from = surfaces.position[a] + surfaces.delta_position[a].vec();
    const Vec3 along = surfaces.position[b] + surfaces.delta_position[b].vec() - from;
    // one square metre of it, held across the flow
    MassPoint p;
    p.position = from + Real(0.5) * along;
    p.velocity = Real(0.5) * (surfaces.velocity[a].vec() + surfaces.velocity[b].vec());
    p.mass = l.settings.density * Real(0.7853982) * width, p.area = 1;
    // a stretched segment shows more area than it did at rest, for the same mass
    const Real stretch = std::max(length(along) / l.rest_length[i], Real(1));
    p.most_drag = share * p.mass / (h * drag * stretch);
    Vec3 half = Vec3::Zero();
    if (blown)
      each_force(l, [&](const ForceEntry& f) {
        if (!f.force->on_area()) return;
        Vec3 full = Vec3::Zero();
        f.force->add(&p, 1, time, &full);
        half += line_force(full, along, width, drag) / 2;
      });
    else
      half = line_force(still_air_on_area(p.velocity, air_density, p.most_drag), along, width, drag) / 2;
    forces[i] += half, forces[i + 1] += half;
  }
}

}  // namespace feder
