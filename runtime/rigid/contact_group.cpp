#include "rigid/contact_group.h"

#include <algorithm>
#include <cstring>

#include "base/hash.h"
#include "base/prefetch.h"
#include "feder/error.h"

namespace feder {
namespace {

// In ContactShared::crowd immovable bodies count kSupport: with 1/2 a heavy crate on a light one oscillates for twice
// as long, with 1 a tower sinks a twentieth deeper.
constexpr Real kSupport = 0.75;
// batches per job
constexpr JobGrain kStoreGrain{8, 1'000};
constexpr JobGrain kEndsGrain{512, 8'000};  // contacts

constexpr std::uint32_t kAhead = 8;  // contacts, asked for before they are read

struct Ends {
  std::uint32_t a, b;  // solver indices
  std::uint8_t kind;
};

// Contacts that cost alike share batches: by their points, and whether they have a warm start.
constexpr int kKinds = 6;
std::uint8_t kind_of(const Contact& c) {
  const int points = std::min<int>(c.point_count, 3) - 1, cold = c.points[0].normal_impulse == 0;
  return static_cast<std::uint8_t>(2 * points + cold);
}

static_assert(kBatchPoints == kMaxContactPoints);

}  // namespace

void ContactGroup::build(const SolverInput& in, StepContext& c, const ContactShared& shared,
                         std::span<const std::uint32_t> slots, int level) {
  level_ = level;
  strikes_ = nullptr, bounces_ = false;
  batch_count_ = overflow_count_ = 0;
  if (slots.empty()) return;
  color(in, c, shared, slots);
  batches_ = c.scratch->take<ContactBatch>(batch_count_);
  sides_ = c.scratch->take<BatchSide>(batch_count_);
  extras_ = c.scratch->take_rare<BatchExtra>(batch_count_);
}

void ContactGroup::color(const SolverInput& in, StepContext& c, const ContactShared& shared,
                         std::span<const std::uint32_t> slots) {
  const Contacts& contacts = *in.contacts;
  const SolverBodies& solver_bodies = *in.solver_bodies;
  const std::uint32_t count = static_cast<std::uint32_t>(slots.size());
  std::uint64_t* taken = shared.colors;
  std::uint8_t* color_of = c.scratch->take<std::uint8_t>(count);
  // in parallel what misses the caches
  Ends* ends = c.scratch->take<Ends>(count);
  c.jobs->for_blocks(count, kEndsGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      if (i + kAhead < last) __builtin_prefetch(&contacts.slots[slots[i + kAhead]]);
      const Contact& contact = contacts.slots[slots[i]];
      ends[i] = {in.solver_index(contact.collider_a), in.solver_index(contact.collider_b), kind_of(contact)};
    }
  });
  // the world and kinematic solver bodies never conflict
  const std::uint64_t kFixedMask = ~std::uint64_t(0) << kFixedColor;
  // greedy: the first colour that neither body has; and how crowded each body is
  std::uint32_t of_color[kColors + 1][kKinds] = {};
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto [a, b, kind] = ends[i];
    const bool moves_a = shared.masses[a].movable > 0, moves_b = shared.masses[b].movable > 0;
    std::uint64_t used = (moves_a ? taken[a] : 0) | (moves_b ? taken[b] : 0);
    used |= moves_a && moves_b ? kFixedMask : ~kFixedMask;
    FEDER_ASSERT(a < solver_bodies.state.size() && b < solver_bodies.state.size());
    const Real wa = solver_bodies.mass[a].inv_mass, wb = solver_bodies.mass[b].inv_mass;
    const bool both = wa > 0 && wb > 0;
    shared.crowd[a] += both ? wa / (wa + wb) : kSupport;
    shared.crowd[b] += both ? wb / (wa + wb) : kSupport;
    std::uint8_t color = kColors;
    if (~used) {
      color = static_cast<std::uint8_t>(__builtin_ctzll(~used));
      const std::uint64_t bit = std::uint64_t(1) << color;
      if (moves_a) taken[a] |= bit;
      if (moves_b) taken[b] |= bit;
    }
    color_of[i] = color;
    ++of_color[color][kind];
  }
  // overflow first, one contact per batch
  std::uint32_t batch = 0, next[kColors + 1][kKinds] = {};
  for (const std::uint32_t of_kind : of_color[kColors]) batch += of_kind;
  overflow_count_ = batch;
  for (int k = 0; k < kColors; ++k) {
    color_first_[k] = batch;
    std::uint32_t lane = batch * kLanes;
    for (int kind = 0; kind < kKinds; ++kind) next[k][kind] = lane, lane += of_color[k][kind];
    batch = (lane + kLanes - 1) / kLanes;
  }
  color_first_[kColors] = batch_count_ = batch;
  // contacts into their lanes
  lanes_ = c.scratch->take<std::uint32_t>(std::size_t(batch) * kLanes);
  std::fill(lanes_, lanes_ + std::size_t(batch) * kLanes, kNone);
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool alone = color_of[i] == kColors;
    std::uint32_t& at = next[color_of[i]][alone ? 0 : ends[i].kind];
    lanes_[at] = slots[i];
    at += alone ? kLanes : 1;
  }
  if constexpr (kAsserts) check_colors(in, c, shared, slots);
}

