// Islands: lines between the centres of bodies that touch or are joined, one colour per island (union-find over those
// links).
#include <algorithm>

#include "constrain/joint.h"
#include "feder/query.h"
#include "feder/rigid.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "state/contacts.h"
#include "view/collector.h"

namespace feder::view {
namespace {

class IslandSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    if (!c.toggles.islands) return;
    const Rigid* rigid = c.world.find<Rigid>();
    Collide* collide = c.world.find<Collide>();
    if (rigid && collide) add(c, *collide, *rigid);
  }

 private:
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

  void add(Collecting& c, Collide& collide, const Rigid& rigid) {
    const Bodies& bodies = rigid.bodies();
    const Colliders& colliders = collide.colliders();
    parent_.resize(bodies.size());
    for (std::uint32_t i = 0; i < bodies.size(); ++i) parent_[i] = i;
    links_.clear();
    for (const std::uint32_t slot : collide.contacts().order) {
      const Contact& contact = collide.contacts().slots[slot];
      const std::uint32_t a = contact.collider_a, b = contact.collider_b;
      if (!contact.touching) continue;
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

Row view_rigid_islands() { return {"rigid", make_source<IslandSource>}; }

}  // namespace feder::view
