// What is asked of soft bodies between steps: strain, volume, energy, momentum.
#include <algorithm>
#include <cmath>

#include "soft/impl.h"

namespace feder {
namespace {

// Largest |s - 1| over the singular values s of F.
double strain_of(const SoftBody& b, std::size_t k) {
  const Mat3d f = b.gradient(k, b.position);
  Mat3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c(i, j) = static_cast<Real>(f(0, i) * f(0, j) + f(1, i) * f(1, j) + f(2, i) * f(2, j) - (i == j));
  Vec3 values;
  Mat3 vectors;
  eigen_symmetric(c, values, vectors);
  double most = 0;
  for (int i = 0; i < 3; ++i) most = std::fmax(most, std::fabs(std::sqrt(std::fmax(1 + double(values[i]), 0)) - 1));
  return most;
}

double volume_of(const SoftBody& b) {
  double sum = 0;
  for (std::size_t k = 0; k < b.mesh.tetrahedra.size(); ++k) sum += tetrahedron_volume(b.corners(k));
  return sum;
}

}  // namespace

Mat3d SoftBody::gradient(std::size_t k, const Array<Vec3>& x) const {
  const Corners at = corners(k, x);
  Mat3d f;
  f.setZero();
  for (std::size_t c = 0; c < 3; ++c) {
    const Real* g = &mesh.inverse[9 * k + 3 * c];
    const Double3 e = at[c + 1] - at[0];
    for (int j = 0; j < 3; ++j)
      f(0, j) += double(g[j]) * e.x, f(1, j) += double(g[j]) * e.y, f(2, j) += double(g[j]) * e.z;
  }
  return f;
}

double SoftBody::elastic_energy(const Array<Vec3>& x) const {
  SoftView v;
  v.mesh = &mesh, v.points = size(), v.version = version;
  v.material = material, v.law = law, v.density = double(settings.density);
  const double own = solver->elastic_energy(v, x);
  if (!std::isnan(own)) return own;
  double sum = 0;
  for (std::size_t k = 0; k < mesh.tetrahedra.size(); ++k) {
    sum += double(mesh.volume[k]) * law->energy(material, gradient(k, x));
  }
  return sum;
}

std::size_t Soft::count() const {
  std::size_t sum = 0;
  for (const auto& b : impl_->bodies) sum += b->mesh.tetrahedra.size();
  return sum;
}

TetrahedronPoints Soft::tetrahedron(ObjectId id, std::size_t k) const {
  const SoftBody& b = impl_->body(id);
  if (k >= b.mesh.tetrahedra.size())
    throw SceneError(impl_->objects.describe(id) + ": expected a tetrahedron number from 1 to " +
                     std::to_string(b.mesh.tetrahedra.size()) + ", got " + std::to_string(k + 1));
  return b.mesh.tetrahedra[k];
}

Real Soft::strain(ObjectId id, std::size_t k) const {
  tetrahedron(id, k);
  return static_cast<Real>(strain_of(impl_->body(id), k));
}

Real Soft::max_strain(ObjectId id) const {
  const SoftBody& b = impl_->body(id);
  double most = 0;
  for (std::size_t k = 0; k < b.mesh.tetrahedra.size(); ++k) most = std::fmax(most, strain_of(b, k));
  return static_cast<Real>(most);
}

Real Soft::tension(ObjectId id, std::size_t i) const {
  return static_cast<Real>(impl_->body(id).tension(impl_->point(id, i)).stress);
}

std::size_t Soft::part_count(ObjectId id) const { return impl_->body(id).mesh.parts(); }
std::size_t Soft::part(ObjectId id, std::size_t i) const { return impl_->body(id).mesh.part_of[impl_->point(id, i)]; }

std::size_t Soft::inverted(ObjectId id) const {
  const SoftBody& b = impl_->body(id);
  std::size_t sum = 0;
  for (std::size_t k = 0; k < b.mesh.tetrahedra.size(); ++k) sum += tetrahedron_volume(b.corners(k)) <= 0;
  return sum;
}

Real Soft::volume(ObjectId id) const { return static_cast<Real>(volume_of(impl_->body(id))); }
Real Soft::rest_volume(ObjectId id) const { return static_cast<Real>(impl_->body(id).mesh.rest_volume); }

void Soft::positions(ObjectId id, std::vector<Vec3>& out) const {
  const SoftBody& b = impl_->body(id);
  out.assign(b.position.begin(), b.position.end());
}

std::size_t Soft::tetrahedron_at(ObjectId id, const Vec3& p, std::array<double, 4>& weights) const {
  const SoftBody& b = impl_->body(id);
  for (std::size_t k = 0; k < b.mesh.tetrahedra.size(); ++k) {
    Aabb box;
    for (const std::uint32_t i : b.mesh.tetrahedra[k]) box.include(b.position[i]);
    if (!overlaps(box, {p, p}) || !within_by_weights(b.corners(k), wide(p))) continue;
    weights = barycentric(b.corners(k), wide(p));
    return k;
  }
  return kNoTetrahedron;
}

int Soft::substeps(ObjectId id) const { return impl_->body(id).state.substeps; }
bool Soft::asleep(ObjectId id) const { return impl_->body(id).state.asleep != 0; }
bool Soft::quarantined(ObjectId id) const { return impl_->body(id).state.frozen != 0; }
std::size_t Soft::soft_count() const { return impl_->bodies.size(); }

Soft::Info Soft::info(std::size_t n) const {
  FEDER_ASSERT(n < impl_->bodies.size());
  const SoftBody& b = *impl_->bodies[n];
  return {b.object,
          {b.position.data(), b.position.size()},
          {b.inv_mass.data(), b.inv_mass.size()},
          {b.mesh.skin.data(), b.mesh.skin.size()},
          b.settings.thickness,
          b.settings.group,
          b.settings.mask};
}
Soft::Info Soft::info(ObjectId id) const { return info(std::size_t(impl_->objects.index(id))); }

Energy Soft::energy(const Vec3& gravity) const {
  Energy e;
  for (const auto& b : impl_->bodies) {
    for (std::uint32_t i = 0; i < b->size(); ++i) {
      const double m = b->mass[i];
      e.kinetic += 0.5 * m * double(dot(b->velocity[i], b->velocity[i]));
      e.potential -= m * double(b->settings.gravity_scale) * double(dot(gravity, b->position[i]));
    }
    e.elastic += b->elastic_energy(b->position);
    impl_->each_force(*b, [&](const ForceEntry& f) {
      for (std::uint32_t i = 0; i < b->size(); ++i) {
        const MassPoint point = impl_->mass_point(*b, i);
        e.potential += f.force->potential(&point, 1);
      }
    });
  }
  return e;
}

Momentum Soft::momentum() const {
  Momentum sum;
  for (const auto& b : impl_->bodies)
    for (std::uint32_t i = 0; i < b->size(); ++i) {
      const Double3 x = wide(b->position[i]), p = double(b->mass[i]) * wide(b->velocity[i]), a = cross(x, p);
      sum.linear[0] += p.x, sum.linear[1] += p.y, sum.linear[2] += p.z;
      sum.angular[0] += a.x, sum.angular[1] += a.y, sum.angular[2] += a.z;
    }
  return sum;
}

void Soft::residuals(std::vector<Residual>& out) const {
  double volume = 0, strain = 0, turned = 0, frozen = 0, sleeping = 0, steps = 1;
  for (const auto& b : impl_->bodies) {
    volume = std::fmax(volume, std::fabs(volume_of(*b) / b->mesh.rest_volume - 1));
    strain = std::fmax(strain, double(max_strain(b->object)));
    turned += static_cast<double>(inverted(b->object));
    frozen += b->state.frozen != 0, sleeping += b->state.asleep != 0;
    steps = std::fmax(steps, double(b->state.substeps));
  }
  out.push_back({"soft.volume_error", volume});
  out.push_back({"soft.max_strain", strain});
  out.push_back({"soft.inverted", turned});
  out.push_back({"soft.substeps", steps});
  out.push_back({"soft.sleeping", sleeping});
  out.push_back({"soft.quarantined", frozen});
}

void Soft::notes(std::vector<Note>& out) const {
  for (const auto& b : impl_->bodies) {
    std::string text = std::to_string(b->mesh.tetrahedra.size()) + " tetrahedra, " + std::to_string(b->size()) +
                       " points, " + std::to_string(b->mesh.skin.size() / 3) + " triangles of skin; " + b->solver_name +
                       ", " + b->law->name + ", " + std::to_string(b->state.substeps) + " solver substeps";
    if (b->share < 1) text += ", acts with " + print_number(std::round(b->share * 1000) / 10) + " % of its stiffness";
    out.push_back({b->object, text});
  }
}

bool Soft::finite() const {
  for (const auto& b : impl_->bodies) {
    if (b->state.frozen) return false;
    for (std::uint32_t i = 0; i < b->size(); ++i)
      if (!is_finite(b->position[i]) || !is_finite(b->velocity[i])) return false;
  }
  return true;
}

}  // namespace feder
