// Fluids against closed forms and one measurement, all in the plane:
//  hydrostatic  a column at rest: pressure rho g (H - y) in all depths
//  dam_break    front of a collapsing square column, Martin & Moyce 1952 (fluid-cloth.md 4.1)
//  draught      a beam that floats: rho_body / rho of its height under water
//  poiseuille   start of the flow between two plates under a body force, Morris 1997 (4.2)
//  droplet      the ellipse that springs back to a circle: w^2 = 6 sigma / (rho R^3), n = 2 in the plane (Rayleigh)
#include <algorithm>
#include <cmath>

#include "rigid/rigid.h"
#include "study/fluid_problem.h"
#include "study/martin_moyce.h"

namespace feder {
namespace {

class Hydrostatic final : public FluidProblem {
 public:
  explicit Hydrostatic(const Params& given) {
    ProblemOptions o(given, info_);
    common(o, 16, 2);
    info_.dof = 2 * 8 * static_cast<int>(1 / spacing_);
    scales(1, std::sqrt(kGravity), ReferenceKind::closed, 1e-6, 0.5,
           "pressure rho g (H - y), rms over four depths by rho g H");
  }
  void build(FluidScene& s, FluidDesc d) const override {
    add_wall(*s.world, Vec3(0, 1, 0), 0), add_wall(*s.world, Vec3(1, 0, 0), 0),
        add_wall(*s.world, Vec3(-1, 0, 0), -kWidth);
    s.water = s.fluid->add_fluid(d);
    add_water(s, kWidth, 1, 0, 0);
  }
  void observe(const FluidScene& s, Observation& out) const override {  // the centre of mass
    double x = 0, y = 0;
    for (const Vec3& p : s.positions) x += static_cast<double>(p[0]), y += static_cast<double>(p[1]);
    const double n = static_cast<double>(s.positions.size());
    out.x = {x / n, y / n, 0};
  }
  void reference(double, Observation& out) const override {
    out.x = {kWidth / 2, 0.5, 0};
    out.v.clear();
  }
  void after_step(FluidScene& s) const override {  // the mean over the last quarter: waves go to and fro
    if (s.world->time() < 0.75 * info_.t_end) return;
    s.kept.resize(kDepths + 1);
    for (int k = 0; k < kDepths; ++k) {
      const Vec3 at(static_cast<Real>(kWidth / 2), static_cast<Real>(depth(k)), 0);
      s.kept[static_cast<std::size_t>(k)] += s.world->query<Fluid>()->pressure_at(s.water, at);
    }
    s.kept[kDepths] += 1;
  }
  double error(FluidScene& s) const override {
    if (s.kept.empty()) return NAN;
    const double rho = static_cast<double>(s.fluid->desc(s.water).density);
    double sum = 0;
    for (int k = 0; k < kDepths; ++k) {
      const double p = s.kept[static_cast<std::size_t>(k)] / s.kept[kDepths] / (rho * kGravity);
      sum += (p - (1 - depth(k))) * (p - (1 - depth(k))) / kDepths;
    }
    return std::sqrt(sum);
  }

 private:
  static constexpr double kWidth = 0.5;  // m
  static constexpr int kDepths = 4;
  static double depth(int k) { return 0.2 * (k + 1); }
};

class DamBreak final : public FluidProblem {
 public:
  explicit DamBreak(const Params& given) {
    ProblemOptions o(given, info_);
    common(o, 20, 0.58);
    info_.dof = 2 * static_cast<int>(1 / (spacing_ * spacing_));
    // two digitisations differ by 2 %
    scales(1, std::sqrt(kGravity), ReferenceKind::published, 0.02, 1,
           "front of a square column by its width, Martin & Moyce 1952, their diaphragm opening 0.124 of t sqrt(g/a) "
           "late; largest deviation relative to the front");
  }
  void build(FluidScene& s, FluidDesc d) const override {
    add_wall(*s.world, Vec3(0, 1, 0), 0), add_wall(*s.world, Vec3(1, 0, 0), 0);
    d.viscosity = Real(0.073);  // the Reynolds number of their 5.7 cm of water
    s.water = s.fluid->add_fluid(d);
    add_water(s, 1, 1, 0, 0);
  }
  void observe(const FluidScene& s, Observation& out) const override {
    out.x = {s.start > 0 ? front(s) / s.start : 1, 0, 0};
  }
  double start_measure(const FluidScene& s) const override { return front(s); }
  void reference(double t, Observation& out) const override {
    out.x = {measured(t * std::sqrt(kGravity) + kDiaphragmDelay), 0, 0};
    if (t == 0) out.x[0] = 1;
    out.v.clear();
  }
  void after_step(FluidScene& s) const override {
    const double scaled = s.world->time() * std::sqrt(kGravity) + kDiaphragmDelay;
    if (scaled < kTable[1][0]) return;
    const double want = measured(scaled);
    if (s.kept.empty()) s.kept.push_back(0);
    s.kept[0] = std::max(s.kept[0], std::fabs(front(s) / s.start / want - 1));
  }
  double error(FluidScene& s) const override { return s.kept.empty() ? NAN : s.kept[0]; }

