// A group of contacts that are solved together: coloured greedily (no two of a colour push the same solver body), eight
// of a colour at a time; those that find no colour are solved alone. Groups of one step share no solver body that
// contacts can push. In the step's scratch memory.
#pragma once
#include <span>

#include "base/jobs.h"
#include "rigid/contact_batch.h"
#include "rigid/solver.h"

namespace feder {

// Contact softness by crowding: one pass per substep cannot resolve many stiff contacts of a body, so a contact is
// softer by kCrowd per contact's worth of stiffness above one. With less, pyramids of 30 do not come to rest; with 1.5
// one of 100 buckles.
inline constexpr Real kCrowd = 1.25;

// What the groups of a step share, by solver index.
struct ContactShared {
  const WideMass* masses = nullptr;
  Real* crowd = nullptr;            // stiffness of a body's contacts over its mass: 1 in a tower, 2 in a pyramid
  std::uint64_t* colors = nullptr;  // bits: those that a body has
};

class ContactGroup {
 public:
  // The contacts in `slots`; `level`: their substep is done in 2^level pieces.
  void build(const SolverInput& in, StepContext& c, const ContactShared& shared, std::span<const std::uint32_t> slots,
             int level);
  // Runs a kernel over all batches, colour after colour, or over those between bodies that move; `pass` has all but the
  // range.
  enum class Which { all, between_movers };
  void run(void (*kernel)(const ContactPass&), ContactPass pass, JobPool& jobs, Which which = Which::all);
  // The same as stages of a loop: body(first, last, worker) is called for batches of one colour. Returns their number.
  static constexpr int kMostStages = 65;  // colours, and before them what found none
  template <class Body>
  std::size_t stages(Body& body, JobPool::Stage* to, Which which = Which::all) const {
    std::size_t count = 0;
    if (overflow_count_ > 0)  // one after the other
      to[count++] = JobPool::stage(0, overflow_count_, {overflow_count_, overflow_count_ * kBatchNs}, body);
    for (int k = 0; k < colors(which); ++k)
      if (color_first_[k] < color_first_[k + 1])
        to[count++] =
            JobPool::stage(color_first_[k], color_first_[k + 1], {kSolveBatches, kSolveBatches * kBatchNs}, body);
    return count;
  }
  void store(Contacts& contacts, JobPool& jobs) const;
  ContactPass pass() const;  // with batches alone
  // Makes the batches of the pass's range from their contacts.
  void prepare(const SolverInput& in, const ContactShared& shared, const Vec3& gravity, const ContactKernels& kernels,
               ContactPass pass);
  bool any_bounces() const;
  bool any_strikes(bool all) const;  // found by `mark`; all: also without restitution
  void expect_strikes(StepContext& c, bool bounces) {
    strikes_ = c.scratch->take<StrikeBatch>(batch_count_), bounces_ = bounces;
  }

  // Batches with bodies that have turned, by solver index, get their masses again.
  void renew(const std::uint8_t* turned, const ContactKernels& kernels, ContactPass pass);

  // Calls f(place) for the points that `mark` has found.
  struct Place {
    std::uint32_t slot, batch, lane;
    int point;
  };
  template <class F>
  void each_strike(F&& f) const {
    for (std::uint32_t batch = 0; batch < batch_count_; ++batch) {
      if (!strikes_[batch].acts) continue;
      const ContactBatch& c = batches_[batch];
      for (std::uint32_t lane = 0; lane < kLanes; ++lane)
        for (int k = 0; k < static_cast<int>(c.points); ++k)
          if (strikes_[batch].approach[k].v[lane] < 0 && c.point[k].mass.v[lane] > 0)
            f(Place{lanes_[std::size_t(batch) * kLanes + lane], batch, lane, k});
    }
  }
  // An impulse of such a point, for events.
  void note_strike(const Place& at, Real impulse) { sides_[at.batch].total[at.point].v[at.lane] += impulse; }

  int level() const { return level_; }
  int pieces() const { return 1 << level_; }
  std::uint32_t batch_count() const { return batch_count_; }
  bool empty() const { return batch_count_ == 0; }
  bool bounces() const { return bounces_; }  // something has restitution

 private:
  static constexpr int kColors = kMostStages - 1;
  static constexpr int kFixedColor = 48;  // colours from here on: contacts against immovable bodies, solved last
  static int colors(Which which) { return which == Which::all ? kColors : kFixedColor; }
  static constexpr std::uint32_t kSolveBatches = 8, kBatchNs = 300;  // of a block; of a batch
  void color(const SolverInput& in, StepContext& c, const ContactShared& shared, std::span<const std::uint32_t> slots);
  void check_colors(const SolverInput& in, StepContext& c, const ContactShared& shared,
                    std::span<const std::uint32_t> slots) const;
  std::span<const std::uint32_t> lanes_of(std::uint32_t batch) const {
    return {lanes_ + std::size_t(batch) * kLanes, kLanes};
  }
  void fill_batch(const SolverInput& in, const ContactShared& shared, const Vec3& gravity, std::uint32_t batch,
                  BatchInput& input);
  void fill_lane(const Contact& contact, const Vec3& gravity, std::uint32_t batch, int lane, BatchInput& input);
  BatchExtra& use_extra(std::uint32_t batch);
  void store_batch(Contacts& contacts, std::uint32_t batch) const;

  ContactBatch* batches_ = nullptr;
  BatchSide* sides_ = nullptr;
  BatchExtra* extras_ = nullptr;
  StrikeBatch* strikes_ = nullptr;  // null: none are expected
  bool bounces_ = false;
  std::uint32_t* lanes_ = nullptr;  // contact slot by batch and lane, kNone where empty
  std::uint32_t batch_count_ = 0, overflow_count_ = 0;
  std::uint32_t color_first_[kColors + 1] = {};  // first batch of each colour; the overflow comes before colour 0
  JobPool::Stage stages_[kMostStages];           // of the kernel that runs
  int level_ = 0;
};

}  // namespace feder
