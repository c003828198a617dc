// Cloth and rigid bodies in one world: vertices and triangles against every shape, attached vertices hold bodies.
// Exists as soon as a world has both. Rows go to the cloth's small steps, which push both sides at the same moment.
#pragma once
#include "cloth/cloth.h"
#include "collide/collide.h"
#include "contact/event_balance.h"
#include "rigid/rigid.h"
#include "state/movers.h"
#include "step/system.h"

namespace feder {

class ClothRigid final : public System {
 public:
  static constexpr const char* kName = "cloth_rigid";
  static const SystemDescriptor& descriptor();
  explicit ClothRigid(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // cloths and bodies that touch now
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // cloth_rigid.attachment_error_m, ...penetration_m

 private:
  // A vertex or triangle near a collider in this step.
  struct Candidate {
    std::uint32_t cloth = 0;  // place in the order of Cloth::info
    std::uint32_t collider = 0;
    std::uint32_t index = 0;     // of the vertex in ClothVertices, or of the triangle within its cloth
    std::uint32_t triangle = 0;  // 1: the latter
  };
  // A cloth and a body: their contact, over steps.
  struct Touch {
    ObjectId cloth, body;
    std::uint32_t begun = 0;                           // reported
    std::uint32_t seen = 0;                            // in this step
    Real impulse = 0;                                  // of this step, N s
    Real support = 0;                                  // the part of it against gravity, N s
    Real speed = 0;                                    // closing, m/s
    Real slip = 0;                                     // m/s
    std::uint32_t index = 0;                           // of the vertex pushed most
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  // from the cloth to the body
    Real strongest = 0;
  };
  // A collider as it is now.
  struct Place {
    Pose pose;
    Vec3 center = Vec3::Zero();  // of mass, m
    Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
    std::uint32_t solver = 0;  // in Movers; 0 = does not move
  };

  // Passes.
  void look_ahead(StepContext& c);
  void find_candidates(StepContext& c);
  void make_rows(StepContext& c);
  void refresh_rows(StepContext& c);
  void fill_rows(StepContext& c);
  void collect(StepContext& c);
  void collect_group(std::size_t group, StepContext& c);
  void finish(StepContext& c);

  void sync();
  void end_contacts();
  void wake_ahead(const Cloth::Info& cloth, StepContext& c);
  Aabb reach_of(std::uint32_t collider, StepContext& c) const;
  void candidates_of(std::size_t n, StepContext& c);
  void make_holds();
  void connect(std::size_t cloth, std::uint32_t body);
  void measure_pin(const Candidate& k, const Place& at, Real radius);
  void warn_of_pins(const Cloth::Info& cloth, std::uint32_t collider, StepContext& c);
  bool may_touch(const Cloth::Info& cloth, std::uint32_t collider) const;
  Real penetration(const Cloth::Info& cloth, std::uint32_t collider, const Pose& pose) const;
  Place place(std::uint32_t collider) const;
  void vertex_rows(const Candidate& k, const Place& at, StepContext& c);
  void triangle_rows(const Candidate& k, const Place& at, StepContext& c);
  void add_row(const Candidate& k, const Place& at, const std::uint32_t (&v)[3], const Real (&weight)[3],
               const Vec3& normal, Real gap, const Vec3& point);
  std::uint32_t touch_of(ObjectId cloth, ObjectId body);
  Real attachments_of(ObjectId body, ObjectId cloth) const;
  bool attached(std::uint32_t vertex, ObjectId body) const;
  Vec3 vertex_place(std::uint32_t i) const { return cloth_.vertices().position[i] + surfaces_.moved[i].vec(); }

  Cloth& cloth_;
  Surfaces& surfaces_;
  Rigid& rigid_;
  Collide& collide_;
  Colliders& colliders_;
  Movers& movers_;
  Objects& objects_;
  Events& events_;
  bool* structure_changed_;
  Array<Candidate> candidates_;
  Array<Touch> touches_;
  Array<Aabb> box_;                      // by vertex: swept over the step
  Array<Real> smallest_;                 // by collider: half of its least size, m
  std::vector<ShapePtr> vertex_shapes_;  // by cloth: a sphere of half the thickness
  Real horizon_ = 0;                     // s, for which rows are made
  Array<Real> pin_depth_;                // by vertex: of pins in the collider whose rows are being made, m
  Array<std::uint32_t> deep_pins_;       // those where it is not 0
  Array<Real> hurry_;                    // by group: the largest travel in a substep over what a row stands
  std::uint32_t refreshing_ = kNone;     // the group whose rows are made between small steps
  bool refreshing() const { return refreshing_ != kNone; }
  // Pairs whose warning of pins inside was sent.
  struct Warned {
    ObjectId cloth, body;
  };
  Array<Warned> warned_;
  EventBalance open_;
};

}  // namespace feder