 private:
  static constexpr double kTable[][2] = {{0, 1},       {0.62, 1.22}, {0.80, 1.44}, {1.02, 1.67}, {1.19, 1.89},
                                         {1.34, 2.11}, {1.50, 2.33}, {1.66, 2.56}, {1.81, 2.78}, {1.97, 3.00}};
  static double measured(double scaled) {
    const int n = static_cast<int>(std::size(kTable));
    int k = 1;
    while (k + 1 < n && kTable[k][0] < scaled) ++k;
    const double share = (scaled - kTable[k - 1][0]) / (kTable[k][0] - kTable[k - 1][0]);
    return kTable[k - 1][1] + share * (kTable[k][1] - kTable[k - 1][1]);
  }
  double front(const FluidScene& s) const {
    double far = 0;
    for (const Vec3& p : s.positions)
      if (static_cast<double>(p[1]) < 2 * s.spacing) far = std::max(far, static_cast<double>(p[0]) + s.spacing / 2);
    return far;
  }
};

class Draught final : public FluidProblem {
 public:
  explicit Draught(const Params& given) {
    ProblemOptions o(given, info_);
    common(o, 16, 3);
    share_ = o.number("density_ratio", 0.5, 1e-2, 1e2, "of the beam to the fluid; from 1 on it sinks to the ground");
    info_.dof = 2 * static_cast<int>(kTank * kLevel / (spacing_ * spacing_)) + 3;
    scales(kHigh, std::sqrt(kGravity * kHigh), ReferenceKind::closed, 1e-6, 0.5,
           "draught rho_body / rho of the height, by the height; above 1: it lies on the ground");
  }
  void build(FluidScene& s, FluidDesc d) const override {
    World& w = *s.world;
    add_wall(w, Vec3(0, 1, 0), 0), add_wall(w, Vec3(1, 0, 0), 0), add_wall(w, Vec3(-1, 0, 0), -kTank);
    d.viscosity = 5;
    s.water = s.fluid->add_fluid(d);
    // in a hollow of three quarters of the draught
    const double side = (kTank - kWide) / 2, under = kLevel - 0.75 * std::min(share_, 1.0) * kHigh;
    add_water(s, kTank, under, 0, 0);
    add_water(s, side, kLevel - under, 0, under), add_water(s, side, kLevel - under, side + kWide, under);
    BodyDesc b;
    b.shape = make_box(static_cast<Real>(kWide), static_cast<Real>(kHigh), 1)->section();
    b.density = static_cast<Real>(1000 * share_);
    b.position = Vec3(static_cast<Real>(kTank / 2), static_cast<Real>(under + kHigh / 2), 0);
    s.body = w.need<Rigid>().add_body(b);
  }
  void observe(const FluidScene& s, Observation& out) const override {
    const Vec3 x = s.world->need<Rigid>().pose(s.body).position;
    out.x = {static_cast<double>(x[0]), static_cast<double>(x[1]), 0};
  }
  // The way to the end is not known: the reference is where it starts.
  void reference(double, Observation& out) const override {
    out.x = {kTank / 2, kLevel - 0.75 * std::min(share_, 1.0) * kHigh + kHigh / 2, 0};
    out.v.clear();
  }
  void after_step(FluidScene& s) const override {
    if (s.world->time() < 0.75 * info_.t_end) return;
    Real left = 0, right = 0;
    if (!s.world->query<Fluid>()->height_at(s.water, Real(0.2), 0, left) ||
        !s.world->query<Fluid>()->height_at(s.water, static_cast<Real>(kTank - 0.2), 0, right))
      return;
    const double bottom = static_cast<double>(s.world->need<Rigid>().pose(s.body).position[1]) - kHigh / 2;
    if (s.kept.empty()) s.kept.assign(2, 0);
    s.kept[0] += share_ < 1 ? static_cast<double>(left + right) / 2 - bottom : bottom;
    s.kept[1] += 1;
  }
  double error(FluidScene& s) const override {
    if (s.kept.empty()) return NAN;
    const double mean = s.kept[0] / s.kept[1];
    return std::fabs(mean - (share_ < 1 ? share_ * kHigh : 0)) / kHigh;
  }

