// Contacts that carry many times what they join. A contact is a spring whose stiffness goes with the smaller mass and
// the square of the substep rate (rigid/solver.h), so a light body under a heavy one sinks in, by x = F / (m w^2).
// Islands in which one would sink by more than kHolds of a body's thickness do their substeps in 2^level pieces, as
// many as the weights on each other and the loads of the last step ask for, and the budget allows. What gives way all
// the same, by more than kSinks, says so once per world. Likewise where joints pull light bodies so that they would
// swing faster than a substep can follow. Islands with net points, or on joints to kinematic bodies, have one piece.
// Kept between steps: the level of each body. It falls only when less would do for kCalmSteps: each change under a load
// that swings would drive it. Weak spot: more pieces under a load that has sunk in already set its energy free.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <tuple>
#include <utility>

#include "rigid/impl.h"

namespace feder {
namespace {

constexpr Real kHolds = Real(0.01);         // of the thickness of the thinner body
constexpr Real kLooks = Real(0.001);        // what one weight sinks by, times ratio^2 - 1 of the masses: sum them
constexpr Real kSwings = Real(0.7);         // (h w)^2 of a link across a tension, with the pieces chosen
constexpr Real kLeastSwings = Real(3.5);    // below, one piece is enough but after a snap
constexpr Real kCalmSwings = Real(1.8);     // below, one piece is enough
constexpr Real kLeastHangs = Real(0.4);     // under the weight of the heaviest: with less, impacts alone do it
constexpr Real kSwingHangs = Real(1.1);     // likewise: with less, a swing alone does not
constexpr Real kEarth = Real(9.81);         // m/s^2: what swings in weightlessness counts as much
constexpr Real kSnaps = 5;                  // weights of tension: more is a snap, a swing has three
constexpr Real kSlack = Real(0.1);          // of the largest tension of the island
constexpr Real kLeastLink = Real(1e-6);     // m
constexpr int kCalmSteps = 30;              // a lower level must do for so long
constexpr Real kFalls = 1.5;                // and would hold so many times the loads: at its edge each bounce undoes it
constexpr int kHotSteps = 4;                // where weights ask for none, loads must do so for so long: impacts do not
constexpr std::uint64_t kMostExtra = 2048;  // pieces times contacts of a world beyond its substeps
constexpr int kTiers = 32;                  // of bodies on each other
constexpr std::uint64_t kLookSteps = 4;  // between two looks at a joint or an old contact of an island without pieces
constexpr std::uint64_t kLoadSteps = 8;  // between two looks for what gives way
constexpr Real kSinks = Real(0.05);      // of the thickness
constexpr Real kSqueezed = Real(0.1);    // of the thickness, at any moment
constexpr Real kOdd = 100;               // times the mass, from which that speaks
constexpr Real kShare = Real(0.25);      // of the depth, at least, must be the load's
constexpr Real kMostTimes = Real(3e4);   // its own weight
constexpr Real kParts = Real(0.95);      // between two looks: what overlaps less is parting

Real squared_pieces(int level) { return static_cast<Real>(std::uint64_t(1) << (2 * level)); }

Real thickness_of(Real core_depth) { return 2 * core_depth / kCoreDepth; }

Real depth_of(const Contact& contact) {
  Real depth = 0;
  for (int k = 0; k < contact.point_count; ++k) depth = std::max(depth, -contact.points[k].separation);
  return depth;
}

}  // namespace

// Who lies above in a contact, and who below; kNone where that is no body. With what part of the weight, and what a
// load needs of the contact: all later looks are at this.
Rigid::Impl::Pile Rigid::Impl::pile_of(const Contact& contact, const Vec3& gravity) const {
  const Real along = dot(contact.normal, gravity);
  const std::uint32_t a = colliders.body_of(contact.collider_a), b = colliders.body_of(contact.collider_b);
  Pile pile = along < 0 ? Pile{b, a, -along, 0, depth_of(contact)} : Pile{a, b, along, 0, depth_of(contact)};
  for (int k = 0; k < contact.point_count; ++k) pile.impulse += contact.points[k].normal_impulse;
  return pile;
}

// The thinner body of a contact and how far it would sink with one piece, over its thickness: under what the contact
// carried in the last step, or the weight of the upper body and of what that carries, which it may not have felt yet.
ContactLoad Rigid::Impl::load_of(const Pile& pile, Real rate, const StepContext& c) const {
  ContactLoad load;
  Real mass = kInfinity, heavy = 0;
  load.depth = pile.depth;
  Real weight = weight_of(pile);
  if (carried && bodies.moves(pile.upper)) weight += carried[pile.upper];
  const Real force = std::max(pile.impulse / c.h, weight);
  if (!(force > 0)) return load;
  for (const std::uint32_t i : {pile.upper, pile.lower}) {
    if (i == kNone || bodies.type[i] != BodyType::dynamic) continue;
    ++load.bodies;
    const Real thickness = thickness_of(core_depth[i]);
    if (bodies.mass[i] < mass) mass = bodies.mass[i], load.light = i;
    heavy = std::max(heavy, bodies.mass[i]);
    if (!(thickness < load.thickness)) continue;
    load.thickness = thickness, load.body = i;
  }
  if (load.body == kNone) return load;
  load.force = force;
  const Real gives = 1 / (mass * rate * rate * load.thickness);
  load.sinks = force * gives, load.by_weight = weight * gives, load.ratio = heavy / mass;
  load.pull = weight / mass;
  return load;
}

Real Rigid::Impl::weight_of(const Pile& pile) const {
  if (pile.upper == kNone || bodies.type[pile.upper] != BodyType::dynamic) return 0;
  return bodies.mass[pile.upper] * std::max(bodies.gravity_scale[pile.upper], Real(0)) * pile.gravity;
}

// (h w)^2 of a link under the weight of a mass.
Real Rigid::Impl::hangs_of(Real per_force, Real mass, const StepContext& c) const {
  return per_force * mass * std::max(length(c.gravity), kEarth);
}

// The square of the pieces that the tension of an island asks for. More than kSnaps weights of tension is a snap:
// pieces begin at once, and are kept while something is slack, which is taut again in an instant.
Real Rigid::Impl::need_of_joints(const IslandLoad& island, const StepContext& c) const {
  const Real hangs = hangs_of(island.per_force, island.mass, c);
  if (hangs < kLeastHangs) return 0;
  const bool slack = island.least < kSlack * island.most;
  const Real swings = std::max(island.swings, island.before > 0 && slack ? kSnaps * hangs : Real(0));
  if (island.open) return swings / kSwings;
  const Real swing = hangs < kSwingHangs ? kInfinity : kLeastSwings;
  const Real least = island.before > 0 ? kCalmSwings : std::max(std::min(kSnaps * hangs, swing), kCalmSwings);
  return swings > least ? swings / kSwings : Real(0);
}

// By body: how the tension of its joints makes it swing. A light body between two others swings across them with
// w^2 = 2 sum(F / l) / m, l the length of a link, and h w > 2 is unstable. Null: no island needs more than one piece.
const JointNeed* Rigid::Impl::joint_needs(StepContext& c) {
  JointNeed* need = c.scratch->take<JointNeed>(bodies.size());
  for (const std::uint32_t i : moving) need[i] = {};
  bool any = false;
  for (const std::uint32_t j : active_joints) {
    const JointRecord& r = records[j];
    const SolverJoint& joint = joints[j];
    if (!bodies.moves(r.body_a) || !bodies.moves(r.body_b)) continue;
    Real squares = 0;
    for (int k = 0; k < std::min<int>(joint.rows, 3); ++k) squares += joint.impulse[k] * joint.impulse[k];
    const JointShape& shape = joint.shape;  // not by the places now: what is torn open must not seem short
    const Real link =
        length(shape.frame_a.position) + length(shape.frame_b.position) + std::max(shape.options.rest_length, Real(0));
    if (!(link > kLeastLink)) continue;
    const Real force = std::sqrt(squares) / c.h;
    for (const std::uint32_t i : {r.body_a, r.body_b}) {
      const Real per_force = 2 * c.h * c.h * bodies.inv_mass[i] / link;
      need[i].per_force += per_force;
      need[i].swings += per_force * force;
      need[i].least = std::min(need[i].least, force), need[i].most = std::max(need[i].most, force);
      need[i].open = need[i].open || r.open_looks > 0;
      any = any || level[i] > 0 || need[i].swings > kCalmSwings;
    }
  }
  return any ? need : nullptr;
}

// What the active contacts of hard islands join, in their order, but of islands beyond the budget; counts these
// contacts, and all joints, by root.
std::span<const Rigid::Impl::Pile> Rigid::Impl::list_piles(IslandLoad* by_root, StepContext& c) {
  const auto drives = [&](std::uint32_t i) { return i != kNone && bodies.type[i] == BodyType::kinematic; };
  for (const std::uint32_t j : active_joints)
    for (const std::uint32_t i : {records[j].body_a, records[j].body_b}) {
      if (!bodies.moves(i)) continue;
      IslandLoad& island = by_root[islands.root(i)];
      if (drives(records[j].body_a) || drives(records[j].body_b)) island.apart = true;
      island.jointed = true;
      ++island.contacts;
    }
  Pile* list = c.scratch->take<Pile>(contacts.active.size());
  std::size_t count = 0;
  for (std::size_t n = 0; n < contacts.active.size(); ++n) {
    const ColliderPair pair = contacts.active_pairs[n];
    const std::uint32_t a = colliders.body_of(pair.a), b = colliders.body_of(pair.b), mover = bodies.moves(a) ? a : b;
    if (!bodies.moves(mover)) continue;
    IslandLoad& island = by_root[islands.root(mover)];
    if (!island.hard) continue;
    for (const std::uint32_t collider : {pair.a, pair.b})
      if (colliders.owner[collider] != ColliderOwner::body) island.apart = true;
    list[count++] = pile_of(contacts.slots[contacts.active[n]], c.gravity);
    ++island.contacts;
  }
  const auto end = std::remove_if(list, list + count, [&](const Pile& pile) {
    return by_root[islands.root(bodies.moves(pile.upper) ? pile.upper : pile.lower)].contacts > kMostExtra;
  });
  return {list, end};
}

// By body: the weight that lies on it, N, when each body shares its own and what it carries out evenly.
void Rigid::Impl::carried_weights(std::span<const Pile> piles, Real* out, StepContext& c) {
  Real* sum = out;
  Real* next = c.scratch->take<Real>(bodies.size());
  Real* supports = c.scratch->take<Real>(bodies.size());
  for (const std::uint32_t i : moving) sum[i] = next[i] = supports[i] = 0;
  for (const Pile& pile : piles)
    if (bodies.moves(pile.upper)) supports[pile.upper] += 1;
  struct Stacked {
    std::uint32_t upper, lower;
    Real weight, supports;  // of the upper one
  };
  Stacked* stacked = c.scratch->take<Stacked>(piles.size());
  std::size_t count = 0;
  for (const Pile& pile : piles)
    if (bodies.moves(pile.upper) && bodies.moves(pile.lower))
      stacked[count++] = {pile.upper, pile.lower, weight_of(pile), supports[pile.upper]};
  const std::span<const Stacked> all(stacked, count);
  bool changes = true;
  for (int tier = 0; changes && tier < kTiers; ++tier) {
    for (const Stacked& s : all) next[s.lower] = 0;
    for (const Stacked& s : all) next[s.lower] += (s.weight + sum[s.upper]) / s.supports;
    changes = false;
    for (const Stacked& s : all) changes = changes || next[s.lower] != sum[s.lower];
    std::swap(sum, next);
  }
  if (sum != out)
    for (const std::uint32_t i : moving) out[i] = sum[i];
}

// By body that moves: its contacts, each by how much of it this body, as the lighter one, is.
const Real* Rigid::Impl::crowds(std::span<const Pile> piles, StepContext& c) {
  Real* crowd = c.scratch->take<Real>(bodies.size());
  for (const std::uint32_t i : moving) crowd[i] = 0;
  for (const Pile& pile : piles) {
    const bool upper = bodies.moves(pile.upper), lower = bodies.moves(pile.lower);
    const Real wu = upper ? 1 / bodies.mass[pile.upper] : 0, wl = lower ? 1 / bodies.mass[pile.lower] : 0;
    if (upper) crowd[pile.upper] += wu / (wu + wl);
    if (lower) crowd[pile.lower] += wl / (wu + wl);
  }
  return crowd;
}

// Bodies whose contacts may need more pieces: of islands that have some, or soon may, all contacts are asked, of others
// some and the new ones.
std::span<const std::uint32_t> Rigid::Impl::list_hard(Real rate, StepContext& c) {
  constexpr JobGrain kGrain{256, 10'000};  // contacts
  constexpr std::uint32_t kAhead = 8;      // contacts, asked for before they are read
  const auto count = static_cast<std::uint32_t>(contacts.active.size());
  std::uint32_t* hard = c.scratch->take<std::uint32_t>(count);
  std::uint32_t* in_block = c.scratch->take<std::uint32_t>(count / kGrain.items + 1);
  ContactLoad* squeezed = c.scratch->take<ContactLoad>(count / kGrain.items + 1);
  const auto hot = [&](std::uint32_t collider) {
    const std::uint32_t i = colliders.body_of(collider);
    return i != kNone && (level[i] > 0 || level_trend[i] != 0);
  };
  c.jobs->for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    std::uint32_t end = first;
    ContactLoad& most = squeezed[first / kGrain.items] = {};
    for (std::uint32_t n = first; n < last; ++n) {
      if (n + kAhead < last) __builtin_prefetch(&contacts.slots[contacts.active[n + kAhead]]);
      const std::uint32_t slot = contacts.active[n];
      const Contact& contact = contacts.slots[slot];
      const bool carried_nothing = contact.points[0].normal_impulse == 0;  // new, perhaps
      if (!carried_nothing && (slot + c.step) % kLookSteps != 0 && !hot(contact.collider_a) && !hot(contact.collider_b))
        continue;
      const ContactLoad load = load_of(pile_of(contact, c.gravity), rate, c);
      if (load.body == kNone || !bodies.moves(load.body)) continue;
      const bool deep = load.ratio > kOdd && load.depth > kSqueezed * load.thickness;
      if (deep && load.bodies == 2 && load.ratio > most.ratio) most = load;
      if (load.sinks > kHolds || (load.ratio * load.ratio - 1) * load.by_weight > kLooks) hard[end++] = load.body;
    }
    in_block[first / kGrain.items] = end - first;
  });
  std::uint32_t end = 0;
  for (std::uint32_t first = 0; first < count; first += kGrain.items) {
    const std::uint32_t found = in_block[first / kGrain.items];
    std::copy(hard + first, hard + first + found, hard + end);
    end += found;
    if (const ContactLoad& load = squeezed[first / kGrain.items]; load.body != kNone) warn_squeezed(load, c);
  }
  return {hard, end};
}

