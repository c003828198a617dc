// Links of surfaces are made and ended by the systems of either side.
#include "state/surface_links.h"

#include "feder/body.h"

namespace feder {
namespace {

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

}  // namespace feder