 private:
  static constexpr double kTank = 2, kLevel = 0.625, kWide = 0.75, kHigh = 0.5;  // m
  double share_;
};

class Poiseuille final : public FluidProblem {
 public:
  explicit Poiseuille(const Params& given) {
    ProblemOptions o(given, info_);
    common(o, 12, 0.4);
    nu_ = o.number("viscosity", 0.5, 1e-3, 10, "kinematic, m^2/s");
    info_.dof = 2 * static_cast<int>(kLong / (spacing_ * spacing_));
    scales(1, kForce / (8 * nu_), ReferenceKind::closed, 1e-4, 0.5,
           "series of Poiseuille: speed in the middle and at a quarter, by the last one in the middle");
  }
  Vec3 gravity() const override { return Vec3(static_cast<Real>(kForce), 0, 0); }
  void build(FluidScene& s, FluidDesc d) const override {
    add_wall(*s.world, Vec3(0, 1, 0), 0), add_wall(*s.world, Vec3(0, -1, 0), -1);
    d.viscosity = static_cast<Real>(1000 * nu_), d.artificial_viscosity = 0;
    s.water = s.fluid->add_fluid(d);
    add_water(s, kLong, 1, 0, 0);
  }
  void observe(const FluidScene& s, Observation& out) const override { out.x = {band(s, 0.5), band(s, 0.25), 0}; }
  void reference(double t, Observation& out) const override {
    out.x = {mean_of(0.5, t), mean_of(0.25, t), 0};
    out.v.clear();
  }
  double error(FluidScene& s) const override {
    Observation want, now;
    reference(info_.t_end, want), observe(s, now);
    return std::max(std::fabs(now.x[0] - want.x[0]), std::fabs(now.x[1] - want.x[1]));
  }