// Levels of the islands: for the weights at once, for impulses one by one.
void Rigid::Impl::choose_levels(StepContext& c) {
  levels.clear();
  carried = nullptr;
  const ContactSpring spring = solver->contact_spring(c.h);
  if (!(spring.rate > 0)) return;
  bool any = false;  // island that has pieces, or may soon
  for (const std::uint32_t i : moving) any = any || level[i] > 0 || level_trend[i] != 0;
  const std::span<const std::uint32_t> hard = list_hard(spring.rate, c);
  const JointNeed* by_joints = active_joints.empty() || (!any && c.step % kLookSteps != 0) ? nullptr : joint_needs(c);
  if (!any && hard.empty() && !by_joints) return;
  join_islands();
  Real* weights = c.scratch->take<Real>(bodies.size());
  const Scratch::Frame frame(*c.scratch);
  IslandLoad* by_root = c.scratch->take<IslandLoad>(bodies.size());
  for (const std::uint32_t i : moving) by_root[i] = {};
  for (const std::uint32_t i : hard) by_root[islands.root(i)].hard = true;
  for (const std::uint32_t i : moving) {
    IslandLoad& island = by_root[islands.root(i)];
    island.hard = island.hard || level[i] > 0;
    island.before = std::max(island.before, level[i]);
    island.trend = std::max(island.trend, level_trend[i]);
    if (!by_joints) continue;
    island.swings = std::max(island.swings, by_joints[i].swings);
    island.per_force = std::max(island.per_force, by_joints[i].per_force);
    island.least = std::min(island.least, by_joints[i].least), island.most = std::max(island.most, by_joints[i].most);
    island.open = island.open || by_joints[i].open;
    if (by_joints[i].per_force > 0) island.mass = std::max(island.mass, bodies.mass[i]);
  }
  const std::span<const Pile> piles = list_piles(by_root, c);
  carried_weights(piles, weights, c);
  carried = weights;
  const Real* crowd = crowds(piles, c);
  for (const Pile& pile : piles) {
    const ContactLoad load = load_of(pile, spring.rate, c);
    if (load.body == kNone) continue;
    IslandLoad& island = by_root[islands.root(bodies.moves(pile.upper) ? pile.upper : pile.lower)];
    const Real crowding = bodies.moves(load.body) ? crowd[load.body] : Real(0);  // else it is about to wake
    const Real crowded = (1 + spring.crowd * std::max(crowding - 1, Real(0))) / kHolds;
    if (island.jointed) continue;  // ragdolls in a pile flew apart with pieces by contacts
    island.by_weight = std::max(island.by_weight, load.by_weight * crowded);
    island.by_impulse = std::max(island.by_impulse, load.sinks * crowded);
  }
  share_out(by_root, c);
}

