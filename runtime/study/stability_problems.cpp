// The problems of the stability maps: one oscillator, a chain on its slowest mode, and the swinging chain.
// h is 1/60 s throughout; the x axis changes the stiffness.
#include <cmath>
#include <map>

#include "study/reference.h"
#include "study/stability_problem.h"

namespace feder {
namespace {

constexpr double kStep = 1.0 / 60;
constexpr double kPiDouble = 3.14159265358979323846;

// As the library sees a number.
double rounded(double x) { return static_cast<double>(static_cast<Real>(x)); }

int run_steps(double period) {
  const double wanted = std::ceil(10 * period / kStep);
  return static_cast<int>(std::clamp(wanted, 200.0, 8000.0));
}

// x = k h^2/m, y = damping ratio: a mass on a spring of rest length zero.
class OscillatorProblem final : public NetStability {
 public:
  StabilityProblemInfo info() const override {
    return {"oscillator",
            "one mass on a linear spring, released from 1 m",
            {"kh2m", "stiffness k h\u00b2/m", "", true, decades(-4, 12, 2)},
            {"zeta", "damping ratio \u03b6", "", false, {0, 0.01, 0.1, 0.5, 1, 2, 5}},
            true};
  }
  bool single_oscillator() const override { return true; }
  double x_of(double z, double) const override { return z * z; }

  StabilityScene scene(double x, double y, bool) const override {
    const double k = x / (kStep * kStep), w = std::sqrt(k);
    StabilityScene s;
    s.net.name = "oscillator";
    s.net.points = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
    s.net.masses = {1, 1};
    s.net.springs.push_back({0, 1, static_cast<Real>(k), static_cast<Real>(2 * y * w), 0, kInfinity});
    s.pins = {0};
    s.steps = s.error_step = run_steps(2 * kPiDouble / w);
    s.speed = w, s.energy = 0.5 * k, s.frequency = w, s.damping_ratio = y;
    return s;
  }

  bool reference(double x, double y, double t, std::vector<Vec3d>& positions, double& energy) const override {
    const double k = rounded(x / (kStep * kStep)), decay = rounded(2 * y * std::sqrt(x) / kStep) / 2;
    double at, speed;
    damped_oscillation(k, decay, t, at, speed);
    positions = {Vec3d(0, 0, 0), Vec3d(at, 0, 0)};
    energy = 0.5 * (k * at * at + speed * speed);
    return true;
  }
};

// x = k h^2/m, y = number of free masses between two walls (fixed-fixed), moving along the chain.
class ChainProblem final : public NetStability {
 public:
  StabilityProblemInfo info() const override {
    return {"chain",
            "equal masses between two walls, longitudinal, on the slowest mode",
            {"kh2m", "stiffness k h\u00b2/m", "", true, decades(-4, 12, 1)},
            {"masses", "free masses", "", true, {1, 2, 5, 10, 20}, {1, 5}},
            true};
  }
  double x_of(double z, double y) const override {
    const double share = 2 * std::sin(y * kPiDouble / (2 * (y + 1)));  // of sqrt(k/m)
    return z * z / (share * share);
  }

  StabilityScene scene(double x, double y, bool for_limit) const override {
    const int n = static_cast<int>(y);
    const double k = x / (kStep * kStep), mode = for_limit ? n : 1;
    StabilityScene s;
    s.net.name = "chain";
    for (int j = 0; j <= n + 1; ++j) {
      // limits: both walls at the origin, springs of no length, so that nothing is lost beside the positions of the
      // points
      const double sine = j == 0 || j == n + 1 ? 0 : std::sin(j * mode * kPiDouble / (n + 1));
      s.net.points.push_back(Vec3(static_cast<Real>(for_limit ? sine : j - 0.5 * (n + 1) + kAmplitude * sine), 0, 0));
      s.net.masses.push_back(1);
      const auto at = static_cast<std::uint32_t>(j);
      if (j > 0)
        s.net.springs.push_back({at - 1, at, static_cast<Real>(k), 0, for_limit ? Real(0) : Real(1), kInfinity});
    }
    s.pins = {0, static_cast<std::size_t>(n + 1)};
    const double w = frequency(k, 1, n), top = frequency(k, n, n);
    s.steps = s.error_step = run_steps(2 * kPiDouble / w);
    s.length = kAmplitude, s.speed = w * kAmplitude, s.frequency = top;
    s.energy = 0.25 * w * w * kAmplitude * kAmplitude * (n + 1);
    return s;
  }

  bool reference(double x, double y, double t, std::vector<Vec3d>& positions, double& energy) const override {
    const int n = static_cast<int>(y);
    const double w = frequency(rounded(x / (kStep * kStep)), 1, n);
    positions.clear();
    for (int j = 0; j <= n + 1; ++j)
      positions.push_back(
          Vec3d(j - 0.5 * (n + 1) + kAmplitude * std::sin(j * kPiDouble / (n + 1)) * std::cos(w * t), 0, 0));
    energy = 0.25 * w * w * kAmplitude * kAmplitude * (n + 1);
    return true;
  }

 private:
  static constexpr double kAmplitude = 0.1;  // of a spring of 1 m
  static double frequency(double k, int mode, int n) {
    return 2 * std::sqrt(k) * std::sin(mode * kPiDouble / (2 * (n + 1)));
  }
};

// x = stiffness, y = mass of the last point by that of the others. Ten links of 0.1 m, horizontal at rest.
class SwingingChain final : public NetStability {
 public:
  StabilityProblemInfo info() const override {
    return {"swinging_chain",
            "ten stiff links swing from the horizontal, a heavy last mass, 60 steps/s",
            {"stiffness", "stiffness k", "N/m", true, decades(2, 12, 1)},
            {"ratio", "mass ratio", "", true, decades(0, 6, 1)},
            false};
  }
  double x_of(double, double) const override { return NAN; }

  StabilityScene scene(double x, double y, bool) const override {
    StabilityScene s;
    s.net.name = "chain";
    s.gravity = Vec3(0, Real(-9.81), 0);
    double mass = 0, moment = 0;
    for (int j = 0; j <= kLinks; ++j) {
      s.net.points.push_back(Vec3(static_cast<Real>(kLength * j), 0, 0));
      const double m = j == kLinks ? kMass * y : kMass;
      s.net.masses.push_back(static_cast<Real>(m));
      if (j == 0) continue;
      mass += m, moment += m * kLength * j;
      s.net.springs.push_back({static_cast<std::uint32_t>(j - 1), static_cast<std::uint32_t>(j), static_cast<Real>(x),
                               0, static_cast<Real>(kLength), kInfinity});
    }
    s.pins = {0};
    s.length = 1, s.speed = std::sqrt(2 * 9.81);
    s.energy = s.energy_zero = 9.81 * moment + 0.5 * 9.81 * mass * 9.81 * mass / x * kLinks;
    s.error_step = 60;  // later, chaos decides
    return s;
  }

  // A run of tr_bdf2 with 50 steps for one.
  bool reference(double x, double y, double t, std::vector<Vec3d>& positions, double& energy) const override {
    if (t > 1.0001) return false;
    energy = scene(x, y, false).energy;
    std::vector<Vec3d>& kept = kept_[{x, y}];
    if (kept.empty()) {
      StabilityScene s = scene(x, y, false);
      s.substeps = kFine;
      World w(net_world(s), net_catalog());
      s.net.integrator = "tr_bdf2";
      const ObjectId net = w.need<Springs>().add_net(s.net);
      for (const std::size_t p : s.pins) w.need<Springs>().pin(net, p);
      for (int k = 0; k < s.error_step; ++k) w.step();
      for (std::size_t i = 0; i < s.net.points.size(); ++i)
        kept.push_back(w.need<Springs>().point(net, i).cast<double>());
    }
    if (std::fabs(t - 1) > 1e-6) return false;
    positions = kept;
    return true;
  }

 private:
  static constexpr int kLinks = 10, kFine = 50;
  static constexpr double kLength = 0.1, kMass = 0.1;  // m, kg
  mutable std::map<std::pair<double, double>, std::vector<Vec3d>> kept_;
};

}  // namespace

StabilityProblems net_stability() {
  StabilityProblems all;
  all.push_back(std::make_unique<OscillatorProblem>());
  all.push_back(std::make_unique<ChainProblem>());
  all.push_back(std::make_unique<SwingingChain>());
  return all;
}

}  // namespace feder
