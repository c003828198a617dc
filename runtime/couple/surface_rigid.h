// Surfaces and rigid bodies in one world: contact of points, segments and triangles with every shape, by the narrow
// phase that bodies use. Exists as soon as a world has both. Rows go to the loop of the surface's group, which pushes
// both sides at the same moment. Points that are colliders of their own (of nets) collide there, and only their
// triangles here.
#pragma once
#include "feder/query.h"
#include "feder/rigid.h"
#include "feder/system.h"
#include "state/colliders.h"
#include "state/contact_book.h"
#include "state/solver_bodies.h"
#include "state/surface.h"
#include "state/surface_links.h"

namespace feder {

class SurfaceRigid final : public System {
 public:
  static constexpr const char* kName = "surface_rigid";
  static const SystemDescriptor& descriptor();
  explicit SurfaceRigid(SystemSetup& setup);
  ~SurfaceRigid() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // pairs of surface and body in contact now
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  void validate() const override;

 private:
  // Candidate of this step: a point, segment or triangle near a collider.
  struct Candidate {
    std::uint32_t surface = 0;  // in Surfaces::list
    std::uint32_t collider = 0;
    std::uint32_t index = 0;    // of the point in Surfaces, or of the edge or triangle within its surface
    std::uint32_t corners = 1;  // 2: the edge of a surface without triangles; 3: a triangle
  };
  // Contact state of a surface and a body in this step.
  struct ContactState {
    ObjectId surface, body;
    Real impulse = 0;                                  // N s; 0: a row, but no contact
    Real support = 0;                                  // the part of it against gravity, N s
    Real speed = 0;                                    // closing, m/s
    Real slip = 0;                                     // m/s
    std::uint32_t index = 0;                           // of the point with the largest impulse
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  // from the surface to the body
    Real strongest = 0;
  };
  // Present pose and velocity of a collider's body.
  struct BodyPose {
    Pose pose;
    Vec3 center = Vec3::Zero();  // of mass, m
    Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
    std::uint32_t solver_index = 0;  // in SolverBodies; 0 = does not move
    Aabb box;                        // of the shape there
  };

  // Passes.
  void begin(StepContext& c);
  void find_candidates(StepContext& c);
  void make_rows(StepContext& c);
  void hold_links(StepContext& c);
  void refresh_rows(StepContext& c);
  void fill_rows(StepContext& c);
  void collect(StepContext& c);
  void collect_group(std::size_t group, StepContext& c);
  void place_attached(const SurfaceGroup& group, StepContext& c);
  void finish(StepContext& c);

  void wake_left();
  void follow(std::uint32_t surface, Real speed, Real h);
  void candidates_of(std::uint32_t surface, StepContext& c);
  void leave_alone(const Surface& surface, std::uint32_t collider);
  void connect(std::uint32_t surface, std::uint32_t body);
  void measure_pin(const Candidate& k, const BodyPose& at, Real radius);
  void warn_of_pins(const Surface& surface, std::uint32_t collider, StepContext& c);
  SurfaceLinks* links_of() const { return store_.find<SurfaceLinks>(); }
  bool anchored(std::uint32_t point, ObjectId body) const;
  void wake(Surface& surface, ObjectId by);
  BodyPose body_pose(std::uint32_t collider) const;
  void point_rows(const Candidate& k, const BodyPose& at, StepContext& c);
  void triangle_rows(const Candidate& k, const BodyPose& at, StepContext& c);
  void segment_rows(const Candidate& k, const BodyPose& at, StepContext& c);
  // Travel of a part relative to the body in the speculative time, m: mean, least and largest of its corners.
  struct Travel {
    Vec3 mean;
    Real least, most;
  };
  template <class F>
  void meet(const Candidate& k, const BodyPose& at, const Shape& shape, const Vec3& a, const Travel& way, F&& add);
  void add_row(const Candidate& k, const BodyPose& at, const std::uint32_t (&v)[3], const Real (&weight)[3],
               const Vec3& normal, Real gap, const Vec3& point);
  std::uint32_t state_of(const Surface& surface, ObjectId body);
  void report(const ContactState& t, const Surface& surface);
  Vec3 current_position(std::uint32_t point) const {
    return surfaces_.position[point] + surfaces_.delta_position[point].vec();
  }

  Arena& arena_;
  Store& store_;
  Surfaces& surfaces_;
  Rigid& rigid_;
  Collide& collide_;
  Colliders& colliders_;
  SolverBodies& solver_bodies_;
  Objects& objects_;
  ContactBook& contacts_;
  const std::uint32_t finder_;
  Array<Candidate> candidates_{&arena_};
  Array<ContactState> contact_states_{&arena_};
  Array<Aabb> box_{&arena_};            // by point: swept over the step
  Array<Real> smallest_{&arena_};       // by collider: half of its least size, m
  Array<std::uint32_t> near_{&arena_};  // colliders near a surface
  Array<std::uint8_t> left_alone_{
      &arena_};                         // by point of a rope: no contact with the collider looked at, where it hangs
  Real farthest_ = 0;                   // m, margin for the motion of colliders in this step
  std::vector<ShapePtr> point_shapes_;  // by surface: a sphere of half the thickness
  Real speculative_time_ = 0;           // s, for which rows are made
  Array<Real> pin_depth_{&arena_};      // by point: of pins in the collider whose rows are being made, m
  Array<std::uint32_t> deep_pins_{&arena_};  // points where it is not 0
  Array<Real> cfl_number_{&arena_};          // by group: the largest travel in a substep over what a row allows
  std::uint32_t refreshing_ = kNone;         // the group whose rows are made between solver substeps
  bool refreshing() const { return refreshing_ != kNone; }
  // Pairs whose warning of pins inside was sent.
  struct Warned {
    ObjectId surface, body;
  };
  Array<Warned> warned_{&arena_};
};

}  // namespace feder
