// Every registered broad phase against the all-pairs oracle of this file. A new variant is enrolled by its line alone.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/rng.h"
#include "bounds/segment_box.h"
#include "broad/broad_phase.h"
#include "feder/params.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Scene {
  std::vector<Aabb> boxes;
  std::vector<BoxMotion> motion;
};

std::vector<IndexPair> oracle(const Scene& s) {
  std::vector<IndexPair> pairs;
  for (std::uint32_t a = 0; a < s.boxes.size(); ++a)
    for (std::uint32_t b = a + 1; b < s.boxes.size(); ++b) {
      if (s.motion[a] == BoxMotion::absent || s.motion[b] == BoxMotion::absent) continue;
      if (s.motion[a] == BoxMotion::still && s.motion[b] == BoxMotion::still) continue;
      if (overlaps(s.boxes[a], s.boxes[b])) pairs.push_back({a, b});
    }
  return pairs;
}

Real uniform(Rng& rng, double lo, double hi) { return static_cast<Real>(lo + (hi - lo) * rng.unit()); }

std::uint32_t below(Rng& rng, std::uint32_t n) { return static_cast<std::uint32_t>(rng.unit() * n); }

Aabb random_box(Rng& rng, const char* layout) {
  const std::string_view kind = layout;
  Vec3 center, half;
  const Real size = static_cast<Real>(5 * std::pow(10.0, kind == "ratio" ? -9 * rng.unit() * rng.unit() : 0));
  for (int k = 0; k < 3; ++k) {
    center[k] = uniform(rng, -10, 10), half[k] = uniform(rng, 0.1, 1);
    if (kind == "clustered") center[k] = uniform(rng, -1, 1) * uniform(rng, 0, 1) * uniform(rng, 0, 3);
    if (kind == "grid") center[k] = Real(below(rng, 6)), half[k] = Real(0.5);  // touching faces, equal boxes
    if (kind == "mixed") half[k] = below(rng, 8) == 0 ? uniform(rng, 5, 50) : uniform(rng, 1e-6, 1e-3);
    if (kind == "flat") half[k] = k == 1 ? 0 : half[k], center[k] = k == 1 ? Real(below(rng, 3)) : center[k];
    if (kind == "identical") center[k] = 1, half[k] = 2;
    if (kind == "ratio") half[k] = size;
    if (kind == "far") center[k] = center[k] / 2 + Real(1e6);
  }
  Aabb box{center - half, center + half};
  if (kind == "unbounded" && below(rng, 10) == 0) {
    const int k = static_cast<int>(below(rng, 3));
    box = Aabb::everything();
    if (below(rng, 2)) box.hi[k] = uniform(rng, -5, 5);
  }
  if (kind == "broken" && below(rng, 5) == 0) {
    box = Aabb();
    const Real nan = std::numeric_limits<Real>::quiet_NaN();
    if (below(rng, 2)) box = {center - half, Vec3(center[0], nan, center[2])};
    if (below(rng, 3) == 0) box = {Vec3::Constant(nan), Vec3::Constant(nan)};
  }
  return box;
}

BoxMotion random_motion(Rng& rng) {
  const std::uint32_t r = static_cast<std::uint32_t>(below(rng, 8));
  return r == 0 ? BoxMotion::absent : r < 3 ? BoxMotion::still : BoxMotion::moving;
}

Scene random_scene(Rng& rng, const char* layout, std::uint32_t count) {
  Scene s;
  for (std::uint32_t i = 0; i < count; ++i) {
    s.boxes.push_back(random_box(rng, layout));
    s.motion.push_back(random_motion(rng));
  }
  return s;
}

// One step of a random history: most boxes drift, a few jump, change motion, or come and go.
void disturb(Rng& rng, const char* layout, Scene& s, double drift) {
  for (std::size_t i = 0; i < s.boxes.size(); ++i) {
    if (s.motion[i] == BoxMotion::moving) {
      const Vec3 d(uniform(rng, -drift, drift), uniform(rng, -drift, drift), uniform(rng, -drift, drift));
      s.boxes[i].lo += d, s.boxes[i].hi += d;
    }
    if (below(rng, 30) == 0) s.boxes[i] = random_box(rng, layout);
    if (below(rng, 15) == 0) s.motion[i] = random_motion(rng);
  }
  if (below(rng, 5) == 0) {
    const std::size_t count = s.boxes.size() / 2 + below(rng, static_cast<std::uint32_t>(s.boxes.size() + 2));
    while (s.boxes.size() > count) s.boxes.pop_back(), s.motion.pop_back();
    while (s.boxes.size() < count) s.boxes.push_back(random_box(rng, layout)), s.motion.push_back(random_motion(rng));
  }
}

