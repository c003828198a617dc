// Ropes: chains of segments with stiffness against stretch and bending, thickness and friction. Straight when nothing
// acts on them, whatever shape they are given; they carry no twist. A rope is solved as a whole, with the bodies it
// lies on (rope/chain.h). Ropes are surfaces of contact: they touch bodies, cloth, nets, each other and themselves.
// Units: stretch in N (E A: force per strain), bend in N m^2 (E I: moment per curvature). One thread at a time.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "feder/system.h"

namespace feder {

inline constexpr ObjectKind kRopeKind{"rope", "ropes"};
inline constexpr WakeCause kRopeCause{"rope"};

struct RopeDesc {
  std::string name;
  TagMask tags = 0;
  std::vector<Vec3> points;      // m, 2 or more; the segments between them are as long as they are here
  Vec3 velocity = Vec3::Zero();  // m/s
  Real radius = Real(0.01);      // m
  Real density = 1000;           // kg/m^3
  Real stretch = 50000;          // N
  Real bend = 0;                 // N m^2
  Real damping = Real(0.002);    // s: stress of strain rate over stiffness; never acts on rigid motion
  // coefficient of what air and wind do across it, for its diameter; that of a cylinder. 0: nothing
  Real drag = Real(1.2);
  Real friction = Real(0.4);
  bool self_collision = true;
  Real gravity_scale = 1;
  std::uint32_t group = 1, mask = 0xffffffffu;
  int substeps = 0;                 // solver substeps per substep of the world; 0: chosen, see rope/step.cpp
  std::vector<std::uint32_t> pins;  // points from 0
  bool clamp_first = false, clamp_last = false;  // that end is pinned, and keeps its direction

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.points), f(d.velocity), f(d.radius), f(d.density), f(d.stretch), f(d.bend);
    f(d.damping), f(d.drag), f(d.friction), f(d.self_collision), f(d.gravity_scale), f(d.group), f(d.mask),
        f(d.substeps);
    f(d.pins), f(d.clamp_first), f(d.clamp_last);
  }
};

class Rope final : public System {
 public:
  static constexpr const char* kName = "rope";
  static const SystemDescriptor& descriptor();
  explicit Rope(SystemSetup& setup);
  ~Rope() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // points
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  Energy energy(const Vec3& gravity) const override;
  Momentum momentum() const override;
  double held(const StepContext& c) override;
  void residuals(std::vector<Residual>& out) const override;  // rope.max_strain, .solves, .missed (m), .sleeping ...
  bool finite() const override;
  void validate() const override;

  ObjectId add_rope(const RopeDesc& desc);  // SceneError on impossible input, nothing changed
  void destroy_rope(ObjectId rope, std::string where);
  std::size_t point_count(ObjectId rope) const;
  // i counts from 0; SceneError when out of range.
  Vec3 point(ObjectId rope, std::size_t i) const;
  void set_point(ObjectId rope, std::size_t i, const Vec3& x);  // moves a pinned point, teleports a free one
  Vec3 velocity(ObjectId rope, std::size_t i) const;
  void set_velocity(ObjectId rope, std::size_t i, const Vec3& v);
  void apply_impulse(ObjectId rope, std::size_t i, const Vec3& impulse);  // N s
  Real point_mass(ObjectId rope, std::size_t i) const;                    // kg
  void pin(ObjectId rope, std::size_t i);
  void unpin(ObjectId rope, std::size_t i);  // of a clamped end, the clamp too
  bool pinned(ObjectId rope, std::size_t i) const;
  Real strain(ObjectId rope, std::size_t k) const;  // of segment k: elongation / rest length
  Real max_strain(ObjectId rope) const;
  Real tension(ObjectId rope, std::size_t k) const;  // stretch times strain of segment k, N
  Real current_length(ObjectId rope) const;          // m
  void positions(ObjectId rope, std::vector<Vec3>& out) const;
  void set_script_force(ObjectId rope, std::size_t i, const Vec3& force);  // N, until changed
  void clear_script_forces();
  int substeps(ObjectId rope) const;  // solver substeps per world substep, as last chosen
  bool asleep(ObjectId rope) const;
  void wake(ObjectId rope, WakeCause cause = WakeCause::script, ObjectId other = {});
  void sleep(ObjectId rope);
  bool quarantined(ObjectId rope) const;

  // Holds point i to a place of a body's frame, m, or to point j of another soft thing (cloth, a net that collides, a
  // rope, a soft body; from 0); from both sides, with the momentum of both. Held apart: a warning, `attachment_gap`.
  void attach(ObjectId rope, std::size_t i, ObjectId body, const Vec3& local);
  void attach_point(ObjectId rope, std::size_t i, ObjectId other, std::size_t j);
  void detach(ObjectId rope, std::size_t i);  // of all

  // Ropes are numbered 0 .. rope_count()-1, in the order of their making.
  struct Info {
    ObjectId object;
    std::span<const Vec3> points;  // m
    std::span<const Real> inv_mass;
    Real radius = 0;  // m
  };
  std::size_t rope_count() const;
  Info info(std::size_t n) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder
