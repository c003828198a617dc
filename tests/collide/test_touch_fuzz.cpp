// Random histories of everything a script can do to colliders: begins and ends alternate, agree with the geometry,
// and neither events nor state depend on the number of threads.
#include <map>
#include <string>

#include "broad/broad_phase.h"
#include "collide/fake_owner.h"
#include "narrow/narrow_phase.h"
#include "support/catch.h"

using namespace feder;

namespace {

ShapePtr random_shape(Rng& rng) {
  if (below(rng, 2)) return make_sphere(rng.uniform(Real(0.2), Real(0.7)));
  return make_box(rng.uniform(Real(0.3), 1), rng.uniform(Real(0.3), 1), rng.uniform(Real(0.3), 1));
}

Pose random_pose(Rng& rng) {
  return {random_point(rng, Real(1.6)), from_axis_angle(random_point(rng, 1), rng.uniform(0, 6))};
}

void random_body(Rng& rng, FakeWorld& w) {
  const std::uint32_t kind = below(rng, 8);
  const ColliderMotion motion = kind == 0   ? ColliderMotion::fixed
                                : kind == 1 ? ColliderMotion::kinematic
                                            : ColliderMotion::dynamic;
  std::vector<CompoundPart> parts{{random_shape(rng), {}}};
  while (below(rng, 3) == 0) parts.push_back({random_shape(rng), {random_point(rng, Real(0.6)), {}}});
  const std::uint32_t b = w.add(parts, random_pose(rng), motion);
  if (below(rng, 6) == 0) w.each(b, [&](std::uint32_t k) { w.c().sensor[k] = 1; });
}

// One random thing a script or an owner does.
void random_edit(Rng& rng, FakeWorld& w, std::vector<std::pair<ObjectId, ObjectId>>& excluded) {
  if (w.bodies.size() < 6) return random_body(rng, w);
  const std::uint32_t b = below(rng, static_cast<std::uint32_t>(w.bodies.size()));
  FakeBody& body = w.bodies[b];
  Colliders& c = w.c();
  switch (below(rng, 12)) {
    case 0:
      if (w.bodies.size() < 24) random_body(rng, w);
      break;
    case 1: w.remove(b); break;
    case 2: w.changed(b), body.pose = random_pose(rng), w.place(b); break;
    case 3: {
      const std::uint32_t mask = below(rng, 4) ? 0xffffffffu : 2;
      w.changed(b), w.each(b, [&](std::uint32_t k) { c.mask[k] = mask; });
      break;
    }
    case 4: w.changed(b), w.each(b, [&](std::uint32_t k) { c.sensor[k] ^= 1; }); break;
    case 5: {
      const auto motion = static_cast<ColliderMotion>(1 + below(rng, 3));
      w.changed(b);
      w.each(b, [&](std::uint32_t k) { c.motion[k] = motion, c.set_awake(k, motion == ColliderMotion::dynamic); });
      break;
    }
    case 6:
    case 7:
      if (c.motion[body.colliders[0]] == ColliderMotion::dynamic)
        w.each(b, [&](std::uint32_t k) { c.set_awake(k, !c.awake[k]); });
      break;
    case 8: {
      if (excluded.size() > 4) break;
      const ObjectId other = w.bodies[below(rng, static_cast<std::uint32_t>(w.bodies.size()))].object;
      if (other != body.object) w.collide->exclude(body.object, other), excluded.push_back({other, body.object});
      break;
    }
    case 9:
      if (!excluded.empty()) w.collide->include(excluded.back().first, excluded.back().second), excluded.pop_back();
      break;
    default: break;
  }
}

// The owner's integration: what is awake moves, mostly a little.
void drift(Rng& rng, FakeWorld& w) {
  for (FakeBody& body : w.bodies) {
    Colliders& c = w.c();
    const bool kinematic = c.motion[body.colliders[0]] == ColliderMotion::kinematic;
    if (!c.awake[body.colliders[0]] && !kinematic) continue;
    const Real s = below(rng, 3) ? Real(0.002) : Real(0.1);
    body.pose.position = body.pose.position * Real(0.995) + random_point(rng, s);
    body.pose.rotation = integrate_rotation(body.pose.rotation, random_point(rng, s));
    if (!kinematic) continue;
    for (const std::uint32_t k : body.colliders) c.set_awake(k, true);
  }
}

using PairOfObjects = std::pair<ObjectId, ObjectId>;

// Reads the events of a step; false when one does not pair.
struct Ledger {
  std::set<PairOfObjects> touching, inside;
  std::size_t begins = 0, ends = 0, stays = 0;
  bool paired = true;

  void read(const FakeWorld& w) {
    for (const Event& e : w.events.list()) {
      const PairOfObjects p{e.a, e.b};
      if (e.kind == EventKind::contact_begin) paired = paired && touching.insert(p).second, ++begins;
      if (e.kind == EventKind::contact_end) paired = paired && touching.erase(p) == 1, ++ends;
      if (e.kind == EventKind::contact_stay) paired = paired && touching.count(p), ++stays;
      if (e.kind == EventKind::hit) paired = paired && touching.count(p);
      if (e.kind == EventKind::sensor_enter) paired = paired && inside.insert(p).second;
      if (e.kind == EventKind::sensor_leave) paired = paired && inside.erase(p) == 1;
    }
  }
};

bool may_touch(FakeWorld& w, std::uint32_t i, std::uint32_t j, const std::vector<PairOfObjects>& excluded) {
  Colliders& c = w.c();
  if (!(c.group[i] & c.mask[j]) || !(c.group[j] & c.mask[i]) || (c.sensor[i] && c.sensor[j])) return false;
  for (const auto& [x, y] : excluded)
    if ((x == c.object[i] && y == c.object[j]) || (y == c.object[i] && x == c.object[j])) return false;
  return c.sensor[i] || c.sensor[j] || c.motion[i] == ColliderMotion::dynamic || c.motion[j] == ColliderMotion::dynamic;
}

// Which pairs of objects certainly touch, and which certainly do not, by testing every collider against every other.
void compare(FakeWorld& w, const Ledger& ledger, const std::vector<PairOfObjects>& excluded, std::string& problem) {
  std::map<PairOfObjects, Real> gap, sensed;
  Colliders& c = w.c();
  for (const FakeBody& x : w.bodies) {
    for (const FakeBody& y : w.bodies) {
      if (x.object == y.object) continue;
      for (const std::uint32_t i : x.colliders) {
        for (const std::uint32_t j : y.colliders) {
          if (!may_touch(w, i, j, excluded)) continue;
          PairCache cache;
          Manifold found[kMaxManifolds];
          Real least = 1;
          const int n =
              w.collide->narrow().collide(*c.shape[i], c.pose[i], *c.shape[j], c.pose[j], Real(0.02), cache, found);
          for (int m = 0; m < n; ++m)
            for (int k = 0; k < found[m].count; ++k) least = std::min(least, found[m].points[k].separation);
          auto& table = c.sensor[i] || c.sensor[j] ? sensed : gap;
          if (&table == &sensed && !c.sensor[i]) continue;
          if (&table == &gap && y.object < x.object) continue;
          const auto [it, fresh] = table.try_emplace({x.object, y.object}, least);
          it->second = std::min(it->second, least);
        }
      }
    }
  }
  // 2.5 mm: the largest motion that recycling ignores; 2 mm: where a touching ends
  const auto expect = [&](bool right, const char* what, const PairOfObjects& p, Real distance) {
    if (!right && problem.empty())
      problem = std::string(what) + " " + std::to_string(p.first.slot) + " " + std::to_string(p.second.slot) + " at " +
                std::to_string(distance) + " m, step " + std::to_string(w.context.step);
  };
  for (const auto& [pair, distance] : gap) {
    const bool touching = ledger.touching.count(pair);
    if (distance < Real(-0.003)) expect(touching, "missing touch", pair, distance);
    if (distance > Real(0.005)) expect(!touching, "extra touch", pair, distance);
  }
  for (const PairOfObjects& p : ledger.touching) expect(gap.count(p), "filtered touch", p, 0);
  for (const auto& [pair, distance] : sensed) {
    const bool inside = ledger.inside.count(pair);
    if (distance < Real(-1e-4)) expect(inside, "missing sensing", pair, distance);
    if (distance > Real(1e-4)) expect(!inside, "extra sensing", pair, distance);
  }
  for (const PairOfObjects& p : ledger.inside) expect(sensed.count(p), "filtered sensing", p, 0);
}

struct Outcome {
  std::uint64_t hash = 0;
  Ledger ledger;
  std::string problem;
};

Outcome history(int threads, const char* broad_phase, int edits, bool check, std::uint64_t seed = 2024) {
  FakeWorld w(threads, broad_phase);
  w.touch_all = false;
  Rng rng(seed);
  Outcome out;
  Hash h;
  std::vector<PairOfObjects> excluded;
  for (int i = 0; i < 16; ++i) random_body(rng, w);
  for (int i = 0; i < edits; ++i) {
    random_edit(rng, w, excluded);
    if (below(rng, 3) == 0) continue;  // several edits between steps
    if (below(rng, 4)) drift(rng, w);
    w.step();
    out.ledger.read(w);
    if (check && i % 4 == 0) compare(w, out.ledger, excluded, out.problem);
    for (const Event& e : w.events.list())
      h.bytes(e.kind.text(), std::string_view(e.kind.text()).size()), h.add(e.a.slot), h.add(e.b.slot), h.add(e.point),
          h.add(e.normal), h.add(e.impulse), h.add(e.slip);
    w.collide->hash(h);
    if (!out.ledger.paired || !out.problem.empty()) break;
  }
  // nothing stays open when everything is gone
  while (!w.bodies.empty()) w.remove(0);
  w.step();
  out.ledger.read(w);
  out.hash = h.value();
  return out;
}

}  // namespace

TEST_CASE("begins and ends pair over random histories", "[collide][fuzz]") {
  const std::uint64_t seed = GENERATE(1u, 2u, 3u, 4u, 5u);
  CAPTURE(seed);
  const Outcome out = history(1, nullptr, 10000, true, seed);
  CHECK(out.ledger.paired);
  CHECK(out.problem == "");
  CHECK(out.ledger.touching.empty());
  CHECK(out.ledger.inside.empty());
  CHECK(out.ledger.begins > 1000);
  CHECK(out.ledger.begins == out.ledger.ends);
  CHECK(out.ledger.stays > 1000);
}

TEST_CASE("events and contacts do not depend on threads or on the broad phase", "[collide][fuzz][threads]") {
  const std::uint64_t one = history(1, nullptr, 1500, false).hash;
  CHECK(history(2, nullptr, 1500, false).hash == one);
  CHECK(history(4, nullptr, 1500, false).hash == one);
  for (const auto& row : broad_phases()) CHECK(history(1, row.name, 1500, false).hash == one);
}
