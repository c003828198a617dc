// Dynamic bounding volume trees over fattened boxes (the default).
// Source: fat leaves and re-insertion as in Bullet's and Box2D's dynamic trees (Presson 2008, Catto 2019, "Dynamic
// Bounding Volume Hierarchies", GDC); written from the talks.
// Kept between calls: a tree of still boxes and one of moving boxes; for every box the fat box in its leaf; and the
// sorted candidates: all pairs of overlapping fat boxes with a moving member. Only boxes that left their fat box are
// re-inserted and re-queried: what moves costs one containment test per box and one exact test per candidate, what
// lies still costs nothing.
// The exact test also makes the result independent of history, although fat boxes are not.
// Boxes that are unbounded, empty or NaN stay in a side list and are tested against everything.
// Weak spot: when most boxes leave their fat boxes in each call, trees are rebuilt and everything is queried again.
#include <algorithm>

#include "bounds/aabb_tree.h"
#include "broad/pair_sort.h"

namespace feder {
namespace {

// Margin of a moving leaf: this part of the box's mean side, so that slow boxes stay inside for many steps while the
// number of candidates hardly grows; plus this many steps of the last motion, which pays for boxes on their way.
constexpr Real kFatMargin = Real(0.1);
constexpr Real kFatSteps = 4;

enum Location : std::uint8_t { kNowhere, kSide, kStillTree, kMovingTree };

// What is known about a box; zero-initialised for a new one.
struct Leaf {
  Location location = kNowhere;
  std::uint8_t changed = 0;  // in changed_ now
};

class Tree final : public BroadPhase {
 public:
  explicit Tree(Arena& arena)
      : boxes_(&arena), fat_(&arena), leaves_(&arena), nodes_(&arena), side_(&arena), changed_(&arena), items_(&arena),
        transfers_(&arena), candidates_(&arena), found_(&arena), merged_(&arena), side_pairs_(&arena), sorter_(arena),
        still_(arena), moving_(arena) {}

  void find_pairs(std::span<const Aabb> boxes, std::span<const BoxMotion> motion,
                  std::span<const std::uint32_t> touched, Array<IndexPair>& pairs) override {
    update_leaves(boxes, motion, touched);
    if (!changed_.empty()) query_changed();
    if (!transfers_.empty()) merge_candidates();
    boxes_.resize(boxes.size());
    for (const std::uint32_t i : touched) boxes_[i] = boxes[i];
    pair_side(boxes, motion, touched);
    write_pairs(boxes, pairs);
  }

  void query(const Aabb& box, Array<std::uint32_t>& found) const override {
    found.clear();
    const auto visit = [&](std::uint32_t i) {
      if (overlaps(boxes_[i], box)) found.push_back(i);
    };
    still_.query(box, visit);
    moving_.query(box, visit);
    for (const std::uint32_t i : side_) visit(i);
    std::sort(found.begin(), found.end());
  }

  void query_still(const Aabb& box, Array<std::uint32_t>& found) const override {
    found.clear();
    const auto visit = [&](std::uint32_t i) {
      if (overlaps(boxes_[i], box)) found.push_back(i);
    };
    still_.query(box, visit);
    for (const std::uint32_t i : side_) visit(i);
    std::sort(found.begin(), found.end());
  }

  void query_ray(const Vec3& origin, const Vec3& ray, Array<std::uint32_t>& found) const override {
    found.clear();
    const auto visit = [&](std::uint32_t i) {
      if (segment_hits(boxes_[i], origin, ray)) found.push_back(i);
    };
    still_.query_ray(origin, ray, visit);
    moving_.query_ray(origin, ray, visit);
    for (const std::uint32_t i : side_) visit(i);
    std::sort(found.begin(), found.end());
  }

 private:
  struct Transfer {
    std::uint32_t box;
    Location location;
  };

  static bool regular(const Aabb& b) {
    const Real big = Real(1e15);  // m; beyond it surfaces overflow in single precision
    for (int k = 0; k < 3; ++k)
      if (!(b.lo[k] <= b.hi[k] && b.lo[k] >= -big && b.hi[k] <= big)) return false;
    return true;
  }

  AabbTree& tree(Location location) { return location == kStillTree ? still_ : moving_; }

  Aabb fattened(std::uint32_t i, const Aabb& box) const {
    const Vec3 size = box.hi - box.lo;
    Aabb fat = box;
    fat.grow(kFatMargin * (size[0] + size[1] + size[2]) / 3);
    if (i >= boxes_.size() || leaves_[i].location != kMovingTree) return fat;
    const Vec3 step = (box.lo - boxes_[i].lo) * kFatSteps;
    // a teleport says nothing about the next steps
    if (length(step) > kFatSteps * (size[0] + size[1] + size[2])) return fat;
    fat.lo += step.cwiseMin(Vec3::Zero());
    fat.hi += step.cwiseMax(Vec3::Zero());
    return fat;
  }

