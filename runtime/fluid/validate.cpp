// Validation of fluids: after a step the arrays of each pool, the ids of its particles, emitters, drains and solvers;
// within it the order of the particles after a sort by cell, and a sample of the rows of neighbours. That no particle
// is lost or doubled is checked by a sum over their ids that does not depend on the order (hash of a multiset, Bellare
// and Micciancio 1997). Allocates nothing.
#include <algorithm>

#include "fluid/impl.h"

namespace feder {
namespace {

constexpr std::uint32_t kSample = 16;  // one row of neighbours in so many is checked

bool listed(const NeighborLists& lists, std::uint32_t i, std::uint32_t j) {
  const auto row = lists.row(i);
  return std::binary_search(row.begin(), row.end(), j);
}

}  // namespace

std::uint64_t FluidPool::id_key(std::uint32_t number) {
  std::uint64_t k = (number + 0x9e3779b97f4a7c15ull) * 0xbf58476d1ce4e5b9ull;
  k = (k ^ k >> 27) * 0x94d049bb133111ebull;
  return k ^ k >> 31;
}

std::uint64_t FluidPool::id_sum() const {
  std::uint64_t keys = 0;
  for (std::uint32_t i = 0; i < count; ++i) keys += id_key(id[i]);
  return keys;
}

void FluidPool::validate_order() const {
  FEDER_ASSERT(id_sum() == ids_there);  // each is there once
  for (std::uint32_t i = 0; i < count; ++i) {
    const int cx = grid.coordinate(0, x[i].x), cy = grid.coordinate(1, x[i].y), cz = grid.coordinate(2, x[i].z);
    FEDER_ASSERT(grid.first(cx, cy, cz) <= i && i < grid.last(cx, cy, cz));
  }
}

// Of lists that were made from non-finite positions only the range of the indices is checked.
void FluidPool::validate_neighbors(Real radius) const {
  bool finite = true;
  for (std::uint32_t i = 0; i < count && finite; ++i) finite = is_finite(x[i].vec());
  for (std::uint32_t i = 0; i < count; i += kSample) {
    const auto row = lists.row(i);
    FEDER_ASSERT(row.size() <= lists.stride && row.size() <= NeighborLists::kMaxNeighbors);
    FEDER_ASSERT(lists.rounded[i] % 8 == 0 && lists.rounded[i] >= row.size() && lists.rounded[i] < row.size() + 8);
    for (std::uint32_t k = lists.count[i]; k < lists.rounded[i]; ++k) FEDER_ASSERT(row.data()[k] == count);
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::uint32_t j = row[k];
      FEDER_ASSERT(j < count && j != i);
      if (!finite) continue;
      FEDER_ASSERT(k == 0 || row[k - 1] < j);
      // symmetric, or pair terms would not cancel; a full row may have been cut
      FEDER_ASSERT(listed(lists, j, i) || lists.count[j] == NeighborLists::kMaxNeighbors);
      FEDER_ASSERT(!(length(Vec3(x[i].vec() - x[j].vec())) > Real(1.001) * radius));
    }
  }
}

void FluidPool::validate() const {
  const std::size_t room = capacity();
  FEDER_ASSERT(count <= room && room <= desc.max_particles);
  FEDER_ASSERT(support > desc.spacing && table && search && kernel && sweeps);
  if (room > 0) {
    for (const auto* array : {&x, &v, &start, &move, &extra, &swap4}) FEDER_ASSERT(array->size() == room + 1);
    for (const auto* array : {&lambda, &screen, &sum, &squares, &diagonal, &ratio, &next_weight, &swap1})
      FEDER_ASSERT(array->size() == room);
    FEDER_ASSERT(swap_id.size() == room && inside.size() == room && contact_first.size() == room + 1);
    for (const auto* array : {&origin, &listed_at, &script_force, &surface})
      FEDER_ASSERT(array->empty() || array->size() == room + 1);
  }
  FEDER_ASSERT(x.size() > count && x[count].w == 0 && length(x[count].vec()) > Real(1e8));
  FEDER_ASSERT(v[count].vec().isZero(0) && extra[count].vec().isZero(0));  // the sentinel does not move

  FEDER_ASSERT(id_sum() == ids_there);
  for (std::uint32_t i = 0; i < count; ++i) {
    FEDER_ASSERT(id[i] < next_id);
    FEDER_ASSERT(is_finite(x[i].vec()) && is_finite(v[i].vec()) && is_finite(lambda[i]));  // else removed
    FEDER_ASSERT(!asleep || v[i].vec().isZero(0));
    FEDER_ASSERT(x[i].w == 0);  // weights live in a sweep
  }
  FEDER_ASSERT(nearly_equal(kinetic, kinetic_energy()));  // every change of a velocity is accounted for
}

void Fluid::Impl::validate_sources() const {
  const auto owned = [&](ObjectId object, ObjectKind kind, std::size_t index, ObjectId fluid) {
    return objects.alive(object) && objects.kind(object) == kind && objects.index(object) == index &&
           objects.alive(fluid) && objects.kind(fluid) == kFluidKind;
  };
  for (std::size_t n = 0; n < emitters.size(); ++n) {
    const FluidEmitter& e = emitters[n];
    FEDER_ASSERT(owned(e.object, kEmitterKind, n, e.fluid));
    FEDER_ASSERT((e.limit == 0 || e.made <= e.limit) && !(e.done && e.running) && e.clock >= 0);
  }
  for (std::size_t n = 0; n < drains.size(); ++n)
    FEDER_ASSERT(owned(drains[n].object, kDrainKind, n, drains[n].fluid) && drains[n].shape < shapes.size());
}

void Fluid::validate() const {
  const Impl& m = *impl_;
  for (const BoundaryShape& w : m.boundary.shapes) FEDER_ASSERT(w.shape && w.body < m.boundary.bodies.size());
  // each pool is moved by the solver it asks for, and by no other
  std::size_t moved = 0;
  for (std::size_t k = 0; k < m.solvers.size(); ++k) {
    if (!m.solvers[k]) continue;
    for (const FluidPool* p : m.solvers[k]->pools) {
      FEDER_ASSERT(p->desc.solver == fluid_solvers()[k].name && !p->mixed);
      if (p->is_mixture()) continue;
      FEDER_ASSERT(&m.pool(p->object) == p);
      ++moved;
    }
  }
  FEDER_ASSERT(moved == m.pools.size());
  for (std::size_t n = 0; n < m.pools.size(); ++n) {
    FEDER_ASSERT(m.objects.index(m.pools[n]->object) == n);
    m.pools[n]->validate();
  }
  m.validate_sources();
}

}  // namespace feder
