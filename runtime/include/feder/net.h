// Mass-spring nets: points, springs and faces, advanced by an integrator of choice (the system "springs").
// SI units. SceneError on impossible input, nothing changed. One thread at a time, that of the world.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "feder/integrator.h"
#include "feder/system.h"

namespace feder {

inline constexpr ObjectKind kNetKind{"net", "nets"};
inline constexpr EventKind kSpringBreak{"spring_break", EventKind::kPlace | EventKind::kForce};

struct SpringDesc {
  std::uint32_t i = 0, j = 0;
  Real stiffness = 1000;          // N/m
  Real damping = 0;               // N s/m along the spring
  Real rest_length = -1;          // m; < 0: distance as built
  Real break_strain = kInfinity;  // elongation / rest length; snaps with an event
  bool tension_only = false;      // a string: slack below its rest length, and never pushes
  int power = 1;                  // force = stiffness |extension|^power towards the rest length; 1 to 9, N/m^power

  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.i), f(d.j), f(d.stiffness), f(d.damping), f(d.rest_length), f(d.break_strain), f(d.tension_only), f(d.power);
  }
};

struct NetDesc {
  std::string name;
  TagMask tags = 0;
  std::vector<Vec3> points;      // world, m
  std::vector<Vec3> velocities;  // empty: at rest
  std::vector<Real> masses;      // one per point, kg, > 0
  std::vector<SpringDesc> springs;
  std::vector<std::uint32_t> faces;  // triangles, three point numbers each: collide, and are impermeable to fluids
  std::string integrator = default_integrator();
  Params integrator_options;
  Real damping = 0;             // drag on every point, 1/s (force = -damping m v)
  Real radius = 0;              // m; > 0: points and faces collide
  bool self_collision = false;  // also with each other, where the net has faces
  Real friction = Real(0.5), restitution = 0;
  std::uint32_t group = 1, mask = 0xffffffffu;
  Real gravity_scale = 1;

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.points), f(d.velocities), f(d.masses), f(d.springs), f(d.faces), f(d.integrator);
    f(d.integrator_options), f(d.damping), f(d.radius), f(d.self_collision), f(d.friction), f(d.restitution);
    f(d.group), f(d.mask), f(d.gravity_scale);
  }
};

// The springs of a net as they are kept; i and j count from 0 within the net. Valid until the net is edited.
struct SpringView {
  std::span<const std::uint32_t> i, j;
  std::span<const Real> rest_length;    // m
  std::span<const std::uint8_t> alive;  // 0: removed or broken
};

// Predictions for a net and its integrator before it runs. Formulas: springs/advice.cpp.
struct NetAdvice {
  ObjectId net;
  std::string integrator;
  IntegratorInfo method;
  double h = 0;                 // s, a substep
  double frequency = 0;         // 1/s, upper bound of all modes (Gershgorin)
  double decay = 0;             // 1/s, upper bound of all decay rates
  double stability_number = 0;  // h times the larger of the two that matter to the method
  bool stable = true;           // stability_number <= limit of the method
  bool never_stable = false;    // no step is stable without damping
  int solver_substeps = 1;      // of an adaptive method within h, at least, for stability
  int substeps = 0;     // of the step dt that keep the number below kSafeShare of the limit; 0: any, or none does
  double error = 0;     // predicted, of the fastest mode after one period, relative
  double resolved = 0;  // 1/s, motions up to here come out within kResolvedError per period
  static constexpr double kSafeShare = 0.9;
  static constexpr double kResolvedError = 0.01;
};

class Springs final : public System {
 public:
  static constexpr const char* kName = "springs";
  static const SystemDescriptor& descriptor();
  explicit Springs(SystemSetup& setup);
  ~Springs() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // points
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  Energy energy(const Vec3& gravity) const override;
  Momentum momentum() const override;
  void residuals(std::vector<Residual>& out) const override;  // springs.max_strain ...
  bool finite() const override;
  void validate() const override;
  double held(const StepContext& c) override;

  ObjectId add_net(const NetDesc& desc);
  void destroy_net(ObjectId net, std::string where);
  std::size_t point_count(ObjectId net) const;
  std::size_t spring_count(ObjectId net) const;
  // i and k count from 0 within the net; SceneError when out of range.
  Vec3 point(ObjectId net, std::size_t i) const;
  void set_point(ObjectId net, std::size_t i, const Vec3& x);
  Vec3 velocity(ObjectId net, std::size_t i) const;
  void set_velocity(ObjectId net, std::size_t i, const Vec3& v);
  void apply_impulse(ObjectId net, std::size_t i, const Vec3& impulse);
  Real point_mass(ObjectId net, std::size_t i) const;
  void pin(ObjectId net, std::size_t i);
  void unpin(ObjectId net, std::size_t i);
  bool pinned(ObjectId net, std::size_t i) const;
  std::size_t add_spring(ObjectId net, const SpringDesc& spring);  // its index
  void remove_spring(ObjectId net, std::size_t k);                 // later indices stay as they are
  Real strain(ObjectId net, std::size_t k) const;                  // elongation / rest length; 0 when removed
  SpringDesc spring(ObjectId net, std::size_t k) const;
  SpringView springs(ObjectId net) const;
  void positions(ObjectId net, std::vector<Vec3>& out) const;
  IntegratorStats stats(ObjectId net) const;
  // Upper bound of the fastest angular frequency of the net (Gershgorin), 1/s: h times it against the limit in
  // IntegratorInfo decides whether the warning "stiff" is raised.
  Real max_frequency(ObjectId net) const;
  NetAdvice advice(ObjectId net, double dt, int substeps) const;
  // A net that went non-finite is pinned at the positions before that step, and finite() stays false.
  bool quarantined(ObjectId net) const;

  // For couplings: the net's run of indices in Particles and how its points collide.
  struct NetInfo {
    ObjectId object;
    std::uint32_t first = 0, count = 0;
    Real friction = 0, restitution = 0;
    std::uint32_t group = 1, mask = 0xffffffffu;
    bool implicit = false;                      // its integrator
    std::span<const std::uint32_t> faces = {};  // three numbers each, from 0 within the net
  };
  std::size_t net_count() const;
  NetInfo net_info(std::size_t n) const;  // 0 .. net_count()-1, in the order the nets were made
  // Entries of removed points in the arrays of others. The coupling that made them frees them, and empties the list,
  // before the next plan.
  struct Removed {
    std::uint32_t collider, solver_slot;  // kNone: had none
  };
  std::vector<Removed>& removed();

  // Attachment: point `i` is fixed to `local` of a body; used by couple and the binding, and enforced by
  // couple/springs_rigid.
  struct Attachment {
    ObjectId net, body;
    std::uint32_t point = 0;    // particle index in Particles
    Vec3 local = Vec3::Zero();  // in the body frame of `body`, m
  };
  void attach(ObjectId net, std::size_t i, ObjectId body, const Vec3& local);
  // To point j, from 0, of another soft thing (cloth, a net that collides, a rope, a soft body); from both sides.
  // SceneError where this net does not collide.
  void attach_point(ObjectId net, std::size_t i, ObjectId other, std::size_t j);
  void detach(ObjectId net, std::size_t i);
  const std::vector<Attachment>& attachments() const;

  // Scripted force on one point, held until changed (evaluated between steps), N.
  void set_script_force(ObjectId net, std::size_t i, const Vec3& force);
  void clear_script_forces();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder
