// Cloth and rigid bodies: attachments of vertices to bodies, and the approach speeds and loads that set the number of
// solver substeps of a cloth. Their contact is that of all surfaces (couple/surface_rigid.h).
#pragma once
#include "feder/cloth.h"
#include "feder/query.h"
#include "feder/rigid.h"
#include "feder/system.h"
#include "state/colliders.h"
#include "state/solver_bodies.h"
#include "state/surface.h"

namespace feder {

class ClothRigid final : public System {
 public:
  static constexpr const char* kName = "cloth_rigid";
  static const SystemDescriptor& descriptor();
  explicit ClothRigid(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // attachments
  void hash(Hash&) const override {}   // all state is that of the two systems
  void save(Writer&) const override {}
  void load(Reader&) override {}
  void residuals(std::vector<Residual>& out) const override;  // cloth_rigid.attachment_error_m, ...penetration_m

 private:
  // Passes.
  void find_approach(StepContext& c);
  void make_attachments(StepContext& c);
  void weigh(StepContext& c);

  void sync();
  void wake_approached(const Cloth::Info& cloth, StepContext& c);
  void list_near(Aabb box, StepContext& c);
  Real penetration(const Cloth::Info& cloth, std::uint32_t collider, const Pose& pose) const;
  Real attachments_of(ObjectId body, ObjectId cloth) const;
  bool attached(std::uint32_t vertex, ObjectId body) const;

  Cloth& cloth_;
  Surfaces& surfaces_;
  Rigid& rigid_;
  Collide& collide_;
  Colliders& colliders_;
  SolverBodies& solver_bodies_;
  Objects& objects_;
  bool* structure_changed_;
  Array<std::uint32_t> near_;  // colliders
  Real fastest_ = 0;           // m/s, of their owners in this step
};

}  // namespace feder
