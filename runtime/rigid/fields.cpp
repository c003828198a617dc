// What bodies with distance fields say: what the field could not do (thin walls, open meshes), once per body; and loads
// that swing too fast for contacts whose geometry is that of the middle of a step, once per world. Such a contact has
// (dt w)^2 = F dt^2/(m r) under the load F on the mass m, r the radius of what touches, and gains energy above 4.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rigid/impl.h"

namespace feder {
namespace {

constexpr Real kSwingsTooFast = 5;  // r is that of the thinner one; the other bends the contact the other way
constexpr int kLoadSteps = 4;       // in a row

}  // namespace

void Rigid::Impl::say_of_fields(StepContext& c) {
  for (const Carved& n : carved_off) {
    Event e;
    e.kind = kCarved;
    e.a = n.body, e.b = n.piece;
    events.add(e);
  }
  carved_off.clear();
  for (const ObjectId object : unsaid) {
    if (!objects.alive(object)) continue;
    for (std::uint32_t k = bodies.first_collider[objects.index(object)]; k != kNone; k = colliders.next_of_body[k])
      for (const std::string& text : colliders.shape[k]->warnings())
        events.warn("field", objects.describe(object) + ": " + text, object);
  }
  unsaid.clear();
  if (!swing_warned && any_field) look_for_swings(c);
}

void Rigid::Impl::look_for_swings(StepContext& c) {
  Real fastest = kSwingsTooFast, force = 0, radius = 0;
  std::uint32_t swinger = kNone;
  for (const std::uint32_t slot : contacts.active) {
    const Contact& contact = contacts.slots[slot];
    Real impulse = 0;
    for (int k = 0; k < contact.point_count; ++k) impulse += contact.points[k].normal_impulse;
    if (!(impulse > 0)) continue;
    Real mass = kInfinity, thin = kInfinity;
    std::uint32_t light = kNone;
    for (const std::uint32_t collider : {contact.collider_a, contact.collider_b}) {
      const std::uint32_t i = colliders.body_of(collider);
      const Real own = colliders.shape[collider]->inner_radius();
      if (own > 0) thin = std::min(thin, own);
      if (i != kNone && bodies.type[i] == BodyType::dynamic && bodies.mass[i] < mass) mass = bodies.mass[i], light = i;
    }
    if (light == kNone || !(thin < kInfinity)) continue;
    const Real swings = impulse / c.h * c.dt * c.dt / (mass * thin);
    if (swings > fastest) fastest = swings, force = impulse / c.h, radius = thin, swinger = light;
  }
  swing_steps = swinger == kNone ? 0 : swing_steps + 1;
  if (swing_steps < kLoadSteps) return;  // a blow does not last
  swing_warned = true;
  char text[200];
  std::snprintf(text, sizeof text,
                " swings under %.3g N faster than steps of %.3g s follow round a radius of %.3g m: a dt of %.2g s, or "
                "a smaller load, would hold it",
                static_cast<double>(force), static_cast<double>(c.dt), static_cast<double>(radius),
                static_cast<double>(c.dt * std::sqrt(4 / fastest)));
  events.warn("overload", objects.describe(bodies.object[swinger]) + text, bodies.object[swinger]);
}

}  // namespace feder