// Checks the colouring: each contact lies in one lane; lanes of a colour, and those of an overflow batch, push
// different solver bodies.
void ContactGroup::check_colors(const SolverInput& in, StepContext& c, const ContactShared& shared,
                                std::span<const std::uint32_t> slots) const {
  std::uint32_t* last =
      c.scratch->take<std::uint32_t>(in.solver_bodies->state.size());  // by solver index: the colour it was met in
  std::fill(last, last + in.solver_bodies->state.size(), kNone);
  MultisetHash active, listed;
  for (const std::uint32_t slot : slots) active.add(slot);
  FEDER_ASSERT(color_first_[0] == overflow_count_ && color_first_[kColors] == batch_count_);
  int color = 0;
  for (std::uint32_t batch = 0; batch < batch_count_; ++batch) {
    while (batch >= overflow_count_ && batch >= color_first_[color + 1]) ++color;
    const std::uint32_t name = batch < overflow_count_ ? kColors + batch : static_cast<std::uint32_t>(color);
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t slot = lanes_[std::size_t(batch) * kLanes + lane];
      if (slot == kNone) continue;
      listed.add(slot);
      const Contact& contact = in.contacts->slots[slot];
      for (const std::uint32_t collider : {contact.collider_a, contact.collider_b}) {
        const std::uint32_t i = in.solver_index(collider);
        if (!(shared.masses[i].movable > 0)) continue;
        FEDER_ASSERT(last[i] != name);
        last[i] = name;
      }
    }
  }
  FEDER_ASSERT(active == listed);
}

// Cleared when a first lane uses it.
BatchExtra& ContactGroup::use_extra(std::uint32_t batch) {
  BatchExtra& extra = extras_[batch];
  if (!batches_[batch].rolls && !batches_[batch].conveys) std::memset(static_cast<void*>(&extra), 0, sizeof extra);
  return extra;
}

