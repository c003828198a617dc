// The classical mass-spring body: springs along the edges of the tetrahedra (edge_springs.h) and in each of these a
// force that preserves its volume (Teschner, Heidelberger, Mueller and Gross, "A Versatile and Robust Model for
// Geometrically Complex Deformable Solids", CGI 2004), moved by an integrator of choice; symplectic Euler unless
// another is named. The energy, with J the volume of a tetrahedron by that at rest, is
//   sum over edges k/2 (l - L)^2 + sum over tetrahedra V (kappa/2 (J - 1)^2 + kappa'/2 min(J - kSqueezed, 0)^2).
// Springs alone have Poisson's ratio 1/4; kappa = K - K of the springs adds what the material resists a change of
// volume beyond them (where springs are too stiff it takes from it, as kappa/2 d^2/(1 + d^2), d = J - 1, lest it win
// where much is stretched). The last term is no part of the material: springs do not know a tetrahedron from its mirror
// image, so it turns back those that are inside out. All forces are along gradients of distances and volumes where the
// points are: they keep linear and angular momentum, and so does the default integrator.
// Stable in any state: springs pull no stiffer across than along, which solver substeps are chosen for; where stretch
// makes a volume force stiffer than they resolve, it is cut and damped. Where they are too few all of the body acts
// softer, with a warning (step.cpp). Damping is that of each spring and volume, along with its stiffness, once in a
// substep where velocities and positions are of one time, by the stages of an explicit method (integrate/
// damping_stages.h). Kept between steps: springs of the mesh; what a multi-step integrator remembers, which begins anew
// in each step. Weak spot: few cells across pull and bend by what their edges say, up to a tenth too soft (tests/soft/
// test_mass_spring.cpp); no Poisson's ratio below 1/4; thrown into a heap, springs may stay folded.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "feder/integrator.h"
#include "feder/snapshot.h"
#include "integrate/damping_stages.h"
#include "integrate/integrator.h"
#include "integrate/limits.h"
#include "soft/edge_springs.h"
#include "soft/solver.h"

namespace feder {
namespace {

constexpr double kResolvedShare = 0.75;  // of the square of the stability limit, by h^2 w^2 of the fastest mode
constexpr double kDampedSubsteps = 2;    // solver substeps at least: damping wants to know what contacts do
constexpr double kGrowing = 0.1;         // h w for methods without a limit that grow at any
constexpr double kContactRate = 16;      // h^2 w^2 that contacts bear, for methods without a limit
constexpr double kLeastPoisson = 0.25, kCauchyBulk = 5.0 / 3;  // of springs alone; bulk by shear modulus there
constexpr Real kSqueezed = Real(0.3);                          // of the volume: below, tetrahedra are turned back
constexpr Real kTurnsBack = 10;                                // stiffness of that by the shear modulus
constexpr Real kLeastVolume = 3;           // of a volume, by the shear modulus, that is resolved for its sake
constexpr Real kVolumeRate = Real(0.5);    // h^2 w^2 that a volume force may always have
constexpr Real kVolumeGrowth = Real(1.5);  // of that at rest, likewise
constexpr Real kCalmed = 2;                // damping below 0 ends at a strain of one over it
constexpr int kPowerIterations = 40;       // of the power method
constexpr double kFromBelow = 1.05;        // of its result
constexpr int kDampingStages = 256;
constexpr Real kRound = Real(0.25);  // of its length: a spring shorter than that does not jump as its ends pass
const Vec3 kNoWay = Vec3(1, 0, 0);

class SoftMassSpring final : public SoftSolver, private ForceField {
 public:
  SoftMassSpring(Arena& a, const Params& p)
      : net_(a), kappa_(&a), allowed_(&a), rest_squares_(&a), x_(&a), v_(&a), inv_mass_(&a), mass_(&a), stage_(&a),
        last_(&a), first_(&a), push_(&a), lag_(&a) {
    const Variant<Integrator>& row =
        find_variant(integrators(), p.text({"integrator"}, default_integrator()), "integrator");
    const Params none;
    lead_ = free_fall_lead(*row.make(a, none));
    method_ = row.make(a, none);
  }

