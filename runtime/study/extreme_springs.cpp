// Extreme inputs of nets and of worlds: descriptions that must be refused, springs without length or stretched a
// hundredfold, masses of 1e6 kg, steps that change a thousandfold.
#include <cmath>

#include "integrate/integrator.h"
#include "integrate/limits.h"
#include "study/extreme.h"
#include "study/worlds.h"

namespace feder {
namespace {

WorldDesc weightless(double dt = 1.0 / 60) { return awake_world(0, dt, 1); }

NetDesc pair_net() {
  NetDesc d;
  d.name = "pair";
  d.points = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
  d.masses = {1, 1};
  d.springs = {{0, 1, 100, 0, 1, kInfinity}};
  return d;
}

// A net that must be refused, beside one that lives on.
ExtremeOutcome refused_net(const char* word, void (*spoil)(NetDesc&)) {
  World w(weightless(), net_catalog());
  w.need<Springs>().add_net(pair_net());
  NetDesc d = pair_net();
  spoil(d);
  return expect_refusal(
      word, [&] { w.need<Springs>().add_net(d); }, [&] { return w.hash(); });
}

ExtremeOutcome refused_world(const char* word, void (*spoil)(WorldDesc&)) {
  WorldDesc d;
  spoil(d);
  return expect_refusal(
      word, [&] { World w(d, net_catalog()); }, [] { return std::uint64_t{0}; });
}

bool finite_net(World& w, ObjectId net) { return w.is_finite() && !w.need<Springs>().quarantined(net); }

// Two points at one place pushed apart along x by a fixed rule; they must part and swing, not hang or fly off.
ExtremeOutcome same_place() {
  World w(weightless(1.0 / 240), net_catalog());
  NetDesc d = pair_net();
  d.points[1] = d.points[0];
  const ObjectId net = w.need<Springs>().add_net(d);
  double most = 0;
  for (int k = 0; k < 480; ++k) {
    w.step();
    most =
        std::max(most, static_cast<double>(length(w.need<Springs>().point(net, 1) - w.need<Springs>().point(net, 0))));
  }
  const bool good = finite_net(w, net) && most > 1.5 && most < 2.2;
  return outcome_of(good, Verdict::stuck, labelled("largest distance, m", most));
}

// f = k x: 1 m out, the amplitude stays.
ExtremeOutcome zero_length() {
  World w(weightless(1.0 / 240), net_catalog());
  NetDesc d = pair_net();
  d.springs[0].rest_length = 0;
  d.integrator = "velocity_verlet";
  const ObjectId net = w.need<Springs>().add_net(d);
  w.need<Springs>().pin(net, 0);
  double most = 0;
  for (int k = 0; k < 4800; ++k) {
    w.step();
    if (k >= 4300) most = std::max(most, std::fabs(static_cast<double>(w.need<Springs>().point(net, 1)[0])));
  }
  const bool good = finite_net(w, net) && std::fabs(most - 1) < 0.01;
  return outcome_of(good, Verdict::growing, labelled("amplitude after 20 s, m", most));
}

ExtremeOutcome stretched_hundredfold() {
  World w(weightless(), net_catalog());
  NetDesc d = pair_net();
  d.springs[0].rest_length = Real(0.01);
  d.springs[0].stiffness = 1e6;
  d.springs[0].damping = 10;
  d.integrator = "tr_bdf2";
  const ObjectId net = w.need<Springs>().add_net(d);
  const double start = w.energy().elastic;
  double most = 0;
  for (int k = 0; k < 300; ++k) {
    w.step();
    most = std::max(most, w.energy().elastic + w.energy().kinetic);
  }
  const bool good = finite_net(w, net) && most <= 1.001 * start;
  return outcome_of(good, Verdict::growing, labelled("largest energy by that of the start", most / start));
}

// 1000 links of 0.1 m with 1e6 kg at the end: the first spring carries everything.
ExtremeOutcome heavy_long_chain() {
  World w(awake_world(9.81, 1.0 / 60, 1), net_catalog());
  NetDesc d;
  d.name = "chain";
  constexpr std::uint32_t kLinks = 1000;
  double mass = 0;
  for (std::uint32_t i = 0; i <= kLinks; ++i) {
    d.points.push_back(Vec3(0, Real(-0.1) * static_cast<Real>(i), 0));
    d.masses.push_back(i == kLinks ? Real(1e6) : Real(1));
    if (i > 0)
      d.springs.push_back({i - 1, i, Real(1e9), 0, Real(0.1), kInfinity}), mass += static_cast<double>(d.masses[i]);
  }
  d.damping = 2;
  d.integrator = "implicit_euler";
  const ObjectId net = w.need<Springs>().add_net(d);
  w.need<Springs>().pin(net, 0);
  for (int k = 0; k < 1200; ++k) w.step();
  const double tension = 1e9 * static_cast<double>(w.need<Springs>().strain(net, 0)) * 0.1, wanted = mass * 9.81;
  const bool good = finite_net(w, net) && std::fabs(tension / wanted - 1) < 0.01;
  return outcome_of(good, Verdict::inaccurate, labelled("tension by the weight below", tension / wanted));
}

// h from 1e-4 to 1e-1 in the middle of a run, for every method without a limit.
ExtremeOutcome step_change() {
  ExtremeOutcome out{true, Verdict::stable, ""};
  for (const Variant<Integrator>& row : integrators()) {
    Arena arena("extreme");
    const auto m = row.make(arena, Params());
    if (!std::isinf(m->info().stability_limit)) continue;
    Oscillator field(100, 0);
    Vec3 x(1, 0, 0), v(0, 0, 0);
    for (int k = 0; k < 100; ++k) m->step(field, 0, Real(1e-4), {&x, 1}, {&v, 1});
    const double before = 1e4 * static_cast<double>(dot(x, x)) + static_cast<double>(dot(v, v));
    double most = 0;
    for (int k = 0; k < 200; ++k) {
      m->step(field, 0, Real(1e-1), {&x, 1}, {&v, 1});
      most = std::max(most, 1e4 * static_cast<double>(dot(x, x)) + static_cast<double>(dot(v, v)));
    }
    if (most <= 1.01 * before) continue;
    out = {false, Verdict::growing, std::string(row.name) + " " + labelled("energy by that before", most / before)};
  }
  return out;
}

ExtremeOutcome tiny_velocities() {
  World w(weightless(), net_catalog());
  NetDesc d = pair_net();
  d.velocities = {Vec3(0, std::numeric_limits<Real>::denorm_min(), 0),
                  Vec3(0, 0, std::numeric_limits<Real>::min() / 3)};
  const ObjectId net = w.need<Springs>().add_net(d);
  for (int k = 0; k < 600; ++k) w.step();
  const double far = static_cast<double>(length(w.need<Springs>().point(net, 1) - Vec3(1, 0, 0)));
  const bool good = finite_net(w, net) && far < 1e-6;
  return outcome_of(good, Verdict::growing, labelled("moved, m", far));
}

ExtremeOutcome many_steps() {
  World w(weightless(), net_catalog());
  constexpr int kSteps = 10000000;
  for (int k = 0; k < kSteps; ++k) w.step();
  const double error = std::fabs(w.time() * 60 / kSteps - 1);
  return {error < 1e-9 && w.step_count() == kSteps, error < 1e-9 ? Verdict::stable : Verdict::inaccurate,
          labelled("relative error of the time", error)};
}

constexpr RefusalRow<NetDesc> kRefusedNets[] = {
    {"mass 0", "refused, masses named", "masses[2]", [](NetDesc& d) { d.masses[1] = 0; }},
    {"mass -1", "refused, masses named", "masses[1]", [](NetDesc& d) { d.masses[0] = -1; }},
    {"mass NaN", "refused, masses named", "masses[1]", [](NetDesc& d) { d.masses[0] = kNan; }},
    {"position NaN", "refused, points named", "points[2]", [](NetDesc& d) { d.points[1][2] = kNan; }},
    {"stiffness -1", "refused, the spring named", "springs[1].stiffness",
     [](NetDesc& d) { d.springs[0].stiffness = -1; }},
    {"stiffness NaN", "refused, the spring named", "springs[1].stiffness",
     [](NetDesc& d) { d.springs[0].stiffness = kNan; }},
    {"spring from a point to itself", "refused, the spring named", "springs[1]",
     [](NetDesc& d) { d.springs[0].j = 0; }},
    {"no such integrator", "refused, the known ones named", "implicit_euler",
     [](NetDesc& d) { d.integrator = "rk17"; }},
    {"misspelt integrator option", "refused, the option named", "tolerance",
     [](NetDesc& d) { d.integrator = "rk45", d.integrator_options.set("tolerence", 1e-3); }},
};
constexpr RefusalRow<WorldDesc> kRefusedWorlds[] = {
    {"dt 0", "refused, dt named", "dt", [](WorldDesc& d) { d.dt = 0; }},
    {"dt -1", "refused, dt named", "dt", [](WorldDesc& d) { d.dt = -1; }},
    {"dt NaN", "refused, dt named", "dt", [](WorldDesc& d) { d.dt = NAN; }},
    {"gravity NaN", "refused, gravity named", "gravity", [](WorldDesc& d) { d.gravity[1] = kNan; }},
};

const ExtremeCase kCases[] = {
    {"springs", "two particles at one point", "part along a fixed direction and swing", false, &same_place},
    {"springs", "rest length 0", "f = k x, the amplitude stays", false, &zero_length},
    {"springs", "spring stretched 100 times", "energy does not rise", false, &stretched_hundredfold},
    {"springs", "1000 links, 1e6 kg at the end", "tension within 1 % of the weight", true, &heavy_long_chain},
    {"springs", "step from 1e-4 to 1e-1 s in a run", "methods without a limit gain no energy", false, &step_change},
    {"springs", "denormal velocities", "nothing moves", false, &tiny_velocities},
    {"world", "1e7 steps", "time right to 1e-9", true, &many_steps},
};

}  // namespace

std::vector<ExtremeCase> springs_extremes() {
  std::vector<ExtremeCase> all;
  add_refusals<NetDesc>("springs", kRefusedNets, refused_net, all);
  add_refusals<WorldDesc>("world", kRefusedWorlds, refused_world, all);
  all.insert(all.end(), std::begin(kCases), std::end(kCases));
  return all;
}

}  // namespace feder
