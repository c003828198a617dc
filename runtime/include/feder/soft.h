// Soft bodies: volumes of tetrahedra with the elasticity of a material, mass, friction and a skin. Each has a solver of
// its own. Their skins are surfaces of contact: they touch bodies, cloth, nets, ropes, each other and themselves.
// Units: young in Pa (stress per strain). One thread at a time, that of the world.
#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "feder/shape.h"
#include "feder/system.h"

namespace feder {

inline constexpr ObjectKind kSoftKind{"soft", "soft_bodies"};
inline constexpr WakeCause kSoftCause{"soft"};
// A point split; index: it; part: the one that the new point beside it belongs to; force: of the stress there, N.
inline constexpr EventKind kFracture{"fracture", EventKind::kPlace | EventKind::kForce | EventKind::kPart};

std::string default_soft_solver();
std::string default_elasticity();

struct SoftDesc {
  std::string name;
  TagMask tags = 0;
  // Points with tetrahedra, or a shape that is filled with cells, `resolution` along its longest side. Tetrahedra that
  // are turned inside out are turned back; those without volume are an error.
  std::vector<Vec3> points;               // m, local
  std::vector<std::uint32_t> tetrahedra;  // four point numbers each
  ShapePtr shape;
  std::uint32_t resolution = 8;
  Pose pose;
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  // m/s; rad/s, about the centre of mass
  Real density = 1000;                                            // kg/m^3
  Real young = 100000;                                            // Pa
  Real poisson = Real(0.3);                                       // above -1, below 0.5
  Real damping = Real(0.002);  // s: stress of strain rate over stiffness; never acts on rigid motion
  Real thickness = 0;          // m, between two skins; half of it to bodies; 0: a tenth of the mean edge of the skin
  Real friction = Real(0.5);
  bool self_collision = true;
  std::string self;  // search of its own for candidates of self-contact, of box_searches(): "swept_boxes" ...; when
                     // empty, they are found together with those of other surfaces
  Real gravity_scale = 1;
  std::uint32_t group = 1, mask = 0xffffffffu;
  int substeps = 0;      // solver substeps per substep of the world; 0: chosen, so that the stiffness is resolved
  int max_substeps = 0;  // largest number that is chosen, with a warning; 0: 64, and more for less than 5000 tetrahedra
  std::string solver = default_soft_solver();  // xpbd, or the first of this build
  Params solver_options;
  std::string elasticity = default_elasticity();  // neo_hookean, or the first of this build
  std::vector<std::uint32_t> pins;                // points from 0
  // Plastic flow: elastic shear beyond the strain `yield` goes over into the shape at rest at the rate `flow`, 1/s.
  Real yield = kInfinity, flow = 0;
  Real fracture_stress = kInfinity;  // Pa: more tension splits the body between tetrahedra

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.points), f(d.tetrahedra), f(d.shape), f(d.resolution), f(d.pose), f(d.velocity);
    f(d.angular_velocity), f(d.density), f(d.young), f(d.poisson), f(d.damping), f(d.thickness), f(d.friction);
    f(d.self_collision), f(d.self), f(d.gravity_scale), f(d.group), f(d.mask), f(d.substeps), f(d.max_substeps),
        f(d.solver);
    f(d.solver_options), f(d.elasticity), f(d.pins), f(d.yield), f(d.flow), f(d.fracture_stress);
  }
};

class Soft final : public System {
 public:
  static constexpr const char* kName = "soft";
  static const SystemDescriptor& descriptor();
  explicit Soft(SystemSetup& setup);
  ~Soft() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // tetrahedra
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  Energy energy(const Vec3& gravity) const override;
  Momentum momentum() const override;
  double held(const StepContext& c) override;
  // soft.volume_error, .max_strain, .inverted, .substeps, .sleeping, .quarantined
  void residuals(std::vector<Residual>& out) const override;
  void notes(std::vector<Note>& out) const override;
  bool finite() const override;
  void validate() const override;

