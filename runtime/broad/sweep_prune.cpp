// Sweep and prune on three axes: the ends of the boxes are sorted along each, and where the lower end of one passes the
// upper end of another, that pair is looked at. Source: Baraff, "Dynamic Simulation of Non-Penetrating Rigid Bodies"
// (1992), chapter on bounding boxes; Cohen et al., "I-COLLIDE", I3D 1995.
// Kept between calls: the three orders and all overlapping pairs. Boxes move little from step to step, so an insertion
// sort swaps few ends, about as many as they move past others; what rests costs a look at its ends.
// Where too many pass each other (a teleport of many, newcomers), all is sorted anew and swept along the axis on which
// the middles vary most. What counts is which ends changed places, so results do not depend on history.
// Unbounded boxes need nothing special: their ends sort first and last.
// Weak spot: crowds, in which ends pass many others that are far away in the other two directions.
#include <algorithm>
#include <cmath>

#include "bounds/segment_box.h"
#include "broad/pair_sort.h"

namespace feder {
namespace {

class SweepPrune final : public BroadPhase {
 public:
  explicit SweepPrune(Arena& arena)
      : boxes_(&arena), old_(&arena),
        listed_(&arena), ends_{Array<End>(&arena), Array<End>(&arena), Array<End>(&arena)}, kept_(&arena),
        added_(&arena), removed_(&arena), sorter_(arena) {}

  void find_pairs(std::span<const Aabb> boxes, std::span<const BoxMotion> motion, std::span<const std::uint32_t>,
                  Array<IndexPair>& pairs, JobPool& jobs) override {
    old_.swap(boxes_);
    boxes_.assign(boxes.begin(), boxes.end());
    const auto count = static_cast<std::uint32_t>(boxes.size());
    added_.clear(), removed_.clear();
    work_ = {};
    if (!enlist(motion) || !sort_ends())
      sweep_all(jobs);
    else
      merge_changes(jobs, std::max(count, static_cast<std::uint32_t>(listed_.size())));
    listed_.resize(count);
    pairs.clear();
    for (const IndexPair& p : kept_)
      if (motion[p.a] == BoxMotion::moving || motion[p.b] == BoxMotion::moving) pairs.push_back(p);
  }

  void query(const Aabb& box, Array<std::uint32_t>& found) const override {
    found.clear();
    for (const End& e : ends_[axis_]) {
      if (e.at > box.hi[axis_]) break;
      if (!e.upper() && overlaps(boxes_[e.item()], box)) found.push_back(e.item());
    }
    std::sort(found.begin(), found.end());
  }

  void query_ray(const Vec3& origin, const Vec3& ray, Array<std::uint32_t>& found) const override {
    found.clear();
    for (std::uint32_t i = 0; i < listed_.size(); ++i)
      if (listed_[i] && segment_hits(boxes_[i], origin, ray)) found.push_back(i);
  }

  BroadWork work() const override { return work_; }

 private:
  static constexpr std::size_t kMostSwaps = 12;  // per end and axis, beyond which a full sort may be cheaper
  struct End {
    Real at;
    std::uint32_t of;  // twice the box, and one more for the upper end: at one place lower ends come first
    std::uint32_t item() const { return of >> 1; }
    bool upper() const { return (of & 1) != 0; }
  };
  static bool before(const End& a, const End& b) {
    if (a.at != b.at) return a.at < b.at;
    return a.upper() != b.upper() ? b.upper() : a.of < b.of;
  }

  // A box with NaN overlaps nothing and would spoil the order.
  static bool ordered(const Aabb& b) {
    for (int k = 0; k < 3; ++k)
      if (std::isnan(b.lo[k]) || std::isnan(b.hi[k])) return false;
    return true;
  }
  bool were_overlapping(std::uint32_t i, std::uint32_t j) const {
    return listed_[i] == kStays && listed_[j] == kStays && overlaps(old_[i], old_[j]);
  }

  // Drops the ends of what is gone and appends those of what is new, beyond all others. False: too much is new.
  bool enlist(std::span<const BoxMotion> motion) {
    const auto count = static_cast<std::uint32_t>(motion.size());
    std::uint32_t gone = 0, fresh = 0;
    if (listed_.size() < count) listed_.resize(count, kAbsent);
    for (std::uint32_t i = 0; i < listed_.size(); ++i) {
      const bool wanted = i < count && motion[i] != BoxMotion::absent && ordered(boxes_[i]);
      const bool was = listed_[i] != kAbsent;
      listed_[i] = !wanted ? kAbsent : was ? kStays : kFresh;
      gone += was && !wanted, fresh += wanted && !was;
    }
    if (gone > 0) {
      const auto left = [&](const IndexPair& p) { return listed_[p.a] == kAbsent || listed_[p.b] == kAbsent; };
      kept_.erase(std::remove_if(kept_.begin(), kept_.end(), left), kept_.end());
    }
    for (int k = 0; k < 3; ++k) {
      Array<End>& ends = ends_[k];
      if (gone > 0) std::erase_if(ends, [&](const End& e) { return listed_[e.item()] != kStays; });
      for (End& e : ends) e.at = e.upper() ? boxes_[e.item()].hi[k] : boxes_[e.item()].lo[k];
      if (fresh == 0) continue;
      for (std::uint32_t i = 0; i < count; ++i)
        if (listed_[i] == kFresh)
          ends.push_back({boxes_[i].lo[k], 2 * i}), ends.push_back({boxes_[i].hi[k], 2 * i + 1});
    }
    return fresh < 16 + ends_[0].size() / 256;
  }

