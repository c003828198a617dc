// Invariants of nets after each step, asserted where asserts are on (feder/error.h): nets own consecutive runs of
// points, springs join points of their net, removed springs have no stiffness, colliders and points refer to each
// other, nets that are not quarantined are finite. The kernels' layout is checked when it is built.
#include "springs/impl.h"
#include "state/colliders.h"
#include "state/solver_bodies.h"

namespace feder {

// Every living spring is in the rows of both its ends.
void SpringLayout::check_built(const SpringArrays& s) const {
  FEDER_ASSERT(lane_of_.size() == std::size_t{2} * s.size() && row_begin_.back() == rows_.size());
  for (std::uint32_t k = 0; k < s.size(); ++k)
    for (std::uint32_t end = 0; s.alive[k] && end < 2; ++end) {
      const std::uint64_t index = lane_of_[std::size_t{2} * k + end];
      const std::uint32_t self = end ? s.j[k] : s.i[k], other = end ? s.i[k] : s.j[k];
      const std::size_t row = index / kLanes;
      FEDER_ASSERT(index % kLanes == self % kLanes);
      FEDER_ASSERT(row >= row_begin_[self / kLanes] && row < row_begin_[self / kLanes + 1]);
      FEDER_ASSERT(rows_[row].other[self % kLanes] == other);
    }
}

void Net::validate() const {
  const SpringArrays& s = springs;
  SpringArrays::each_array(s, [&](const auto& array) { FEDER_ASSERT(array.size() == s.size()); });
  for (std::uint32_t k = 0; k < s.size(); ++k) {
    FEDER_ASSERT(s.i[k] < points && s.j[k] < points && s.i[k] != s.j[k]);
    FEDER_ASSERT(s.alive[k] ? s.stiffness[k] >= 0 : s.stiffness[k] == 0 && s.limit[k] == kInfinity);
    FEDER_ASSERT(can_break || s.limit[k] == kInfinity);
    FEDER_ASSERT(has_power || s.power[k] == 1);
  }
  FEDER_ASSERT(faces.size() % 3 == 0);
  for (const std::uint32_t point : faces) FEDER_ASSERT(point < points);
}

void Springs::Impl::check_points(const Net& n) const {
  const Particles& p = particles;
  FEDER_ASSERT(!n.bad());
  for (std::uint32_t i = n.first; i < n.first + n.points; ++i) {
    FEDER_ASSERT(p.net[i] == n.object && p.mass[i] > 0);
    FEDER_ASSERT(p.inertia[i] == p.mass[i]);  // couplings have taken back what the point carried
    FEDER_ASSERT(p.inv_mass[i] == 0 || p.inv_mass[i] == 1 / p.mass[i]);
    FEDER_ASSERT(is_finite(p.position[i]) && is_finite(p.velocity[i]));
    FEDER_ASSERT(!n.frozen || (p.inv_mass[i] == 0 && p.velocity[i].isZero(0)));
  }
}

void Springs::Impl::check_colliders() const {
  const Colliders* c = store.find<Colliders>();
  const SolverBodies* m = store.find<SolverBodies>();
  for (std::uint32_t i = 0; i < particles.size(); ++i) {
    const std::uint32_t k = particles.collider[i], slot = particles.solver_slot[i];
    FEDER_ASSERT(slot == kNone || (m && slot < m->index.size()));
    if (k == kNone) continue;
    FEDER_ASSERT(c && k < c->size() && c->motion[k] != ColliderMotion::none);
    FEDER_ASSERT(c->owner[k] == ColliderOwner::point && c->owner_index[k] == i && c->solver_slot[k] == slot);
    FEDER_ASSERT(c->object[k] == particles.net[i]);
  }
}

void Springs::validate() const {
  const Impl& m = *impl_;
  const Particles& p = m.particles;
  Particles::each_array(p, [&](const auto& array) { FEDER_ASSERT(array.size() == p.size()); });
  std::uint32_t next = 0;
  for (std::size_t index = 0; index < m.nets.size(); ++index) {
    const Net& n = *m.nets[index];
    FEDER_ASSERT(n.first == next && n.points > 0 && n.integrator);
    next += n.points;
    FEDER_ASSERT(m.objects.alive(n.object) && m.objects.index(n.object) == index);
    n.validate();
    m.check_points(n);
  }
  FEDER_ASSERT(next == p.size());
  m.check_colliders();
  for (const Attachment& a : m.attachments) {
    FEDER_ASSERT(m.objects.alive(a.net) && a.point < p.size() && p.net[a.point] == a.net);
    FEDER_ASSERT(is_finite(a.local));
  }
}

}  // namespace feder
