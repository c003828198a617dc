// A box that spins freely near its middle axis and tumbles over again and again: numerics.md 2.6, rigid.md 5.4. Errors
// are those of the tips of its three unit axes; angular momentum is world fixed.
#include "base/math.h"
#include "study/rigid_problem.h"
#include "study/top.h"

namespace feder {

void TopEquation::operator()(Wide, const Wide* y, Wide* d) const {
  const Wide *w = y, *q = y + 3;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    d[i] = (inertia[j] - inertia[k]) * w[j] * w[k];
  }
  if (weight != 0) {
    // up in body axes: the middle row of R
    const Wide up[3] = {2 * (q[0] * q[1] + q[2] * q[3]), 1 - 2 * (q[0] * q[0] + q[2] * q[2]),
                        2 * (q[1] * q[2] - q[0] * q[3])};
    // axis x (-weight up)
    const int j = (axis + 1) % 3, k = (axis + 2) % 3;
    d[j] += weight * up[k];
    d[k] -= weight * up[j];
  }
  for (int i = 0; i < 3; ++i) d[i] /= inertia[i];
  d[3] = (q[3] * w[0] + q[1] * w[2] - q[2] * w[1]) / 2;
  d[4] = (q[3] * w[1] + q[2] * w[0] - q[0] * w[2]) / 2;
  d[5] = (q[3] * w[2] + q[0] * w[1] - q[1] * w[0]) / 2;
  d[6] = -(q[0] * w[0] + q[1] * w[1] + q[2] * w[2]) / 2;
}

void axis_of(const Wide* q, int axis, Wide (&out)[3]) {
  const int i = axis, j = (axis + 1) % 3, k = (axis + 2) % 3;
  out[i] = 1 - 2 * (q[j] * q[j] + q[k] * q[k]);
  out[j] = 2 * (q[i] * q[j] + q[k] * q[3]);
  out[k] = 2 * (q[i] * q[k] - q[j] * q[3]);
}

namespace {

class FreeTop final : public RigidProblem {
 public:
  explicit FreeTop(const Params& given) {
    ProblemOptions o(given, info_);
    static const char* const half_names[] = {"hx", "hy", "hz"};
    static const char* const spin_names[] = {"wx", "wy", "wz"};
    static const double halves[] = {0.1, 0.2, 0.3}, spins[] = {0.05, 5, 0.05};
    for (int k = 0; k < 3; ++k)
      half_[k] = o.number(half_names[k], halves[k], 1e-3, 1e3, "half size, m; the mass is 1 kg");
    for (int k = 0; k < 3; ++k) spin_[k] = o.number(spin_names[k], spins[k], -1e4, 1e4, "spin at the start, rad/s");
    info_.t_end = o.number("t_end", 10, 1e-3, 1e4, "s");
    double energy = 0;
    TopEquation equation;
    for (int k = 0; k < 3; ++k) {
      const double a = half_[(k + 1) % 3], b = half_[(k + 2) % 3], inertia = (a * a + b * b) / 3;
      equation.inertia[k] = inertia;
      energy += 0.5 * inertia * spin_[k] * spin_[k];
    }
    const double speed = std::sqrt(spin_[0] * spin_[0] + spin_[1] * spin_[1] + spin_[2] * spin_[2]);
    info_.dof = 3;
    info_.x_scale = 1, info_.v_scale = std::max(speed, 1e-6);
    info_.energy_start = info_.energy_scale = energy;
    info_.conserves_angular = true;
    orientations_ = true;
    gravity_ = 0;
    set_reference(ReferenceKind::quad, 14, 1e-13, "Euler's equations, extrapolation of order 20 in long double");
    info_.reference.rounding *= 1e3;  // near its middle axis the spin forgets where it came from
    for (int s = 1; s <= 64; s *= 2) steps_.push_back(static_cast<int>(std::ceil(speed * info_.t_end * 2)) * s);
    substeps_ = 1;
    exact_ = std::make_unique<OdeReference>(equation, std::vector<Wide>{spin_[0], spin_[1], spin_[2], 0, 0, 0, 1},
                                            info_.t_end, kStudySamples);
  }

  void build(World& world, std::vector<ObjectId>& observed) const override {
    const auto size = [&](int k) { return static_cast<Real>(2 * half_[k]); };
    BodyDesc d = body(make_box(size(0), size(1), size(2)), Vec3::Zero(), 1, 0);
    d.angular_velocity = Vec3(static_cast<Real>(spin_[0]), static_cast<Real>(spin_[1]), static_cast<Real>(spin_[2]));
    observed.push_back(world.need<Rigid>().add_body(d));
  }

  void observe(const Rigid& rigid, std::span<const ObjectId> observed, Observation& out) const override {
    const std::uint32_t i = rigid.index(observed.front());
    const Quat& q = rigid.bodies().rotation[i];
    const Vec3& w = rigid.bodies().angular_velocity[i];
    const Wide wide[4] = {q.x, q.y, q.z, q.w};
    fill(wide, {w[0], w[1], w[2]}, out);
  }

  void reference(double t, Observation& out) const override {
    const std::vector<Wide>& y = exact_->at(t);
    Wide w[3] = {0, 0, 0}, e[3];
    for (int k = 0; k < 3; ++k) {
      axis_of(&y[3], k, e);
      for (int i = 0; i < 3; ++i) w[i] += y[static_cast<std::size_t>(k)] * e[i];
    }
    fill(&y[3], {w[0], w[1], w[2]}, out);
  }
  double constraint(World&) const override { return 0; }

 private:
  static void fill(const Wide* q, const std::array<Wide, 3>& w, Observation& out) {
    out.x.clear(), out.v.clear(), out.q.clear();
    for (int k = 0; k < 3; ++k) {
      Wide e[3];
      axis_of(q, k, e);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t a = (i + 1) % 3, b = (i + 2) % 3;
        out.x.push_back(static_cast<double>(e[i]));
        out.v.push_back(static_cast<double>(w[a] * e[b] - w[b] * e[a]));
      }
    }
    for (int k = 0; k < 4; ++k) out.q.push_back(static_cast<double>(q[k]));
  }

  double half_[3], spin_[3];
  std::unique_ptr<OdeReference> exact_;
};

}  // namespace

Variant<StudyProblem> study_free_top() {
  return {"free_top", "a box that spins near its middle axis and tumbles",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<FreeTop>(p); }};
}

}  // namespace feder
