// Contacts: points with normals, impulses as arrows as long as 0.1 s of the force would push 1 kg, and islands: lines
// between the centres of bodies that touch or are joined, one colour per island (union-find over those links).
#include <algorithm>
#include <cmath>

#include "collide/collide.h"
#include "rigid/rigid.h"
#include "view/collector.h"

namespace feder::view {
namespace {

class ContactSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    if (!c.toggles.contacts && !c.toggles.impulses && !c.toggles.islands) return;
    Collide* collide = c.world.find<Collide>();
    if (!collide) return;
    const Contacts& contacts = collide->contacts();
    if (c.toggles.contacts || c.toggles.impulses)
      for (const std::uint32_t slot : contacts.order)
        if (contacts.slots[slot].touching) add_contact(c, collide->colliders(), contacts.slots[slot]);
    if (Rigid* rigid = c.toggles.islands ? c.world.find<Rigid>() : nullptr) add_islands(c, *collide, *rigid);
  }

 private:
  static void add_contact(Collecting& c, const Colliders& colliders, const Contact& contact) {
    const auto dt = static_cast<Real>(c.world.desc().dt);
    for (int i = 0; i < contact.point_count; ++i) {
      const ContactPoint& p = contact.points[i];
      const Vec3 at = colliders.center[contact.collider_a] + p.arm_a;
      if (c.toggles.contacts) {
        add_line(c.frame.overlay_lines, at, Vec3(at + Real(0.15) * contact.normal), rgb(0xd83a8c), 2);
        add_cross(c.frame.overlay_lines, at, contact.normal);
      }
      // the arrow of a resting weight of 1 kg is as long as that of 10 N: 0.1 m; square root, so that stacks stay
      // readable
      const Real force = p.total_impulse / dt;
      if (c.toggles.impulses && force > 0)
        add_arrow(c.frame.overlay_lines, at, Vec3(Real(0.0316) * std::sqrt(force) * contact.normal), rgb(0xe8792c), 2);
    }
  }

  static void add_cross(std::vector<Line>& lines, const Vec3& at, const Vec3& normal) {
    Vec3 u, v;
    tangent_frame(normal, u, v);
    const Real size = Real(0.04);
    add_line(lines, Vec3(at - size * u), Vec3(at + size * u), rgb(0xd83a8c), 2);
    add_line(lines, Vec3(at - size * v), Vec3(at + size * v), rgb(0xd83a8c), 2);
  }

  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void link(const Bodies& bodies, std::uint32_t a, std::uint32_t b) {
    if (bodies.type[a] != BodyType::dynamic || bodies.type[b] != BodyType::dynamic) return;
    links_.emplace_back(a, b);
    const std::uint32_t ra = root(a), rb = root(b);
    parent_[std::max(ra, rb)] = std::min(ra, rb);
  }

  void add_islands(Collecting& c, Collide& collide, const Rigid& rigid) {
    const Bodies& bodies = rigid.bodies();
    const Colliders& colliders = collide.colliders();
    parent_.resize(bodies.size());
    for (std::uint32_t i = 0; i < bodies.size(); ++i) parent_[i] = i;
    links_.clear();
    for (const std::uint32_t slot : collide.contacts().order) {
      const Contact& contact = collide.contacts().slots[slot];
      const std::uint32_t a = contact.collider_a, b = contact.collider_b;
      if (!contact.touching || contact.sensor) continue;
      if (colliders.owner[a] == ColliderOwner::body && colliders.owner[b] == ColliderOwner::body)
        link(bodies, colliders.owner_index[a], colliders.owner_index[b]);
    }
    c.world.objects().for_each(kJointKind, [&](ObjectId id) {
      const Rigid::JointInfo j = rigid.joint_info(id);
      if (j.a && j.b) link(bodies, rigid.index(j.a), rigid.index(j.b));
    });
    for (const auto& [a, b] : links_) {
      const std::uint32_t island = root(a);
      const Color color = group_color("island", 0x9e3779b9u * (island + 1));
      add_line(c.frame.overlay_lines, bodies.position[a], bodies.position[b], bodies.awake[a] ? color : asleep(color),
               2.5f);
    }
  }

  std::vector<std::uint32_t> parent_;  // by body
  std::vector<std::pair<std::uint32_t, std::uint32_t>> links_;
};

}  // namespace

Row view_contacts() {
  return {"collide", [] { return std::unique_ptr<FrameSource>(new ContactSource); }};
}

}  // namespace feder::view
