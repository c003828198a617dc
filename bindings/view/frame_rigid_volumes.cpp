// Volumes of the indices of meshes at one level; of shapes without any, at level 0, the box. What an index answers is
// kept while that level is drawn.
#include <cstdio>
#include <unordered_map>

#include "feder/query.h"
#include "feder/rigid.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "view/collector.h"

namespace feder::view {
namespace {

constexpr std::size_t kMostEdges = 50'000;  // of a mesh; a picture of more shows nothing
constexpr std::uint32_t kLevelColors[] = {0xd03a2f, 0xe8792c, 0x8a7a00, 0x2b8a3e, 0x0f7f8f, 0x2f62d0, 0x7a3fc0};

class VolumeSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    const Rigid* rigid = c.world.find<Rigid>();
    Collide* collide = c.world.find<Collide>();
    if (!c.toggles.volumes || c.toggles.volume_level != level_) kept_.clear();
    if (!c.toggles.volumes || !rigid || !collide) return;
    level_ = c.toggles.volume_level;
    const Colliders& colliders = collide->colliders();
    for (auto& [shape, level] : kept_) level.used = false;
    for (std::uint32_t k = 0; k < colliders.size(); ++k) {
      if (colliders.motion[k] == ColliderMotion::none || colliders.owner[k] != ColliderOwner::body) continue;
      const Level& level = of(colliders.shapes[k]);
      const Pose pose = rigid->bodies().com_pose(colliders.owner_index[k]) * colliders.local[k];
      add(c, level, pose, colliders.object[k]);
      if (level.ends.empty() && level_ == 0) add_box(c.frame.outlines, colliders.shape[k]->bounds(pose), color());
    }
    std::erase_if(kept_, [](const auto& entry) { return !entry.second.used; });
  }

 private:
  struct Level {
    ShapePtr shape;          // so that its address stays its own
    std::vector<Vec3> ends;  // of edges, in pairs, in the shape's frame
    bool deeper = false, complete = true, used = false;
  };

  const Level& of(const ShapePtr& shape) {
    Level& level = kept_[shape.get()];
    level.used = true;
    if (level.shape) return level;
    level.shape = shape;
    const auto take = [](void* context, const Vec3& a, const Vec3& b) {
      Level& to = *static_cast<Level*>(context);
      to.complete = to.ends.size() < 2 * kMostEdges;
      if (to.complete) to.ends.push_back(a), to.ends.push_back(b);
      return to.complete;
    };
    level.deeper = shape->volumes_at(level_, take, &level);
    return level;
  }

  void add(Collecting& c, const Level& level, const Pose& pose, ObjectId object) const {
    c.frame.deeper_volumes |= level.deeper;
    for (std::size_t i = 0; i + 1 < level.ends.size(); i += 2)
      add_line(c.frame.outlines, to_world(pose, level.ends[i]), to_world(pose, level.ends[i + 1]), color(), 1);
    if (level.complete) return;
    Note note{object, {}};
    std::snprintf(note.text, sizeof note.text, "%s: of its volumes at level %d the first %zu edges are drawn",
                  c.world.objects().describe(object).c_str(), level_, kMostEdges);
    c.frame.notes.push_back(note);
  }

  Color color() const { return rgb(kLevelColors[static_cast<std::size_t>(level_) % std::size(kLevelColors)]); }

  std::unordered_map<const Shape*, Level> kept_;  // found by shape, in no order
  int level_ = 0;
};

}  // namespace

Row view_rigid_volumes() { return {"rigid", make_source<VolumeSource>}; }

}  // namespace feder::view
