// Viscosity over a solver substep: the Laplacian of the velocity as a sum over pairs (Monaghan & Gingold 1983; Monaghan
// 2005), the boundary by the integral of the same term over the solid with the velocity continued oddly through its
// face (Morris 1997), or not at all: free slip, no tangential stress at the wall.
// Explicit, in a round or two, where that is stable; else implicit (backward Euler, as in Weiler, Koschier, Brand &
// Bender 2018): velocities of particles and of the bodies they rub solve (M + h K) v = M v*, K symmetric, by conjugate
// gradients in the norm of the kinetic energy from v* on. Bodies are unknowns of the system, so that light ones in
// honey do not ring. Every iterate keeps all momentum. Kept between calls: nothing. Weak spot: of what is so viscous
// that kViscousIterations do not suffice, slow motion over many spacings is less so; a warning says so.
#include <algorithm>
#include <cmath>

#include "base/cast.h"
#include "fluid/block_sums.h"
#include "fluid/solver.h"

namespace feder {
namespace {

constexpr Real kViscousLimit = Real(0.1);  // of (support/2)^2/nu, largest time of a round; 0.125 in Morris 1997
constexpr Real kMaxRounds = 2;             // explicit ones in a solver substep
constexpr Real kNearest = Real(0.05);      // supports, of a particle to a wall: friction is finite
constexpr int kViscousIterations = 300;
constexpr double kSolved = 1e-3;  // of the velocities, that the solve leaves at most
constexpr double kMissedBy = 10;  // times that: worth a warning

struct Dot {
  double sum = 0;
  void add(const Dot& d) { sum += d.sum; }
};

double dots(const Row4& a, const Row4& b) { return static_cast<double>(dot(a.vec(), b.vec())); }

// Velocity and angular velocity of a body, or the impulse and its moment about the centre.
struct BodyRow {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};

double dots(const BodyRow& a, const BodyRow& b) {
  return static_cast<double>(dot(a.linear, b.linear)) + static_cast<double>(dot(a.angular, b.angular));
}

class Viscous {
 public:
  Viscous(FluidPool& p, Boundary& boundary, Real h, StepContext& c)
      : p_(p), boundary_(boundary), c_(c), mixture_(p.is_mixture()), r2_(p.support * p.support), h_(h),
        share_(share_in(p)), factor_(laplacian_factor(p, share_)) {
    FEDER_ASSERT(h > 0 && p.desc.viscosity > 0);
    // between fluids of a mixture the harmonic mean of their viscosities acts (Patankar 1980)
    if (mixture_)
      p_.weigh(*c_.jobs,
               [&](std::uint32_t i) { return p_.share_of(i) * p_.share_of(i) * p_.fluid_of(i).desc.viscosity; });
  }
  ~Viscous() {
    if (mixture_) p_.clear_weights(*c_.jobs);
  }
  Viscous(const Viscous&) = delete;
  Viscous& operator=(const Viscous&) = delete;
  void round();
  void solve();

 private:
  // h times the kinematic viscosity of a fluid, m^2.
  Real share_in(const FluidPool& of) const { return h_ * p_.viscous_scale * of.desc.viscosity / of.desc.density; }
  Real share_of(std::uint32_t i) const { return mixture_ ? share_in(p_.fluid_of(i)) : share_; }
  // Of the velocity of a particle that slides by the contact, taken from it in the substep.
  Real rate(const BoundaryContact& k) const {
    const Real s = k.distance(p_.x[k.particle].vec()) / p_.support;
    if (s >= 1) return 0;
    return share_of(k.particle) * p_.table_of(k.particle).at(std::max(s, Real(0))).friction /
           (std::max(s, kNearest) * r2_);
  }
  static Vec3 along(const BoundaryContact& k, const Vec3& slip) { return slip - dot(slip, k.normal) * k.normal; }
  void laplacian(const Row4* velocities, Row4* to);
  void rub_explicitly(std::uint32_t i, Vec3* impulses);
  void rub(const Row4* velocities, bool of_state, const BodyRow* bodies, Row4* to, BodyRow* to_bodies);
  void give_impulses();
  template <class F>
  double sum(const F& f) {
    return sum_ranges<Dot>(p_.count, kParticleGrain, *c_.jobs, *c_.scratch,
                           [&f](std::uint32_t first, std::uint32_t last, Dot& d) {
                             for (std::uint32_t i = first; i < last; ++i) d.sum += f(i);
                           })
        .sum;
  }
  // Weights of the positions; between fluids of a mixture the harmonic mean of their viscosities acts (Patankar 1980).
  template <class F>
  void each(F&& f) {
    c_.jobs->for_blocks(p_.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) f(i);
    });
  }

