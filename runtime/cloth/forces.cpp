// Forces on vertices, once per substep: gravity, scripts, the world's force generators. Those that act on areas (wind)
// are asked per triangle and pressed through its normal: with F the force on one square metre held across the flow, e
// its direction, n the triangle's normal and c = e.n, the pressure on an inclined plate is |F| A c n, two-sided; its
// part along the flow, c^2 e, is scaled by `drag`, the part across it, c (n - c e), by `lift`. What streams along the
// sheet rubs at kSkin of that.
#include <cmath>

#include "cloth/impl.h"

namespace feder {
namespace {
constexpr Real kSkin = Real(0.02);
}

void Cloth::Impl::add_forces(StepContext& c) {
  const Forces* forces = store.find<Forces>();
  const double time = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  for (auto& p : sheets) {
    Sheet& s = *p;
    if (!s.active()) continue;
    const Vec3 g = c.gravity * s.settings.gravity_scale;
    force.resize(s.total);
    for (std::uint32_t i = 0; i < s.points; ++i) force[i] = vertices.script_force[s.first + i];
    if (forces) {
      const TagMask tags = objects.tags(s.object);
      bool blown = false;
      points.clear();
      for (const ForceEntry& f : forces->list) {
        if (!acts_on(f, s.object, tags)) continue;
        if (f.force->on_area()) {
          blown = true;
          continue;
        }
        if (points.empty())
          for (std::uint32_t i = s.first; i < s.first + s.points; ++i) {
            const Real area = vertices.mass[i] / s.settings.area_density;
            points.push_back({vertices.position[i] + moved[i].vec(), speed[i].vec(), vertices.mass[i], area,
                              area * s.settings.thickness});
          }
        f.force->add(points.data(), s.points, time, force.data());
      }
      if (blown && s.settings.wind) add_wind(s, time);
    }
    Vec3 sum = g * s.mass;
    for (std::uint32_t i = 0; i < s.points; ++i) {
      acceleration[s.first + i] = g + force[i] * moved[s.first + i].w;
      sum += force[i];
    }
    // as large as lately, so that gusts do not make the number of small steps jump
    s.state.pull = std::max(length(sum) / s.mass, Real(0.95) * s.state.pull);
    for (std::uint32_t i = s.points; i < s.total; ++i) acceleration[s.first + i] = Vec3::Zero();
  }
}

void Cloth::Impl::add_wind(Sheet& s, double time) {
  const std::size_t count = s.mesh.triangles.size() / 3;
  points.resize(count);
  const Forces& forces = store.get<Forces>();
  const TagMask tags = objects.tags(s.object);
  for (std::size_t t = 0; t < count; ++t) {
    const std::uint32_t* v = &s.mesh.triangles[3 * t];
    MassPoint& p = points[t];
    p = {};
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = s.first + v[k];
      p.position += (vertices.position[i] + moved[i].vec()) / 3;
      p.velocity += speed[i].vec() / 3;
    }
    p.mass = s.settings.area_density;
    p.area = 1;
  }
  for (const ForceEntry& f : forces.list) {
    if (!acts_on(f, s.object, tags) || !f.force->on_area()) continue;
    for (std::size_t t = 0; t < count; ++t) {
      const std::uint32_t* v = &s.mesh.triangles[3 * t];
      Vec3 x[3], full = Vec3::Zero();
      for (int k = 0; k < 3; ++k) x[k] = vertices.position[s.first + v[k]] + moved[s.first + v[k]].vec();
      f.force->add(&points[t], 1, time, &full);
      const Vec3 twice = cross(x[1] - x[0], x[2] - x[0]);
      const Real area = Real(0.5) * length(twice), size = length(full);
      if (!(area > 0) || !(size > 0)) continue;
      const Vec3 n = twice / (2 * area), e = full / size;
      const Real along = dot(e, n);
      const Vec3 part = s.settings.drag * (along * along + kSkin) * e + s.settings.lift * along * (n - along * e);
      const Vec3 third = part * (size * area / 3);
      for (int k = 0; k < 3; ++k) force[v[k]] += third;
    }
  }
}

}  // namespace feder