  // Insertion sort along each axis. False: the order has little to do with the last one, and is left unfinished.
  bool sort_ends() {
    for (Array<End>& ends : ends_) {
      std::size_t swaps = 0;
      const std::size_t most = std::max(kMostSwaps * ends.size(), swept_ / 4) + 64;
      for (std::size_t n = 1; n < ends.size(); ++n) {
        const End e = ends[n];
        std::size_t at = n;
        for (; at > 0 && before(e, ends[at - 1]); --at) {
          if (e.upper() != ends[at - 1].upper()) note(e, ends[at - 1]);
          ends[at] = ends[at - 1];
        }
        ends[at] = e;
        swaps += n - at;
        if (swaps > most) break;
      }
      work_.swaps += swaps;
      if (swaps > most) return false;
    }
    return true;
  }

  // A lower end that came below an upper one: the two may overlap now; an upper end below a lower one: no longer.
  void note(const End& e, const End& passed) {
    const std::uint32_t i = std::min(e.item(), passed.item()), j = std::max(e.item(), passed.item());
    if (i == j) return;
    ++work_.tests;
    if (overlaps(boxes_[i], boxes_[j]) == e.upper()) return;
    if (were_overlapping(i, j) == e.upper()) (e.upper() ? removed_ : added_).push_back({i, j});
  }

  // Both lists may name a pair once for each axis.
  void merge_changes(JobPool& jobs, std::uint32_t count) {
    for (Array<IndexPair>* list : {&added_, &removed_}) {
      sorter_.sort(*list, count, jobs);
      list->erase(std::unique(list->begin(), list->end()), list->end());
    }
    if (!removed_.empty()) {
      auto gone = removed_.begin();
      const auto left = [&](const IndexPair& p) {
        while (gone != removed_.end() && *gone < p) ++gone;
        return gone != removed_.end() && *gone == p;
      };
      std::size_t stays = 0;
      for (const IndexPair& p : kept_)
        if (!left(p)) kept_[stays++] = p;
      kept_.resize(stays);
    }
    // from behind, so that nothing is in the way
    std::size_t from = kept_.size(), to = from + added_.size();
    kept_.resize(to);
    for (std::size_t k = added_.size(); k > 0;) {
      const bool later = from > 0 && added_[k - 1] < kept_[from - 1];
      kept_[--to] = later ? kept_[--from] : added_[--k];
    }
  }

  void sweep_all(JobPool& jobs) {
    for (Array<End>& ends : ends_) std::sort(ends.begin(), ends.end(), before);
    choose_axis();
    kept_.clear();
    swept_ = 0;
    const Array<End>& ends = ends_[axis_];
    for (std::size_t n = 0; n < ends.size(); ++n) {
      if (ends[n].upper()) continue;
      const std::uint32_t i = ends[n].item();
      const Aabb& box = boxes_[i];
      std::size_t m = n + 1;
      for (; m < ends.size() && ends[m].at <= box.hi[axis_]; ++m) {
        const std::uint32_t j = ends[m].item();
        if (!ends[m].upper() && overlaps(box, boxes_[j])) kept_.push_back({std::min(i, j), std::max(i, j)});
      }
      swept_ += m - n, work_.tests += m - n;
    }
    sorter_.sort(kept_, static_cast<std::uint32_t>(boxes_.size()), jobs);
  }

  // The one along which the middles vary most.
  void choose_axis() {
    double sum[3] = {0, 0, 0}, square[3] = {0, 0, 0}, count = 0;
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
      const Vec3 center = (boxes_[i].lo + boxes_[i].hi) * Real(0.5);
      if (listed_[i] == kAbsent || !is_finite(center)) continue;
      for (int k = 0; k < 3; ++k) sum[k] += double(center[k]), square[k] += double(center[k]) * double(center[k]);
      count += 1;
    }
    double most = -1;
    for (int k = 0; k < 3 && count > 0; ++k)
      if (const double spread = square[k] - sum[k] * sum[k] / count; spread > most) most = spread, axis_ = k;
  }

  enum Listed : std::uint8_t { kAbsent, kStays, kFresh };
  Array<Aabb> boxes_, old_;  // of this call and the last
  Array<std::uint8_t> listed_;
  Array<End> ends_[3];     // sorted
  Array<IndexPair> kept_;  // all that overlap, sorted; with those that are both still
  Array<IndexPair> added_, removed_;
  PairSort sorter_;
  int axis_ = 0;
  BroadWork work_;         // of the last call
  std::size_t swept_ = 0;  // ends looked at in the last full sweep
};

}  // namespace

Variant<BroadPhase> broad_sweep_prune() {
  return variant_of<BroadPhase, SweepPrune>("sweep_prune", "boxes sorted along three axes; orders and pairs are kept");
}

}  // namespace feder
