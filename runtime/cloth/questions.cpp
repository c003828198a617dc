// Queries of the world: energy, momentum, residuals, finiteness.
#include <algorithm>
#include <cmath>

#include "cloth/impl.h"
#include "geom/crossings.h"

namespace feder {

Energy Cloth::energy(const Vec3& gravity) const {
  Energy e;
  const ClothVertices& p = impl_->vertices;
  for (const auto& s : impl_->sheets) {
    const Vec3* x = p.position.data() + s->first;
    for (std::uint32_t i = s->first; i < s->first + s->points; ++i) {
      const double m = p.mass[i];
      e.kinetic += 0.5 * m * static_cast<double>(dot(p.velocity[i], p.velocity[i]));
      e.potential -=
          m * static_cast<double>(s->settings.gravity_scale) * static_cast<double>(dot(gravity, p.position[i]));
    }
    for (const ClothLink& l : s->mesh.links) {
      const double stretch = static_cast<double>(length(x[l.b] - x[l.a]) - l.rest);
      e.elastic += 0.5 * static_cast<double>(l.stiffness) * stretch * stretch;
    }
    for (const ClothHinge& h : s->mesh.hinges) {
      double bend = static_cast<double>(hinge_angle(x[h.v[0]], x[h.v[1]], x[h.v[2]], x[h.v[3]]) - h.angle);
      bend = std::remainder(bend, 6.283185307179586);
      e.elastic += 0.5 * static_cast<double>(h.stiffness) * bend * bend;
    }
    if (s->settings.pressure != 0 && s->gas.closed)
      e.potential -= static_cast<double>(s->settings.pressure) * volume(s->object);
    impl_->each_force(*s, [&](const ForceEntry& f) {
      for (std::uint32_t i = s->first; i < s->first + s->points; ++i) {
        const MassPoint point = impl_->mass_point(*s, i);
        e.potential += f.force->potential(&point, 1);
      }
    });
  }
  return e;
}

Momentum Cloth::momentum() const {
  Momentum sum;
  const ClothVertices& p = impl_->vertices;
  for (std::uint32_t i = 0; i < p.size(); ++i) {
    const double m = p.mass[i];
    const double x[3] = {p.position[i][0], p.position[i][1], p.position[i][2]};
    const double v[3] = {m * p.velocity[i][0], m * p.velocity[i][1], m * p.velocity[i][2]};
    for (int k = 0; k < 3; ++k) {
      sum.linear[k] += v[k];
      sum.angular[k] += x[(k + 1) % 3] * v[(k + 2) % 3] - x[(k + 2) % 3] * v[(k + 1) % 3];
    }
  }
  return sum;
}

std::size_t Cloth::tangles(ObjectId id) const {
  const Sheet& s = impl_->sheet(id);
  Arena arena("tangles");
  CrossingSearch search(arena);
  Array<Crossing> found{&arena};
  const std::span<const Vec3> points(impl_->vertices.position.data() + s.first, s.points);
  const CrossingMesh mesh{points,
                          {s.mesh.triangles.data(), s.mesh.triangles.size()},
                          &s.mesh.edges[0].a,
                          sizeof(ClothEdge) / sizeof(std::uint32_t),
                          static_cast<std::uint32_t>(s.mesh.edges.size())};
  search.find(mesh, bounds_of(points), found);
  return found.size();
}

void Cloth::residuals(std::vector<Residual>& out) const {
  double strain = 0, frozen = 0, sleeping = 0, crossings = 0;
  for (const auto& s : impl_->sheets) {
    strain = std::max(strain, static_cast<double>(max_strain(s->object)));
    crossings += s->state.tangles;
    frozen += s->state.frozen != 0, sleeping += s->state.asleep != 0;
  }
  out.push_back({"cloth.max_strain", strain});
  int steps = 1;
  const Surfaces& all = impl_->surfaces;
  for (std::size_t k = 0; k < all.group_count; ++k) steps = std::max(steps, all.groups[k]->steps);
  out.push_back({"cloth.small_steps", static_cast<double>(steps)});
  out.push_back({"cloth.row_updates", static_cast<double>(all.row_updates)});
  out.push_back({"cloth.sleeping", sleeping});
  out.push_back({"cloth.tangles", crossings});
  out.push_back({"cloth.quarantined", frozen});
}

bool Cloth::finite() const {
  const ClothVertices& p = impl_->vertices;
  for (const auto& s : impl_->sheets)
    if (s->state.frozen) return false;
  for (std::uint32_t i = 0; i < p.size(); ++i)
    if (!is_finite(p.position[i]) || !is_finite(p.velocity[i])) return false;
  return true;
}

}  // namespace feder
