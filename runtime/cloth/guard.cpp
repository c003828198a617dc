// No pair crosses in a substep. Two convex features that lie on different sides of a plane at the start and at the end
// of a linear motion, have not met in between (x(t).n is linear). The plane's normal is that of the closest points at
// the start; the guard makes each vertex of the one side stay beyond each of the other along it by a share of the
// distance they had: first by pushing pairs apart as their masses say (momentum is kept), then, should that not
// settle, by holding vertices back to the common drift, which always ends.
// Rows do the real work; the guard acts where they failed. Its corrections are counted in the residuals.
#include <algorithm>

#include "cloth/impl.h"

namespace feder {
namespace {
constexpr int kPasses = 12;
constexpr int kHoldPasses = 100;
constexpr Real kKept = Real(0.1);  // of the distance, in one substep
}  // namespace

// A vertex that left the box its candidates were searched in goes no farther in this substep; the search is made anew.
void Cloth::Impl::keep_in_boxes(StepContext& c) {
  since_found += c.h;
  const Vec3 shift = since_found * drift;
  for (const std::uint32_t i : near_vertex) {
    if (moved[i].w == 0) continue;
    const Real half = Real(0.5) * sheet_of(i).settings.thickness;
    const Vec3 x = place(i) - shift;
    const Aabb& b = vertex_box[i];
    const Vec3 lo = b.lo + Vec3::Constant(half), hi = b.hi - Vec3::Constant(half);
    const Vec3 in = x.cwiseMax(lo).cwiseMin(hi);
    if (in == x) continue;
    ++clamped;
    moved[i].add(in - x);
  }
  // re-examined when somebody comes near the rim
  for (const std::uint32_t i : near_vertex) {
    const Real rim = Real(0.6) * sheet_of(i).settings.thickness;
    const Vec3 x = place(i) - shift;
    const Aabb& b = vertex_box[i];
    if ((x - b.lo).minCoeff() < rim || (b.hi - x).minCoeff() < rim) {
      pairs_stale = true;
      break;
    }
  }
}

// Are the features apart along the normal? With `push`, moves those that are not.
bool Cloth::Impl::separate(NearPair& p, Real h, bool push) {
  const std::uint32_t split = p.edges ? 2 : 1;
  const Real wanted = kKept * p.distance;
  Real along[4];
  for (int k = 0; k < 4; ++k) along[k] = dot(p.normal, place(p.v[k]) - place(p.v[0]));
  bool good = true;
  for (std::uint32_t i = 0; i < split; ++i)
    for (std::uint32_t j = split; j < 4; ++j) {
      const Real gap = along[i] - along[j];
      if (gap >= wanted) continue;
      good = false;
      Row4 &a = moved[p.v[i]], &b = moved[p.v[j]];
      const Real w = a.w + b.w;
      if (!push || !(w > 0)) continue;
      const Real share = Real(1.01) * (wanted - gap) / w;
      a.add((a.w * share) * p.normal), b.add((-b.w * share) * p.normal);
      speed[p.v[i]].add((a.w * share / h) * p.normal), speed[p.v[j]].add((-b.w * share / h) * p.normal);
      along[i] += a.w * share, along[j] -= b.w * share;
      ++guarded;
    }
  return good;
}

void Cloth::Impl::guard(StepContext& c) {
  if (!near_wanted()) return;
  keep_in_boxes(c);
  bool good = false;
  for (int pass = 0; pass < kPasses && !good; ++pass) {
    good = true;
    for (NearPair& p : pairs) good = separate(p, c.h, true) && good;
  }
  if (good) return;
  held_back.assign(moved.size(), 0);
  for (int pass = 0; pass < kHoldPasses; ++pass) {
    bool any = false;
    for (NearPair& p : pairs) {
      if (separate(p, c.h, false)) continue;
      for (const std::uint32_t i : p.v) {
        if (held_back[i] || moved[i].w == 0) continue;
        held_back[i] = 1, any = true, ++guarded;
        moved[i].set(guard_start[i].vec() + c.h * drift);
        speed[i].set(drift);
      }
    }
    if (!any) break;
  }
}

// Begin and end of contact between cloths. Self-contact has no events.
void Cloth::Impl::report_near(StepContext& c) {
  touching_now.clear();
  Event e;
  const auto key = [](std::uint64_t a, std::uint64_t b) { return a < b ? a << 32 | b : b << 32 | a; };
  for (const ClothRow& r : near_rows) {
    if (r.impulse == 0) continue;
    const Sheet &a = sheet_of(r.vertex[0]), &b = sheet_of(r.vertex[3]);
    if (&a == &b) continue;
    const std::uint64_t k = key(a.object.slot, b.object.slot);
    if (std::find(touching_now.begin(), touching_now.end(), k) != touching_now.end()) continue;
    touching_now.push_back(k);
    const bool turned = a.object.slot > b.object.slot;
    e.a = turned ? b.object : a.object, e.b = turned ? a.object : b.object;
    e.point = place(r.vertex[0]);
    e.normal = turned ? r.normal : Vec3(-r.normal);
    e.index = r.vertex[0] - a.first;
    if (std::find(touching.begin(), touching.end(), k) != touching.end()) continue;
    e.kind = EventKind::contact_begin;
    c.events->add(e);
    if (!c.events->wanted(EventKind::hit)) continue;
    Event hit = e;
    hit.kind = EventKind::hit, hit.speed = r.approach, hit.impulse = r.impulse;
    c.events->add(hit);
  }
  for (const std::uint64_t k : touching) {
    if (std::find(touching_now.begin(), touching_now.end(), k) != touching_now.end()) continue;
    Event end;
    end.kind = EventKind::contact_end;
    for (const auto& s : sheets) {
      if (s->object.slot == k >> 32) end.a = s->object;
      if (s->object.slot == (k & 0xffffffffu)) end.b = s->object;
    }
    if (end.a && end.b) c.events->add(end);
  }
  touching.assign(touching_now.begin(), touching_now.end());
}

}  // namespace feder
