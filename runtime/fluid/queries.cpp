// Queries of fluids between steps. Neighbours are found at the present positions, contacts at the boundary as the
// coupling placed it (Rank::query_boundary).
#include <algorithm>
#include <cmath>
#include <numeric>

#include "fluid/impl.h"

namespace feder {

void Fluid::Impl::refresh(FluidPool& p) {
  if (p.count == 0) return;
  find_ratios_now(p);
  find_mixed_ratios(p);
}

void Fluid::Impl::find_ratios_now(FluidPool& p) {
  FEDER_ASSERT(p.start.size() > p.count);
  std::copy(p.x.begin(), p.x.begin() + p.count, p.start.begin());
  p.put_sentinel();
  p.find_neighbors(one_thread, 0);
  p.find_contacts(one_thread, boundary, 0, Vec3::Zero(), false);
  p.find_ratios(boundary, one_thread);
}

std::vector<std::uint32_t> Fluid::Impl::by_id(const FluidPool& p) const {
  std::vector<std::uint32_t> order(p.count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return p.id[a] < p.id[b]; });
  if constexpr (kAsserts)
    for (std::size_t k = 1; k < order.size(); ++k) FEDER_ASSERT(p.id[order[k - 1]] < p.id[order[k]]);
  return order;
}

void Fluid::positions(ObjectId id, std::vector<Vec3>& out) const {
  const FluidPool& p = impl_->pool(id);
  impl_->list_by_id(p, out, [&](std::uint32_t i) { return p.x[i].vec(); });
}

void Fluid::velocities(ObjectId id, std::vector<Vec3>& out) const {
  const FluidPool& p = impl_->pool(id);
  impl_->list_by_id(p, out, [&](std::uint32_t i) { return p.v[i].vec(); });
}

void Fluid::densities(ObjectId id, std::vector<Real>& out) {
  FluidPool& p = impl_->pool(id);
  const Impl::KeptRatios kept(p);
  impl_->refresh(p);
  impl_->list_by_id(p, out, [&](std::uint32_t i) { return p.ratio[i]; });
}

void Fluid::pressures(ObjectId id, std::vector<Real>& out) {
  FluidPool& p = impl_->pool(id);
  const Impl::KeptRatios kept(p);
  impl_->refresh(p);
  const FluidSolver& s = impl_->solver_of(p);
  impl_->list_by_id(p, out, [&](std::uint32_t i) { return s.pressure(p, i); });
}

void Fluid::density_error(ObjectId id, double& mean, double& largest) {
  std::vector<Real> ratios;
  densities(id, ratios);
  mean = largest = 0;
  for (const Real r : ratios) {
    const double e = std::max(0.0, static_cast<double>(r) - 1);
    mean += e;
    largest = std::max(largest, e);
  }
  if (!ratios.empty()) mean /= static_cast<double>(ratios.size());
}

// The smoothed fluid, over the share of the kernel that the boundary leaves free, crosses one half at the surface. It
// is searched downwards, within a spacing of each particle of the column only: gaps cost nothing, and far from the
// origin no step is lost to rounding.
bool Fluid::height_at(ObjectId id, Real x, Real z, Real& y) {
  const FluidPool& p = impl_->pool(id);
  std::vector<Vec3> column;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    const Real dx = p.x[i].x - x, dz = p.dimension == 2 ? Real(0) : p.x[i].z - z;
    if (dx * dx + dz * dz < p.support * p.support) column.push_back(p.x[i].vec());
  }
  std::sort(column.begin(), column.end(), [](const Vec3& a, const Vec3& b) { return a[1] > b[1]; });
  const double support = p.support, spacing = p.desc.spacing, step = spacing / 4;
  const double factor = static_cast<double>(p.value_factor) / p.kernel->norm_density[p.dimension - 2];
  // share of fluid at a height
  const auto share = [&](double at) {
    const Vec3 here = vec3(x, static_cast<Real>(at), p.dimension == 2 ? Real(0) : z);
    double fluid = 0, wall = 0;
    auto q = std::partition_point(column.begin(), column.end(), [&](const Vec3& c) { return c[1] > at + support; });
    for (; q != column.end() && static_cast<double>((*q)[1]) > at - support; ++q)
      fluid += factor * p.kernel->density.value(p.dimension, static_cast<double>(length(Vec3(*q - here))) / support);
    for (const BoundaryShape& w : impl_->boundary.shapes) {
      Vec3 n;
      const Real d = w.shape->distance(to_local(w.pose, here), p.support, n);
      if (p.meets(w) && d < p.support) wall += static_cast<double>(p.table->at(d / p.support).share);
    }
    return fluid / std::max(0.1, 1 - wall);
  };
  // steps of a quarter of a spacing, then bisection
  double searched = kInfinity;  // down to this height, m
  for (const Vec3& q : column) {
    const double from = std::min(searched, q[1] + spacing);
    searched = q[1] - spacing;
    for (int k = 0; k < 8; ++k) {
      double in = from - k * step, out = in + step;
      if (in <= searched || share(in) < 0.5) continue;
      for (int bisection = 0; bisection < 20; ++bisection) {
        const double middle = (in + out) / 2;
        (share(middle) < 0.5 ? out : in) = middle;
      }
      y = static_cast<Real>(in);
      return true;
    }
  }
  return false;
}

std::uint32_t Fluid::count_inside(ObjectId id, const Shape& shape, const Pose& pose, std::uint32_t group,
                                  std::uint32_t mask) const {
  const FluidPool& p = impl_->pool(id);
  if (!(p.desc.group & mask) || !(group & p.desc.mask)) return 0;
  const Aabb box = shape.bounds(pose);
  std::uint32_t n = 0;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    const Vec3 x = p.x[i].vec();
    Vec3 normal;
    if (overlaps(Aabb{x, x}, box)) n += shape.distance(to_local(pose, x), p.desc.spacing, normal) < 0;
  }
  return n;
}

void Fluid::clear_contact_states() {
  for (auto& p : impl_->pools) std::fill(p->contact_states.begin(), p->contact_states.end(), FluidContactState{});
}

void Fluid::list_contact_states(Array<FluidContactState>& out) const {
  for (const auto& p : impl_->pools)
    for (const FluidContactState& t : p->contact_states) {
      if (t.count == 0) continue;
      FEDER_ASSERT(t.body && !(t.speed < 0));
      out.push_back(t);
      out.back().fluid = p->object;
      out.back().point = t.point / static_cast<Real>(t.count);
      out.back().normal = normalized_or(t.normal, vec3(0, 1, 0));
    }
}

std::uint64_t Fluid::solver_substeps(ObjectId fluid) const { return impl_->pool(fluid).steps; }
std::uint64_t Fluid::solver_iterations(ObjectId fluid) const { return impl_->pool(fluid).iterations; }

}  // namespace feder
