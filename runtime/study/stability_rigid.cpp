// Stability maps of bodies, run by every rigid solver: what happens when the step, the speed, the masses, the sizes or
// the position of a scene leave the usual (axes of stability.h). Each scene ends where it is known: at rest in its
// place, or before the wall.
#include "study/stability_rigid.h"

#include <algorithm>
#include <cmath>

#include "feder/query.h"
#include "rigid/solver.h"
#include "state/bodies.h"

namespace feder {

const StabilityAxis& rigid_step_axis() {
  static const StabilityAxis axis = {
      "h", "step h", "s", true, {1e-3, 3e-3, 1e-2, 1.0 / 60, 3e-2, 0.1, 0.3}, {1e-2, 1.0 / 60, 0.1}};
  return axis;
}

namespace {

BodyDesc box(double width, double height, double depth, const Vec3d& at, double mass) {
  BodyDesc d;
  d.shape = make_box(static_cast<Real>(width), static_cast<Real>(height), static_cast<Real>(depth));
  d.position = at.cast<Real>();
  if (mass > 0)
    d.mass = static_cast<Real>(mass);
  else
    d.type = BodyType::fixed;
  return d;
}

// Boxes on each other on the ground, from below: they should just stand.
void add_pile(RigidScene& s, const std::vector<double>& edges, const std::vector<double>& masses, double x) {
  s.bodies.push_back(box(20, 1, 20, Vec3d(x, -0.5, 0), 0));
  double height = 0;
  s.size = 1e300, s.energy = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double e = edges[i];
    const Vec3d at(x, height + e / 2, 0);
    s.watched.push_back(s.bodies.size()), s.expected.push_back(at.cast<Real>().cast<double>());
    s.bodies.push_back(box(e, e, e, at, masses[i]));
    height += e, s.size = std::min(s.size, e);
    s.energy += masses[i] * s.gravity * e;
  }
  s.length = s.size, s.speed = std::sqrt(2 * s.gravity * height);
}

RigidScene stack(double h, double count) {
  RigidScene s;
  s.h = h, s.seconds = 3;
  add_pile(s, std::vector<double>(static_cast<std::size_t>(count), 1.0),
           std::vector<double>(static_cast<std::size_t>(count), 1.0), 0);
  return s;
}

RigidScene heavy(double h, double ratio) {
  RigidScene s;
  s.h = h;
  add_pile(s, {1, 1}, {1, ratio}, 0);
  return s;
}

RigidScene small(double h, double ratio) {
  RigidScene s;
  s.h = h;
  const double edge = 1 / ratio;
  add_pile(s, {1, edge}, {1000, 1000 * edge * edge * edge}, 0);
  return s;
}

// Beside the pile a box slides 6 m without friction: rest alone would hide that positions are coarse out there.
RigidScene far(double h, double distance) {
  constexpr double kSpeed = 3, kStart = -5;  // m/s, m
  RigidScene s;
  s.h = h;
  add_pile(s, {1, 1}, {1, 1}, distance);
  BodyDesc slider = box(1, 1, 1, Vec3d(distance + kStart, 0.5, 5), 1);
  slider.velocity = Vec3(static_cast<Real>(kSpeed), 0, 0);
  slider.friction_static = slider.friction_dynamic = 0;
  s.watched.push_back(s.bodies.size());
  const double steps = std::max(8.0, std::ceil(s.seconds / h - 1e-9));
  s.expected.push_back(slider.position.cast<double>() + Vec3d(kSpeed * steps * h, 0, 0));
  s.energy += 0.5 * kSpeed * kSpeed;
  s.bodies.push_back(slider);
  return s;
}

RigidScene bullet(double speed, double wall) {
  constexpr double kRadius = 0.05, kPath = 1;  // m
  RigidScene s;
  s.gravity = 0, s.speed = speed, s.energy = 0.5 * speed * speed;
  s.seconds = std::max(0.5, 2 * kPath / speed);
  s.length = kPath, s.size = 2 * kRadius;
  s.bodies.push_back(box(wall, 4, 4, Vec3d(kPath + wall / 2, 0, 0), 0));
  BodyDesc d;
  d.shape = make_sphere(static_cast<Real>(kRadius)), d.mass = 1, d.bullet = true;
  d.velocity = Vec3(static_cast<Real>(speed), 0, 0);
  s.bodies.push_back(d);
  s.watched = {1}, s.expected = {Vec3d(kPath - kRadius, 0, 0)};
  return s;
}

// About the axis of the largest inertia, a hundredth off.
RigidScene spin(double h, double rate) {
  RigidScene s;
  s.h = h, s.gravity = 0, s.keeps_energy = true, s.speed = rate;
  BodyDesc d = box(1, 0.2, 0.5, Vec3d(0, 0, 0), 1);
  d.angular_velocity = Vec3(static_cast<Real>(0.01 * rate), static_cast<Real>(rate), 0);
  s.bodies = {d};
  s.energy = s.energy_start = 0.5 * rate * rate * ((1 + 0.25) / 12 + 1e-4 * (0.04 + 0.25) / 12);
  s.watched = {0}, s.expected = {Vec3d(0, 0, 0)};
  return s;
}

// Crates made in place on two ramps: one with 2 % more static friction than the slope needs stays, one with 25 % less
// slides with the dynamic one.
RigidScene friction(double degrees, double ratio) {
  RigidScene s;
  s.seconds = 1;
  const double angle = degrees * std::acos(-1.0) / 180, slope = std::tan(angle);
  const Quat tilt = from_axis_angle(Vec3(0, 0, 1), static_cast<Real>(-angle));
  const Vec3d up(std::sin(angle), std::cos(angle), 0), down(std::cos(angle), -std::sin(angle), 0);
  const double seconds = std::ceil(s.seconds / s.h - 1e-9) * s.h;
  for (const double share : {1.02, 0.75}) {
    const Vec3d at(0, 0, share > 1 ? 0 : 5);
    const double path =
        share > 1 ? 0 : s.gravity * (std::sin(angle) - ratio * share * slope * std::cos(angle)) * seconds * seconds / 2;
    for (BodyDesc d : {box(40, 1, 2, at - 0.5 * up, 0), box(1, 0.5, 1, at + 0.25 * up, 1)}) {
      d.rotation = tilt;
      d.friction_static = static_cast<Real>(share * slope);
      d.friction_dynamic = static_cast<Real>(ratio * share * slope);
      s.bodies.push_back(d);
    }
    s.watched.push_back(s.bodies.size() - 1);
    s.expected.push_back(at + 0.25 * up + path * down);
  }
  s.length = 1, s.size = 0.5, s.energy = s.gravity;
  s.speed = s.gravity * seconds;
  return s;
}

std::vector<RigidMap> maps() {
  std::vector<RigidMap> all = {
      {{"stack",
        "boxes on each other for 3 s",
        rigid_step_axis(),
        {"boxes", "boxes", "", true, {1, 2, 5, 10, 20, 40}, {1, 10}}},
       &stack},
      {{"heavy",
        "a box on a lighter one",
        rigid_step_axis(),
        {"ratio", "mass ratio", "", true, {1, 10, 100, 1e3, 1e4, 1e6}, {1, 100, 1e6}}},
       &heavy},
      {{"size",
        "a box on one of 1 m",
        rigid_step_axis(),
        {"ratio", "size ratio", "", true, {1, 10, 100, 1e3, 1e4}, {1, 100, 1e4}}},
       &small},
      {{"far",
        "two boxes on each other and one that slides, away from the origin",
        rigid_step_axis(),
        {"distance", "distance from the origin", "m", true, {1, 10, 100, 1e3, 1e4, 1e5, 1e6, 1e7}, {1, 1e4, 1e7}}},
       &far},
      {{"bullet",
        "a ball of 0.1 m, marked as bullet, against a wall",
        {"speed", "speed", "m/s", true, {1, 3, 10, 30, 100, 300, 1e3, 3e3, 1e4}, {1, 100, 1e4}},
        {"wall", "thickness of the wall", "m", true, {0.01, 0.1, 1}, {0.01, 1}}},
       &bullet},
      {{"spin",
        "a weightless box spins about its axis of largest inertia",
        rigid_step_axis(),
        {"spin", "spin", "rad/s", true, {1, 10, 100, 1e3, 1e4}, {1, 100, 1e4}}},
       &spin},
      {{"friction",
        "crates on slopes with friction 2 % above and 25 % below what holds, 60 steps/s",
        {"slope", "slope", "deg", false, {5, 10, 20, 30, 40}, {5, 40}},
        {"ratio", "dynamic by static friction", "", false, {0, 0.1, 0.25, 0.5, 0.9, 1}, {0, 0.25, 1}}},
       &friction}};
  for (RigidMap& map : joint_stability_maps()) all.push_back(std::move(map));
  return all;
}

struct RigidTrial {
  RigidTrial(const RigidScene& s, const std::string& solver) : world(describe(s, solver), catalog()) {
    for (const BodyDesc& d : s.bodies) ids.push_back(rigid().add_body(d));
    for (const RigidScene::Joint& j : s.joints) {
      JointDesc d = j.joint;
      if (j.a != RigidScene::kNoBody) d.a = ids[j.a];
      if (j.b != RigidScene::kNoBody) d.b = ids[j.b];
      rigid().add_joint(d);
    }
  }
  static WorldDesc describe(const RigidScene& s, const std::string& solver) {
    WorldDesc d = awake_world(s.gravity, s.h);
    d.systems["rigid"].set("solver", solver);
    return d;
  }
  static Catalog catalog() {
    static const SystemDescriptor* const systems[] = {&Collide::descriptor(), &Rigid::descriptor()};
    return systems;
  }
  Rigid& rigid() { return world.need<Rigid>(); }
  // Largest penetration or error of a joint, m.
  double constraint() {
    const double deepest = std::max(0.0, static_cast<double>(world.need<Collide>().max_penetration()));
    return std::max(deepest, static_cast<double>(rigid().max_joint_error()));
  }
  Vec3d position(std::size_t body) { return rigid().bodies().position[rigid().index(ids[body])].cast<double>(); }
  Vec3d velocity(std::size_t body) { return rigid().bodies().velocity[rigid().index(ids[body])].cast<double>(); }
  bool finite(std::size_t body) {
    return rigid().finite() && std::isfinite(position(body).norm()) && std::isfinite(velocity(body).norm());
  }