  bool takes(const ElasticLaw& law) const override { return std::string_view(law.name) == "neo_hookean"; }

  bool flows() const override { return false; }

  double wanted_substeps(const SoftView& v, Real h) override {
    build(v);
    return std::fmax(double(h) * std::sqrt(fastest_ / resolved()), v.damping > 0 ? kDampedSubsteps : 1);
  }

  SoftStiffness prepare(const SoftView& v, Real h, StepContext&) override {
    build(v);
    const double z = fastest_ * double(h) * double(h);
    share_ = unlimited() || z <= 1.0001 * resolved() ? 1 : resolved() / z;
    return {share_};
  }

  Real lead() const override { return lead_; }

  void advance(const SoftView& v, Real h, StepContext& c) override {
    FEDER_ASSERT(version_ == v.version && h > 0);
    view_ = v, step_ = h;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      x_[i] = v.delta_position[i].vec(), v_[i] = v.velocity[i].vec();
      inv_mass_[i] = v.delta_position[i].w, mass_[i] = inv_mass_[i] != 0 ? 1 / inv_mass_[i] : Real(1);
    }
    if (v.damping > 0 && c.inner.index == turn(c)) damp(c.h);
    method_->step(*this, c.time, h, {x_.data(), v.points}, {v_.data(), v.points});
    for (std::uint32_t i = 0; i < v.points; ++i) {
      Row4& d = v.delta_position[i];
      if (d.w != 0) d.set(x_[i]), v.velocity[i].set(v_[i]);
      v.before[i] = {d.x, d.y, d.z, 1};
    }
  }

  double elastic_energy(const SoftView& v, const Array<Vec3>& x) override {
    build(v);
    double sum = 0;
    for (const SoftSpring& s : net_.springs) {
      const double size = length(wide(x[s.j]) - wide(x[s.i])), rest = double(s.rest), round = double(kRound) * rest;
      const double least = std::fmax(size, round), longer = least - rest;
      double area = longer * longer / 2;
      if (size < round)
        area += (rest * (round * round - size * size) / 2 - (round * round * round - size * size * size) / 3) / round;
      sum += double(mu_) * double(s.weight) * area;
    }
    for (std::size_t k = 0; k < net_.cells.size(); ++k) {
      const SoftCell& c = net_.cells[k];
      const double j =
          tetrahedron_volume({wide(x[c.v[0]]), wide(x[c.v[1]]), wide(x[c.v[2]]), wide(x[c.v[3]])}) / double(c.volume);
      const double d = j - 1, kappa = double(kappa_[k]), less = std::fmin(j - double(kSqueezed), 0);
      sum += double(c.volume) * (kappa / 2 * (kappa < 0 ? d * d / (1 + d * d) : d * d) + turns_back_ / 2 * less * less);
    }
    return sum;
  }

  std::string limits(const SoftView& v) override {
    build(v);
    if (!lacks(v.material)) return "";
    return "has no Poisson's ratio below 0.25: it acts as if poisson were that, with the same young; xpbd has any";
  }

  void save(Writer& w) const override { w.list(method_->memory.points), w.list(method_->memory.numbers); }
  void load(Reader& r) override { r.list(method_->memory.points), r.list(method_->memory.numbers); }

  void validate(const SoftView& v) const override {
    if (version_ != v.version) return;
    FEDER_ASSERT(net_.cells.size() == v.mesh->tetrahedra.size() && x_.size() == v.points);
    for (const SoftSpring& s : net_.springs) FEDER_ASSERT(s.i < s.j && s.j < v.points && s.rest > 0 && s.weight > 0);
  }

 private:
  static bool lacks(const SoftMaterial& m) { return m.lame < (1 - 1e-6) * m.mu; }
  static double young(const SoftMaterial& m) { return m.mu * (3 * m.lame + 2 * m.mu) / (m.lame + m.mu); }
  bool unlimited() const { return !std::isfinite(method_->info().stability_limit); }
  // h^2 w^2 of the fastest mode that it is used at.
  double resolved() const {
    const double limit = method_->info().stability_limit;
    if (unlimited()) return kContactRate;
    return limit > 0 ? kResolvedShare * limit * limit : kGrowing * kGrowing;
  }

