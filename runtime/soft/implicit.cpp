// Backward (implicit) Euler, the truth of studies: each solver substep of h goes to the minimum of the incremental
// potential
//   E(x) = sum m |x - y|^2/(2 h^2) + sum over tetrahedra V Psi(F),  y = x0 + h v + h^2 a (Martin et al. 2011, eq. 5)
// by Newton's method with a line search on E, in double whatever Real is, for any law of elasticity. Its Hessian is
// made positive semidefinite tetrahedron by tetrahedron (Smith, de Goes and Kim 2018, section 4), so with the inertia
// the matrix is positive definite. It is factored where that is cheap (linear/block_ldl.h), else solved by conjugate
// gradients as exactly as the step of Newton can use (Eisenstat and Walker 1996), or factored where those take longer.
// Damping is part of the potential:
// (tau/h) V Psi_lin(E - E0) of Green's strain E resists what changes it from E0 at the start of the solver substep, so
// turning as a whole is free of it. The method itself damps like a material of tau = h, which counts as part of
// `damping`: a mode decays at max(damping, h) w^2/2. Forces act where a solver substep ends, which is a torque about
// where it began: of a body that nothing pins it is taken out as a rotation of the whole, and so is what a linear
// solve to a tolerance adds to linear momentum. `tolerance` is that of the residual force over the sum of the
// magnitudes of all forces at the points, in the norm of the inverse mass; a solver substep that misses it within
// `iterations` steps of Newton is spoken of.
// Kept between steps: layout of the matrix by mesh. Weak spot: one thread, and 50 times the cost of xpbd and more;
// contacts correct what it has reached.
#include <algorithm>
#include <cmath>
#include <vector>

#include "feder/error.h"
#include "linear/block_ldl.h"
#include "linear/cg.h"
#include "soft/solver.h"
#include "soft/stability.h"
#include "state/angular_momentum.h"

namespace feder {
namespace {

constexpr double kArmijo = 1e-4;              // share of the slope that a step has to gain
constexpr double kEnergyRounding = 1e-13;     // of the sum of all energies
constexpr double kDensityRounding = 1e-15;    // of stiffness times volume: terms of the energy that cancel at rest
constexpr double kStrainRounding = 1e-8;      // strain whose forces are none to speak of
constexpr double kMaxForcing = 0.1;           // largest residual that a linear solve may leave
constexpr double kNear = 0.01;                // residual near the minimum
constexpr double kStiffSubstep = 16;          // largest h^2 w^2 that contacts bear
constexpr double kDampingGrowth = 1.7320508;  // of the response of a tetrahedron to its strain rate, over that at rest
constexpr int kHalvings = 30;                 // of a step in the line search
constexpr int kCgPerPoint = 3;                // cap of a linear solve, iterations
constexpr int kModeIterations = 40;           // of the power method
constexpr std::uint64_t kFactorFloor = 20'000, kFactorPerBlock = 60;  // block products that cost less than iterating
constexpr std::uint64_t kMostFactor = 40'000'000;                     // block products: beyond, never
constexpr std::uint64_t kProducts = 3;                                // of a block with vectors, by one with a block

double dot_of(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length_of(const Vec3d& a) { return std::sqrt(dot_of(a, a)); }

class SoftImplicit final : public SoftSolver {
 public:
  SoftImplicit(Arena& arena, const Params& p)
      : tolerance_(p.number({"tolerance", "", {0, 1, true}}, 1e-5)),
        iterations_(p.integer({"iterations", "", {1, 10'000}}, 50)), tets_(&arena), u_(&arena), trial_(&arena),
        start_(&arena), goal_(&arena), gradient_(&arena), mass_(&arena), free_(&arena), right_(&arena), step_(&arena),
        size_(&arena), matrix_(arena), ldl_(arena), cg_(arena) {}

  bool takes(const ElasticLaw&) const override { return true; }

  // Any number does for the body itself. But contacts and attached bodies move points between solver substeps, which
  // stores energy in tetrahedra, and feel no more than m d/h^2: a column of three cubes under two and a half times the
  // weight of one falls at h^2 w^2 = 50 and stands at 13.
  double wanted_substeps(const SoftView& v, Real h) override {
    build(v);
    return double(h) * std::sqrt(fastest_ / kStiffSubstep);
  }

  SoftStiffness prepare(const SoftView& v, Real, StepContext&) override {
    build(v);
    missed_ = 0, direct_ = cheap_;
    for (Tet& t : tets_)
      for (int k = 0; k < 3; ++k) t.base[k] = Vec3(v.position[t.v[k + 1]] - v.position[t.v[0]]).cast<double>();
    return {};
  }

  void advance(const SoftView& v, Real h, StepContext&) override {
    FEDER_ASSERT(version_ == v.version && h > 0);
    h_ = double(h);
    begin(v, h);
    // from the better of two guesses: where nothing but inertia acts, and where it is
    const double coasting = energy(v, goal_), standing = energy(v, start_);
    const Array<Vec3d>& guess = coasting < standing ? goal_ : start_;
    std::copy(guess.begin(), guess.end(), u_.begin());
    minimise(v, std::fmin(coasting, standing));
    each_free_part(v, [&](std::span<const std::uint32_t> part) { take_out(v, part); });
    for (std::uint32_t i = 0; i < v.points; ++i) {
      Row4& d = v.delta_position[i];
      if (free_[i] != 0) {
        const Vec3d reached = u_[i] - (h_ * h_) * v.steady_contact[i].cast<double>();
        v.velocity[i].set(((reached - start_[i]) / h_).cast<Real>());
        d.set(reached.cast<Real>());
      }
      v.before[i] = {d.x, d.y, d.z, 1};
    }
  }

  std::string shortfall() const override {
    if (!(missed_ > 0)) return "";
    return "stopped after " + std::to_string(steps_) + " steps of Newton at a residual of " + print_number(missed_) +
           ", its tolerance is " + print_number(tolerance_) +
           ": more solver substeps or a larger solver_options.iterations would do";
  }

  void validate(const SoftView& v) const override {
    if (version_ != v.version) return;
    FEDER_ASSERT(tets_.size() == v.mesh->tetrahedra.size() && u_.size() == v.points);
    for (std::size_t k = 0; k < tets_.size(); ++k)
      for (int c = 0; c < 4; ++c) FEDER_ASSERT(tets_[k].v[c] == v.mesh->tetrahedra[k][static_cast<std::size_t>(c)]);
  }

 private:
  struct Tet {
    std::uint32_t v[4], block[6];
    double volume;      // m^3, at rest
    Vec3d gradient[4];  // of the weights of its corners, 1/m
    Vec3d base[3];      // v[1], v[2], v[3] minus v[0] at the start of the step, m
    Mat3d strain;       // Green's, at the start of the solver substep, where damping acts
    double lag;         // likewise: damping time beyond h, over h; less where it is strained much
  };

  void build(const SoftView& v) {
    if (version_ == v.version) {
      if (shape_ != v.shape) reshape(v);
      return;
    }
    version_ = v.version;
    const SoftMesh& m = *v.mesh;
    // pattern: each pair of points that share a tetrahedron
    std::vector<BlockIndex> pairs;
    const auto pair = [](std::uint32_t i, std::uint32_t j) { return BlockIndex{std::min(i, j), std::max(i, j)}; };
    const auto earlier = [](const BlockIndex& a, const BlockIndex& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; };
    const auto corner = [](const TetrahedronPoints& t, int c) { return t[static_cast<std::size_t>(c)]; };
    for (const TetrahedronPoints& t : m.tetrahedra)
      for (const auto& p : kCornerPairs) pairs.push_back(pair(corner(t, p[0]), corner(t, p[1])));
    std::sort(pairs.begin(), pairs.end(), earlier);
    pairs.erase(std::unique(pairs.begin(), pairs.end(),
                            [](const BlockIndex& a, const BlockIndex& b) { return a.i == b.i && a.j == b.j; }),
                pairs.end());
    matrix_.set_pattern(v.points, pairs);
    const std::uint64_t blocks = v.points + 2 * pairs.size();
    factors_ = ldl_.analyze(v.points, pairs, kMostFactor);
    cheap_ = factors_ && ldl_.operations() <= std::max(kFactorFloor, kFactorPerBlock * blocks);
    // as long as it is cheaper than to factor
    cg_iterations_ = factors_ ? static_cast<int>(kProducts * ldl_.operations() / blocks) + 1
                              : kCgPerPoint * static_cast<int>(v.points) + 50;
    tets_.clear();
    for (std::size_t k = 0; k < m.tetrahedra.size(); ++k) {
      Tet t{};
      std::copy(m.tetrahedra[k].begin(), m.tetrahedra[k].end(), t.v);
      for (int n = 0; n < 6; ++n)
        t.block[n] = static_cast<std::uint32_t>(std::lower_bound(pairs.begin(), pairs.end(),
                                                                 pair(t.v[kCornerPairs[n][0]], t.v[kCornerPairs[n][1]]),
                                                                 earlier) -
                                                pairs.begin());
      t.volume = double(m.volume[k]);
      tets_.push_back(t);
    }
    for (Array<Vec3d>* a : {&u_, &trial_, &start_, &goal_, &gradient_}) a->assign(v.points, Vec3d(0, 0, 0));
    mass_.resize(v.points), free_.resize(v.points), right_.resize(v.points), step_.resize(v.points);
    size_.resize(v.points);
    rounding_ = kDensityRounding * rest_stiffness(v.material) * m.rest_volume;
    const std::vector<double> whole(tets_.size(), 1);
    at_first_ = fastest_mode(m, v.points, v.material, v.density, whole, kModeIterations);
    reshape(v);
  }

  void reshape(const SoftView& v) {
    shape_ = v.shape;
    const SoftMesh& m = *v.mesh;
    Real most = 1;
    for (const Real x : m.stiffening) most = std::max(most, x);
    fastest_ = at_first_ * double(most);
    for (std::size_t k = 0; k < tets_.size(); ++k) {
      Tet& t = tets_[k];
      t.gradient[0] = Vec3d(0, 0, 0);
      for (int c = 1; c < 4; ++c) {
        for (int d = 0; d < 3; ++d)
          t.gradient[c][d] = double(m.inverse[9 * k + static_cast<std::size_t>(3 * (c - 1) + d)]);
        t.gradient[0] -= t.gradient[c];
      }
    }
  }

  // Start and goal of a solver substep, and the strain that damping resists a change of.
  void begin(const SoftView& v, Real h) {
    for (std::uint32_t i = 0; i < v.points; ++i) {
      const Row4& x = v.delta_position[i];
      free_[i] = x.w;
      mass_[i] = x.w != 0 ? 1 / double(x.w) : 0;
      if (x.w != 0) v.velocity[i].add(h * v.acceleration[i]);
      start_[i] = x.vec().cast<double>();
      goal_[i] = start_[i];
      if (x.w == 0) continue;
      goal_[i] += h_ * v.velocity[i].vec().cast<double>();
      // contacts push after it, so that what they push in would spring back in its substep, and they would feel no more
      // than m d/h^2: it expects them as they last were, and gives their part back
      goal_[i] += (h_ * h_) * v.steady_contact[i].cast<double>();
    }
    lag_ = std::fmax(double(v.damping) - h_, 0) / h_;
    if (lag_ > 0)
      for (Tet& t : tets_) {
        t.strain = green(deform(t, start_));
        const Mat3d square = 2 * t.strain + Mat3d::Identity();
        t.lag = lag_ * std::fmin(1, kDampingGrowth / square.norm());
      }
  }

  static Mat3d deform(const Tet& t, const Array<Vec3d>& u) {
    Mat3d f;
    f.setZero();
    for (int c = 0; c < 3; ++c) {
      const Vec3d e = t.base[c] + (u[t.v[c + 1]] - u[t.v[0]]);
      f.noalias() += e * t.gradient[c + 1].transpose();
    }
    return f;
  }
  static Mat3d green(const Mat3d& f) {
    Mat3d e;
    e.noalias() = f.transpose() * f;
    e.diagonal().array() -= 1;
    return 0.5 * e;
  }
  static double trace(const Mat3d& m) { return m(0, 0) + m(1, 1) + m(2, 2); }

  // J
  double energy(const SoftView& v, const Array<Vec3d>& u) const {
    double inertia = 0, elastic = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      const Vec3d d = u[i] - goal_[i];
      inertia += mass_[i] * dot_of(d, d);
    }
    for (const Tet& t : tets_) {
      const Mat3d f = deform(t, u);
      double density = v.law->energy(v.material, f);
      if (lag_ > 0) {
        const Mat3d e = green(f) - t.strain;
        density += t.lag * (v.material.mu * e.squaredNorm() + v.material.lame / 2 * trace(e) * trace(e));
      }
      elastic += t.volume * density;
    }
    return 0.5 * inertia / (h_ * h_) + elastic;
  }

  // Gradient and Hessian at u_; returns the residual, see above.
  double linearise(const SoftView& v, bool project) {
    matrix_.set_zero();
    const double none = kStrainRounding * rest_stiffness(v.material);
    for (std::uint32_t i = 0; i < v.points; ++i) {
      const double m = mass_[i] / (h_ * h_);
      gradient_[i] = m * (u_[i] - goal_[i]);
      matrix_.diagonal[i].diagonal().array() += m;
      size_[i] = length_of(gradient_[i]) + mass_[i] * double(length(v.acceleration[i]));
    }
    for (const Tet& t : tets_) add_tet(v, t, none, project);
    double residual = 0, scale = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      const double w = double(free_[i]);
      residual += w * dot_of(gradient_[i], gradient_[i]), scale += w * size_[i] * size_[i];
      // rounding of stiff blocks must not make it indefinite
      matrix_.diagonal[i].diagonal().array() += 1e-15 * trace(matrix_.diagonal[i]);
    }
    return scale > 0 ? std::sqrt(residual / scale) : residual;
  }

  void add_tet(const SoftView& v, const Tet& t, double none, bool project) {
    const Mat3d f = deform(t, u_);
    Mat3d stress = v.law->stress(v.material, f);
    CornerStiffness k;
    corner_stiffness(*v.law, v.material, f, t.gradient, project, k);
    if (lag_ > 0) add_damping(v, t, f, project, stress, k);
    for (int c = 0; c < 4; ++c) {
      Vec3d force;
      force.noalias() = stress * t.gradient[c];
      force *= t.volume;
      gradient_[t.v[c]] += force;
      size_[t.v[c]] += length_of(force) + none * t.volume * length_of(t.gradient[c]);
      matrix_.diagonal[t.v[c]] += t.volume * k.diagonal[c];
    }
    for (int n = 0; n < 6; ++n) {
      if (t.v[kCornerPairs[n][0]] < t.v[kCornerPairs[n][1]])
        matrix_.off[t.block[n]] += t.volume * k.off[n];
      else
        matrix_.off[t.block[n]] += t.volume * k.off[n].transpose();
    }
  }

  // Stress F S of the change of strain, S = 2 mu E + lambda tr E 1, and its Hessian; by Gauss and Newton if `project`.
  void add_damping(const SoftView& v, const Tet& t, const Mat3d& f, bool project, Mat3d& stress,
                   CornerStiffness& k) const {
    const double mu = t.lag * v.material.mu, lame = t.lag * v.material.lame;
    Mat3d s = green(f) - t.strain;
    const double all = trace(s);
    s *= 2 * mu;
    s.diagonal().array() += lame * all;
    stress.noalias() += f * s;
    Mat3d square;
    square.noalias() = f * f.transpose();
    Vec3d along[4];
    for (int c = 0; c < 4; ++c) along[c].noalias() = f * t.gradient[c];
    const auto add = [&](int a, int b, Mat3d& to) {
      to += (mu * dot_of(t.gradient[a], t.gradient[b])) * square;
      to.noalias() += mu * along[b] * along[a].transpose();
      to.noalias() += lame * along[a] * along[b].transpose();
      if (project) return;
      const Vec3d pulled = s * t.gradient[b];
      to.diagonal().array() += dot_of(t.gradient[a], pulled);
    };
    for (int c = 0; c < 4; ++c) add(c, c, k.diagonal[c]);
    for (int n = 0; n < 6; ++n) add(kCornerPairs[n][0], kCornerPairs[n][1], k.off[n]);
  }

  // Near the minimum the Hessian is positive as it is, and converges faster than what was made so.
  void minimise(const SoftView& v, double now) {
    bool project = true;
    for (int n = 0;; ++n) {
      const double residual = linearise(v, project);
      if (residual <= tolerance_) return;
      const bool gained = n < iterations_ && direction(v, residual, project) && search(v, now);
      if (!gained && (project || n >= iterations_)) {
        // a step that gains nothing is rounding where the residual is small
        if (residual > missed_) missed_ = residual, steps_ = n;
        return;
      }
      project = !(gained && direct_ && residual < kNear);
    }
  }

  // step_ towards the minimum of the quadratic model; false where there is none.
  bool direction(const SoftView& v, double residual, bool project) {
    double norm = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      right_[i] = free_[i] != 0 ? Vec3((-gradient_[i]).cast<Real>()) : Vec3(0, 0, 0);
      norm += double(dot(right_[i], right_[i]));
    }
    if (!std::isfinite(norm)) return false;
    bool factored = direct_ && ldl_.factor(matrix_, free_);
    if (!factored && !project) return false;
    if (!factored) {
      const double forcing = std::fmin(kMaxForcing, std::sqrt(residual));
      const bool iterated = cg_.solve(matrix_, free_, right_, {forcing, cg_iterations_}, step_).converged;
      factored = !iterated && !direct_ && factors_ && ldl_.factor(matrix_, free_);
      direct_ = direct_ || factored;  // for the rest of the step
    }
    if (factored) ldl_.solve(right_, free_, step_);
    return true;
  }

  // Halves the step until the energy falls enough; true when it did. A free body stays on its goal as a whole, which a
  // linear solve to a tolerance would not give.
  bool search(const SoftView& v, double& now) {
    double slope = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) slope += dot_of(gradient_[i], step_[i].cast<double>());
    if (!(slope < 0)) return false;
    double s = 1;
    for (int n = 0; n < kHalvings; ++n, s /= 2) {
      for (std::uint32_t i = 0; i < v.points; ++i) trial_[i] = u_[i] + s * step_[i].cast<double>();
      each_free_part(v, [&](std::span<const std::uint32_t> part) { centre(part, trial_); });
      const double then = energy(v, trial_);
      if (!(then <= now + kArmijo * s * slope + kEnergyRounding * std::fabs(now) + rounding_)) continue;
      std::swap(u_, trial_);
      now = then;
      return true;
    }
    return false;
  }

  template <class F>
  void each_free_part(const SoftView& v, F&& f) const {
    for (std::uint32_t n = 0; n < v.mesh->parts(); ++n) {
      const std::span<const std::uint32_t> part = v.mesh->part(n);
      if (std::none_of(part.begin(), part.end(), [&](std::uint32_t i) { return free_[i] == 0; })) f(part);
    }
  }

  double mass_of(std::span<const std::uint32_t> part) const {
    double sum = 0;
    for (const std::uint32_t i : part) sum += mass_[i];
    return sum;
  }

  void centre(std::span<const std::uint32_t> part, Array<Vec3d>& u) const {
    Vec3d mean(0, 0, 0);
    for (const std::uint32_t i : part) mean += mass_[i] * (u[i] - goal_[i]);
    mean /= mass_of(part);
    for (const std::uint32_t i : part) u[i] -= mean;
  }

  // Linear momentum and the torque about where the solver substep began.
  void take_out(const SoftView& v, std::span<const std::uint32_t> part) {
    centre(part, u_);
    const auto place = [&](std::uint32_t k) {
      return Vec3(v.position[part[k]] - v.position[part[0]] + v.delta_position[part[k]].vec());
    };
    const auto count = static_cast<std::uint32_t>(part.size());
    Vec3d gained(0, 0, 0);  // kg m^2
    for (std::uint32_t k = 0; k < count; ++k) {
      const Vec3d r = place(k).cast<double>(), d = mass_[part[k]] * (u_[part[k]] - goal_[part[k]]);
      gained += Vec3d(r[1] * d[2] - r[2] * d[1], r[2] * d[0] - r[0] * d[2], r[0] * d[1] - r[1] * d[0]);
    }
    take_out_spin(
        gained.cast<Real>(), count, static_cast<Real>(mass_of(part)), 0,
        [&](std::uint32_t k) { return static_cast<Real>(mass_[part[k]]); }, place,
        [&](std::uint32_t k, const Vec3& change) { u_[part[k]] += change.cast<double>(); });
  }

  double tolerance_;
  int iterations_, steps_ = 0;  // the latter: of Newton, where it missed the tolerance
  std::uint64_t version_ = ~std::uint64_t(0), shape_ = 0;
  Array<Tet> tets_;
  // displacements since the start of the step by point, m: reached, tried, at the start of the solver substep, of
  // inertia alone
  Array<Vec3d> u_, trial_, start_, goal_;
  Array<Vec3d> gradient_;  // N
  Array<double> mass_;     // kg; 0: fixed
  Array<Real> free_;       // inverse masses
  Array<Vec3> right_, step_;
  Array<double> size_;  // sum of the magnitudes of forces, N
  BlockSparse matrix_;
  BlockLdl ldl_;
  ConjugateGradient cg_;
  bool factors_ = false, cheap_ = false;  // it may be factored; at no more than a few iterations cost
  bool direct_ = false;                   // it is, for this step
  int cg_iterations_ = 0;
  double h_ = 0, lag_ = 0;             // s; damping time beyond h, over h
  double at_first_ = 0, fastest_ = 0;  // w^2 of the fastest mode, 1/s^2: before anything flowed, and now
  double rounding_ = 0;                // J, of the energy
  double missed_ = 0;                  // the largest residual above the tolerance in this step
};

}  // namespace

Variant<SoftSolver> soft_implicit() {
  return {
      "implicit", "backward Euler by Newton's method to a tolerance: the truth of studies, slow",
      [](Arena& a, const Params& p) -> std::unique_ptr<SoftSolver> { return std::make_unique<SoftImplicit>(a, p); }};
}

}  // namespace feder
