// The passes of the cloth system. A substep of the world is divided into solver substeps, the same number for the
// surfaces of a group (contact/groups.cpp). Stretch law: one sweep per solver substep h leaves a strain of at most
// 2 g n^2 h^2/L in a sheet of n rows and length L under g (coloured order; measured in
// tests/cloth/test_stretch_law.cpp); the number of solver substeps is chosen so that this stays below `stretch_error`.
// n counts from the pins, or from the middle of a free sheet. g is multiplied by the mass that rests on the cloth over
// its own; where wind pulls more than gravity, its mean acceleration counts; the decelerations of an approaching body
// and of the cloth's own swing are added. For a solver that converges only what loads and approaching bodies add
// counts: it leaves nothing of its own weight, but does not know the mass of what lies on it. Kept between steps: the
// number chosen (ClothState::substeps), with hysteresis.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "cloth/impl.h"
#include "state/angular_momentum.h"

namespace feder {
namespace {
constexpr Real kMinGravity = 1;  // m/s^2, at least: weightless cloth is pulled by something else
constexpr JobGrain kVertexGrain{2048, 8'000};
constexpr double kStay = 0.9;          // hysteresis: a number that falls by less than this share stays
constexpr Real kFramed = Real(1.002);  // pins farther apart than at rest by more stretch the cloth between them

// Of a cloth of at least so many vertices solver substeps are dear; a smaller one may have more of them.
constexpr double kLarge = 2500;
double size_share(const Sheet& s) { return std::fmin(1, double(s.points) / kLarge); }

// Strain that sweeps may leave. Where ties to pins hold a cloth that bears nothing, what they leave is below their
// limit whatever the sweeps do; but a cloth that hangs nearly straight sags by ten times its strain, so where it costs
// little they leave less: at share^(3/2) solver substeps grow with the share to the power -1/4, cost falls with 3/4.
// At a single pin all of the weight hangs from a few links, and ties are slack along the folds: 50 x 50 stretch by .04
// at worst there, with kUsual by .061.
double stretch_error(const Sheet& s) {
  constexpr double kUsual = 0.01, kTied = 0.05, kAtOnePin = 0.0025, kGrown = 3500, kMostGrown = 12;
  if (s.settings.stretch_error > 0) return double(s.settings.stretch_error);
  if (s.ties.batches.empty()) return kUsual;
  double tied = std::fmax(kUsual, std::fmin(1.5 * double(s.settings.max_strain), kTied));
  // Long links hold the size of large ones: the law's strain may grow with the square of n there, so that the number of
  // solver substeps follows from the length of the cloth alone (3 m at two corners: 16 a frame from 60 to 140 cells).
  if (s.solver->reaches() && !s.settings.flows()) tied *= std::fmin(std::fmax(s.points / kGrown, 1), kMostGrown);
  const double share = s.solver->sheds_strain() ? size_share(s) : 1;
  const double error = kUsual + double(s.unladen()) * (tied * share * std::sqrt(share) - kUsual);
  return s.ties.pins.size() == 1 ? std::fmin(error, kAtOnePin) : error;
}

// Largest number of solver substeps: what the settings say, or what a large cloth may have; a small one may have more
// for its own stiffness and for what hits it (`own`: as many as they want), not for what lies on it.
double most_substeps(const Sheet& s, double own) {
  constexpr double kUsual = 64, kMost = 1000;
  if (s.settings.max_substeps > 0) return s.settings.max_substeps;
  return std::fmax(kUsual, std::fmin(own, std::fmin(kUsual / size_share(s), kMost)));
}

// What to do about a cap that is too low: where the stretch law asks for the solver substeps, the stretch_error that
// the cap can hold, in two digits upwards; and the cap itself, which has a largest value.
std::string cap_cure(const Sheet& s, double wanted, double cap) {
  std::string cure;
  if (wanted <= 10000) cure = "max_substeps = " + std::to_string(static_cast<int>(std::ceil(wanted)));
  const double error = stretch_error(s) * (wanted / cap) * (wanted / cap);
  if (s.bend_substeps <= cap && error <= 0.5) {
    const double digit = std::pow(10.0, std::floor(std::log10(error)) - 1);
    cure += (cure.empty() ? "" : " or ") + ("stretch_error = " + print_number(std::ceil(error / digit) * digit));
  }
  return cure.empty() ? "" : ": " + cure + " would do now";
}

typedef Real Wide4 __attribute__((vector_size(4 * sizeof(Real))));
Wide4 wide4(const Row4& r) { return Wide4{r.x, r.y, r.z, r.w}; }
void put4(Row4& r, Wide4 v) { r = Row4{v[0], v[1], v[2], v[3]}; }

}  // namespace

ClothView Cloth::Impl::view(Sheet& s) {
  FEDER_ASSERT(delta_position.size() >= vertices.size() && before.size() >= vertices.size());
  ClothView v;
  v.mesh = &s.mesh;
  v.points = s.points, v.total = s.total;
  v.version = s.version;
  v.rests = s.rests, v.flows = s.settings.flows();
  v.lacking = s.lacking;
  v.taut = s.framed || (s.settings.pressure != 0 && s.gas.closed);
  v.damping = s.settings.damping;
  v.max_strain = s.limited() ? s.settings.max_strain : kInfinity;
  v.tie_limit = s.ties.limit, v.ties = s.ties.batches, v.tie_layers = s.ties.layers;
  v.position = vertices.position.data() + s.first;
  v.rest = vertices.rest.data() + s.first;
  v.delta_position = delta_position.data() + s.first;
  v.before = before.data() + s.first;
  v.velocity = velocity.data() + s.first;
  v.acceleration = acceleration.data() + s.first;
  v.mass = vertices.mass.data() + s.first;
  return v;
}

// Longest of the shortest paths from the pins along edges, in links and metres (breadth first). It sets n and L of the
// stretch law.
void Cloth::Impl::measure_paths(Sheet& s) {
  s.paths_stale = false;
  s.bend_step = -1;
  constexpr std::uint32_t kFar = kNone;
  std::vector<std::uint32_t> rows_to(s.points, kFar), queue;
  std::vector<Real> path_to(s.points, 0);
  for (std::uint32_t i = 0; i < s.points; ++i)
    if (vertices.inv_mass[s.first + i] == 0) queue.push_back(i);
  s.any_pin = !queue.empty();
  for (const Attachment& a : attachments)
    if (a.vertex >= s.first && a.vertex < s.first + s.points) queue.push_back(a.vertex - s.first), s.any_pin = true;
  // a free sheet: from the vertex nearest to its middle
  const Vec3* rest = vertices.rest.data() + s.first;
  if (queue.empty()) {
    Vec3 middle = Vec3::Zero();
    for (std::uint32_t i = 0; i < s.points; ++i) middle += rest[i] / static_cast<Real>(s.points);
    std::uint32_t nearest = 0;
    for (std::uint32_t i = 1; i < s.points; ++i)
      if (length(rest[i] - middle) < length(rest[nearest] - middle)) nearest = i;
    queue.push_back(nearest);
  }
  for (const std::uint32_t i : queue) rows_to[i] = 0;

  const Incidence links(s.points, [&](auto&& f) {
    for (std::uint32_t k = 0; k < s.mesh.links.size(); ++k)
      if (const ClothLink& l = s.mesh.links[k]; !l.shear) f(l.a, k), f(l.b, k);
  });
  // the queue is in the order of rows_to
  const auto size = [&](const ClothLink& l) { return length(rest[l.b] - rest[l.a]); };  // before any flow
  s.rows = 1, s.path = size(s.mesh.links[0]);
  for (std::size_t q = 0; q < queue.size(); ++q) {
    const std::uint32_t i = queue[q];
    if (static_cast<Real>(rows_to[i]) > s.rows) s.rows = static_cast<Real>(rows_to[i]), s.path = path_to[i];
    for (const std::uint32_t k : links.of(i)) {
      const ClothLink& l = s.mesh.links[k];
      const std::uint32_t j = l.a == i ? l.b : l.a;
      if (rows_to[j] != kFar) continue;
      rows_to[j] = rows_to[i] + 1, path_to[j] = path_to[i] + size(l);
      queue.push_back(j);
    }
  }
}

// Deceleration that stops or turns the cloth's own motion within its length, m/s^2: the variance of its velocity over
// the path.
double Cloth::Impl::swing(const Sheet& s) const {
  Vec3 mean = Vec3::Zero();
  double square = 0;
  for (std::uint32_t i = s.first; i < s.first + s.points; ++i) {
    const Vec3& u = vertices.velocity[i];
    mean += vertices.mass[i] * u;
    square += double(vertices.mass[i]) * double(dot(u, u));
  }
  mean /= s.mass;
  return std::fmax(square / double(s.mass) - (s.any_pin ? 0 : double(dot(mean, mean))), 0) / double(s.path);
}

// Solver substeps by the stretch law and by the solver's own need, up to the cap. With hysteresis (kStay), so that
// contacts and sweeps work alike from step to step.
void Cloth::Impl::choose_steps(StepContext& c) {
  for (auto& p : sheets) {
    Sheet& s = *p;
    if (!s.active()) continue;
    if (s.paths_stale) measure_paths(s), make_ties(s);
    if (s.settings.substeps > 0) {
      s.state.substeps = s.settings.substeps, s.lacking = 1;
    } else {
      if (const bool framed = pins_apart(s) > kFramed; framed != s.framed) s.framed = framed, s.bend_step = -1;
      if (s.bend_step != c.h) s.bend_step = c.h, s.bend_substeps = s.solver->wanted_substeps(view(s), c.h);
      double wanted = s.bend_substeps, unladen = wanted;
      const bool sheds = s.solver->sheds_strain();
      if (sheds || s.solver->converges()) {
        const Real weight = length(c.gravity) * std::fabs(s.settings.gravity_scale);
        const double own = double(std::max({weight, s.state.pull, kMinGravity})), load = double(s.state.load / s.mass);
        const double g = (sheds ? own + swing(s) : 0) + double(s.impact);
        const double n = s.rows, h = c.h, law = h * n * std::sqrt(2 / (stretch_error(s) * double(s.path)));
        unladen = std::fmax(unladen, law * std::sqrt(g));
        wanted = std::fmax(wanted, law * std::sqrt(g + own * load));
      }
      if (s.settings.pressure != 0) wanted = std::fmax(wanted, gas_substeps(s, c.h));
      // the cap of the settings, with a warning
      const double cap = std::fmax(most_substeps(s, unladen), s.solver->least_cap());
      if (wanted > cap && !s.state.warned) {
        s.state.warned = 1;
        c.events->warn("substep_cap",
                       objects.describe(s.object) + " would need " +
                           std::to_string(static_cast<long long>(std::ceil(std::fmin(wanted, 1e15)))) +
                           " solver substeps per substep, its max_substeps is " +
                           std::to_string(static_cast<int>(cap)) + ": it " + s.solver->beyond_cap() +
                           cap_cure(s, wanted, cap),
                       s.object);
      }
      s.lacking = static_cast<Real>(std::fmax(wanted / cap, 1));
      if (wanted > cap) wanted = s.solver->substeps_beyond(cap);
      const std::int32_t count = static_cast<std::int32_t>(std::ceil(std::fmax(1.0, std::fmin(wanted, cap))));
      const bool fewer = count < s.state.substeps;
      const bool stays = fewer && static_cast<double>(count) > kStay * s.state.substeps;
      if (!stays || s.state.fresh || s.state.substeps > cap) s.state.substeps = count;
    }
    FEDER_ASSERT(s.state.substeps >= 1);
  }
}

void Cloth::Impl::check_damping(Sheet& s, StepContext& c) {
  const double longest = s.solver->longest_damping(c.h), asked = s.settings.damping;
  if (asked <= longest || s.state.warned_damping) return;
  s.state.warned_damping = 1;
  c.events->warn("damping_cap",
                 objects.describe(s.object) + ": damping of " + std::to_string(asked) + " s acts on bending as " +
                     std::to_string(longest) + " s: softer or coarser cloth, or more substeps, take more",
                 s.object);
}

void Cloth::Impl::check_shortfall(Sheet& s, StepContext& c) {
  if (s.state.warned_shortfall) return;
  const std::string what = s.solver->shortfall();
  if (what.empty()) return;
  s.state.warned_shortfall = 1;
  c.events->warn("unconverged", objects.describe(s.object) + ": " + s.solver_name + " " + what, s.object);
}

void Cloth::Impl::prepare_solver(Sheet& s, StepContext& c) {
  if (s.paths_stale) measure_paths(s), make_ties(s);
  place_ties(s);
  s.solver->prepare(view(s), c);
  s.prepared = true;
}

// Work arrays of the step: displacements start at zero. A sleeping or frozen cloth has infinite mass.
void Cloth::Impl::gather(Sheet& s, Real h) {
  const Vec3 lead = s.solver->lead(h) * h * s.flight();
  for (std::uint32_t i = s.first; i < s.first + s.total; ++i) {
    const Real w = s.active() ? vertices.inv_mass[i] : Real(0);
    const Vec3 u = w != 0 ? Vec3(vertices.velocity[i] - lead) : Vec3(0, 0, 0);
    delta_position[i] = {0, 0, 0, w};
    velocity[i] = {u[0], u[1], u[2], w};
  }
}

void Cloth::Impl::prepare(StepContext& c) {
  FEDER_ASSERT(c.h > 0 && c.h <= c.dt);
  drain_wakes();
  const std::uint32_t first = surfaces.claim(vertices.size());
  FEDER_ASSERT(first == 0 && surfaces.list.empty());  // vertices are the first points
  acceleration.resize(vertices.size());
  // wakes by gravity
  any_active = false;
  if (gravity_known && gravity != c.gravity)
    for (auto& s : sheets) wake(*s, WakeCause::force, {});
  gravity = c.gravity, gravity_known = true;
  for (auto& s : sheets) {
    any_active = any_active || s->active();
    if (s->active()) put_back(*s, c);
    if (s->settings.pressure != 0 && s->active()) check_pressure(*s, c);
    s->bad_vertex = kNone;
    s->prepared = false, s->gusty = true;
    if (s->kinetic < 0) s->kinetic = kinetic_energy(*s);
    s->kinetic_before = s->kinetic;
    for (ClothGhost& g : s->mesh.ghosts) {
      Vec3* x = vertices.position.data() + s->first;
      if (s->state.fresh) g.offset = x[g.vertex] - x[g.clamped];
      x[g.vertex] = x[g.clamped] + g.offset;
    }
    for (std::uint32_t i = s->first; i < s->first + s->total; ++i)
      delta_position[i].w = s->active() ? vertices.inv_mass[i] : Real(0);
  }
  warn_of_coincident(c);
  // what contact and couplings see of the cloths
  std::copy(vertices.position.begin(), vertices.position.end(), surfaces.position.begin());
  std::copy(vertices.mass.begin(), vertices.mass.end(), surfaces.mass.begin());
  for (const Attachment& a : attachments) surfaces.anchors.push_back({objects.index(a.cloth), a.vertex, a.body});
  if (any_active) choose_steps(c);
  for (auto& s : sheets) {
    show(*s);
    if (!any_active) continue;
    if (s->active() && s->state.fresh) {
      s->state.fresh = 0;
      if (!s->any_pin) s->set_flight(c.gravity * s->settings.gravity_scale);
    }
    if (s->active()) {
      prepare_solver(*s, c);
      check_damping(*s, c);
    }
    gather(*s, c.h / static_cast<Real>(s->state.substeps));
  }
}

void Cloth::Impl::declare_surfaces() {
  const auto self = [](const auto& s) { return s->settings.self_collision != 0; };
  surfaces.declare(
      {kName, static_cast<std::uint32_t>(sheets.size()), true, std::any_of(sheets.begin(), sheets.end(), self), true});
}

// The surface of a cloth in this step.
void Cloth::Impl::show(const Sheet& s) {
  Surface f;
  f.object = s.object;
  f.first = s.first, f.count = s.points, f.total = s.total;
  f.triangles = {s.mesh.triangles.data(), s.mesh.triangles.size()};
  static_assert(sizeof(ClothEdge) % sizeof(std::uint32_t) == 0 && offsetof(ClothEdge, b) == sizeof(std::uint32_t));
  f.edges = {s.mesh.edges.empty() ? nullptr : &s.mesh.edges[0].a, sizeof(ClothEdge) / sizeof(std::uint32_t),
             static_cast<std::uint32_t>(s.mesh.edges.size())};
  f.borders = s.mesh.edges.empty() ? nullptr : &s.mesh.edges[0].triangle[1];
  f.version = s.version;
  f.rest = vertices.rest.data() + s.first;
  f.thickness = s.settings.thickness, f.friction = s.settings.friction, f.wakes = kClothCause;
  f.relaxation = s.solver->relaxation();
  f.group = s.settings.group, f.mask = s.settings.mask;
  Real fastest = 0;
  for (std::uint32_t i = s.first; s.active() && i < s.first + s.points; ++i)
    fastest = std::max(fastest, dot(vertices.velocity[i], vertices.velocity[i]));
  f.fastest = std::sqrt(fastest), f.approach_speed = s.approach_speed;
  f.steps = s.state.substeps;
  f.self = s.settings.self_collision != 0;
  f.search = s.search;
  if (f.self) show_tangles(s, f);
  f.active = s.active(), f.sleep_candidate = s.state.sleep_steps != 0, f.pinned = s.any_pin;
  surfaces.list.push_back(f);
}

// Gathers again where the group chose another number of solver substeps: the lead of velocities depends on h.
void Cloth::Impl::gather_again(StepContext& c) {
  FEDER_ASSERT(surfaces.list.size() >= sheets.size() && c.h > 0);
  for (std::size_t n = 0; n < sheets.size(); ++n) {
    const SurfaceGroup& g = group_of(*sheets[n]);
    if (sheets[n]->active() && g.steps != sheets[n]->state.substeps) gather(*sheets[n], g.step);
  }
}

void Cloth::Impl::begin_substep(StepContext& c) {
  drain_wakes();
  if (any_active) add_forces(c);
}

// Error of angular momentum. A link pushes along its direction at the end of the solver substep, which is a torque
// about positions at its start: a free sheet that is bent fast would start to turn. Displacements d become velocities
// d/h, so a sweep changes angular momentum by sum m x0 cross d/h, x0 at the start of the solver substep. It is summed
// here, and taken out once per substep.
void Cloth::Impl::measure_gained_momentum(Sheet& s, Real h) {
  Double3 gained{0, 0, 0};  // kg m^2
  const Vec3 near =
      vertices.position[s.first] + before[s.first].vec();  // any reference point: a sweep keeps linear momentum
  for (std::uint32_t i = s.first; i < s.first + s.points; ++i) {
    const Vec3 r = vertices.position[i] + before[i].vec() - near;
    const Vec3 change = delta_position[i].vec() - before[i].vec() - h * velocity[i].vec();
    gained = gained + double(vertices.mass[i]) * cross(wide(r), wide(change));
  }
  s.gained_momentum += narrow((1 / double(h)) * gained);
}

// Takes the error out as a rotation of the whole about its centre of mass.
void Cloth::Impl::remove_gained_momentum(Sheet& s) {
  const Vec3 gained_momentum = s.gained_momentum;
  s.gained_momentum = Vec3::Zero();
  const Vec3 near = current_position(s.first);
  take_out_spin(
      gained_momentum, s.points, s.mass, 0, [&](std::uint32_t i) { return vertices.mass[s.first + i]; },
      [&](std::uint32_t i) { return Vec3(current_position(s.first + i) - near); },
      [&](std::uint32_t i, const Vec3& change) { velocity[s.first + i].add(change); });
}

void Cloth::Impl::advance(StepContext& c) {
  const SurfaceGroup& g = group(c);
  const double start = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  each_active(g, [&](Sheet& s) {
    surfaces.row_updates += s.mesh.links.size() + s.mesh.hinges.size();
    if (!s.prepared) prepare_solver(s, c);  // woken by a coupling in this step: held until its end
    ClothView v = view(s);
    v.crowded = g.crowded;
    const bool carries = s.solver->carries_bodies() && !g.attachments.empty();
    if (carries) carry_bodies(s, g, v);
    const bool inflated = s.gas.pressure != 0;
    if (inflated) push_gas(s, g.step);
    s.solver->advance(v, start + c.inner.index * static_cast<double>(g.step), g.step, c);
    if (inflated && !s.any_pin && before[s.first].w == 0) keep_momentum(s, g.step);
    if (carries) hand_over(s, g);
    if (!s.any_pin && before[s.first].w == 0) measure_gained_momentum(s, g.step);
  });
}

void Cloth::Impl::read_velocities(StepContext& c) {
  const SurfaceGroup& g = group(c);
  each_active(g, [&](const Sheet& s) {
    FEDER_ASSERT(delta_position[s.first + s.total - 1].vec().isZero(0));  // the spare vertex of empty lanes
    c.jobs->for_blocks(s.total, kVertexGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = s.first + first; i < s.first + last; ++i) {
        FEDER_ASSERT(before[i].w == 0 || before[i].w == 1);
        // four numbers at once: a division for each would be the dearest thing here
        const Wide4 u = (wide4(delta_position[i]) - wide4(before[i])) / g.step;
        const Real inv_mass = velocity[i].w;
        put4(velocity[i], before[i].w != 0 ? wide4(velocity[i]) + u : u);
        velocity[i].w = inv_mass;
      }
    });
  });
}

void Cloth::Impl::damp(StepContext& c) {
  if (!c.inner.last()) return;
  each_active(group(c), [&](Sheet& s) {
    if (!s.gained_momentum.isZero(0)) remove_gained_momentum(s);
    s.solver->damp(view(s), c.h, c);
  });
}

// Wakes that contact asked for: something moves against a sleeper, or an object it lay on is gone.
void Cloth::Impl::drain_wakes() {
  for (const Surfaces::Wake& w : surfaces.wakes)
    if (objects.alive(w.object) && objects.kind(w.object) == kClothKind) wake(sheet(w.object), w.cause, w.other);
  std::erase_if(surfaces.wakes, [&](const Surfaces::Wake& w) {
    return !objects.alive(w.object) || objects.kind(w.object) == kClothKind;
  });
}

void Cloth::Impl::wake_touched(StepContext&) {
  drain_wakes();
  for (auto& s : sheets)
    if (!s->state.asleep) s->state.load = 0;  // couplings set it again, for the next step
}

void Cloth::Impl::commit(StepContext& c) {
  if (any_active) {
    for (auto& s : sheets) {
      s->impact = s->approach_speed = 0;
      s->beside_body = false;
      s->set_flight(s->active() && !s->any_pin ? Vec3(c.gravity * s->settings.gravity_scale) : Vec3(0, 0, 0));
    }
    // displacements become positions, unless one is not finite
    for (auto& s : sheets) {
      if (!s->active()) continue;
      check_shortfall(*s, c);
      const Real h = group_of(*s).step;
      const Vec3 lead = s->solver->lead(h) * h * s->flight();
      for (std::uint32_t i = s->first; i < s->first + s->points; ++i) {
        if (vertices.inv_mass[i] == 0) continue;
        const Vec3 x = vertices.position[i] + delta_position[i].vec(), v = velocity[i].vec() + lead;
        if (!is_finite(x) || !is_finite(v)) {
          s->bad_vertex = i - s->first;
          break;
        }
      }
      if (s->bad_vertex != kNone) continue;
      for (std::uint32_t i = s->first; i < s->first + s->points; ++i) {
        if (vertices.inv_mass[i] == 0) continue;
        vertices.position[i] += delta_position[i].vec();
        vertices.velocity[i] = velocity[i].vec() + lead;
      }
    }
    read_tangles(c);
    watch(c);
    quarantine(c);
    flow(c);
    tear(c);
  }
  update_sleep(c);
}

// Quarantine: a cloth with a non-finite vertex is frozen where the step began.
void Cloth::Impl::quarantine(StepContext& c) {
  std::string message;
  ObjectId object;
  for (auto& s : sheets) {
    if (s->bad_vertex == kNone || s->state.frozen) continue;
    FEDER_ASSERT(s->bad_vertex < s->points);
    s->state.frozen = 1;
    suspect(*s);
    for (std::uint32_t i = s->first; i < s->first + s->points; ++i)
      vertices.velocity[i] = Vec3::Zero(), vertices.inv_mass[i] = 0;
    message += (message.empty() ? "" : "; ") + objects.describe(s->object) + " vertex " +
               std::to_string(s->bad_vertex + 1) + " went non-finite: the cloth is held where it was";
    if (!object) object = s->object;
  }
  if (!message.empty()) c.events->warn("non_finite", message, object);
}

}  // namespace feder