 private:
  static constexpr double kLong = 4, kForce = 0.5, kBand = 0.09;  // m, m/s^2, m
  // Mean speed of the middle particles within kBand of y (or as far from the other plate), by the last speed in the
  // middle.
  double band(const FluidScene& s, double y) const {
    double middle = 0, sum = 0;
    for (const Vec3& p : s.positions) middle += static_cast<double>(p[0]) / static_cast<double>(s.positions.size());
    int n = 0;
    for (std::size_t i = 0; i < s.positions.size(); ++i) {
      const double at = static_cast<double>(s.positions[i][1]), wall = std::min(at, 1 - at);
      if (std::fabs(static_cast<double>(s.positions[i][0]) - middle) > 0.6 || std::fabs(wall - y) > kBand) continue;
      sum += static_cast<double>(s.velocities[i][0]), ++n;
    }
    return n ? sum / n / info_.v_scale : 0;
  }
  double mean_of(double y, double t) const {
    double sum = 0;
    constexpr int kParts = 16;
    for (int k = 0; k < kParts; ++k) {
      const double a = std::min(y + kBand, 0.5), b = y - kBand;
      sum += speed(b + (a - b) * (k + 0.5) / kParts, t) / kParts;
    }
    return sum;
  }
  // Morris, Fox & Zhu 1997, by the last speed in the middle.
  double speed(double y, double t) const {
    constexpr double pi = 3.14159265358979323846;
    double u = 4 * y * (1 - y);
    for (int n = 0; n < 60; ++n) {
      const double k = (2 * n + 1) * pi;
      u -= 32 / (k * k * k) * std::sin(k * y) * std::exp(-k * k * nu_ * t);
    }
    return t > 0 ? u : 0;
  }
  double nu_;
};

// Drawn out along x and let go: it passes its circle after a quarter and after three quarters of a period.
class Droplet final : public FluidProblem {
 public:
  explicit Droplet(const Params& given) {
    ProblemOptions o(given, info_);
    common(o, 24, 2.4);
    tension_ = o.number("tension", 125, 1, 1e5, "N/m; 125 makes a period of 2.565 s");
    frequency_ = std::sqrt(6 * tension_ / (1000 * kRadius * kRadius * kRadius));
    count_ = static_cast<int>(std::lround(kPi * kRadius * kRadius / (spacing_ * spacing_)));
    info_.dof = 2 * count_;
    // the formula is that of small swings: the next term is of the order of the square of the stretch
    scales(1, frequency_ * kStretch, ReferenceKind::closed, kStretch * kStretch, 4,
           "half a period pi / w between two passages through the circle, w^2 = 6 sigma / (rho R^3), relative");
  }
  Vec3 gravity() const override { return Vec3(0, 0, 0); }
  void build(FluidScene& s, FluidDesc d) const override {
    // what damps particles lets them freeze to a lattice, which is stiff; so they start on none (Vogel's spiral)
    d.surface_tension = static_cast<Real>(tension_), d.artificial_viscosity = 0;
    s.water = s.fluid->add_fluid(d);
    std::vector<Vec3> points;
    const double golden = kPi * (3 - std::sqrt(5.0));
    for (int i = 1; i <= count_; ++i) {
      const double r = kRadius * std::sqrt((i - 0.5) / count_), turn = i * golden;
      points.push_back(Vec3(static_cast<Real>((1 + kStretch) * r * std::cos(turn)),
                            static_cast<Real>(r * std::sin(turn) / (1 + kStretch)), 0));
    }
    s.fluid->fill(s.water, points, Vec3::Zero());
  }
  // How much longer along x than along y, by what it was at the start.
  void observe(const FluidScene& s, Observation& out) const override {
    out.x = {s.start != 0 ? longer(s) / s.start : 1, 0, 0};
  }
  double start_measure(const FluidScene& s) const override { return longer(s); }
  void reference(double t, Observation& out) const override {
    out.x = {std::cos(frequency_ * t), 0, 0};
    out.v.clear();
  }
  // kept: the measure and the time before, then the times of the passages.
  void after_step(FluidScene& s) const override {
    const double now = longer(s), t = s.world->time();
    if (s.kept.empty()) s.kept = {s.start, 0};
    const double before = s.kept[0];
    if (before * now <= 0) s.kept.push_back(s.kept[1] + (t - s.kept[1]) * before / (before - now));
    s.kept[0] = now, s.kept[1] = t;
  }
  double error(FluidScene& s) const override {
    if (s.kept.empty() || s.world->time() < 0.99 * info_.t_end) return NAN;
    if (s.kept.size() < 4) return 1;  // has not come back
    return std::fabs((s.kept[3] - s.kept[2]) * frequency_ / kPi - 1);
  }

 private:
  static constexpr double kPi = 3.14159265358979323846;
  static constexpr double kRadius = 0.5, kStretch = 0.15;  // m, of the radius
  double longer(const FluidScene& s) const {
    double xx = 0, yy = 0;
    for (const Vec3& p : s.positions) {
      xx += static_cast<double>(p[0]) * static_cast<double>(p[0]);
      yy += static_cast<double>(p[1]) * static_cast<double>(p[1]);
    }
    return (xx - yy) / (xx + yy);
  }
  double tension_, frequency_ = 1;
  int count_ = 1;
};

template <class T>
Variant<StudyProblem> row(const char* name, const char* summary) {
  return {name, summary,
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<T>(p); }};
}

}  // namespace

Variant<StudyProblem> study_hydrostatic() {
  return row<Hydrostatic>("hydrostatic", "a column of fluid at rest: its pressure");
}
Variant<StudyProblem> study_dam_break() { return row<DamBreak>("dam_break", "a square column collapses: its front"); }
Variant<StudyProblem> study_draught() { return row<Draught>("draught", "a beam floats: how deep"); }
Variant<StudyProblem> study_poiseuille() {
  return row<Poiseuille>("poiseuille", "a flow between plates starts: its profile");
}
Variant<StudyProblem> study_droplet() {
  return row<Droplet>("droplet", "a drop swings about its round shape: its period");
}

}  // namespace feder