  ObjectId add_soft(const SoftDesc& desc);  // SceneError on impossible input, nothing changed
  void destroy_soft(ObjectId soft, std::string where);
  std::size_t point_count(ObjectId soft) const;
  std::size_t tetrahedron_count(ObjectId soft) const;
  // i counts from 0; SceneError when out of range.
  Vec3 point(ObjectId soft, std::size_t i) const;
  Vec3 rest_point(ObjectId soft, std::size_t i) const;  // unstrained, m, local
  std::array<std::uint32_t, 4> tetrahedron(ObjectId soft, std::size_t k) const;
  void set_point(ObjectId soft, std::size_t i, const Vec3& x);  // moves a pinned point, teleports a free one
  Vec3 velocity(ObjectId soft, std::size_t i) const;
  void set_velocity(ObjectId soft, std::size_t i, const Vec3& v);
  void apply_impulse(ObjectId soft, std::size_t i, const Vec3& impulse);  // N s
  Real point_mass(ObjectId soft, std::size_t i) const;                    // kg
  void pin(ObjectId soft, std::size_t i);
  void unpin(ObjectId soft, std::size_t i);
  bool pinned(ObjectId soft, std::size_t i) const;
  Real volume(ObjectId soft) const;       // m^3, now
  Real rest_volume(ObjectId soft) const;  // m^3
  // Largest elongation or shortening along any direction in tetrahedron k, or, for all, the largest.
  Real strain(ObjectId soft, std::size_t k) const;
  Real max_strain(ObjectId soft) const;
  // Largest tension along any direction at point i, the mean of the Cauchy stress of the tetrahedra round it, Pa.
  Real tension(ObjectId soft, std::size_t i) const;
  // Parts are what tetrahedra connect, numbered from 0 in the order of their first points.
  std::size_t part_count(ObjectId soft) const;
  std::size_t part(ObjectId soft, std::size_t i) const;  // that point i belongs to
  std::size_t inverted(ObjectId soft) const;             // tetrahedra that are turned inside out now
  // The tetrahedron that p lies in now, the first one, and its barycentric weights there; or kNoTetrahedron.
  std::size_t tetrahedron_at(ObjectId soft, const Vec3& p, std::array<double, 4>& weights) const;
  static constexpr std::size_t kNoTetrahedron = std::size_t(-1);
  void positions(ObjectId soft, std::vector<Vec3>& out) const;
  void set_script_force(ObjectId soft, std::size_t i, const Vec3& force);  // N, until changed
  void clear_script_forces();
  int substeps(ObjectId soft) const;  // solver substeps per world substep, as last chosen
  bool asleep(ObjectId soft) const;
  void wake(ObjectId soft, WakeCause cause = WakeCause::script, ObjectId other = {});
  void sleep(ObjectId soft);
  bool quarantined(ObjectId soft) const;

  // Holds point i to a place of a body's frame, m, or to point j of another soft thing (cloth, a net that collides, a
  // rope, a soft body; from 0); from both sides, with the momentum of both. What is held apart is a warning,
  // `attachment_gap`.
  void attach(ObjectId soft, std::size_t i, ObjectId body, const Vec3& local);
  void attach_point(ObjectId soft, std::size_t i, ObjectId other, std::size_t j);
  void detach(ObjectId soft, std::size_t i);  // of all

  // Soft bodies are numbered 0 .. soft_count()-1, in the order of their making.
  struct Info {
    ObjectId object;
    std::span<const Vec3> points;  // m
    std::span<const Real> inv_mass;
    std::span<const std::uint32_t> skin;  // three point numbers per triangle, counter-clockwise seen from outside
    Real thickness = 0;                   // m
    std::uint32_t group = 1, mask = 0xffffffffu;
  };
  std::size_t soft_count() const;
  Info info(std::size_t n) const;
  Info info(ObjectId soft) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder
