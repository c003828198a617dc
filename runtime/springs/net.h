// One net: its springs as arrays, its integrator, and the force field that the integrator evaluates. Private to the
// module.
#pragma once
#include <array>

#include "base/jobs.h"
#include "feder/force.h"
#include "feder/net.h"
#include "forces/forces.h"
#include "integrate/integrator.h"
#include "springs/layout.h"
#include "state/particles.h"

namespace feder {

// Springs of a net; point indices count from 0 within the net. A removed spring keeps its index, without stiffness.
struct SpringArrays {
  explicit SpringArrays(Arena& a) : arena(a) {}

  Arena& arena;
  Array<std::uint32_t> i{&arena}, j{&arena};
  Array<Real> stiffness{&arena};    // N/m
  Array<Real> damping{&arena};      // N s/m
  Array<Real> rest_length{&arena};  // m
  Array<Real> break_strain{&arena};
  Array<Real> limit{&arena};  // squared length at which it snaps, m^2
  Array<std::uint8_t> alive{&arena};
  Array<std::uint8_t> tension_only{&arena};
  Array<std::uint8_t> power{&arena};  // of the extension; 1: linear

  std::uint32_t size() const { return static_cast<std::uint32_t>(i.size()); }
  void add(const SpringDesc& s, Real rest);
  void remove(std::uint32_t k);

  template <class S, class F>
  static void each_array(S& s, F&& f) {
    for_each_of(f, s.i, s.j, s.stiffness, s.damping, s.rest_length, s.break_strain, s.limit, s.alive, s.tension_only,
                s.power);
  }
  // Force along the spring, N, and its slope, N/m, at an extension (negative: compressed); without damping.
  double tension(std::uint32_t k, double stretch) const { return stiffness_at(k, stretch, power[k]) * stretch; }
  double slope(std::uint32_t k, double stretch) const { return power[k] * stiffness_at(k, stretch, power[k]); }
  double stiffness_at(std::uint32_t k, double stretch, int p) const {
    FEDER_ASSERT(p >= 1 && p <= 9);
    double s = stiffness[k];
    for (; p > 1; --p) s *= std::fabs(stretch);
    return s;
  }
};

// What decides a net's motion beside its points and springs; plain data, saved as it is.
struct NetSettings {
  Real damping = 0;  // 1/s
  Real gravity_scale = 1;
  Real friction = 0, restitution = 0;
  std::uint32_t group = 1, mask = 0xffffffffu;
  std::uint32_t self = 0;  // collides with itself
};

// Forces of a net: weight, drag, springs, the world's force generators and scripted forces.
class Net final : public ForceField {
 public:
  Net(Arena& a, Particles& p) : arena(a), particles_(p) {}

  Arena& arena;
  ObjectId object;
  std::uint32_t first = 0, points = 0;  // run in Particles
  NetSettings settings;
  SpringArrays springs{arena};
  Array<std::uint32_t> faces{&arena};                 // triangles, three points each
  Array<std::array<std::uint32_t, 2>> edges{&arena};  // of the faces, or each point twice where there are none
  Array<Vec3> rest_position{&arena};  // where the points were made, m; empty: does not collide with itself
  SpringLayout layout{arena};         // of the springs, for the kernels
  std::string integrator_name;
  Params integrator_options;
  std::unique_ptr<Integrator> integrator;
  std::uint64_t version = 0;  // of the spring pattern
  bool can_break = false;     // some spring has a finite break strain
  bool has_power = false;     // some spring is not linear
  bool frozen = false;        // quarantined
  bool warned_stiff = false, warned_unconverged = false, warned_coincident = false, warned_frozen = false;
  std::uint64_t coincident = 0;     // times a spring's ends were at one spot, so that a rule gave its direction
  Real checked_step = 0;            // s, substep the stiffness was checked for; 0: has to be
  Real frequency = 0, decay = 0;    // bounds() when the step was checked
  std::uint32_t bad_point = kNone;  // found non-finite in this step
  bool on_stepping_thread = false;  // a generator of this step runs a script
  bool snapped = false;             // some spring is longer than it bears, found in this substep

  bool bad() const { return bad_point != kNone && !frozen; }  // to be quarantined
  // Worth spreading over threads?
  bool wide() const { return springs.size() + points >= kWide; }
  // What acts this step. Called once per step; the generators are not kept beyond it.
  void prepare(const Vec3& gravity, Real air_density, const Forces* forces, TagMask tags);
  // `jobs`: for the springs of this net; null when nets run side by side.
  void integrate(double t, Real h, JobPool* jobs);
  void remove_spring(std::uint32_t k);
  void list_edges();  // surface.cpp
  // First non-finite point of the net, or kNone. `jobs` as above; places_only: velocities are known to be finite.
  std::uint32_t find_non_finite(JobPool* jobs = nullptr, bool places_only = false) const;
  // Upper bounds of the angular frequency and decay rate of all modes (Gershgorin), 1/s. Springs with a power and
  // generators count as they are now; generators only after prepare(), and only those with a known derivative.
  void bounds(double& most_frequency, double& most_decay, bool with_generators = false, double time = 0);
  Energy energy();
  void validate() const;  // validate.cpp: springs and faces
  // watch.cpp
  Real squared_speeds() const;
  double kinetic_energy() const;
  double kinetic_before() const;  // at the start of the step; a bound from above, sharp where masses are equal
  double given(double dt);
  Real squares = -1;        // m^2/s^2, sum at the end of the last step; < 0: a velocity was edited
  Real squares_before = 0;  // at the start of the step
  Real length_of(std::uint32_t k) const;
  Real strain(std::uint32_t k) const;
  std::span<const Vec3> positions() const { return {particles_.position.data() + first, points}; }
  std::span<const Vec3> velocities() const { return {particles_.velocity.data() + first, points}; }

  std::size_t count() const override { return points; }
  std::span<const Real> inv_mass() const override { return {particles_.inv_mass.data() + first, points}; }
  std::span<const Real> mass() const override { return {particles_.inertia.data() + first, points}; }
  void eval(std::span<const Vec3> x, std::span<const Vec3> v, double t, std::span<Vec3> force) override;
  bool damped() const override { return damped_; }
  bool stiff_damping(Real h) const override {
    const Real hw = h * frequency;
    return generators_damp_ || hw * hw + 2 * h * decay > 4;
  }
  void damping(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& d) override;
  void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) override;
  void pattern(std::vector<BlockIndex>& blocks) const override;
  std::uint64_t pattern_version() const override { return version; }
  std::span<Vec3> position_low() override { return {particles_.position_low.data() + first, points}; }
  JobPool* jobs() const override { return jobs_; }

 private:
  static constexpr std::uint32_t kWide = 4096;  // below, waking threads costs more than they bring

  bool all_points_finite(JobPool* jobs, bool places_only) const;
  void add_still_air(std::span<const Vec3> x, std::span<const Vec3> v, std::span<Vec3> force) const;
  // Slack: a tension_only spring without tension. `rate`: of its length, m/s.
  bool is_slack(std::uint32_t k, double len, double rate) const;
  // Adds the force of a generator on points_ to `out`.
  void add_generator(const ForceEntry& f, double t, Vec3* out);
  std::size_t pick_points(const ForceEntry& f);
  void fill_points(std::span<const Vec3> x, std::span<const Vec3> v);
  // Adds the generators' derivative by position or velocity to the diagonal, negative part only.
  void add_force_derivative(std::span<const Vec3> x, std::span<const Vec3> v, double t, bool by_velocity,
                            BlockSparse& out);
  bool add_known_derivative(const ForceEntry& f, double t, bool by_velocity);
  void add_differences(std::span<const Vec3> x, std::span<const Vec3> v, double t, bool by_velocity);

  Particles& particles_;
  JobPool* jobs_ = nullptr;                     // while integrating
  std::uint64_t laid_out_ = ~std::uint64_t{0};  // version of the layout
  Vec3 gravity_ = Vec3::Zero();                 // m/s^2, scaled
  Real air_density_ = 0;                        // kg/m^3, of still air at its faces
  Real step_ = 0;                               // s, of the call of integrate()
  Real drag_share_ = kInfinity;                 // MassPoint::most_drag is this times mass / step
  bool damped_ = false;
  bool generators_damp_ = false;  // some generator depends on velocity, by an unknown rate
  Array<const ForceEntry*> acting_{&arena};
  Array<MassPoint> points_{&arena};  // for the generators
  Array<MassPoint> some_{&arena};    // for those that act on some points only
  Array<Vec3> some_force_{&arena};
  Array<Vec3> below_{&arena}, above_{&arena};  // their forces, for differences
  Array<Mat3> derivative_{&arena}, some_derivative_{&arena};
  Array<double> row_stiffness_{&arena}, row_damping_{&arena};  // sums of bounds()
};

}  // namespace feder
