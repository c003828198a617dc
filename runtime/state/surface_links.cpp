// Links of surfaces are made and ended by the systems of either side.
#include "state/surface_links.h"

#include <cstdio>

#include "feder/body.h"

namespace feder {
namespace {

constexpr Real kGap = Real(0.5);    // that is reported, in mean edges
constexpr Real kClose = Real(0.1);  // thicknesses: a gap that needs no look at the edges

// The mean length of its edges now, m; its thickness where it has none with a length.
Real mean_edge(const Surfaces& all, const Surface& s) {
  Real sum = 0;
  std::uint32_t count = 0;
  const std::uint32_t* ends = s.edges.ends;
  for (std::uint32_t e = 0; e < s.edges.count; ++e, ends += s.edges.stride) {
    if (ends[0] == ends[1]) continue;
    sum += length(Vec3(all.position[s.first + ends[0]] - all.position[s.first + ends[1]])), ++count;
  }
  return count > 0 ? sum / static_cast<Real>(count) : s.thickness;
}

void wake_linked(Store& store, const Objects& objects, ObjectId id) {
  Surfaces* surfaces = store.find<Surfaces>();
  if (surfaces && objects.alive(id) && objects.kind(id) != kBodyKind)
    surfaces->wakes.push_back({id, {}, WakeCause::script});
}

}  // namespace

void hold_point(Store& store, const Objects& objects, ObjectId a, std::size_t i, ObjectId b, std::size_t j,
                const Vec3& local) {
  if (!objects.alive(b)) throw SceneError("attach: expected a living object, got " + objects.describe(b));
  if (a == b && i == j)
    throw SceneError("attach: expected two points, got point " + std::to_string(i + 1) + " of " + objects.describe(a) +
                     " twice");
  if (!is_finite(local)) throw SceneError("attach: expected three finite numbers");
  SurfaceLink l;
  l.a = a, l.b = b;
  l.point = static_cast<std::uint32_t>(i), l.other = static_cast<std::uint32_t>(j);
  l.local = local;
  l.to_body = objects.kind(b) == kBodyKind;
  store.need<SurfaceLinks>("contact").list.push_back(l);
  wake_linked(store, objects, a), wake_linked(store, objects, b);
}

void hold_to_body(Store& store, const Objects& objects, ObjectId a, std::size_t i, ObjectId body, const Vec3& local) {
  if (!objects.alive(body) || objects.kind(body) != kBodyKind)
    throw SceneError("attach: expected a living body, got " + objects.describe(body));
  hold_point(store, objects, a, i, body, 0, local);
}

bool release_point(Store& store, const Objects& objects, ObjectId a, std::size_t i) {
  SurfaceLinks* links = store.find<SurfaceLinks>();
  if (!links) return false;
  const auto names = [&](const SurfaceLink& l) {
    return (l.a == a && l.point == i) || (!l.to_body && l.b == a && l.other == i);
  };
  for (const SurfaceLink& l : links->list)
    if (names(l)) wake_linked(store, objects, l.a), wake_linked(store, objects, l.b);
  return std::erase_if(links->list, names) > 0;
}

void warn_of_gap(SurfaceLink& l, const Surfaces& all, const Surface& s, Real gap, const std::string& to,
                 const Objects& objects, Events& events) {
  if (l.warned || !(gap > kClose * s.thickness)) return;
  const Real edge = mean_edge(all, s);
  if (!(gap > kGap * edge)) return;
  l.warned = 1;
  char numbers[96];
  std::snprintf(numbers, sizeof numbers, "%.3g mm, %.3g mean edges", double(1000 * gap), double(gap / edge));
  events.warn("attachment_gap",
              objects.describe(l.a) + " point " + std::to_string(l.point + 1) + " is held to " + to +
                  " from a distance of " + numbers +
                  ": put the two together before attaching, or take more substeps where a load pulls them apart",
              l.a);
}

}  // namespace feder
