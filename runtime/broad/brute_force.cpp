// All pairs against all pairs: the oracle of the other broad phases, and good enough below some fifty boxes.
// Kept between calls: a copy of the boxes for queries. Weak spot: n^2 / 2 box tests.
#include <algorithm>

#include "bounds/segment_box.h"
#include "broad/broad_phase.h"

namespace feder {
namespace {

class BruteForce final : public BroadPhase {
 public:
  explicit BruteForce(Arena& arena) : boxes_(&arena), motion_(&arena) {}

  void find_pairs(std::span<const Aabb> boxes, std::span<const BoxMotion> motion, std::span<const std::uint32_t>,
                  Array<IndexPair>& pairs, JobPool&) override {
    boxes_.assign(boxes.begin(), boxes.end());
    motion_.assign(motion.begin(), motion.end());
    pairs.clear();
    const std::uint32_t count = static_cast<std::uint32_t>(boxes.size());
    for (std::uint32_t a = 0; a < count; ++a) {
      if (motion[a] == BoxMotion::absent) continue;
      for (std::uint32_t b = a + 1; b < count; ++b) {
        if (motion[b] == BoxMotion::absent) continue;
        if (motion[a] == BoxMotion::still && motion[b] == BoxMotion::still) continue;
        if (overlaps(boxes[a], boxes[b])) pairs.push_back({a, b});
      }
    }
  }

  void query(const Aabb& box, Array<std::uint32_t>& found) const override {
    found.clear();
    for (std::uint32_t i = 0; i < boxes_.size(); ++i)
      if (motion_[i] != BoxMotion::absent && overlaps(boxes_[i], box)) found.push_back(i);
  }

  void query_ray(const Vec3& origin, const Vec3& ray, Array<std::uint32_t>& found) const override {
    found.clear();
    for (std::uint32_t i = 0; i < boxes_.size(); ++i)
      if (motion_[i] != BoxMotion::absent && segment_hits(boxes_[i], origin, ray)) found.push_back(i);
  }

  BroadWork work() const override {
    std::uint64_t still = 0, moving = 0;
    for (const BoxMotion m : motion_) still += m == BoxMotion::still, moving += m == BoxMotion::moving;
    return {0, moving * still + moving * (moving - std::min<std::uint64_t>(moving, 1)) / 2, 0};
  }

 private:
  Array<Aabb> boxes_;
  Array<BoxMotion> motion_;
};

}  // namespace

Variant<BroadPhase> broad_brute_force() {
  return variant_of<BroadPhase, BruteForce>("brute_force", "every box against every other; the oracle");
}

}  // namespace feder
