// Joints as lines: from each body's centre to its anchor, the axis, and a gap in red where a joint is pulled open.
#include "constrain/joint.h"
#include "feder/rigid.h"
#include "state/bodies.h"
#include "view/collector.h"

namespace feder::view {
namespace {

class JointSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    if (!c.toggles.joints) return;
    const Rigid* rigid = c.world.find<Rigid>();
    if (!rigid || rigid->joint_count() == 0) return;
    c.world.objects().for_each(kJointKind, [&](ObjectId id) { add(c, *rigid, id); });
  }

 private:
  static void add(Collecting& c, const Rigid& rigid, ObjectId id) {
    const Rigid::JointInfo j = rigid.joint_info(id);
    const Color arm = rgb(0xe8b23a);
    auto& lines = c.frame.overlay_lines;
    Real size = Real(0.3);
    const auto side = [&](ObjectId body, const Vec3& anchor) {
      if (!body) return;
      const std::uint32_t i = rigid.index(body);
      if (rigid.bodies().type[i] == BodyType::fixed) return;
      size = std::min(rigid.bodies().extent[i], Real(2)) / 2;
      add_line(lines, rigid.bodies().position[i], anchor, arm, 2);
    };
    side(j.a, j.anchor_a), side(j.b, j.anchor_b);
    if (length(j.anchor_b - j.anchor_a) > Real(1e-4)) add_line(lines, j.anchor_a, j.anchor_b, rgb(0xd8402c), 2);
    if (j.kind->uses & kUsesAxis)
      add_line(lines, Vec3(j.anchor_a - size * j.axis), Vec3(j.anchor_a + size * j.axis), rgb(0x2f62d0), 2.5f);
    c.label(id, j.anchor_a, rgb(0x6b4c06));
  }
};

}  // namespace

Row view_rigid_joints() { return {"rigid", make_source<JointSource>}; }

}  // namespace feder::view
