// Dynamic bounding volume trees over fattened boxes (the default).
// Source: fat leaves and re-insertion as in Bullet's and Box2D's dynamic trees (Presson 2008, Catto 2019, "Dynamic
// Bounding Volume Hierarchies", GDC); written from the talks.
// Kept between calls: a tree of still boxes and one of moving boxes; for every box the fat box in its leaf; and the
// sorted candidates: all pairs of overlapping fat boxes with a moving member. Only boxes that left their fat box are
// re-inserted and re-queried: what moves costs one containment test per box and one exact test per candidate, what
// lies still costs nothing.
// The exact test also makes the result independent of history, although fat boxes are not.
// Boxes that are unbounded, empty or NaN stay in a side list and are tested against everything.
// When many leave theirs, the tree is refitted, built anew now and then, and asked by packs of neighbours.
// Weak spot: when most boxes leave their fat boxes in each call, everything is queried again.
#include <algorithm>
#include <bit>
#include <limits>

#include "bounds/aabb_tree.h"
#include "bounds/box_block.h"
#include "broad/pair_sort.h"

namespace feder {
namespace {

// Margin of a moving leaf: this part of the box's mean side, so that slow boxes stay inside for many steps while the
// number of candidates hardly grows; plus this many steps of the last motion, which pays for boxes on their way.
constexpr Real kFatMargin = Real(0.1);
constexpr Real kFatSteps = 4;
// In that motion, of the mean side: what moves by more leaves any box soon that is not met by too many others, and a
// teleport says nothing about the next steps.
constexpr Real kMostFat = Real(0.75);
constexpr int kMostRefits = 8;      // of a tree between two builds: more do not help in a drum that turns
constexpr double kMostStrayed = 1;  // nor where boxes went by more than their mean side since

constexpr int kPackOf = 8;            // boxes that are asked for together
constexpr std::size_t kPackFrom = 2;  // one of so many leaves has changed: all are asked, pack by pack

constexpr JobGrain kQueryGrain{64, 15'000}, kPackGrain{16, 15'000}, kPairGrain{2048, 8'000};  // boxes; packs; pairs

constexpr Real kNothing = std::numeric_limits<Real>::quiet_NaN();  // a side of no box

enum Location : std::uint8_t { kNowhere, kSide, kStillTree, kMovingTree };

// What is known about a box; zero-initialised for a new one.
struct Leaf {
  Location location = kNowhere;
  std::uint8_t changed = 0;  // in changed_ now
};

class Tree final : public BroadPhase {
 public:
  explicit Tree(Arena& arena)
      : arena_(&arena), boxes_(&arena), fat_(&arena), leaves_(&arena), nodes_(&arena), side_(&arena), changed_(&arena),
        items_(&arena), order_(&arena), transfers_(&arena), candidates_(&arena), side_pairs_(&arena), marked_(&arena),
        sorter_(arena), still_(arena), moving_(arena) {
    found_by_.emplace_back(arena_);
  }

  void find_pairs(std::span<const Aabb> boxes, std::span<const BoxMotion> motion,
                  std::span<const std::uint32_t> touched, Array<IndexPair>& pairs, JobPool& jobs) override {
    looked_at_ = touched.size();
    update_leaves(boxes, motion, touched);
    if (!changed_.empty()) query_changed(jobs);
    if (!transfers_.empty()) merge_candidates(jobs);
    boxes_.resize(boxes.size());
    for (const std::uint32_t i : touched) boxes_[i] = boxes[i];
    pair_side(boxes, motion, touched, jobs);
    write_pairs(boxes, pairs, jobs);
    trim();
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

  bool cells_at(int level, void (*take)(void*, const Aabb&), void* to) const override {
    const auto draw = [&](const Aabb& box) { take(to, box); };
    const bool deeper = still_.nodes_at(level, draw);
    return moving_.nodes_at(level, draw) || deeper;
  }

  // The boxes that are looked at, those whose neighbours were found anew, and candidates.
  BroadWork work() const override {
    Counted all;
    const auto nothing = [](std::uint32_t, std::uint32_t) {};
    for (std::size_t first = 0; first < order_.size(); first += kPackOf) each_near(pack_at(first), nothing, all);
    if (order_.empty())
      for (const std::uint32_t i : changed_)
        if (leaves_[i].location > kSide) each_near(i, nothing, all);
    return {all.visits, all.tests + looked_at_ + candidates_.size() + side_.size() * boxes_.size(), 0};
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

  Aabb fattened(std::uint32_t i, const Aabb& box) {
    const Vec3 size = box.hi - box.lo;
    const Real side = (size[0] + size[1] + size[2]) / 3;
    const bool followed = i < boxes_.size() && leaves_[i].location == kMovingTree;
    const Vec3 step = followed ? Vec3((box.lo - boxes_[i].lo) * kFatSteps) : Vec3(0, 0, 0);
    const Real way = length(step);
    if (side > 0 && std::isfinite(way)) way_ += static_cast<double>(way / side) / double(kFatSteps);
    if (way > kMostFat * side) return box;
    Aabb fat = box;
    fat.grow(kFatMargin * side);
    fat.lo += step.cwiseMin(Vec3::Zero());
    fat.hi += step.cwiseMax(Vec3::Zero());
    return fat;
  }

  // Brings the location of every box up to date and lists those whose candidates must be found anew. A box that comes
  // to rest within its fat box changes trees but keeps its candidates: they are a superset of what it needs.
  void update_leaves(std::span<const Aabb> boxes, std::span<const BoxMotion> motion,
                     std::span<const std::uint32_t> touched) {
    changed_.clear();
    order_.clear();
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
    way_ = 0;
    for (const std::uint32_t i : touched) update(i);
    for (std::uint32_t i = count; i < leaves_.size(); ++i) update(i);
    if (!touched.empty()) strayed_ += way_ / static_cast<double>(touched.size());
    place_leaves();
  }

  // Inserting one by one costs about ten times as much per leaf as building, and that ten times as much as refitting.
  void place_leaves() {
    const std::size_t many = still_.leaves() / 8 + moving_.leaves() / 8 + 64;
    const auto stays = [&](const Transfer& c) {
      return c.location == kMovingTree && leaves_[c.box].location == kMovingTree;
    };
    const auto staying = static_cast<std::size_t>(std::count_if(transfers_.begin(), transfers_.end(), stays));
    if (transfers_.size() - staying > many) return rebuild();
    const bool refit = staying > moving_.leaves() / 8 + 32;
    for (const Transfer& c : transfers_)
      if (!refit || !stays(c)) transfer(c.box, c.location);
    if (!refit) return;
    if (++refits_ < kMostRefits && strayed_ < kMostStrayed) return moving_.refit(fat_);
    refits_ = 0, strayed_ = 0;
    list_location(kMovingTree, items_);
    moving_.build(items_, fat_, nodes_);
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
  void query_changed(JobPool& jobs) {
    while (found_by_.size() < static_cast<std::size_t>(jobs.threads())) found_by_.emplace_back(arena_);
    Array<IndexPair>& all = found_by_[0];
    for (Array<IndexPair>& found : found_by_) found.reserve(all.capacity());
    Uncounted none;
    if (changed_.size() * kPackFrom > moving_.leaves()) {
      moving_.each_leaf([&](std::uint32_t i) { order_.push_back(i); });
      const auto packs = static_cast<std::uint32_t>((order_.size() + kPackOf - 1) / kPackOf);
      jobs.for_blocks(packs, kPackGrain, [&](std::uint32_t first, std::uint32_t last, int worker) {
        Array<IndexPair>& found = found_by_[static_cast<std::size_t>(worker)];
        const auto visit = [&](std::uint32_t i, std::uint32_t j) {
          if (leaves_[i].changed || leaves_[j].changed) found.push_back({std::min(i, j), std::max(i, j)});
        };
        for (std::uint32_t n = first; n < last; ++n) each_near(pack_at(std::size_t(n) * kPackOf), visit, none);
      });
    } else {
      const auto count = static_cast<std::uint32_t>(changed_.size());
      jobs.for_blocks(count, kQueryGrain, [&](std::uint32_t first, std::uint32_t last, int worker) {
        Array<IndexPair>& found = found_by_[static_cast<std::size_t>(worker)];
        const auto visit = [&](std::uint32_t i, std::uint32_t j) {
          if (j != i && !(leaves_[j].changed && j < i)) found.push_back({std::min(i, j), std::max(i, j)});
        };
        for (std::uint32_t n = first; n < last; ++n)
          if (leaves_[changed_[n]].location > kSide) each_near(changed_[n], visit, none);
      });
    }
    for (std::size_t i = 1; i < found_by_.size(); ++i) all.insert(all.end(), found_by_[i].begin(), found_by_[i].end());
    sorter_.sort(all, static_cast<std::uint32_t>(leaves_.size()), jobs);
  }

  // Moving boxes that are neighbours in their tree: what meets the box around them is compared with all at once.
  struct Pack {
    Aabb around;
    BoxBlock boxes[kPackOf / 4];
    std::span<const std::uint32_t> items;
    unsigned overlapping(const Aabb& box) const {  // a bit each
      const BoxAround b(box);
      return feder::overlapping(boxes[0], b) | feder::overlapping(boxes[1], b) << 4;
    }
  };
  static_assert(kPackOf == 8);

  Pack pack_at(std::size_t first) const {
    Pack p;
    p.items = std::span(order_).subspan(first, std::min<std::size_t>(kPackOf, order_.size() - first));
    for (int k = 0; k < kPackOf; ++k) {
      const auto n = static_cast<std::size_t>(k);
      const bool used = n < p.items.size();
      const Aabb box = used ? fat_[p.items[n]] : Aabb{Vec3::Constant(kNothing), Vec3::Constant(kNothing)};
      p.boxes[k / 4].put(k % 4, box);
      if (used) p.around = k == 0 ? box : Aabb{p.around.lo.cwiseMin(box.lo), p.around.hi.cwiseMax(box.hi)};
    }
    return p;
  }

  // Calls visit(i, j) for the boxes j near the box i.
  template <class F, class W>
  void each_near(std::uint32_t i, F&& visit, W& work) const {
    const auto met = [&](std::uint32_t j) { visit(i, j); };
    moving_.query(fat_[i], met, work);
    if (leaves_[i].location == kMovingTree) still_.query(fat_[i], met, work);
  }
  // For the boxes i of a pack; of two moving boxes the first in the tree's order has the other.
  template <class F, class W>
  void each_near(const Pack& p, F&& visit, W& work) const {
    const auto meet = [&](std::uint32_t j, unsigned of) {
      work.test();
      for (unsigned bits = p.overlapping(fat_[j]) & of; bits != 0; bits &= bits - 1)
        visit(p.items[static_cast<std::size_t>(std::countr_zero(bits))], j);
    };
    for (std::size_t k = 1; k < p.items.size(); ++k) meet(p.items[k], (1u << k) - 1);
    const auto any = [&](std::uint32_t j) { meet(j, ~0u); };
    moving_.query_after(nodes_[p.items.back()], p.around, any, work);
    still_.query(p.around, any, work);
  }

  // Marks those candidates for which stays(pair), a bit each.
  template <class F>
  void mark_candidates(JobPool& jobs, F&& stays) {
    static_assert(kPairGrain.items % 64 == 0);
    const auto count = static_cast<std::uint32_t>(candidates_.size());
    marked_.resize((count + 63) / 64);
    jobs.for_blocks(count, kPairGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t n = first; n < last; n += 64) {
        std::uint64_t bits = 0;
        for (std::uint32_t k = n; k < std::min(n + 64, last); ++k)
          bits |= std::uint64_t(stays(candidates_[k])) << (k - n);
        marked_[n / 64] = bits;
      }
    });
  }
  // Calls f(pair) for these, in their order.
  template <class F>
  void each_marked(F&& f) const {
    for (std::size_t word = 0; word < marked_.size(); ++word)
      for (std::uint64_t bits = marked_[word]; bits != 0; bits &= bits - 1)
        f(candidates_[64 * word + static_cast<std::size_t>(std::countr_zero(bits))]);
  }

  void merge_candidates(JobPool& jobs) {
    const Array<IndexPair>& found = found_by_[0];
    mark_candidates(jobs,
                    [&](const IndexPair& p) { return !leaves_[p.a].changed && !leaves_[p.b].changed && one_moves(p); });
    std::size_t from = 0;
    each_marked([&](const IndexPair& p) { candidates_[from++] = p; });
    // from behind, so that nothing is in the way
    std::size_t to = from + found.size();
    candidates_.resize(to);
    for (std::size_t k = found.size(); k > 0;) {
      const bool later = from > 0 && found[k - 1] < candidates_[from - 1];
      candidates_[--to] = later ? candidates_[--from] : found[--k];
    }
    for (const std::uint32_t i : changed_) leaves_[i].changed = 0;
  }

  // What a step with many new pairs needed.
  void trim() {
    const bool much = found_slack_.clear(found_by_[0]);
    for (Array<IndexPair>& found : found_by_) {
      found.clear();
      if (much) Array<IndexPair>(arena_).swap(found);
    }
  }

  bool one_moves(const IndexPair& p) const {
    return leaves_[p.a].location == kMovingTree || leaves_[p.b].location == kMovingTree;
  }

  // A side box that lies still meets those that move, which are all touched.
  void pair_side(std::span<const Aabb> boxes, std::span<const BoxMotion> motion, std::span<const std::uint32_t> touched,
                 JobPool& jobs) {
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
    sorter_.sort(side_pairs_, static_cast<std::uint32_t>(leaves_.size()), jobs);
  }

  // The candidates that really overlap, merged with the pairs of the side list.
  void write_pairs(std::span<const Aabb> boxes, Array<IndexPair>& pairs, JobPool& jobs) {
    mark_candidates(jobs, [&](const IndexPair& p) { return overlaps(boxes[p.a], boxes[p.b]) && one_moves(p); });
    pairs.clear();
    auto side = side_pairs_.begin();
    each_marked([&](const IndexPair& p) {
      while (side != side_pairs_.end() && *side < p) pairs.push_back(*side++);
      pairs.push_back(p);
    });
    pairs.insert(pairs.end(), side, side_pairs_.end());
  }

  Arena* arena_;
  Array<Aabb> boxes_;  // of the last call
  Array<Aabb> fat_;
  Array<Leaf> leaves_;
  Array<std::uint32_t> nodes_;  // of the leaf in its tree
  Array<std::uint32_t> side_, changed_, items_, order_;
  Array<Transfer> transfers_;
  Array<IndexPair> candidates_, side_pairs_;
  std::vector<Array<IndexPair>> found_by_;  // by worker; in the end the first has all
  Slack found_slack_;
  Array<std::uint64_t> marked_;  // a bit per candidate
  PairSort sorter_;
  int refits_ = 0;                // since the tree was built
  double way_ = 0, strayed_ = 0;  // by their sides, of those that left their fat boxes: in a call, and since then
  std::size_t looked_at_ = 0;     // boxes in the last call
  AabbTree still_, moving_;
};

}  // namespace

Variant<BroadPhase> broad_tree() {
  return variant_of<BroadPhase, Tree>("tree", "dynamic trees of fattened boxes; what rests costs nearly nothing");
}

}  // namespace feder