  void build(const SoftView& v) {
    if (version_ == v.version) return;
    version_ = v.version;
    net_.build(*v.mesh, v.points);
    // of a ratio below 1/4 Young's modulus alone is kept
    const double mu = lacks(v.material) ? young(v.material) / (2 + 2 * kLeastPoisson) : v.material.mu;
    const double bulk = lacks(v.material) ? mu * kCauchyBulk : v.material.bulk();
    mu_ = static_cast<Real>(mu), turns_back_ = double(kTurnsBack) * mu;
    kappa_.clear(), allowed_.clear(), rest_squares_.clear();
    for (const SoftCell& c : net_.cells) {
      const double springs = mu * double(c.bulk);
      kappa_.push_back(static_cast<Real>(bulk - springs));
      rest_squares_.push_back(gradient_squares(c, Mat3::Identity()));
      allowed_.push_back(4 * std::max(std::fabs(kappa_.back()), kLeastVolume * mu_) / static_cast<Real>(v.density) *
                         rest_squares_.back());
    }
    for (Array<Vec3>* a : {&x_, &v_, &stage_, &last_, &first_, &push_, &lag_}) a->assign(v.points, Vec3(0, 0, 0));
    inv_mass_.assign(v.points, 0), mass_.assign(v.points, 1);
    fastest_ = kFromBelow * fastest(v);
  }

  // Bound of w^2 of the fastest mode in any state, 1/s^2, by the power method: springs as stiff across as along, and
  // the volume forces at rest.
  double fastest(const SoftView& v) const {
    std::vector<double> mass(v.points, 0);
    for (const SoftCell& c : net_.cells)
      for (const std::uint32_t i : c.v) mass[i] += v.density * double(c.volume) / 4;
    std::vector<Double3> u(v.points), force(v.points);
    Rng rng(1);
    for (Double3& d : u) d = {double(rng.uniform(-1, 1)), double(rng.uniform(-1, 1)), double(rng.uniform(-1, 1))};
    double most = 0;
    for (int n = 0; n < kPowerIterations; ++n) {
      std::fill(force.begin(), force.end(), Double3{0, 0, 0});
      for (const SoftSpring& s : net_.springs) {
        const Double3 f = double(mu_) * double(s.weight) * (u[s.j] - u[s.i]);
        force[s.i] = force[s.i] - f, force[s.j] = force[s.j] + f;
      }
      for (std::size_t k = 0; k < net_.cells.size(); ++k) {
        const SoftCell& c = net_.cells[k];
        double change = 0;
        for (int m = 0; m < 3; ++m) change += dot(wide(c.gradient[m]), u[c.v[m + 1]] - u[c.v[0]]);
        const double by = std::fmax(double(kappa_[k]), double(kLeastVolume * mu_)) * double(c.volume) * change;
        for (int m = 0; m < 3; ++m) {
          const Double3 f = by * wide(c.gradient[m]);
          force[c.v[m + 1]] = force[c.v[m + 1]] + f, force[c.v[0]] = force[c.v[0]] - f;
        }
      }
      double up = 0, down = 0, norm = 0;
      for (std::uint32_t i = 0; i < v.points; ++i) {
        up += dot(u[i], force[i]), down += mass[i] * dot(u[i], u[i]);
        u[i] = (1 / mass[i]) * force[i];
        norm = std::fmax(norm, dot(u[i], u[i]));
      }
      if (!(down > 0 && norm > 0)) break;
      most = std::fmax(most, up / down);
      for (Double3& d : u) d = (1 / std::sqrt(norm)) * d;
    }
    return most;
  }