  World world;
  std::vector<ObjectId> ids;
};

// Fills verdict, time and entity when a watched body is non-finite or gone.
bool failed(RigidTrial& t, const RigidScene& s, const StabilityThresholds& limits, double energy, StabilityCell& cell) {
  for (std::size_t i = 0; i < s.watched.size(); ++i) {
    const std::size_t body = s.watched[i];
    const bool finite = t.finite(body);
    const double error = (t.position(body) - s.expected[i]).norm(), scene = std::max(s.length, s.expected[i].norm());
    if (finite && error <= limits.far * scene && t.velocity(body).norm() <= limits.fast * s.speed &&
        energy <= limits.energy * s.energy)
      continue;
    cell.verdict = finite ? Verdict::diverged : Verdict::nan;
    cell.t_fail = t.world.time();
    cell.entity = failed_entity(t.world, t.world.objects().describe(t.ids[body]));
    return true;
  }
  return false;
}

// Errors at the end, and how far the bodies went against how far they should.
void measure_ends(RigidTrial& t, const RigidScene& s, const std::vector<Vec3d>& start, StabilityTrace& trace,
                  StabilityCell& cell) {
  cell.error = 0;
  for (std::size_t i = 0; i < s.watched.size(); ++i) {
    const Vec3d at = t.position(s.watched[i]);
    cell.error = std::max(cell.error, (at - s.expected[i]).norm() / s.length);
    const double path = (s.expected[i] - start[i]).norm();
    if (path > trace.reference_displacement)
      trace.reference_displacement = path, trace.displacement = (at - start[i]).norm();
  }
}

void run_rigid(const RigidScene& s, const std::string& method, const StabilityThresholds& limits, StabilityCell& cell) {
  RigidTrial t(s, method);
  StabilityTrace trace;
  // what grows, grows beside the scale
  const double zero = s.keeps_energy ? -s.energy_zero : total_energy(t.world) - s.energy;
  std::vector<Vec3d> start;
  for (const std::size_t body : s.watched) start.push_back(t.position(body));
  const int steps = std::max(8, static_cast<int>(std::ceil(s.seconds / s.h - 1e-9)));
  double most = 0;
  bool gone = false;
  for (int k = 0; k < steps && !gone; ++k) {
    t.world.step();
    const double energy = total_energy(t.world) - zero;
    most = std::max(most, energy);
    trace.energy.push_back(energy);
    if (s.keeps_energy) trace.exact_energy.push_back(s.energy_start);
    gone = failed(t, s, limits, energy, cell);
  }
  cell.energy_ratio = most / s.energy;
  if (gone) return;
  if (s.known) measure_ends(t, s, start, trace, cell);
  cell.constraint = t.constraint() / s.size;
  StabilityThresholds own = limits;
  own.constraint = limits.penetration;
  cell.verdict = verdict_of(trace, s.length, s.energy, own, cell);
}

}  // namespace

StabilityProblems rigid_stability() {
  StabilityProblems all;
  for (const RigidMap& map : maps())
    all.push_back(stability_table(
        "rigid", map.info, solver_methods(rigid_solvers()),
        [scene = map.scene](const std::string& method, double x, double y, const StabilityThresholds& limits) {
          return checked_cell(x, y, [&](StabilityCell& cell) { run_rigid(scene(x, y), method, limits, cell); });
        }));
  return all;
}

}  // namespace feder
