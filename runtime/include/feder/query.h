// Collision detection as one system ("collide"): bounding boxes -> broad phase -> narrow phase -> contacts, with
// filters, sensors and begin/end events; and the queries: rays, swept shapes, overlaps. Knows colliders, not bodies.
// SI units, world coordinates. Queries go to World::query<Collide>(), between two steps, on the world's thread.
#pragma once
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "feder/shape.h"
#include "feder/system.h"

namespace feder {

struct Colliders;
struct Contacts;
class NarrowPhase;
enum class BoxMotion : std::uint8_t;

struct RaycastHit {
  std::uint32_t collider = kNone;
  ObjectId object;
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  Real fraction = 1;
};

struct QueryFilter {
  std::uint32_t group = 0xffffffffu, mask = 0xffffffffu;
  bool sensors = false;
  ObjectId ignore;
};

struct MaterialPair {
  std::uint16_t a = 0, b = 0;                                          // material numbers
  Real friction_static = -1, friction_dynamic = -1, restitution = -1;  // < 0: the usual mixing

  template <class P, class F>
  static void each_field(P& p, F&& f) {
    f(p.a), f(p.b), f(p.friction_static), f(p.friction_dynamic), f(p.restitution);
  }
};

class Collide final : public System, public ContactService {
 public:
  static constexpr const char* kName = ContactService::kSystem;
  static constexpr Rank kQuery = Rank::query_colliders;  // World::query
  static const SystemDescriptor& descriptor();
  explicit Collide(SystemSetup& setup);
  ~Collide() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // colliders
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  // collide.max_penetration_m; with a narrow phase by name also how often pairs were handed on: collide.handed_on
  void residuals(std::vector<Residual>& out) const override;
  void notes(std::vector<Note>& out) const override;  // how meshes find their triangles
  void validate() const override;

  Colliders& colliders();
  Contacts& contacts();
  const NarrowPhase& narrow() const;

  void exclude(ObjectId a, ObjectId b) override;
  void include(ObjectId a, ObjectId b) override;
  void forget(std::uint32_t collider) override;
  void check_shape(const Shape& shape) const override;
  std::uint16_t material(std::string_view name) override;
  SurfaceNumbers material_numbers(std::uint16_t material) const override;
  Real core_depth(const Shape& shape) const override;
  void obstacles(std::uint32_t collider, const Aabb& box, bool moving, Array<std::uint32_t>& found) const override;
  OwnerImpact impact(std::uint32_t a, const OwnerMotion& motion_a, std::uint32_t b, const OwnerMotion& motion_b,
                     Real begin, Real end) const override;
  void set_material_pair(const MaterialPair& pair);
  // What parts and triangles with a surface of that material have where they state nothing themselves. Before bodies
  // with such parts are added. SceneError on numbers that are not finite, or a restitution above 1.
  void define_material(std::string_view name, const SurfaceNumbers& numbers);

  // Colliders whose boxes overlap this one, ascending: by the broad phase, with the boxes of this step, from
  // Rank::wake_touched to its end.
  void near(const Aabb& box, Array<std::uint32_t>& found) const;
  // By collider, as the broad phase had them in the last step.
  std::span<const Aabb> boxes() const;
  std::span<const BoxMotion> box_motion() const;  // broad/broad_phase.h
  // For pictures: what the broad phase searches by, at a level: its nodes or cells. Is there a level below?
  bool cells_at(int level, void (*take)(void* to, const Aabb&), void* to) const;

  // On the state now, by World::query<Collide>(), which has placed the colliders.
  bool raycast(const Vec3& origin, const Vec3& ray, const QueryFilter& filter, RaycastHit& hit);  // nearest
  void raycast_all(const Vec3& origin, const Vec3& ray, const QueryFilter& filter, std::vector<RaycastHit>& hits);
  bool shape_cast(const Shape& shape, const Pose& pose, const Vec3& motion, const QueryFilter& filter, RaycastHit& hit);
  void overlap(const Shape& shape, const Pose& pose, const QueryFilter& filter, std::vector<ObjectId>& found);
  Real max_penetration() const;  // of the deepest contact now, m (0 when none)

  // Contacts of an object now: for scripts. Normal points away from the object.
  struct ContactInfo {
    ObjectId other;
    Vec3 point, normal;
    Real separation, impulse;
  };
  void contacts_of(ObjectId object, std::vector<ContactInfo>& out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder
