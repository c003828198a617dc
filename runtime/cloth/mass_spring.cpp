// The classical mass-spring cloth (Provot 1995): links of the mesh as stretch springs, a spring across each hinge
// against bending, moved by an integrator of choice; Heun unless another is named. Contact corrections are relaxed by
// a quarter (Bridson et al. 2002). Strain rate is taken out between substeps, not by the integrator.
// A spring across a hinge of heights a, b has the stiffness that stores a hinge's energy at a fold of 1 rad,
// k = 4 bend_hinge (a + b)^2/(a b)^2. Weak spot: its energy grows with the fourth power of the fold, so a flat sheet
// has no bending stiffness at all: the tip of a clamped strip of 10 segments drops by 0.82, 7.2, 47 m per load for
// loads of 1, 0.1, 0.01 (hinges: 0.42, 0.50, 0.50; tests/cloth/test_mass_spring.cpp); and explicit integrators need
// solver substeps below a part of 1/w of the stiffest link. Heun is unstable for any undamped oscillator, by (h w)^4/8
// per step: it lives on the damping. Where nobody named an integrator, one that no stiffness makes unstable takes over
// where the default would need more than kLeastCap solver substeps. Kept between steps: springs of the mesh.
#include <algorithm>
#include <cmath>

#include "cloth/batches.h"
#include "feder/snapshot.h"
#include "integrate/integrator.h"
#include "integrate/limits.h"

namespace feder {
namespace {

constexpr double kLimitShare = 0.5;  // of the stability limit
// largest h w for methods that have no limit: Heun grows by e^(z^4/8) a step, which weak damping does not shed at
// larger z
constexpr double kGrowingLimit = 0.1;
constexpr double kMinCap = 256;
constexpr double kSlack = 1.001;   // for rounding of the chosen number of solver substeps
constexpr double kStiffSteps = 4;  // solver substeps of the method that takes over: contacts need some
constexpr const char* kStiffMethod = "implicit_euler";
const Vec3 kNoDirection = Vec3(1, 0, 0);

struct Spring {
  std::uint32_t i, j;  // i < j
  Real rest, stiffness;
};

bool has_integrator(std::string_view name) { return default_variant(integrators(), name) == name; }

std::string default_integrator() {
  if (!has_integrator("heun") && has_integrator("velocity_verlet")) return "velocity_verlet";
  return default_variant(integrators(), "heun");
}

class MassSpring final : public ClothSolver, private ForceField {
 public:
  MassSpring(Arena& a, const Params& p) : batches_(a), springs_(&a), x_(&a), v_(&a), inv_mass_(&a), view_{} {
    const std::string name = p.text({"integrator"}, default_integrator());
    take(a, name, explicit_);
    if (!p.has("integrator") && has_integrator(kStiffMethod)) take(a, kStiffMethod, stiff_);
  }

  void prepare(const ClothView& v, StepContext& c) override {
    bool same = !build(v);
    if (v.flows)
      for (std::size_t k = 0; k < v.mesh->links.size(); ++k) springs_[k].rest = v.mesh->links[k].rest;
    batches_.build(v);
    batches_.current_position(v, *c.jobs);
    same = same && inv_mass_.size() == v.points;
    inv_mass_.resize(v.points);
    for (std::uint32_t i = 0; i < v.points; ++i) {
      same = same && inv_mass_[i] == v.delta_position[i].w;
      inv_mass_[i] = v.delta_position[i].w;
    }
    if (!same) fastest_ = fastest(v);
    overstretched_ = stiff_.integrator && overstretched(v);
  }

  void advance(const ClothView& v, double t, Real h, StepContext& c) override {
    FEDER_ASSERT(version_ == v.version && inv_mass_.size() == v.points && h > 0);
    view_ = v;
    Method& method = at(h);
    x_.resize(v.points), v_.resize(v.points);
    for (std::uint32_t i = 0; i < v.points; ++i) x_[i] = v.delta_position[i].vec(), v_[i] = v.velocity[i].vec();
    method.integrator->step(*this, t, h, {x_.data(), v.points}, {v_.data(), v.points});
    for (std::uint32_t i = 0; i < v.total; ++i) {
      v.before[i] = {v.delta_position[i].x, v.delta_position[i].y, v.delta_position[i].z, 1};
      if (i < v.points && v.delta_position[i].w != 0) v.delta_position[i].set(x_[i]), v.velocity[i].set(v_[i]);
    }
    batches_.limit(v, h, c);
    batches_.tie(v, h, c);
    for (std::uint32_t i = 0; i < v.points; ++i) v.before[i] = {x_[i][0], x_[i][1], x_[i][2], 1};
  }