  FluidPool& p_;
  Boundary& boundary_;
  StepContext& c_;
  bool mixture_;
  Real r2_, h_, share_, factor_;
};

// h nu times the Laplacian, between particles.
void Viscous::laplacian(const Row4* velocities, Row4* to) {
  SweepInput in = p_.sweep_input();
  in.soft = Real(1e-6) * r2_, in.velocity = &velocities[0].x;
  c_.jobs->for_blocks(p_.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    (mixture_ ? p_.sweeps->viscous_by : p_.sweeps->viscous)(in, first, last, &to[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      const Real density = p_.uneven() ? p_.mass_of(i) / p_.volume : p_.fluid_of(i).desc.density;
      const Real factor = mixture_ ? laplacian_factor(p_, h_ * p_.viscous_scale / density) : factor_;
      to[i].set(factor * to[i].vec());
    }
  });
}

// Friction of a particle at the boundary, implicit in each contact: it never reverses the slip. `impulses`: by body
// that the fluid does not move, or null.
void Viscous::rub_explicitly(std::uint32_t i, Vec3* impulses) {
  for (const BoundaryContact& k : p_.contacts_of(i)) {
    const Real by = rate(k);
    FEDER_ASSERT(!(by < 0));
    if (!(by > 0)) continue;
    BoundaryBody& b = boundary_.body_of(k);
    const Vec3 at = p_.x[i].vec();
    const Vec3 change = -(by / (1 + by)) * along(k, p_.v[i].vec() - b.velocity_at(at));
    p_.v[i].set(p_.v[i].vec() + change);
    if (b.dynamic)
      b.push(at, -p_.mass_of(i) * change);
    else if (impulses)
      impulses[boundary_.shapes[k.shape].body] += -p_.mass_of(i) * change;
  }
}

void Viscous::round() {
  laplacian(p_.v.data(), p_.extra.data());
  const auto meets_dynamic = [&](std::uint32_t i) {
    const auto contacts = p_.contacts_of(i);
    return std::any_of(contacts.begin(), contacts.end(),
                       [&](const BoundaryContact& k) { return boundary_.body_of(k).dynamic; });
  };
  const bool any_dynamic = !p_.dynamic_contacts.empty();
  weigh_blocks(p_.count, boundary_, c_, [&](std::uint32_t i, Vec3* impulses) {
    p_.v[i].set(p_.v[i].vec() + p_.extra[i].vec());
    if (!p_.slips && !(any_dynamic && meets_dynamic(i))) rub_explicitly(i, impulses);
  });
  if (p_.slips) return;
  // each changes the velocities of bodies that the next one meets
  const Scratch::Frame frame(*c_.scratch);
  Vec3* impulses = c_.scratch->take<Vec3>(boundary_.bodies.size());
  std::fill_n(impulses, boundary_.bodies.size(), Vec3(Vec3::Zero()));
  std::uint32_t last = kNone;
  for (const std::uint32_t at : p_.dynamic_contacts) {
    if (p_.contacts[at].particle == last) continue;
    last = p_.contacts[at].particle;
    rub_explicitly(last, impulses);
  }
  if (last == kNone) return;
  for (std::size_t n = 0; n < boundary_.bodies.size(); ++n)
    if (!boundary_.bodies[n].dynamic) boundary_.bodies[n].impulse += impulses[n];
}

// Subtracts K h of the slip from rows of particles, and adds it to those of bodies (as impulses). `of_state`: bodies
// that the fluid does not move, too, have their velocity; else they have none.
void Viscous::rub(const Row4* velocities, bool of_state, const BodyRow* bodies, Row4* to, BodyRow* to_bodies) {
  if (p_.slips) return;
  const auto slip = [&](const BoundaryContact& k) {
    const std::uint32_t n = boundary_.shapes[k.shape].body;
    const BoundaryBody& b = boundary_.bodies[n];
    const Vec3 at = p_.x[k.particle].vec(), v = velocities[k.particle].vec();
    if (of_state) return Vec3(along(k, v - b.velocity_at(at)));
    return Vec3(along(k, b.dynamic ? Vec3(v - bodies[n].linear - cross(bodies[n].angular, at - b.center)) : v));
  };
  each([&](std::uint32_t i) {
    Vec3 taken = Vec3::Zero();
    for (const BoundaryContact& k : p_.contacts_of(i)) {
      const Real by = rate(k);
      if (by > 0) taken += by * slip(k);
    }
    to[i].set(to[i].vec() - taken);
  });
  for (const std::uint32_t at : p_.dynamic_contacts) {
    const BoundaryContact& k = p_.contacts[at];
    const Real by = rate(k);
    if (!(by > 0)) continue;
    const std::uint32_t n = boundary_.shapes[k.shape].body;
    const Vec3 impulse = p_.mass_of(k.particle) * by * slip(k);
    to_bodies[n].linear += impulse;
    to_bodies[n].angular += cross(p_.x[k.particle].vec() - boundary_.bodies[n].center, impulse);
  }
}

// What the friction that was solved for gives to bodies. The velocities of those that move have it already.
void Viscous::give_impulses() {
  if (p_.slips) return;
  const auto impulse = [&](const BoundaryContact& k) {
    const BoundaryBody& b = boundary_.body_of(k);
    return Vec3(p_.mass_of(k.particle) * rate(k) *
                along(k, p_.v[k.particle].vec() - b.velocity_at(p_.x[k.particle].vec())));
  };
  weigh_blocks(p_.count, boundary_, c_, [&](std::uint32_t i, Vec3* impulses) {
    if (!impulses) return;
    for (const BoundaryContact& k : p_.contacts_of(i))
      if (!boundary_.body_of(k).dynamic) impulses[boundary_.shapes[k.shape].body] += impulse(k);
  });
  for (const std::uint32_t at : p_.dynamic_contacts) {
    BoundaryBody& b = boundary_.body_of(p_.contacts[at]);
    const Vec3 given = impulse(p_.contacts[at]);
    b.impulse += given, b.pressed += length(given);
  }
}