// Levels by need, the neediest first, while the budget lasts.
void Rigid::Impl::share_out(IslandLoad* by_root, StepContext& c) {
  const auto level_for = [](Real need) {
    int wanted = 0;
    while (wanted + 1 < kLevels && squared_pieces(wanted) < need) ++wanted;
    return wanted;
  };
  std::uint32_t* order = c.scratch->take<std::uint32_t>(moving.size());
  std::size_t count = 0;
  for (const std::uint32_t i : moving) {
    if (islands.root(i) != i) continue;
    IslandLoad& island = by_root[i];
    const int before = island.before;
    island.by_joints = need_of_joints(island, c);
    const int by_joints = level_for(island.by_joints);
    const bool lasts = before > 0 || island.open || hangs_of(island.per_force, island.mass, c) >= kSwingHangs;
    const int by_weight = std::max(level_for(island.by_weight), lasts ? by_joints : 0);
    const int by_impulse = std::max(level_for(island.by_impulse), by_joints);
    if (island.apart || island.contacts > kMostExtra) {
      island.wanted = island.trend = 0;
      continue;
    }
    island.wanted = std::max(by_weight, before);
    const int by_load = level_for(kFalls * std::max(island.by_weight, island.by_impulse));
    const bool calm = std::max({by_load, by_weight, by_impulse}) < before;
    if (by_impulse > island.wanted)
      island.trend = static_cast<std::int8_t>(std::max<int>(island.trend, 0) + 1);
    else
      island.trend = static_cast<std::int8_t>(calm ? std::min<int>(island.trend, 0) - 1 : 0);
    if (island.trend > (by_weight > 0 ? 0 : kHotSteps)) island.trend = 0, ++island.wanted;
    if (island.trend < -kCalmSteps) island.trend = 0, --island.wanted;
    if (island.wanted > 0) order[count++] = i;
  }
  const auto need = [&](std::uint32_t i) {
    return std::max({by_root[i].by_weight, by_root[i].by_impulse, by_root[i].by_joints});
  };
  std::sort(order, order + count, [&](std::uint32_t a, std::uint32_t b) {
    return std::make_tuple(-by_root[a].wanted, -need(a), a) < std::make_tuple(-by_root[b].wanted, -need(b), b);
  });
  std::uint64_t left = kMostExtra;
  for (std::size_t n = 0; n < count; ++n) {
    IslandLoad& island = by_root[order[n]];
    const auto extra = [&](int k) { return island.contacts * ((std::uint64_t(1) << k) - 1); };
    while (island.wanted > 0 && extra(island.wanted) > left) --island.wanted;
    left -= extra(island.wanted);
  }
  if (count > 0) levels.assign(solver_bodies.state.size(), 0);
  for (std::uint32_t p = 0; p < moving.size(); ++p) {
    const std::uint32_t i = moving[p];
    const IslandLoad& island = by_root[islands.root(i)];
    level[i] = static_cast<std::uint8_t>(island.wanted);
    level_trend[i] = island.trend;
    if (level[i] > 0) levels[p + 1] = level[i];
  }
}

// An impact of a body so much heavier that its contact hardly sees what holds the light one from behind.
void Rigid::Impl::warn_squeezed(const ContactLoad& load, StepContext& c) {
  if (load_warned) return;
  load_warned = true;
  char text[200];
  std::snprintf(text, sizeof text,
                " gives way by %.2g %% of its thickness to a body of %.0f times its mass: more substeps than %d, or "
                "masses that differ less, would hold it",
                static_cast<double>(100 * load.depth / load.thickness), static_cast<double>(load.ratio), c.substeps);
  events.warn("overload", objects.describe(bodies.object[load.light]) + text, bodies.object[load.light]);
}

// Bodies in an impact, or made inside each other, part again: the same one must be found twice, overlapping no less,
// and its load must explain that, by the give of its contacts or by weights beyond what any number of pieces holds.
void Rigid::Impl::check_loads(StepContext& c) {
  if (c.step % kLoadSteps != 0 || load_warned) return;
  const ContactSpring spring = solver->contact_spring(c.h);
  if (!(spring.rate > 0)) return;
  ContactLoad worst;
  Real most = kSinks;
  const Real too_much = kMostTimes * c.gravity.norm();
  for (const std::uint32_t slot : contacts.active) {
    const Contact& contact = contacts.slots[slot];
    Real thinner = kInfinity;  // bodies that do not move have no depth
    for (const std::uint32_t collider : {contact.collider_a, contact.collider_b})
      if (const std::uint32_t i = colliders.body_of(collider); bodies.moves(i))
        thinner = std::min(thinner, thickness_of(core_depth[i]));
    if (depth_of(contact) <= most * thinner) continue;
    const ContactLoad load = load_of(pile_of(contact, c.gravity), spring.rate, c);
    if (load.bodies < 2 || load.depth <= most * load.thickness) continue;
    const Real share = load.depth / load.thickness;
    if (load.sinks < kShare * share * squared_pieces(level[load.body]) && load.pull <= too_much) continue;
    worst = load, most = share;
  }
  const ContactLoad before = std::exchange(gives_way, worst);
  if (worst.body == kNone || worst.body != before.body || worst.depth < kParts * before.depth) return;
  load_warned = true;
  char text[200];
  std::snprintf(
      text, sizeof text,
      " gives way by %.2g %% of its thickness under %.3g N: more substeps than %d, or masses that differ less, "
      "would hold it",
      static_cast<double>(100 * most), static_cast<double>(worst.force), c.substeps);
  events.warn("overload", objects.describe(bodies.object[worst.body]) + text, bodies.object[worst.body]);
}

}  // namespace feder