  void damp(const ClothView& v, Real h, StepContext& c) override {
    if (v.damping > 0) batches_.damp_links(v, h, c), batches_.damp_hinges(v, h, c);
  }
  double longest_damping(Real h) const override { return batches_.longest_damping(h); }

  void validate(const ClothView& v) const override {
    batches_.validate(v);
    if (version_ != v.version) return;
    FEDER_ASSERT(springs_.size() >= v.mesh->links.size());
    for (const Spring& s : springs_) FEDER_ASSERT(s.i <= s.j && s.j < v.points && !(s.rest < 0));
  }

  double wanted_substeps(const ClothView& v, Real h) const override {
    return std::sqrt(fastest(v)) * double(h) / stability_limit();
  }
  bool carries_bodies() const override { return false; }
  double substeps_beyond(double cap) const override { return stiff_.integrator ? kStiffSteps : cap; }

  void save(Writer& w) const override {
    for (const Method* m : {&explicit_, &stiff_})
      if (m->integrator) w.list(m->integrator->memory.points), w.list(m->integrator->memory.numbers);
  }
  void load(Reader& r) override {
    for (Method* m : {&explicit_, &stiff_})
      if (m->integrator) r.list(m->integrator->memory.points), r.list(m->integrator->memory.numbers);
  }
  Real lead(Real h) const override { return takes_over(h) ? stiff_.lead : explicit_.lead; }
  Real relaxation() const override { return Real(0.25); }
  bool sheds_strain() const override { return false; }
  double least_cap() const override { return kMinCap; }
  const char* beyond_cap() const override {
    return stiff_.integrator ? "is moved by implicit_euler, which damps fast motion; soften it, or take xpbd"
                             : "may be unstable; soften it, or take implicit_euler or xpbd";
  }

 private:
  struct Method {
    std::unique_ptr<Integrator> integrator;
    Real lead = 0;
  };
  static void take(Arena& a, const std::string& name, Method& method) {
    Params none;
    const Variant<Integrator>& row = find_variant(integrators(), name, "integrator");
    method.lead = free_fall_lead(*row.make(a, none));
    method.integrator = row.make(a, none);
  }
  // The largest h times the fastest angular frequency at which the method is used.
  double stability_limit() const {
    const double limit = explicit_.integrator->info().stability_limit;
    return limit > 0 ? kLimitShare * limit : kGrowingLimit;
  }
  bool takes_over(Real h) const {
    return overstretched_ || (stiff_.integrator && std::sqrt(fastest_) * double(h) > kSlack * stability_limit());
  }
  Method& at(Real h) { return takes_over(h) ? stiff_ : explicit_; }

  // Bound of w^2 of the fastest mode, 1/s^2: the largest row sum of the stiffness matrix over mass (Gershgorin).
  static double fastest(const ClothView& v) {
    std::vector<double> stiff(v.points, 0);
    double most = 0;
    each_spring(v, [&](const Spring& s) {
      stiff[s.i] += double(s.stiffness) * (v.delta_position[s.j].w != 0 ? 2 : 1);
      stiff[s.j] += double(s.stiffness) * (v.delta_position[s.i].w != 0 ? 2 : 1);
    });
    for (std::uint32_t i = 0; i < v.points; ++i) most = std::max(most, stiff[i] * double(v.delta_position[i].w));
    return most;
  }

  // A link is pulled to kOverstretch times its length. It then is nearly as stiff across as along, and damping of
  // strain takes nothing from motion across: energy that an explicit method adds there stays.
  static bool overstretched(const ClothView& v) {
    constexpr Real kOverstretch = 2;
    return std::any_of(v.mesh->links.begin(), v.mesh->links.end(), [&](const ClothLink& l) {
      const Vec3 e = v.position[l.b] - v.position[l.a];
      return dot(e, e) > kOverstretch * kOverstretch * l.rest * l.rest;
    });
  }

