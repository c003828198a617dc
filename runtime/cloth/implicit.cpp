// Implicit Euler cloth, the truth of studies: each solver substep of h goes to the minimum of the incremental potential
//   E(x) = sum m |x - y|^2/(2 h^2) + sum of links k (l - rest)^2/2 + sum of hinges k (angle - rest)^2/2,
// y = x0 + h v + h^2 a (Martin et al. 2011, eq. 5), by Newton's method with a line search on E, in double whatever Real
// is. Hessian: links exactly where they are stretched, hinges by Gauss and Newton, k grad grad^T; of a compressed link
// only so much of the negative part across it as the inertia of its ends outweighs (Choi and Ko 2002 drop all of it),
// so the matrix is positive definite. It is factored where that is cheap (linear/block_ldl.h), else solved by
// conjugate gradients as exactly as the step of Newton can use (Eisenstat and Walker 1996). Damping is part of the
// potential: k tau/(2 h) (l - l0)^2 resists what changes a length or an angle from l0 at the start of the substep, so
// turning as a whole is free of it and there is no longest damping. The method itself damps like a material of tau = h,
// which counts as part of `damping`: a mode decays at max(damping, h) w^2/2. `max_strain` makes a link kLimitStiffness
// times as stiff just below it; ties are not needed. `tolerance` is that of the residual force over the sum of the
// magnitudes of all forces at the vertices, in the norm of the inverse mass; a solver substep that misses it within
// `iterations` steps of Newton is spoken of.
// Kept between steps: layout of the matrix by mesh. Weak spot: one thread, and 50 to 100 times the cost of xpbd;
// Gauss-Newton hinges converge linearly where cloth is creased sharply; contacts correct what it has reached.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cloth/batches.h"
#include "cloth/dihedral.h"
#include "cloth/solver.h"
#include "linear/block_ldl.h"
#include "linear/cg.h"

