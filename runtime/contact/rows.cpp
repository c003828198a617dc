// Contact rows and attachments, one after another (Gauss-Seidel) in each solver substep, between the solvers' own
// sweeps. A row corrects the displacements of its vertices along its normal, or off a solver body, which takes the
// opposite impulse at the same moment; friction is a Coulomb cone by displacement. Collisions are fully plastic:
// rebound of a row is taken out again. Overlap from before the substep is undone at kPushSpeed at most, so that it
// cannot explode. A row near pinned vertices has little effect on the free ones: to move a point that takes a share b
// of a vertex by d, the vertex moves d/b. It is limited to kMaxMotion d, so what pins make impossible stays undone and
// does not grow. Rows run on one thread: those between surfaces in their makers' order, those against bodies in runs,
// by strides of the golden section: a sweep from one side to the other pushes a sheet that way. Kept between calls:
// impulses of the rows. Weak spot: Gauss-Seidel converges slowly for heavy bodies on light cloth.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "contact/body_point.h"
#include "contact/impl.h"
#include "state/angular_momentum.h"

namespace feder {
namespace {
constexpr Real kPushSpeed = 1;    // m/s
constexpr Real kPullSpeed = 3;    // m/s, of attachments
constexpr std::size_t kRun = 4;   // rows against bodies, one after another
constexpr std::size_t kFew = 64;  // runs, below which they stay in order
// Largest motion of one vertex over the correction of its row. Free vertices of a mesh, whose masses differ by up to
// 1:6, move by 1.9 at most (the maximum of 6 a/(6 a^2 + (1 - a)^2)).
constexpr Real kMaxMotion = 2;
constexpr Real kParallel = Real(1e-4);  // least squared sine of two directions along which a push can be displaced
constexpr Real kMaxTilt = Real(0.5);    // largest displacement, of their lengths

// Sum of w weight^2 of a row, 1/kg, and the largest w |weight|.
struct RowResponse {
  Real sum = 0, largest = 0;
  void add(Real inv_mass, Real weight) {
    const Real motion = inv_mass * std::abs(weight);
    sum += motion * std::abs(weight);
    largest = std::max(largest, motion);
  }
  // With that of the solver body: the divisor of a correction or change of velocity.
  Real with(Real body) const { return std::max(sum + body, largest / kMaxMotion); }
};

// Calls f(row) for the rows against bodies: runs of them in order, neighbouring runs far from each other.
template <class F>
void each_scattered(Array<SurfaceRow>& rows, F&& f) {
  const std::size_t runs = (rows.size() + kRun - 1) / kRun;
  std::size_t stride = runs < kFew ? 1 : runs * 618 / 1000;
  while (std::gcd(stride, runs) > 1) ++stride;
  for (std::size_t k = 0, r = 0; k < runs; ++k) {
    for (std::size_t i = kRun * r; i < std::min(kRun * (r + 1), rows.size()); ++i) f(rows[i]);
    if ((r += stride) >= runs) r -= runs;
  }
}

// Calls f(row) for the rows that gave an impulse, in order.
template <class F>
void each_given(SurfaceGroup& g, const NearSearch& near, F&& f) {
  for (std::size_t k = 0; k < near.given.size(); ++k)
    for (unsigned left = near.given[k]; left != 0; left &= left - 1)
      f(g.near_rows[k * kLanes + static_cast<std::size_t>(std::countr_zero(left))]);
}
}  // namespace

// Solver bodies move by their velocities. Each group starts from their poses at the start of the substep.
void SurfaceContact::Impl::advance_bodies(StepContext& c) {
  const SurfaceGroup& g = group(c);
  Array<Vec3>&shift = surfaces.body_delta_position, &rotation = surfaces.body_delta_rotation;
  const SolverBodies* solver_bodies = surfaces.solver_bodies;
  FEDER_ASSERT(g.solver_indices.empty() ||
               shift.size() == solver_bodies->state.size());  // nobody joins within a substep
  for (const std::uint32_t m : g.solver_indices) {
    if (c.inner.index == 0) shift[m] = rotation[m] = Vec3::Zero();
    shift[m] += g.step * solver_bodies->state[m].velocity;
    rotation[m] += g.step * solver_bodies->state[m].angular_velocity;
  }
}

void SurfaceContact::Impl::solve_attachments(StepContext& c) {
  const SurfaceGroup& g = group(c);
  const SolverBodies* solver_bodies = surfaces.solver_bodies;
  const Real h = g.step;
  for (const SurfaceAttachment& k : g.attachments) {
    FEDER_ASSERT(k.vertex < delta_position.size());
    // effective mass of the three rows
    Row4& x = delta_position[k.vertex];
    Mat3 response = Mat3::Zero();
    if (k.solver_index != 0) {
      const Mat3 arm = skew(k.arm);
      response = -(arm * solver_bodies->mass[k.solver_index].inv_inertia * arm);
      response.diagonal() += solver_bodies->mass[k.solver_index].inv_mass_axes;
    }
    response.diagonal().array() += x.w;
    Vec3 error = k.error + x.vec() - surfaces.body_displacement(k.solver_index, k.arm);
    // the error from before this solver substep closes at kPullSpeed: a vertex attached far away must not throw the
    // body
    Vec3 change = x.vec() - before[k.vertex].vec();
    if (before[k.vertex].w != 0) change += h * velocity[k.vertex].vec();
    if (k.solver_index != 0) change -= h * velocity_at(solver_bodies->state[k.solver_index], k.arm);
    const Vec3 start = error - change;
    const Real open = length(start), closed = kPullSpeed * h;
    if (open > closed) error -= (1 - closed / open) * start;
    const Vec3 push = -(inverse(response) * error);  // kg m
    x.add(x.w * push);
    surfaces.push_body(k.solver_index, k.arm, -push, h);
  }
}

void SurfaceContact::Impl::solve_row(SurfaceRow& r, bool near, Real h) {
  const SolverBodies* solver_bodies = surfaces.solver_bodies;
  // displacement of the point since the start of the step, and its change in this solver substep
  Vec3 d = Vec3::Zero(), change = Vec3::Zero();
  RowResponse response;
  for (int k = 0; k < 4; ++k) {
    if (r.weight[k] == 0) continue;
    FEDER_ASSERT(r.vertex[k] < delta_position.size());
    const Row4& x = delta_position[r.vertex[k]];
    d += r.weight[k] * x.vec();
    change += r.weight[k] * (x.vec() - before[r.vertex[k]].vec());
    if (before[r.vertex[k]].w != 0) change += (r.weight[k] * h) * velocity[r.vertex[k]].vec();
    response.add(x.w, r.weight[k]);
  }
  const Real gap = r.offset + dot(r.normal, d - surfaces.body_displacement(r.solver_index, r.arm));
  r.pushed = 0;
  if (!(gap < 0)) return;
  FEDER_ASSERT(is_direction(r.normal) && !(r.friction < 0) && r.relaxation > 0);
  FEDER_ASSERT(!near || r.contact_state == kNone || r.contact_state < surface_pairs.size());
  if (r.solver_index != 0) change -= h * velocity_at(solver_bodies->state[r.solver_index], r.arm);
  // normal: the closing of this solver substep at once, older overlap at kPushSpeed
  const Real closing = dot(r.normal, change);
  const Real along = response.with(surfaces.body_response(r.solver_index, r.arm, r.normal));
  if (!(along > 0)) return;
  const Real need = std::min(-gap, kPushSpeed * h + std::max(-closing, Real(0)));
  const Real push = r.relaxation * need / along;  // kg m
  if (r.impulse == 0) r.approach = std::max(-closing / h, Real(0));
  r.impulse += push / h, r.pushed = push / h;
  FEDER_ASSERT(!(push < 0));  // contacts do not pull

  // friction: the sliding of this solver substep, within the cone
  Vec3 total = push * r.normal;
  const Vec3 sliding = change - closing * r.normal - h * r.slide;
  const Real slid = length(sliding);
  if (r.friction > 0 && slid > 0) {
    const Vec3 t = sliding / slid;
    const Real across = response.with(surfaces.body_response(r.solver_index, r.arm, t));
    total -= std::min(r.friction * push, slid / across) * t;
  }
  // both sides take the same correction
  Real tilt[4] = {0, 0, 0, 0};
  if (near) {
    const Vec3 x[4] = {start(r.vertex[0], h), start(r.vertex[1], h), start(r.vertex[2], h), start(r.vertex[3], h)};
    balance(r, x, total, push, tilt);
    if (r.contact_state == kNone) add_gained(r, x, total / h, tilt, 1 / h);
  }
  for (int k = 0; k < 4; ++k) {
    if (r.weight[k] == 0 && tilt[k] == 0) continue;
    Row4& x = delta_position[r.vertex[k]];
    const Vec3 was = x.vec(), to = r.weight[k] * total + tilt[k] * r.normal;
    x.add(x.w * to);
    if (near && r.contact_state != kNone) account(r, k, x.vec() - was, to, h);
  }
  surfaces.push_body(r.solver_index, r.arm, -total, h);
}

Vec3 SurfaceContact::Impl::start(std::uint32_t i, Real h) const {
  const Vec3 x = position[i] + before[i].vec();
  return before[i].w != 0 ? Vec3(x - h * velocity[i].vec()) : x;
}

// Torque of a row: it pushes two points that lie apart, so friction, and motion along the surface since the normal was
// found, would leave one. `tilt` (kg m along the normal) displaces the point of attack of the normal push on the
// features until the lines of both forces coincide, which keeps angular momentum; what their shape does not allow
// (parallel edges, points) is left. A displacement d that becomes a velocity d/h changes x cross v by (x - h v) cross
// d/h, so x is the position at the start of the solver substep.
void SurfaceContact::Impl::balance(const SurfaceRow& r, const Vec3 (&x)[4], const Vec3& total, Real push,
                                   Real (&tilt)[4]) const {
  if (!(push > 0)) return;
  Vec3 gap = Vec3::Zero();
  for (int k = 0; k < 4; ++k) gap += r.weight[k] * x[k];
  // displacement that the second feature's point needs relative to that of the first
  const Vec3 shift = cross(r.normal, cross(gap, total)) / push;
  const Vec3 a = r.edges ? Vec3(x[0] - x[1]) : Vec3(x[2] - x[1]), b = r.edges ? Vec3(x[3] - x[2]) : Vec3(x[3] - x[1]);
  const Vec3 flat_a = a - dot(a, r.normal) * r.normal, flat_b = b - dot(b, r.normal) * r.normal;
  const Real aa = dot(flat_a, flat_a), bb = dot(flat_b, flat_b), det = dot(r.normal, cross(a, b));
  Real s = 0, t = 0;
  if (det * det > kParallel * aa * bb)
    s = dot(r.normal, cross(shift, b)) / det, t = dot(r.normal, cross(a, shift)) / det;
  else if (aa > bb)
    s = dot(shift, flat_a) / aa;
  else if (bb > 0)
    t = dot(shift, flat_b) / bb;
  // shares of the lengths, limited; to weights of the vertices
  const Real most = std::max(std::abs(s), std::abs(t));
  if (most > kMaxTilt) s *= kMaxTilt / most, t *= kMaxTilt / most;
  s *= push, t *= push;
  if (r.edges)
    tilt[0] = -s, tilt[1] = s, tilt[2] = t, tilt[3] = -t;
  else
    tilt[1] = s + t, tilt[2] = -s, tilt[3] = -t;
}

// Torque of a row within one surface about its first point: what balance() left of it.
void SurfaceContact::Impl::add_gained(const SurfaceRow& r, const Vec3 (&x)[4], const Vec3& total, const Real (&tilt)[4],
                                      Real scale) {
  Vec3& gained = gained_momentum[near_surface[r.vertex[0]]];
  for (int k = 1; k < 4; ++k) gained += cross(x[k] - x[0], r.weight[k] * total + (scale * tilt[k]) * r.normal);
}

// Takes out of each surface what its own contacts gave it, as a rotation of the whole.
void SurfaceContact::Impl::remove_gained_momentum(const SurfaceGroup& g) {
  for (const std::uint32_t n : g.members) {
    const Surface& s = list[n];
    Vec3 gained = Vec3::Zero();
    std::swap(gained, gained_momentum[n]);
    if (gained.isZero(0) || s.pinned || !s.active) continue;
    const std::uint32_t first = s.first, count = s.count + s.inner;  // of a soft body its inside too
    Real total = 0;
    for (std::uint32_t i = first; i < first + count; ++i) total += mass[i];
    const Vec3 near = current_position(first);
    take_out_spin(
        gained, count, total, 0, [&](std::uint32_t i) { return mass[first + i]; },
        [&](std::uint32_t i) { return Vec3(current_position(first + i) - near); },
        [&](std::uint32_t i, const Vec3& change) { velocity[first + i].add(change); });
  }
}

// Fully plastic contact: where a row that pushed now separates, the relative velocity along the normal becomes zero. A
// row that other rows have pushed open in this solver substep gives back what it gave in it: on a curved body the
// points of an edge lie farther out than its middle, and would bounce for ever.
void SurfaceContact::Impl::stop_rebound(SurfaceRow& r, bool near, Real h) {
  SolverBodies* solver_bodies = surfaces.solver_bodies;
  if (r.impulse == 0) return;
  // only rows that are still closed, or were when this solver substep began
  Vec3 d = Vec3::Zero(), u = Vec3::Zero();
  RowResponse response;
  for (int k = 0; k < 4; ++k) {
    if (r.weight[k] == 0) continue;
    d += r.weight[k] * delta_position[r.vertex[k]].vec();
    u += r.weight[k] * velocity[r.vertex[k]].vec();
    response.add(delta_position[r.vertex[k]].w, r.weight[k]);
  }
  const bool of_fluid = r.solver_index != 0 && r.contact_state == kNone;
  const bool open = r.offset + dot(r.normal, d - surfaces.body_displacement(r.solver_index, r.arm)) > Real(1e-3) * h;
  if (open && (of_fluid || r.pushed == 0)) return;
  if (r.solver_index != 0) u -= velocity_at(solver_bodies->state[r.solver_index], r.arm);
  const Real parting = dot(r.normal, u), along = response.with(surfaces.body_response(r.solver_index, r.arm, r.normal));
  if (!(parting > 0) || !(along > 0)) return;
  // no more than the row has given; to a particle of a fluid in all solver substeps, or it would be held by the sheet
  const Real impulse = std::min(parting / along, of_fluid ? r.impulse - r.returned : open ? r.pushed : r.impulse);
  if (!(impulse > 0)) return;
  r.returned += impulse;
  Real tilt[4] = {0, 0, 0, 0};
  if (near) {
    const Vec3 x[4] = {current_position(r.vertex[0]), current_position(r.vertex[1]), current_position(r.vertex[2]),
                       current_position(r.vertex[3])};
    balance(r, x, impulse * r.normal, impulse, tilt);
    if (r.contact_state == kNone) add_gained(r, x, -impulse * r.normal, tilt, -1);
  }
  for (int k = 0; k < 4; ++k) {
    if (r.weight[k] == 0 && tilt[k] == 0) continue;
    Row4& v = velocity[r.vertex[k]];
    const Vec3 was = v.vec(), push = (-r.weight[k] * impulse - tilt[k]) * r.normal;
    v.add(delta_position[r.vertex[k]].w * push);
    if (near && r.contact_state != kNone) account(r, k, v.vec() - was, push, 1);
  }
  if (r.solver_index == 0) return;
  // of a body only velocities change, its displacement stands
  const SolverMass& mm = solver_bodies->mass[r.solver_index];
  SolverBody& m = solver_bodies->state[r.solver_index];
  m.velocity += mm.inv_mass_axes.cwiseProduct(impulse * r.normal);
  m.angular_velocity += mm.inv_inertia * cross(r.arm, impulse * r.normal);
}

// The rows that make_near_rows made; none has given an impulse.
void SurfaceContact::Impl::batch_rows(const SurfaceGroup& g, NearSearch& near) const {
  const std::size_t rows = g.near_rows.size(), count = (rows + kLanes - 1) / kLanes;
  near.batches.resize(count), near.given.assign(count, 0);
  for (std::size_t k = 0; k < kLanes * count; ++k) {
    RowBatch& b = near.batches[k / kLanes];
    const std::size_t lane = k % kLanes;
    const bool whole = k < rows;
    const SurfaceRow& r = g.near_rows[whole ? k : 0];
    for (int i = 0; i < 4; ++i) b.v[i][lane] = r.vertex[i], b.weight[i].v[lane] = whole ? r.weight[i] : Real(0);
    b.normal.x.v[lane] = r.normal[0], b.normal.y.v[lane] = r.normal[1], b.normal.z.v[lane] = r.normal[2];
    b.offset.v[lane] = whole ? r.offset : Real(1);
  }
}

// Row after row; eight are asked together whether they are closed, and where one is those behind it again, since it
// moves what they share.
void SurfaceContact::Impl::solve_near(SurfaceGroup& g, NearSearch& near, Real h) {
  const auto count = static_cast<unsigned>(near.batches.size());
  if (count == 0) return;
  each_given(g, near, [](SurfaceRow& r) { r.pushed = 0; });
  unsigned closed = 0;
  for (unsigned k = 0;; ++k) {
    k = kernels->next_closed(near.batches.data(), k, count, &delta_position[0].x, closed);
    if (k >= count) return;
    const std::size_t first = k * kLanes, last = std::min(first + kLanes, g.near_rows.size());
    for (std::size_t r = first + static_cast<std::size_t>(std::countr_zero(closed)); r < last; ++r) {
      solve_row(g.near_rows[r], true, h);
      if (g.near_rows[r].impulse != 0) near.given[k] |= static_cast<unsigned char>(1u << (r - first));
    }
  }
}

void SurfaceContact::Impl::solve(StepContext& c) {
  SurfaceGroup& g = group(c);
  surfaces.row_updates += g.attachments.size() + g.near_rows.size() + g.rows.size();
  solve_near(g, search(c), g.step);
  each_scattered(g.rows, [&](SurfaceRow& r) { solve_row(r, false, g.step); });
}

void SurfaceContact::Impl::rebound(StepContext& c) {
  SurfaceGroup& g = group(c);
  each_given(g, search(c), [&](SurfaceRow& r) { stop_rebound(r, true, g.step); });
  each_scattered(g.rows, [&](SurfaceRow& r) { stop_rebound(r, false, g.step); });
}

}  // namespace feder