// Indices of the boxes that differ from those of the call before, and of all that move.
std::vector<std::uint32_t> touched_since(const Scene& before, const Scene& s) {
  std::vector<std::uint32_t> list;
  for (std::uint32_t i = 0; i < s.boxes.size(); ++i) {
    const bool same = i < before.boxes.size() && before.motion[i] == s.motion[i] &&
                      before.boxes[i].lo == s.boxes[i].lo && before.boxes[i].hi == s.boxes[i].hi;
    if (!same || s.motion[i] == BoxMotion::moving) list.push_back(i);
  }
  return list;
}
std::vector<std::uint32_t> all_of(const Scene& s) { return touched_since({}, s); }

struct Fixture {
  explicit Fixture(int threads = 1) : jobs(threads) {}
  Arena arena{"broad"};
  Params params;
  JobPool jobs;
  Array<IndexPair> pairs{&arena};
  Array<std::uint32_t> found{&arena};
};

std::vector<IndexPair> list(const Array<IndexPair>& a) { return {a.begin(), a.end()}; }
std::vector<std::uint32_t> list(const Array<std::uint32_t>& a) { return {a.begin(), a.end()}; }

const char* const kLayouts[] = {"spread",    "clustered", "grid",      "mixed", "flat",
                                "identical", "far",       "unbounded", "ratio", "broken"};

}  // namespace

TEST_CASE("broad phase finds exactly the overlapping pairs, sorted", "[broad][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(broad_phases().size())));
  const std::uint32_t count = GENERATE(0u, 1u, 2u, 257u);
  const char* layout = kLayouts[GENERATE(range(0, 10))];
  const auto& variant = broad_phases()[static_cast<std::size_t>(index)];
  CAPTURE(variant.name, count, layout);
  Fixture f;
  Rng rng(7);
  const auto broad = variant.make(f.arena, f.params);
  const Scene s = random_scene(rng, layout, count);
  f.pairs.push_back({3, 4});  // replaced, not kept
  broad->find_pairs(s.boxes, s.motion, all_of(s), f.pairs, f.jobs);
  REQUIRE(list(f.pairs) == oracle(s));
}

TEST_CASE("broad phase stays exact over a long history", "[broad][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(broad_phases().size())));
  const char* layout = kLayouts[GENERATE(range(0, 10))];
  const double drift = GENERATE(0.0, 0.02, 2.0);
  const auto& variant = broad_phases()[static_cast<std::size_t>(index)];
  CAPTURE(variant.name, layout, drift);
  Fixture f;
  Rng rng(11);
  const auto broad = variant.make(f.arena, f.params);
  Scene s = random_scene(rng, layout, 90);
  bool equal = true, fresh_equal = true;
  Scene last;
  for (int call = 0; call < 120 && equal; ++call) {
    CAPTURE(call);
    broad->find_pairs(s.boxes, s.motion, touched_since(last, s), f.pairs, f.jobs);
    last = s;
    equal = list(f.pairs) == oracle(s);
    REQUIRE(equal);
    if (call % 40 == 39) {
      // a newcomer without that history gives the same
      const auto other = variant.make(f.arena, f.params);
      Array<IndexPair> again(&f.arena);
      other->find_pairs(s.boxes, s.motion, all_of(s), again, f.jobs);
      fresh_equal = fresh_equal && list(again) == list(f.pairs);
    }
    disturb(rng, layout, s, drift);
  }
  REQUIRE(fresh_equal);
}

// A drum: all go on, and boxes that were neighbours part, for longer than between two builds of a tree.
TEST_CASE("broad phase stays exact where all boxes move, on several threads", "[broad][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(broad_phases().size())));
  const int threads = GENERATE(1, 3);
  const auto& variant = broad_phases()[static_cast<std::size_t>(index)];
  CAPTURE(variant.name, threads);
  Fixture f(threads);
  Rng rng(29);
  const auto broad = variant.make(f.arena, f.params);
  Scene s = random_scene(rng, "spread", 1200);
  std::fill(s.motion.begin(), s.motion.end(), BoxMotion::moving);
  for (Aabb& b : s.boxes) {
    const Vec3 at(uniform(rng, -5, 5), uniform(rng, -5, 5), uniform(rng, -5, 5));
    b = {at - Vec3::Constant(Real(0.4)), at + Vec3::Constant(Real(0.4))};
  }
  Scene last;
  for (int call = 0; call < 40; ++call) {
    CAPTURE(call);
    broad->find_pairs(s.boxes, s.motion, touched_since(last, s), f.pairs, f.jobs);
    REQUIRE(list(f.pairs) == oracle(s));
    last = s;
    for (Aabb& b : s.boxes) {
      const Vec3 at = (b.lo + b.hi) * Real(0.5), rate(uniform(rng, 0, 0.2), 0, Real(0.05) * at[0]);
      const Vec3 step = cross(rate, at);
      b.lo += step, b.hi += step;
    }
  }
}