void ContactGroup::fill_lane(const Contact& contact, const Vec3& gravity, std::uint32_t batch, int lane,
                             BatchInput& input) {
  FEDER_ASSERT(contact.touching);
  FEDER_ASSERT(contact.point_count >= 1 && contact.point_count <= kBatchPoints);
  ContactBatch& c = batches_[batch];
  BatchSide& side = sides_[batch];
  const Real share = Real(1) / static_cast<Real>(pieces());  // impulses are kept per substep
  const auto put = [lane](Lane8x3& to, const Vec3& v) {
    to.x.v[lane] = v[0], to.y.v[lane] = v[1], to.z.v[lane] = v[2];
  };
  // points
  put(c.normal, contact.normal);
  for (int j = 0; j < contact.point_count; ++j) {
    const ContactPoint& from = contact.points[j];
    BatchPoint& q = c.point[j];
    put(input.arm_a[j], from.arm_a);
    put(input.arm_b[j], from.arm_b);
    q.separation.v[lane] = from.separation;
    q.impulse.v[lane] = share * from.normal_impulse;
    q.mass.v[lane] = 1;
  }
  c.points = std::max(c.points, static_cast<unsigned char>(contact.point_count));
  // landing: no warm start, and about to carry weight: worth more rounds
  input.lands.v[lane] = contact.fresh || std::fabs(dot(contact.normal, gravity)) > length(gravity) / 2 ? 1 : 0;
  // friction and restitution
  c.friction_static.v[lane] = contact.friction_static;
  c.friction_dynamic.v[lane] = contact.friction_dynamic;
  c.tangent_impulse[0].v[lane] = share * contact.tangent_impulse[0];
  c.tangent_impulse[1].v[lane] = share * contact.tangent_impulse[1];
  c.twist_impulse.v[lane] = share * contact.twist_impulse;
  if (!contact.surface_velocity.isZero(0)) {
    Vec3 t1, t2;
    tangent_frame(contact.normal, t1, t2);
    BatchExtra& extra = use_extra(batch);
    c.conveys = 1;
    extra.tangent_speed[0].v[lane] = dot(contact.surface_velocity, t1);
    extra.tangent_speed[1].v[lane] = dot(contact.surface_velocity, t2);
  }
  side.restitution.v[lane] = contact.restitution;
  if (contact.restitution > 0) c.bounces = 1;
  if (!(contact.rolling_friction > 0)) return;
  BatchExtra& extra = use_extra(batch);
  c.rolls = 1;
  extra.rolling_arm.v[lane] = contact.rolling_friction;
  put(extra.rolling_impulse, share * contact.rolling_impulse);
}

void ContactGroup::fill_batch(const SolverInput& in, const ContactShared& shared, const Vec3& gravity,
                              std::uint32_t batch, BatchInput& input) {
  ContactBatch& c = batches_[batch];
  std::memset(static_cast<void*>(&c), 0, sizeof c);
  std::memset(static_cast<void*>(&input), 0, sizeof input);
  std::memset(static_cast<void*>(&sides_[batch]), 0, sizeof(BatchSide));
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t slot = lanes_[std::size_t(batch) * kLanes + static_cast<std::size_t>(lane)];
    if (slot == kNone) continue;
    FEDER_ASSERT(slot < in.contacts->slots.size());
    const Contact& contact = in.contacts->slots[slot];
    const std::uint32_t a = in.solver_index(contact.collider_a), b = in.solver_index(contact.collider_b);
    const bool moves_a = shared.masses[a].movable > 0, moves_b = shared.masses[b].movable > 0;
    c.index_a[lane] = a, c.index_b[lane] = b;
    const unsigned char bit = static_cast<unsigned char>(1u << lane);
    if (moves_a) c.writes_a |= bit;
    if (moves_b) c.writes_b |= bit;
    if (!moves_a || !moves_b) c.fixed |= bit;
    c.leak.v[lane] = 1 + kCrowd * std::max(std::max(shared.crowd[a], shared.crowd[b]) - 1, Real(0));
    fill_lane(contact, gravity, batch, lane, input);
  }
}

void ContactGroup::prepare(const SolverInput& in, const ContactShared& shared, const Vec3& gravity,
                           const ContactKernels& kernels, ContactPass pass) {
  BatchInput input;
  pass.input = &input;
  const std::uint32_t first = pass.first, last = pass.last;
  int color = 0;  // the next
  for (std::uint32_t batch = first; batch < last; ++batch) {
    if (batch + 1 < last)
      for (const std::uint32_t slot : lanes_of(batch + 1))
        if (slot != kNone) prefetch(in.contacts->slots[slot]);
    fill_batch(in, shared, gravity, batch, input);
    while (color < kColors && color_first_[color] <= batch) ++color;
    batches_[batch].last_of_color = batch < overflow_count_ || batch + 1 == color_first_[color];
    pass.first = batch, pass.last = batch + 1;
    kernels.prepare(pass);
  }
}