void Viscous::solve() {
  const Scratch::Frame frame(*c_.scratch);
  const std::uint32_t n = p_.count;
  const std::size_t bodies = p_.dynamic_contacts.empty() || p_.slips ? 0 : boundary_.bodies.size();
  Row4 *residual = c_.scratch->take<Row4>(n), *direction = c_.scratch->take<Row4>(n + 1u),
       *effect = c_.scratch->take<Row4>(n);
  // impulses that are left, the direction and its momentum, and what it does
  BodyRow *left = c_.scratch->take<BodyRow>(bodies), *turn = c_.scratch->take<BodyRow>(bodies),
          *momentum = c_.scratch->take<BodyRow>(bodies), *given = c_.scratch->take<BodyRow>(bodies);
  std::fill_n(left, bodies, BodyRow{}), std::fill_n(turn, bodies, BodyRow{}), std::fill_n(momentum, bodies, BodyRow{});
  std::fill_n(direction, n + 1u, Row4{});
  const auto mass = [&](std::uint32_t i) { return static_cast<double>(p_.mass_of(i)); };
  const auto eased = [&](std::size_t b) {
    const BoundaryBody& body = boundary_.bodies[b];
    return BodyRow{body.inv_mass.cwiseProduct(left[b].linear), body.inv_inertia * left[b].angular};
  };
  const auto size_of_residual = [&] {
    double size = sum([&](std::uint32_t i) { return mass(i) * dots(residual[i], residual[i]); });
    for (std::size_t b = 0; b < bodies; ++b) size += dots(left[b], eased(b));
    return size;
  };
  laplacian(p_.v.data(), residual);
  rub(p_.v.data(), true, nullptr, residual, left);
  const double wanted = kSolved * kSolved * sum([&](std::uint32_t i) { return mass(i) * dots(p_.v[i], p_.v[i]); });
  double size = size_of_residual(), carry = 0;
  int iterations = 0;
  for (; size > wanted && iterations < kViscousIterations; ++iterations) {
    each([&](std::uint32_t i) { direction[i].set(residual[i].vec() + static_cast<Real>(carry) * direction[i].vec()); });
    for (std::size_t b = 0; b < bodies; ++b) {
      const BodyRow moved = eased(b);
      const Real kept = static_cast<Real>(carry);
      turn[b] = {moved.linear + kept * turn[b].linear, moved.angular + kept * turn[b].angular};
      momentum[b] = {left[b].linear + kept * momentum[b].linear, left[b].angular + kept * momentum[b].angular};
      given[b] = {};
    }
    laplacian(direction, effect);
    rub(direction, false, turn, effect, given);
    double curvature = sum(
        [&](std::uint32_t i) { return mass(i) * (dots(direction[i], direction[i]) - dots(direction[i], effect[i])); });
    for (std::size_t b = 0; b < bodies; ++b) curvature += dots(turn[b], momentum[b]) - dots(turn[b], given[b]);
    if (!(curvature > 0)) break;
    const Real step = static_cast<Real>(size / curvature);
    each([&](std::uint32_t i) {
      p_.v[i].set(p_.v[i].vec() + step * direction[i].vec());
      residual[i].set(residual[i].vec() - step * (direction[i].vec() - effect[i].vec()));
    });
    for (std::size_t b = 0; b < bodies; ++b) {
      BoundaryBody& body = boundary_.bodies[b];
      if (!body.dynamic) continue;
      body.velocity += step * turn[b].linear, body.angular_velocity += step * turn[b].angular;
      left[b].linear -= step * (momentum[b].linear - given[b].linear);
      left[b].angular -= step * (momentum[b].angular - given[b].angular);
    }
    const double before = size;
    size = size_of_residual();
    carry = size / before;
  }
  give_impulses();
  if (iterations < kViscousIterations || size <= kMissedBy * kMissedBy * wanted || p_.warned_viscosity) return;
  p_.warned_viscosity = true;
  c_.events->warn("fluid_viscosity",
                  "viscosity " + std::to_string(p_.desc.viscosity) + " Pa s is not solved for in " +
                      std::to_string(kViscousIterations) +
                      " iterations of a substep: slow motion is less viscous than asked for; take a larger spacing or "
                      "more substeps",
                  p_.object);
}

}  // namespace

// What makes the sum of Sweeps::viscous a Laplacian, times `by`.
Real laplacian_factor(const FluidPool& p, Real by) {
  const int d = p.dimension;
  if (p.kernel->radial_viscosity) return 2 * static_cast<Real>(d + 2) * by * p.viscous_factor;
  return by * p.viscous_factor;
}

namespace {

Real explicit_rounds(const FluidPool& p, Real h) {
  const Real nu = p.viscous_scale * p.desc.viscosity / p.desc.density / p.lightest, unit = p.support / 2;
  return std::max(std::ceil(h * nu / (kViscousLimit * unit * unit)), Real(1));
}

}  // namespace

bool needs_implicit_viscosity(const FluidPool& p, Real h) { return explicit_rounds(p, h) > kMaxRounds; }

void add_viscosity(FluidPool& p, Boundary& boundary, Real h, StepContext& c) {
  if (needs_implicit_viscosity(p, h)) return Viscous(p, boundary, h, c).solve();
  const Real rounds = explicit_rounds(p, h);
  Viscous system(p, boundary, h / rounds, c);
  for (Real k = 0; k < rounds; ++k) system.round();
}

}  // namespace feder