  // F is given by its columns; out: those of its cofactors.
  static Mat3 cofactors(const Mat3& f) {
    Mat3 c;
    c.col(0) = cross(Vec3(f.col(1)), Vec3(f.col(2)));
    c.col(1) = cross(Vec3(f.col(2)), Vec3(f.col(0)));
    c.col(2) = cross(Vec3(f.col(0)), Vec3(f.col(1)));
    return c;
  }
  // Sum of the squares of the gradients of J by the four corners, 1/m^2.
  static Real gradient_squares(const SoftCell& c, const Mat3& cofactor) {
    Vec3 all = Vec3::Zero();
    Real sum = 0;
    for (const Vec3& g : c.gradient) {
      const Vec3 by = cofactor * g;
      sum += dot(by, by), all += by;
    }
    return sum + dot(all, all);
  }

  Vec3 between(std::uint32_t i, std::uint32_t j, std::span<const Vec3> x) const {
    return (view_.position[j] - view_.position[i]) + (x[j] - x[i]);
  }
  struct Volume {
    Vec3 gradient[3];    // of J by the corners v[1], v[2], v[3], 1/m
    Real stress, stiff;  // dE/dJ and what d2E/dJ2 has that is positive, by volume, Pa
  };
  Volume volume_of(std::size_t k, std::span<const Vec3> x, std::span<const Vec3> v) const {
    const SoftCell& c = net_.cells[k];
    Mat3 f = Mat3::Zero();
    for (int n = 0; n < 3; ++n) f += between(c.v[0], c.v[n + 1], x) * c.gradient[n].transpose();
    const Mat3 cof = cofactors(f);
    const Real j = dot(Vec3(f.col(0)), Vec3(cof.col(0))), d = j - 1, kappa = kappa_[k];
    Volume out;
    Vec3 all = Vec3::Zero();
    Real squares = 0;
    for (int n = 0; n < 3; ++n) {
      out.gradient[n] = cof * c.gradient[n];
      squares += dot(out.gradient[n], out.gradient[n]), all += out.gradient[n];
    }
    squares += dot(all, all);
    const bool squeezed = j < kSqueezed;
    out.stress = kappa < 0 ? kappa * d / ((1 + d * d) * (1 + d * d)) : kappa * d;
    out.stiff = std::fabs(kappa);
    if (squeezed) out.stress += kTurnsBack * mu_ * (j - kSqueezed), out.stiff += kTurnsBack * mu_;
    if (unlimited()) {
      if (kappa < 0) out.stiff -= std::fabs(kappa);  // what is positive of it
      return out;
    }
    // What solver substeps resolve of it, by the tetrahedron alone with its share of the masses. The rest would be
    // forces that are not of an energy: they act against changes of volume, as a backward step would have them.
    const Real z = static_cast<Real>(share_) * step_ * step_ * 4 / static_cast<Real>(view_.density) *
                   (out.stiff * squares + std::fabs(out.stress) * std::sqrt(f.squaredNorm()) * rest_squares_[k]);
    const Real most = std::max(kVolumeRate, kVolumeGrowth * static_cast<Real>(share_) * step_ * step_ * allowed_[k]);
    if (!(z > most)) return out;
    const Real cut = most / z;
    Real rate = 0;  // of J, 1/s
    for (int n = 0; n < 3; ++n) rate += dot(out.gradient[n], Vec3(v[c.v[n + 1]] - v[c.v[0]]));
    out.stress = cut * (out.stress + (1 - cut) * step_ * out.stiff * rate);
    return out;
  }

  // The solver substep in which damping acts in this substep: always the same one would spare modes that stand still
  // then.
  static int turn(const StepContext& c) {
    constexpr double kGolden = 0.6180339887498949;
    const double count = static_cast<double>(c.step % (1u << 20)) * c.substeps + c.substep, x = count * kGolden;
    return static_cast<int>((x - std::floor(x)) * c.inner.count);
  }

  // Takes what a substep of h loses out of v_, where it is that of the time of x_: forces are added for as much as the
  // method lags, those of contacts as the last solver substep had them, and taken back.
  void damp(Real h) {
    const std::uint32_t n = view_.points;
    eval({x_.data(), n}, {v_.data(), n}, 0, {push_.data(), n});
    for (std::uint32_t i = 0; i < n; ++i) {
      lag_[i] =
          inv_mass_[i] != 0 ? (lead_ * step_) * (inv_mass_[i] * push_[i] + view_.steady_contact[i]) : Vec3(0, 0, 0);
      v_[i] += lag_[i];
    }
    const double z = share_ * fastest_ * double(view_.damping) * double(h);
    const int count = DampingStages::needed(z, kDampingStages);
    DampingStages stages(count);
    const Real time = static_cast<Real>(double(view_.damping) * double(h) * std::fmin(1, stages.stability_limit() / z));
    for (int k = 0; k < count; ++k) {
      const DampingStage s = stages.next();
      const Real mu = static_cast<Real>(s.mu), nu = static_cast<Real>(s.nu), rate = static_cast<Real>(s.rate);
      resist(time, k == 0 ? v_ : stage_);
      for (std::uint32_t i = 0; i < n; ++i) {
        const Vec3 push = inv_mass_[i] * push_[i];
        if (k == 0) {
          first_[i] = push, last_[i] = Vec3(0, 0, 0), stage_[i] = rate * push;
          continue;
        }
        const Vec3 now = stage_[i];
        stage_[i] = mu * now + nu * last_[i] + rate * (first_[i] + push);
        last_[i] = now;
      }
    }
    for (std::uint32_t i = 0; i < n; ++i) v_[i] += stage_[i] - lag_[i];
  }

  // push_ = -time K v, of the stiffness K of springs and volumes at rest as they lie now.
  void resist(Real time, const Array<Vec3>& v) {
    std::fill(push_.begin(), push_.end(), Vec3(0, 0, 0));
    const std::span<const Vec3> x{x_.data(), x_.size()};
    const Real scale = static_cast<Real>(share_) * time;
    for (const SoftSpring& s : net_.springs) {
      const Vec3 n = normalized_or(between(s.i, s.j, x), kNoWay);
      const Vec3 f = (scale * mu_ * s.weight * dot(n, Vec3(v[s.j] - v[s.i]))) * n;
      push_[s.i] += f, push_[s.j] -= f;
    }
    for (std::size_t k = 0; k < net_.cells.size(); ++k) {
      const SoftCell& c = net_.cells[k];
      Mat3 f = Mat3::Zero();
      for (int n = 0; n < 3; ++n) f += between(c.v[0], c.v[n + 1], x) * c.gradient[n].transpose();
      const Mat3 cof = cofactors(f);
      Vec3 g[3];
      Real rate = 0;
      for (int n = 0; n < 3; ++n) g[n] = cof * c.gradient[n], rate += dot(g[n], Vec3(v[c.v[n + 1]] - v[c.v[0]]));
      const Real now = gradient_squares(c, cof);
      Real cut = std::min(rest_squares_[k] / now, Real(1));
      if (kappa_[k] < 0) {  // it takes from what springs resist, which only do so all round near rest
        const Mat3 strain = f.transpose() * f - Mat3::Identity();
        cut = std::max(1 - kCalmed * std::sqrt(strain.squaredNorm()), Real(0));
      }
      const Real by = scale * cut * kappa_[k] * c.volume * rate;
      for (int n = 0; n < 3; ++n) push_[c.v[n + 1]] -= by * g[n], push_[c.v[0]] += by * g[n];
    }
  }

