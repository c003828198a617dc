// Forces on vertices, once per substep: gravity, scripts, the world's force generators. Generators that act on areas
// (wind) are evaluated per triangle and act as pressure along and across its normal (forces/area.h). Air is still where
// no wind acts on the cloth; what it does is small in a step for most cloths, and is then found once a step.
#include "forces/forces.h"

#include <algorithm>
#include <cmath>

#include "cloth/impl.h"
#include "forces/area.h"

namespace feder {
namespace {
constexpr Real kCalm = Real(0.05);  // largest share of a triangle's mass that calm air stops in a step
}  // namespace

void Cloth::Impl::add_forces(StepContext& c) {
  const Forces* forces = store.find<Forces>();
  const double time = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  for (auto& p : sheets) {
    Sheet& s = *p;
    if (!s.active()) continue;
    const Vec3 g = c.gravity * s.settings.gravity_scale;
    FEDER_ASSERT(s.first + s.total <= acceleration.size());
    force.resize(s.total);
    const Vec3* script = vertices.script_force.data() + s.first;
    std::copy(script, script + s.points, force.begin());
    // generators on points; those on areas are left to add_wind
    bool blown = false;
    if (forces) {
      const TagMask tags = objects.tags(s.object);
      points.clear();
      const Real share = forces->drag_share() / c.h;
      for (const ForceEntry& f : forces->list) {
        if (!acts_on(f, s.object, tags)) continue;
        if (f.force->on_area()) {
          blown = true;
          continue;
        }
        if (points.empty())
          for (std::uint32_t i = s.first; i < s.first + s.points; ++i) {
            const Real area = vertices.mass[i] / s.settings.area_density;
            points.push_back({vertices.position[i] + delta_position[i].vec(), velocity[i].vec(), vertices.mass[i], area,
                              area * s.settings.thickness, share * vertices.mass[i]});
          }
        FEDER_ASSERT(points.size() == s.points);  // shared with add_wind
        f.force->add(points.data(), s.points, time, force.data());
      }
      if (blown && s.settings.wind) add_wind(s, time, c.h);
    }
    if (!blown && s.settings.wind && air_density > 0) {
      if (s.gusty) meet_still_air(s, c);
      for (std::uint32_t i = 0; i < s.points; ++i) force[i] += air[s.first + i];
    }
    // accelerations; hidden vertices have none
    Vec3 sum = g * s.mass;
    for (std::uint32_t i = 0; i < s.points; ++i) {
      acceleration[s.first + i] = g + force[i] * delta_position[s.first + i].w;
      sum += force[i];
    }
    // decays slowly, so that gusts do not make the number of solver substeps jump
    s.state.pull = std::max(length(sum) / s.mass, Real(0.95) * s.state.pull);
    for (std::uint32_t i = s.points; i < s.total; ++i) acceleration[s.first + i] = Vec3::Zero();
    if (s.settings.pressure != 0 || s.gas.pressure != 0) begin_pressure(s, c);
  }
}

void Cloth::Impl::add_wind(Sheet& s, double time, Real h) {
  const std::size_t count = s.mesh.triangles.size() / 3;
  points.resize(count);
  const Forces& forces = store.get<Forces>();
  const AreaShares shares{s.settings.drag, s.settings.lift};
  const TagMask tags = objects.tags(s.object);
  // points: the middle of each triangle, for one square metre of it; drag is limited per square metre at rest
  const Real most = forces.drag_share() * s.settings.area_density / h;
  for (std::size_t t = 0; t < count; ++t) {
    const std::uint32_t* v = &s.mesh.triangles[3 * t];
    MassPoint& p = points[t];
    p = {};
    Vec3 x[3], rest[3];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = s.first + v[k];
      x[k] = current_position(i), rest[k] = vertices.rest[i];
      p.position += x[k] / 3;
      p.velocity += velocity[i].vec() / 3;
    }
    p.mass = s.settings.area_density;
    p.area = 1;
    // each corner bears a third of the triangle, in mass as in drag
    const Real stretch = length(cross(x[1] - x[0], x[2] - x[0])) / length(cross(rest[1] - rest[0], rest[2] - rest[0]));
    if (stretch > 0) p.most_drag = most / stretch;
  }
  // pressure on the triangle, a third to each corner
  for (const ForceEntry& f : forces.list) {
    if (!acts_on(f, s.object, tags) || !f.force->on_area()) continue;
    for (std::size_t t = 0; t < count; ++t) {
      const std::uint32_t* v = &s.mesh.triangles[3 * t];
      Vec3 x[3], full = Vec3::Zero();
      for (int k = 0; k < 3; ++k) x[k] = current_position(s.first + v[k]);
      f.force->add(&points[t], 1, time, &full);
      const Vec3 third = area_force(full, cross(x[1] - x[0], x[2] - x[0]), shares) / 3;
      for (int k = 0; k < 3; ++k) force[v[k]] += third;
    }
  }
}

// Force of still air by vertex, in `air`.
void Cloth::Impl::meet_still_air(Sheet& s, StepContext& c) {
  FEDER_ASSERT(air_density > 0 && c.h > 0 && c.h <= c.dt);
  air.resize(vertices.size());
  s.still_air.build(s.mesh, s.points, s.total - 1, s.version);
  StillAir::Flow f;
  f.position = vertices.position.data() + s.first;
  f.delta_position = delta_position.data() + s.first, f.velocity = velocity.data() + s.first;
  f.density = air_density, f.most = kMaxMassShare / c.h, f.drag = s.settings.drag, f.lift = s.settings.lift;
  s.gusty = s.still_air.meet(f, air.data() + s.first, *c.jobs) * kMaxMassShare * c.dt > kCalm * c.h;
}

}  // namespace feder