void ContactGroup::store_batch(Contacts& contacts, std::uint32_t batch) const {
  const ContactBatch& c = batches_[batch];
  const BatchSide& side = sides_[batch];
  const Real whole = static_cast<Real>(pieces());
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t slot = lanes_[std::size_t(batch) * kLanes + static_cast<std::size_t>(lane)];
    if (slot == kNone) continue;
    Contact& contact = contacts.slots[slot];
    FEDER_ASSERT(contact.collider_a != kNone && contact.point_count <= c.points);  // as it was filled
    for (int j = 0; j < contact.point_count; ++j) {
      ContactPoint& to = contact.points[j];
      to.normal_impulse = whole * c.point[j].impulse.v[lane];
      to.total_impulse = side.total[j].v[lane];
    }
    contact.tangent_impulse[0] = whole * c.tangent_impulse[0].v[lane];
    contact.tangent_impulse[1] = whole * c.tangent_impulse[1].v[lane];
    contact.twist_impulse = whole * c.twist_impulse.v[lane];
    contact.rolling_impulse = Vec3::Zero();
    if (!c.rolls) continue;
    const Lane8x3& rolling = extras_[batch].rolling_impulse;
    contact.rolling_impulse = whole * Vec3(rolling.x.v[lane], rolling.y.v[lane], rolling.z.v[lane]);
  }
}

void ContactGroup::store(Contacts& contacts, JobPool& jobs) const {
  jobs.for_blocks(batch_count_, kStoreGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      if (i + 1 < last)
        for (const std::uint32_t slot : lanes_of(i + 1))
          if (slot != kNone) prefetch(contacts.slots[slot]);
      store_batch(contacts, i);
    }
  });
}

ContactPass ContactGroup::pass() const {
  ContactPass p{};
  p.batches = batches_;
  p.sides = sides_;
  p.extras = extras_;
  p.strikes = strikes_;
  // beyond that, a pass waits for memory: processors do not see far enough ahead by themselves
  constexpr std::size_t kCached = 1'000'000;  // bytes
  p.fetched = batch_count_ * sizeof(ContactBatch) > kCached ? batch_count_ : 0;
  return p;
}

void ContactGroup::renew(const std::uint8_t* turned, const ContactKernels& kernels, ContactPass pass) {
  for (std::uint32_t i = 0; i < batch_count_; ++i) {
    const ContactBatch& c = batches_[i];
    unsigned any = 0;
    for (int lane = 0; lane < kLanes; ++lane) any |= turned[c.index_a[lane]] | turned[c.index_b[lane]];
    if (!any) continue;
    pass.first = i, pass.last = i + 1;
    kernels.renew(pass);
  }
}

bool ContactGroup::any_bounces() const {
  for (std::uint32_t i = 0; i < batch_count_; ++i)
    if (batches_[i].bounces) return true;
  return false;
}

bool ContactGroup::any_strikes(bool all) const {
  for (std::uint32_t i = 0; i < batch_count_; ++i)
    if ((all || batches_[i].bounces) && strikes_[i].acts) return true;
  return false;
}

void ContactGroup::run(void (*kernel)(const ContactPass&), ContactPass p, JobPool& jobs, Which which) {
  if (batch_count_ == 0) return;
  if (jobs.threads() == 1) {  // batches lie in the order of their colours: one thread does all in one go
    p.first = 0, p.last = color_first_[colors(which)];
    kernel(p);
    return;
  }
  const auto part = [&p, kernel](std::uint32_t first, std::uint32_t last, int) {
    ContactPass own = p;
    own.first = first, own.last = last;
    kernel(own);
  };
  jobs.run_stages({stages_, stages(part, stages_, which)});
}

}  // namespace feder