  // ForceField, at displacements since the start of the step.
  std::size_t count() const override { return view_.points; }
  std::span<const Real> inv_mass() const override { return {inv_mass_.data(), view_.points}; }
  std::span<const Real> mass() const override { return {mass_.data(), view_.points}; }
  bool damped() const override { return false; }
  bool stiff_damping(Real) const override { return false; }
  void damping(std::span<const Vec3>, std::span<const Vec3>, double, BlockSparse& d) override { d.set_zero(); }
  void eval(std::span<const Vec3> x, std::span<const Vec3> v, double, std::span<Vec3> force) override {
    FEDER_ASSERT(x.size() == view_.points && force.size() == view_.points);
    for (std::uint32_t i = 0; i < view_.points; ++i) force[i] = mass_[i] * view_.acceleration[i];
    const Real share = static_cast<Real>(share_), stiffness = share * mu_;
    for (const SoftSpring& s : net_.springs) {
      const Vec3 e = between(s.i, s.j, x);
      const Real size = length(e);
      const Vec3 f = e * (stiffness * s.weight * (size - s.rest) / std::max(size, kRound * s.rest));
      force[s.i] += f, force[s.j] -= f;
    }
    for (std::size_t k = 0; k < net_.cells.size(); ++k) {
      const SoftCell& c = net_.cells[k];
      const Volume w = volume_of(k, x, v);
      const Real by = share * c.volume * w.stress;
      for (int n = 0; n < 3; ++n) force[c.v[n + 1]] -= by * w.gradient[n], force[c.v[0]] += by * w.gradient[n];
    }
  }
  // Indefinite parts are dropped: of a compressed spring across (Choi & Ko 2002), of volumes the second derivatives.
  void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double, BlockSparse& k, BlockSparse& d) override {
    d.set_zero(), k.set_zero();
    FEDER_ASSERT(k.off.size() == net_.springs.size());  // in the order of pattern()
    for (std::size_t n = 0; n < net_.springs.size(); ++n) {
      const SoftSpring& s = net_.springs[n];
      const Vec3d e = between(s.i, s.j, x).cast<double>();
      const double size = std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
      const double stiffness = share_ * double(mu_) * double(s.weight), rest = double(s.rest);
      const Vec3d u = size > 0 ? Vec3d(e / size) : Vec3d(1, 0, 0);
      const double across = size > rest ? stiffness * (1 - rest / size) : 0;
      Mat3d block;
      for (int col = 0; col < 3; ++col) block.col(col) = ((stiffness - across) * u[col]) * u;
      block.diagonal().array() += across;
      k.diagonal[s.i] -= block, k.diagonal[s.j] -= block;
      k.off[n] += block;
    }
    for (std::size_t m = 0; m < net_.cells.size(); ++m) {
      const SoftCell& c = net_.cells[m];
      const Volume w = volume_of(m, x, v);
      const double by = share_ * double(c.volume) * double(w.stiff);
      Vec3d g[4];
      g[0] = Vec3d(0, 0, 0);
      for (int n = 0; n < 3; ++n) g[n + 1] = w.gradient[n].cast<double>(), g[0] -= g[n + 1];
      for (int n = 0; n < 4; ++n) k.diagonal[c.v[n]].noalias() -= by * g[n] * g[n].transpose();
      for (int n = 0; n < 6; ++n) {
        const int a = kCornerPairs[n][0], b = kCornerPairs[n][1];
        const int i = c.v[a] < c.v[b] ? a : b, j = i == a ? b : a;
        k.off[c.edge[n]].noalias() -= by * g[i] * g[j].transpose();
      }
    }
  }
  void pattern(std::vector<BlockIndex>& blocks) const override {
    for (const SoftSpring& s : net_.springs) blocks.push_back({s.i, s.j});
  }
  std::uint64_t pattern_version() const override { return version_; }

  std::unique_ptr<Integrator> method_;
  Real lead_ = Real(0.5);
  SoftSprings net_;
  Array<Real> kappa_;         // by tetrahedron: stiffness of its volume force, Pa
  Array<Real> allowed_;       // w^2 of that at rest, of the tetrahedron alone, 1/s^2
  Array<Real> rest_squares_;  // of the gradients of weights, 1/m^2
  Array<Vec3> x_, v_;         // of a solver substep
  Array<Real> inv_mass_, mass_;
  Array<Vec3> stage_, last_, first_, push_, lag_;  // of damping, m/s; N s; m/s
  SoftView view_;
  std::uint64_t version_ = ~std::uint64_t(0);
  double fastest_ = 0, share_ = 1, turns_back_ = 0;
  Real mu_ = 0, step_ = 0;
};

}  // namespace

Variant<SoftSolver> soft_mass_spring() {
  return {
      "mass_spring", "springs along edges and volume forces, with an integrator by name; the classical model",
      [](Arena& a, const Params& p) -> std::unique_ptr<SoftSolver> { return std::make_unique<SoftMassSpring>(a, p); }};
}

}  // namespace feder
