// Contacts: points with normals, impulses as arrows as long as 0.1 s of the force would push 1 kg.
#include <cmath>

#include "feder/query.h"
#include "state/colliders.h"
#include "state/contacts.h"
#include "view/collector.h"

namespace feder::view {
namespace {

class ContactSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    if (!c.toggles.contacts && !c.toggles.impulses) return;
    Collide* collide = c.world.find<Collide>();
    if (!collide) return;
    const Contacts& contacts = collide->contacts();
    for (const std::uint32_t slot : contacts.order)
      if (contacts.slots[slot].touching) add_contact(c, collide->colliders(), contacts.slots[slot]);
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
};

}  // namespace

Row view_collide() { return {"collide", make_source<ContactSource>}; }

}  // namespace feder::view