namespace feder {
namespace {

constexpr double kLimitStiffness = 1000;   // of a link at max_strain, times its own
constexpr double kLimitBegins = 0.99;      // of max_strain, where that begins
constexpr double kAcrossShare = 0.2;       // of the inertia of a vertex that compressed links may take from it
constexpr double kArmijo = 1e-4;           // share of the slope that a step has to gain
constexpr double kEnergyRounding = 1e-13;  // of the sum of all energies
constexpr double kMaxForcing = 0.1;        // largest residual that a linear solve may leave
constexpr double kStiffSubstep = 200;      // largest h^2 sum k/m of a vertex that contacts bear
constexpr int kHalvings = 30;              // of a step in the line search
constexpr int kCgPerPoint = 3;             // cap of a linear solve, iterations
constexpr std::uint64_t kFactorFloor = 20'000, kFactorPerBlock = 60;  // block products that cost less than iterating

Double3 row_of(const Row4& r) { return {double(r.x), double(r.y), double(r.z)}; }
void add_to(Double3& sum, const Double3& d) { sum.x += d.x, sum.y += d.y, sum.z += d.z; }

// s a b^T
Mat3d outer(double s, const Double3& a, const Double3& b) {
  Mat3d m;
  m << s * a.x * b.x, s * a.x * b.y, s * a.x * b.z, s * a.y * b.x, s * a.y * b.y, s * a.y * b.z, s * a.z * b.x,
      s * a.z * b.y, s * a.z * b.z;
  return m;
}

class ImplicitCloth final : public ClothSolver {
 public:
  ImplicitCloth(Arena& arena, const Params& p)
      : tolerance_(p.number({"tolerance", "", {0, 1, true}}, 1e-5)),
        iterations_(p.integer({"iterations", "", {1, 10'000}}, 50)), links_(&arena), hinges_(&arena), degree_(&arena),
        u_(&arena), trial_(&arena), start_(&arena), goal_(&arena), gradient_(&arena), free_(&arena), right_(&arena),
        step_(&arena), size_(&arena), matrix_(arena), ldl_(arena), cg_(arena) {}

  void prepare(const ClothView& v, StepContext&) override {
    build(v);
    if (v.flows) {
      for (std::size_t k = 0; k < links_.size(); ++k) links_[k].rest = double(v.mesh->links[k].rest);
      for (std::size_t k = 0; k < hinges_.size(); ++k) hinges_[k].rest = double(v.mesh->hinges[k].angle);
    }
    missed_ = 0;
    for (Link& l : links_) l.base = wide(v.position[l.b] - v.position[l.a]);
    for (Hinge& k : hinges_)
      for (int i = 0; i < 3; ++i) k.base[i] = wide(v.position[k.v[i + 1]] - v.position[k.v[0]]);
  }

  void advance(const ClothView& v, double, Real h, StepContext&) override {
    FEDER_ASSERT(version_ == v.version && h > 0);
    h_ = double(h);
    begin(v, h);
    // from the better of two guesses: where nothing but inertia acts, and where it is
    const double coasting = energy(v, goal_), standing = energy(v, start_);
    const Array<Double3>& guess = coasting < standing ? goal_ : start_;
    std::copy(guess.begin(), guess.end(), u_.begin());
    minimise(v, std::fmin(coasting, standing));
    for (std::uint32_t i = 0; i < v.total; ++i)
      if (free_[i] != 0) v.delta_position[i].set(narrow(u_[i]));
  }

  void damp(const ClothView&, Real, StepContext&) override {}
  // Any number does for the sheet itself. But contacts and attached bodies move vertices between solver substeps, which
  // stores k d^2/2 in its links, and feel no more than m d/h^2.
  double wanted_substeps(const ClothView& v, Real h) const override {
    return double(h) * std::sqrt(stiffest_link(v) / kStiffSubstep);
  }
  bool sheds_strain() const override { return false; }
  bool converges() const override { return true; }
  std::string shortfall() const override {
    if (!(missed_ > 0)) return "";
    return "stopped after " + std::to_string(iterations_) + " steps of Newton at a residual of " +
           print_number(missed_) + ", its tolerance is " + print_number(tolerance_) +
           ": more solver substeps or a larger solver_options.iterations would do";
  }
  void validate(const ClothView& v) const override {
    if (version_ != v.version) return;
    FEDER_ASSERT(links_.size() == v.mesh->links.size() && hinges_.size() == v.mesh->hinges.size());
    for (const Link& l : links_) FEDER_ASSERT(l.a < v.points && l.b < v.points && l.block < matrix_.off.size());
    for (const Hinge& k : hinges_)
      for (const std::uint32_t i : k.v) FEDER_ASSERT(i + 1 < v.total);
  }

 private:
  struct Link {
    std::uint32_t a, b, block;
    double rest, stiffness;           // m, N/m
    double pull, target;              // N/m, m: with damping, in this solver substep
    double longest, limit_stiffness;  // m, N/m: of the strain limit
    Double3 base;                     // b minus a at the start of the step, m
  };
  struct Hinge {
    std::uint32_t v[4], block[6];
    double rest, stiffness;  // rad, N m
    double pull, target;     // N m, rad
    HingeFloor floor;
    Double3 base[3];  // v[1], v[2], v[3] minus v[0] at the start of the step, m
  };
  static constexpr int kPair[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

  void build(const ClothView& v) {
    if (version_ == v.version) return;
    version_ = v.version;
    // pattern: each pair of vertices that share an element
    std::vector<BlockIndex> pairs;
    const auto pair = [](std::uint32_t i, std::uint32_t j) { return BlockIndex{std::min(i, j), std::max(i, j)}; };
    const auto earlier = [](const BlockIndex& a, const BlockIndex& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; };
    for (const ClothLink& l : v.mesh->links) pairs.push_back(pair(l.a, l.b));
    for (const ClothHinge& k : v.mesh->hinges)
      for (const auto& p : kPair) pairs.push_back(pair(k.v[p[0]], k.v[p[1]]));
    std::sort(pairs.begin(), pairs.end(), earlier);
    pairs.erase(std::unique(pairs.begin(), pairs.end(),
                            [](const BlockIndex& a, const BlockIndex& b) { return a.i == b.i && a.j == b.j; }),
                pairs.end());
    matrix_.set_pattern(v.total, pairs);
    direct_ = ldl_.analyze(v.total, pairs, std::max(kFactorFloor, kFactorPerBlock * (v.total + 2 * pairs.size())));
    const auto slot = [&](std::uint32_t i, std::uint32_t j) {
      return static_cast<std::uint32_t>(std::lower_bound(pairs.begin(), pairs.end(), pair(i, j), earlier) -
                                        pairs.begin());
    };
    // elements
    links_.clear(), hinges_.clear(), degree_.assign(v.total, 0);
    for (const ClothLink& l : v.mesh->links) {
      Link to{};
      to.a = l.a, to.b = l.b, to.block = slot(l.a, l.b);
      to.rest = double(l.rest), to.stiffness = double(l.stiffness);
      links_.push_back(to);
      ++degree_[l.a], ++degree_[l.b];
    }
    for (const ClothHinge& k : v.mesh->hinges) {
      Hinge to{};
      std::copy(k.v, k.v + 4, to.v);
      for (int n = 0; n < 6; ++n) to.block[n] = slot(k.v[kPair[n][0]], k.v[kPair[n][1]]);
      to.rest = double(k.angle), to.stiffness = double(k.stiffness);
      to.floor = hinge_floor(k, v.rest);
      hinges_.push_back(to);
    }
    for (Array<Double3>* a : {&u_, &trial_, &start_, &goal_, &gradient_}) a->assign(v.total, Double3{0, 0, 0});
    free_.resize(v.total), right_.resize(v.total), step_.resize(v.total), size_.resize(v.total);
  }

  // Start and goal of a solver substep, and what its elements pull towards.
  void begin(const ClothView& v, Real h) {
    afloat_ = true;
    for (std::uint32_t i = 0; i < v.total; ++i) {
      Row4& x = v.delta_position[i];
      free_[i] = x.w;
      afloat_ = afloat_ && (i >= v.points || x.w != 0);
      v.before[i] = {x.x, x.y, x.z, 0};
      if (x.w != 0) v.velocity[i].add(h * v.acceleration[i]);
      start_[i] = row_of(x);
      goal_[i] = start_[i] + double(h) * (x.w != 0 ? row_of(v.velocity[i]) : Double3{0, 0, 0});
    }
    const double lag = std::fmax(double(v.damping) - h_, 0) / h_;
    for (Link& l : links_) {
      const double size = length(edge(l, start_)), longest = l.rest * (1 + kLimitBegins * double(v.max_strain));
      l.pull = l.stiffness * (1 + lag), l.target = (l.rest + lag * size) / (1 + lag);
      l.longest = std::fmax(longest, size - double(kShedSpeed) * h_);
      l.limit_stiffness = kLimitStiffness * l.stiffness;
    }
    for (Hinge& k : hinges_) {
      const Dihedral<Double3> d = shape(k, start_);
      const double bent = within_turn(arc_tangent2(d.sine, d.cosine) - k.rest);
      k.pull = k.stiffness * (1 + lag), k.target = k.rest + bent * lag / (1 + lag);
    }
  }

  static Double3 edge(const Link& l, const Array<Double3>& u) { return l.base + (u[l.b] - u[l.a]); }
  static Dihedral<Double3> shape(const Hinge& k, const Array<Double3>& u) {
    Double3 e[3] = {};
    for (int i = 0; i < 3; ++i) e[i] = k.base[i] + (u[k.v[i + 1]] - u[k.v[0]]);
    return dihedral(e[0], e[1], e[2], k.floor);
  }
  static double bent(const Hinge& k, const Dihedral<Double3>& d) {
    return within_turn(within_turn(arc_tangent2(d.sine, d.cosine) - k.target));
  }

  // J
  double energy(const ClothView& v, const Array<Double3>& u) const {
    double inertia = 0, links = 0, hinges = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      const Double3 d = u[i] - goal_[i];
      if (free_[i] != 0) inertia += double(v.mass[i]) * dot(d, d);
    }
    for (const Link& l : links_) {
      const double size = length(edge(l, u)), over = size - l.longest, off = size - l.target;
      links += l.pull * off * off + (over > 0 ? l.limit_stiffness * over * over : 0);
    }
    for (const Hinge& k : hinges_) {
      const double angle = bent(k, shape(k, u));
      hinges += k.pull * angle * angle;
    }
    return 0.5 * (inertia / (h_ * h_) + links + hinges);
  }

  // Gradient and Hessian at u_; returns the residual, see above.
  double linearise(const ClothView& v) {
    matrix_.set_zero();
    for (std::uint32_t i = 0; i < v.total; ++i) {
      const double m = i < v.points ? double(v.mass[i]) / (h_ * h_) : 0;
      gradient_[i] = m * (u_[i] - goal_[i]);
      matrix_.diagonal[i].diagonal().array() += m;
      size_[i] = length(gradient_[i]) + m * h_ * h_ * double(length(v.acceleration[i]));
    }
    for (const Link& l : links_) add_link(v, l);
    for (const Hinge& k : hinges_) add_hinge(k);
    double residual = 0, scale = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      const double w = double(free_[i]);
      residual += w * dot(gradient_[i], gradient_[i]), scale += w * size_[i] * size_[i];
      // rounding of stiff blocks must not make it indefinite
      matrix_.diagonal[i].diagonal().array() += 1e-15 * matrix_.diagonal[i].trace();
    }
    return scale > 0 ? std::sqrt(residual / scale) : residual;
  }

  void add_link(const ClothView& v, const Link& l) {
    const Double3 e = edge(l, u_);
    const double size = length(e), over = size - l.longest;
    const Double3 n = size > 0 ? (1 / size) * e : Double3{1, 0, 0};
    const double limit = over > 0 ? l.limit_stiffness : 0;
    const double force = l.pull * (size - l.target) + limit * std::fmax(over, 0), along = l.pull + limit;
    // stiffness across the link is force/length; of a negative one what inertia outweighs
    double across = size > 0 ? force / size : 0;
    if (!(across > 0)) {
      double least = 0;
      for (const std::uint32_t i : {l.a, l.b})
        if (free_[i] != 0)
          least = std::fmax(least, -across * double(degree_[i]) * h_ * h_ / (kAcrossShare * double(v.mass[i])));
      across = least > 1 ? across / least : across;
    }
    Mat3d block = outer(along - across, n, n);
    block.diagonal().array() += across;
    matrix_.diagonal[l.a] += block, matrix_.diagonal[l.b] += block;
    matrix_.off[l.block] -= block;
    add_to(gradient_[l.a], -force * n), add_to(gradient_[l.b], force * n);
    size_[l.a] += std::fabs(force), size_[l.b] += std::fabs(force);
  }

  void add_hinge(const Hinge& k) {
    const Dihedral<Double3> d = shape(k, u_);
    const double torque = k.pull * bent(k, d);
    for (int i = 0; i < 4; ++i) {
      const Double3& g = d.gradient[i];
      matrix_.diagonal[k.v[i]] += outer(k.pull, g, g);
      add_to(gradient_[k.v[i]], torque * g);
      size_[k.v[i]] += std::fabs(torque) * length(g);
    }
    for (int n = 0; n < 6; ++n) {
      const bool ahead = k.v[kPair[n][0]] < k.v[kPair[n][1]];
      const int i = kPair[n][ahead ? 0 : 1], j = kPair[n][ahead ? 1 : 0];
      matrix_.off[k.block[n]] += outer(k.pull, d.gradient[i], d.gradient[j]);
    }
  }

  void minimise(const ClothView& v, double now) {
    for (int n = 0;; ++n) {
      const double residual = linearise(v);
      if (residual <= tolerance_) return;
      if (n == iterations_ || !direction(v, residual) || !search(v, now)) {
        // a step that gains nothing is rounding where the residual is small
        missed_ = std::fmax(missed_, residual);
        return;
      }
    }
  }

  // step_ towards the minimum of the quadratic model; false where there is none.
  bool direction(const ClothView& v, double residual) {
    double norm = 0;
    for (std::uint32_t i = 0; i < v.total; ++i) {
      right_[i] = free_[i] != 0 ? narrow(-gradient_[i]) : Vec3(0, 0, 0);
      norm += double(dot(right_[i], right_[i]));
    }
    if (!std::isfinite(norm)) return false;
    if (direct_ && ldl_.factor(matrix_, free_)) {
      ldl_.solve(right_, free_, step_);
      return true;
    }
    const double forcing = std::fmin(kMaxForcing, std::sqrt(residual));
    cg_.solve(matrix_, free_, right_, {forcing, kCgPerPoint * static_cast<int>(v.total) + 50}, step_);
    return true;
  }

  // Halves the step until the energy falls enough; true when it did. A free cloth stays on its goal as a whole, which a
  // linear solve to a tolerance would not give.
  bool search(const ClothView& v, double& now) {
    double slope = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) slope += dot(gradient_[i], wide(step_[i]));
    if (!(slope < 0)) return false;
    double s = 1;
    for (int n = 0; n < kHalvings; ++n, s /= 2) {
      for (std::uint32_t i = 0; i < v.total; ++i) trial_[i] = u_[i] + s * wide(step_[i]);
      if (afloat_) centre(v);
      const double then = energy(v, trial_);
      if (!(then <= now + kArmijo * s * slope + kEnergyRounding * now)) continue;
      std::swap(u_, trial_);
      now = then;
      return true;
    }
    return false;
  }

  void centre(const ClothView& v) {
    Double3 mean{0, 0, 0};
    double mass = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      add_to(mean, double(v.mass[i]) * (trial_[i] - goal_[i]));
      mass += double(v.mass[i]);
    }
    mean = (1 / mass) * mean;
    for (std::uint32_t i = 0; i < v.points; ++i) trial_[i] = trial_[i] - mean;
  }

  double tolerance_;
  int iterations_;
  std::uint64_t version_ = ~std::uint64_t(0);
  Array<Link> links_;
  Array<Hinge> hinges_;
  Array<std::uint32_t> degree_;  // links at a vertex
  // displacements since the start of the step by vertex, m: reached, tried, at the start of the solver substep, of
  // inertia alone
  Array<Double3> u_, trial_, start_, goal_;
  Array<Double3> gradient_;  // N
  Array<Real> free_;         // inverse masses
  Array<Vec3> right_, step_;
  Array<double> size_;  // sum of the magnitudes of forces, N
  BlockSparse matrix_;
  BlockLdl ldl_;
  ConjugateGradient cg_;
  bool direct_ = false, afloat_ = false;  // factored; nothing holds it
  double h_ = 0, missed_ = 0;             // s; the largest residual above the tolerance in this step
};

}  // namespace

Variant<ClothSolver> cloth_implicit() {
  return {
      "implicit", "implicit Euler by Newton's method to a tolerance: the truth of studies, slow",
      [](Arena& a, const Params& p) -> std::unique_ptr<ClothSolver> { return std::make_unique<ImplicitCloth>(a, p); }};
}

}  // namespace feder