TEST_CASE("broad phase queries equal a linear scan", "[broad][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(broad_phases().size())));
  const char* layout = kLayouts[GENERATE(range(0, 10))];
  const auto& variant = broad_phases()[static_cast<std::size_t>(index)];
  CAPTURE(variant.name, layout);
  Fixture f;
  Rng rng(13);
  const auto broad = variant.make(f.arena, f.params);
  Scene s = random_scene(rng, layout, 150);
  std::size_t hits = 0;
  for (int call = 0; call < 60; ++call) {
    broad->find_pairs(s.boxes, s.motion, all_of(s), f.pairs, f.jobs);
    const Aabb box = random_box(rng, layout);
    const Vec3 origin = random_box(rng, layout).lo, end = random_box(rng, layout).hi;
    Vec3 ray = end - origin;
    if (call % 3 == 0) ray[call % 2] = 0;
    if (call % 20 == 0) ray = Vec3::Zero();
    if (!is_finite(ray) || !is_finite(origin)) continue;
    std::vector<std::uint32_t> in_box, on_ray;
    for (std::uint32_t i = 0; i < s.boxes.size(); ++i) {
      if (s.motion[i] == BoxMotion::absent) continue;
      if (overlaps(s.boxes[i], box)) in_box.push_back(i);
      if (segment_hits(s.boxes[i], origin, ray)) on_ray.push_back(i);
    }
    broad->query(box, f.found);
    REQUIRE(list(f.found) == in_box);
    broad->query_ray(origin, ray, f.found);
    // what is not a number may be reported or not
    const auto broken = [&](std::uint32_t i) { return !(s.boxes[i].lo[1] <= s.boxes[i].hi[1]); };
    std::erase_if(on_ray, broken), std::erase_if(f.found, broken);
    REQUIRE(list(f.found) == on_ray);
    hits += in_box.size() + on_ray.size();
    disturb(rng, layout, s, 0.1);
  }
  REQUIRE(hits > 0);
}

TEST_CASE("broad phase does not allocate after warm-up", "[broad][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(broad_phases().size())));
  const auto& variant = broad_phases()[static_cast<std::size_t>(index)];
  CAPTURE(variant.name);
  Fixture f;
  Rng rng(17);
  const auto broad = variant.make(f.arena, f.params);
  Scene s = random_scene(rng, "spread", 300);
  std::fill(s.motion.begin(), s.motion.end(), BoxMotion::moving);
  // the busiest call first: everything overlaps everything
  const std::vector<Aabb> spread = s.boxes;
  for (Aabb& b : s.boxes) b = {Vec3::Constant(-1), Vec3::Constant(1)};
  broad->find_pairs(s.boxes, s.motion, all_of(s), f.pairs, f.jobs);
  s.boxes = spread;
  broad->find_pairs(s.boxes, s.motion, all_of(s), f.pairs, f.jobs);
  std::fill(s.motion.begin(), s.motion.end(), BoxMotion::still);
  broad->find_pairs(s.boxes, s.motion, all_of(s), f.pairs, f.jobs);
  std::fill(s.motion.begin(), s.motion.end(), BoxMotion::moving);
  broad->find_pairs(s.boxes, s.motion, all_of(s), f.pairs, f.jobs);
  // what that call needed goes back in the first hundred
  std::uint64_t before = 0;
  for (int call = 0; call < 200; ++call) {
    if (call == 100) before = f.arena.allocations();
    for (std::size_t i = 0; i < s.boxes.size(); ++i) {
      const Vec3 d(uniform(rng, -0.2, 0.2), uniform(rng, -0.2, 0.2), uniform(rng, -0.2, 0.2));
      s.boxes[i].lo += d, s.boxes[i].hi += d;
      if (call % 10 == 5) s.motion[i] = below(rng, 2) ? BoxMotion::moving : BoxMotion::still;
    }
    broad->find_pairs(s.boxes, s.motion, all_of(s), f.pairs, f.jobs);
  }
  REQUIRE(f.arena.allocations() == before);
}

TEST_CASE("segment and box agree with sampled points", "[broad]") {
  Rng rng(3);
  int inside = 0;
  for (int n = 0; n < 2000; ++n) {
    const Aabb box = random_box(rng, "spread");
    const Vec3 origin(uniform(rng, -10, 10), uniform(rng, -10, 10), uniform(rng, -10, 10));
    const Vec3 ray = (box.lo + box.hi) * Real(0.5) - origin + Vec3::Constant(uniform(rng, -1.5, 1.5));
    bool sampled = false;
    for (int k = 0; k <= 400 && !sampled; ++k) {
      const Vec3 p = origin + ray * (Real(k) / 400);
      sampled = contains(box, Aabb{p, p});
    }
    if (sampled) REQUIRE(segment_hits(box, origin, ray));
    // a miss of a box grown by the sample spacing is a miss
    Aabb grown = box;
    grown.grow(length(ray) / 400);
    if (segment_hits(box, origin, ray) && !sampled) {
      bool near = false;
      for (int k = 0; k <= 400 && !near; ++k) {
        const Vec3 p = origin + ray * (Real(k) / 400);
        near = contains(grown, Aabb{p, p});
      }
      REQUIRE(near);
    }
    inside += sampled;
  }
  REQUIRE(inside > 200);
  REQUIRE(inside < 1900);
}