  template <class F>
  static void each_spring(const ClothView& v, F&& f) {
    for (const ClothLink& l : v.mesh->links) f(Spring{l.a, l.b, l.rest, l.stiffness});
    for (const ClothHinge& k : v.mesh->hinges) {
      const std::uint32_t i = std::min(k.v[2], k.v[3]), j = std::max(k.v[2], k.v[3]);
      FEDER_ASSERT(i < v.points && j + 1 < v.total);
      if (j >= v.points) continue;  // a ghost vertex: springs cannot hold a slope
      const Vec3 e = v.rest[k.v[1]] - v.rest[k.v[0]];
      const Real size = length(e), a = length(cross(e, v.rest[k.v[2]] - v.rest[k.v[0]])) / size,
                 b = length(cross(e, v.rest[k.v[3]] - v.rest[k.v[0]])) / size;
      f(Spring{i, j, length(v.rest[j] - v.rest[i]), 4 * k.stiffness * (a + b) * (a + b) / (a * a * b * b)});
    }
  }

  bool build(const ClothView& v) {  // false: nothing changed
    if (version_ == v.version) return false;
    version_ = v.version;
    springs_.clear();
    each_spring(v, [&](const Spring& s) { springs_.push_back(s); });
    return true;
  }

  Vec3 edge(const Spring& s, std::span<const Vec3> x) const {
    return (view_.position[s.j] - view_.position[s.i]) + (x[s.j] - x[s.i]);
  }

  // ForceField, at displacements since the start of the step.
  std::size_t count() const override { return view_.points; }
  std::span<const Real> inv_mass() const override { return {inv_mass_.data(), inv_mass_.size()}; }
  std::span<const Real> mass() const override { return {view_.mass, view_.points}; }
  bool damped() const override { return false; }
  bool stiff_damping(Real) const override { return false; }
  void eval(std::span<const Vec3> x, std::span<const Vec3>, double, std::span<Vec3> force) override {
    FEDER_ASSERT(x.size() == view_.points && force.size() == view_.points);
    for (std::uint32_t i = 0; i < view_.points; ++i) force[i] = view_.mass[i] * view_.acceleration[i];
    for (const Spring& s : springs_) {
      const Vec3 e = edge(s, x);
      const Vec3 f = normalized_or(e, kNoDirection) * (s.stiffness * (length(e) - s.rest));
      force[s.i] += f;
      force[s.j] -= f;
    }
  }
  void damping(std::span<const Vec3>, std::span<const Vec3>, double, BlockSparse& d) override { d.set_zero(); }
  // As for nets: the indefinite part of a compressed spring is dropped (Choi & Ko 2002).
  void jacobian(std::span<const Vec3> x, std::span<const Vec3>, double, BlockSparse& k, BlockSparse& d) override {
    d.set_zero(), k.set_zero();
    FEDER_ASSERT(k.off.size() == springs_.size());  // in the order of pattern()
    for (std::size_t n = 0; n < springs_.size(); ++n) {
      const Spring& s = springs_[n];
      const Vec3d e = edge(s, x).cast<double>();
      const double size = std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]), stiffness = s.stiffness, rest = s.rest;
      const Vec3d u = size > 0 ? Vec3d(e / size) : Vec3d(1, 0, 0);
      const double across = size > rest ? stiffness * (1 - rest / size) : 0;
      Mat3d block;
      for (int col = 0; col < 3; ++col) block.col(col) = ((stiffness - across) * u[col]) * u;
      block.diagonal().array() += across;
      k.diagonal[s.i] -= block;
      k.diagonal[s.j] -= block;
      k.off[n] = block;
    }
  }
  void pattern(std::vector<BlockIndex>& blocks) const override {
    for (const Spring& s : springs_) blocks.push_back({s.i, s.j});
  }
  std::uint64_t pattern_version() const override { return version_; }

  ClothBatches batches_;  // for damping
  Array<Spring> springs_;
  Array<Vec3> x_, v_;
  Array<Real> inv_mass_;
  ClothView view_;
  Method explicit_, stiff_;     // as named, or the default; the one that takes over from the default, if any
  double fastest_ = 0;          // bound of w^2, 1/s^2
  bool overstretched_ = false;  // in this step
  std::uint64_t version_ = ~std::uint64_t(0);
};

}  // namespace

Variant<ClothSolver> cloth_mass_spring() {
  return {"mass_spring", "stretch and bend springs with an integrator by name; no bending stiffness when flat",
          [](Arena& a, const Params& p) -> std::unique_ptr<ClothSolver> { return std::make_unique<MassSpring>(a, p); }};
}

}  // namespace feder