  // Brings the location of every box up to date and lists those whose candidates must be found anew. A box that comes
  // to rest within its fat box changes trees but keeps its candidates: they are a superset of what it needs.
  void update_leaves(std::span<const Aabb> boxes, std::span<const BoxMotion> motion,
                     std::span<const std::uint32_t> touched) {
    changed_.clear();
    transfers_.clear();
    const std::uint32_t count = static_cast<std::uint32_t>(boxes.size());
    if (leaves_.size() < count) leaves_.resize(count), fat_.resize(count), nodes_.resize(count, kNone);
    const auto update = [&](std::uint32_t i) {
      const Location now = leaves_[i].location;
      const Location wanted = i >= count || motion[i] == BoxMotion::absent ? kNowhere
                              : !regular(boxes[i])                         ? kSide
                              : motion[i] == BoxMotion::still              ? kStillTree
                                                                           : kMovingTree;
      const bool fits = wanted <= kSide || (now > kSide && contains(fat_[i], boxes[i]));
      if (wanted == now && fits) return;
      transfers_.push_back({i, wanted});
      if (now == kMovingTree && wanted == kStillTree && fits) return;
      leaves_[i].changed = 1;
      changed_.push_back(i);
      if (wanted > kSide) fat_[i] = wanted == kMovingTree ? fattened(i, boxes[i]) : boxes[i];
    };
    for (const std::uint32_t i : touched) update(i);
    for (std::uint32_t i = count; i < leaves_.size(); ++i) update(i);
    // inserting one by one costs about ten times as much per leaf as building
    if (transfers_.size() > still_.leaves() / 8 + moving_.leaves() / 8 + 64) {
      rebuild();
    } else {
      for (const Transfer& c : transfers_) transfer(c.box, c.location);
    }
  }

  void transfer(std::uint32_t i, Location location) {
    Leaf& leaf = leaves_[i];
    if (leaf.location == kSide) side_.erase(std::find(side_.begin(), side_.end(), i));
    if (leaf.location > kSide) tree(leaf.location).remove(nodes_[i]);
    leaf.location = location;
    if (location == kSide) side_.push_back(i);
    if (location > kSide) nodes_[i] = tree(location).insert(fat_[i], i);
  }

  void rebuild() {
    for (const Transfer& c : transfers_) leaves_[c.box].location = c.location;
    list_location(kSide, side_);
    list_location(kStillTree, items_);
    still_.build(items_, fat_, nodes_);
    list_location(kMovingTree, items_);
    moving_.build(items_, fat_, nodes_);
  }

  void list_location(Location location, Array<std::uint32_t>& out) const {
    out.clear();
    for (std::uint32_t i = 0; i < leaves_.size(); ++i)
      if (leaves_[i].location == location) out.push_back(i);
  }

  // All candidates with a member in changed_, each once: of two changed boxes the lower index reports.
  void query_changed() {
    found_.clear();
    for (const std::uint32_t i : changed_) {
      if (leaves_[i].location <= kSide) continue;
      const auto visit = [&](std::uint32_t j) {
        if (j == i || (leaves_[j].changed && j < i)) return;
        found_.push_back({std::min(i, j), std::max(i, j)});
      };
      moving_.query(fat_[i], visit);
      if (leaves_[i].location == kMovingTree) still_.query(fat_[i], visit);
    }
    sorter_.sort(found_, static_cast<std::uint32_t>(leaves_.size()));
  }

  void merge_candidates() {
    merged_.clear();
    if (changed_.empty()) found_.clear();
    std::size_t n = 0;
    for (const IndexPair& p : candidates_) {
      if (leaves_[p.a].changed || leaves_[p.b].changed || !one_moves(p)) continue;
      while (n < found_.size() && found_[n] < p) merged_.push_back(found_[n++]);
      merged_.push_back(p);
    }
    merged_.insert(merged_.end(), found_.begin() + static_cast<std::ptrdiff_t>(n), found_.end());
    candidates_.swap(merged_);
    merged_.reserve(candidates_.capacity());  // both grow together, so that a swap never allocates later
    for (const std::uint32_t i : changed_) leaves_[i].changed = 0;
  }

  bool one_moves(const IndexPair& p) const {
    return leaves_[p.a].location == kMovingTree || leaves_[p.b].location == kMovingTree;
  }

  // A side box that lies still meets those that move, which are all touched.
  void pair_side(std::span<const Aabb> boxes, std::span<const BoxMotion> motion,
                 std::span<const std::uint32_t> touched) {
    side_pairs_.clear();
    for (const std::uint32_t i : side_) {
      const bool still = motion[i] == BoxMotion::still;
      const auto meet = [&](std::uint32_t j) {
        if (j == i || motion[j] == BoxMotion::absent || (leaves_[j].location == kSide && j < i)) return;
        if (still && motion[j] == BoxMotion::still) return;
        if (overlaps(boxes[i], boxes[j])) side_pairs_.push_back({std::min(i, j), std::max(i, j)});
      };
      if (still)
        for (const std::uint32_t j : touched) meet(j);
      else
        for (std::uint32_t j = 0; j < boxes.size(); ++j) meet(j);
    }
    sorter_.sort(side_pairs_, static_cast<std::uint32_t>(leaves_.size()));
  }

  // The candidates that really overlap, merged with the pairs of the side list.
  void write_pairs(std::span<const Aabb> boxes, Array<IndexPair>& pairs) const {
    pairs.clear();
    std::size_t n = 0;
    for (const IndexPair& p : candidates_) {
      if (!overlaps(boxes[p.a], boxes[p.b]) || !one_moves(p)) continue;
      while (n < side_pairs_.size() && side_pairs_[n] < p) pairs.push_back(side_pairs_[n++]);
      pairs.push_back(p);
    }
    pairs.insert(pairs.end(), side_pairs_.begin() + static_cast<std::ptrdiff_t>(n), side_pairs_.end());
  }

  Array<Aabb> boxes_;  // of the last call
  Array<Aabb> fat_;
  Array<Leaf> leaves_;
  Array<std::uint32_t> nodes_;  // of the leaf in its tree
  Array<std::uint32_t> side_, changed_, items_;
  Array<Transfer> transfers_;
  Array<IndexPair> candidates_, found_, merged_, side_pairs_;
  PairSort sorter_;
  AabbTree still_, moving_;
};

}  // namespace

Variant<BroadPhase> broad_tree() {
  return variant_of<BroadPhase, Tree>("tree", "dynamic trees of fattened boxes; what rests costs nearly nothing");
}

}  // namespace feder
