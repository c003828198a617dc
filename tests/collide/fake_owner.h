// A stand-in for the owner of bodies: writes colliders, boxes and awake flags, plays the solver's part for impulses.
// It moves bodies only when a test says so.
#pragma once
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "base/jobs.h"
#include "base/rng.h"
#include "feder/query.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "state/command_log.h"
#include "state/contact_book.h"
#include "state/contacts.h"

namespace feder {

struct NoSystems final : SystemFinder {
  System* find_system(std::string_view) override { return nullptr; }
};

struct FakeBody {
  ObjectId object;
  std::vector<std::uint32_t> colliders;
  Pose pose;
  Vec3 velocity = Vec3::Zero();
};

class FakeWorld {
 public:
  explicit FakeWorld(int threads = 1, const char* broad_phase = nullptr)
      : jobs(threads), scratch(store.arena("scratch")) {
    if (broad_phase) world_options.set("broad_phase", std::string(broad_phase));
    SystemSetup setup{store, objects, events, options, world_options, 3, finder, commands, &structure_changed};
    collide = std::make_unique<Collide>(setup);
    for (const EventKind k : {EventKind::contact_stay, EventKind::hit}) events.set_wanted(k, true);
    context.store = &store, context.objects = &objects, context.events = &events;
    context.jobs = &jobs, context.scratch = &scratch;
    context.dt = context.h = Real(1) / 60;
  }

  Colliders& c() { return collide->colliders(); }

  std::uint32_t add(const std::vector<CompoundPart>& parts, const Pose& pose,
                    ColliderMotion motion = ColliderMotion::dynamic) {
    FakeBody body;
    body.pose = pose;
    body.object = objects.add(kBodyKind, static_cast<std::uint32_t>(bodies.size()), "", 0);
    for (const CompoundPart& p : parts) {
      const std::uint32_t k = c().add();
      c().motion[k] = motion, c().awake[k] = motion == ColliderMotion::dynamic;
      c().object[k] = body.object, c().local[k] = p.pose;
      c().shapes[k] = p.shape, c().shape[k] = p.shape.get();
      body.colliders.push_back(k);
    }
    bodies.push_back(body);
    place(static_cast<std::uint32_t>(bodies.size() - 1));
    return static_cast<std::uint32_t>(bodies.size() - 1);
  }
  std::uint32_t add(ShapePtr shape, const Vec3& position, ColliderMotion motion = ColliderMotion::dynamic) {
    return add({{std::move(shape), {}}}, {position, {}}, motion);
  }

  void remove(std::uint32_t b) {
    for (const std::uint32_t k : bodies[b].colliders) collide->forget(k), c().remove(k);
    objects.remove(bodies[b].object, "");
    bodies[b] = bodies.back();
    bodies.pop_back();
  }

  void changed(std::uint32_t b) {
    for (const std::uint32_t k : bodies[b].colliders) collide->forget(k), c().changed.push_back(k);
  }
  template <class F>
  void each(std::uint32_t b, F&& f) {
    for (const std::uint32_t k : bodies[b].colliders) f(k);
  }

  void place(std::uint32_t b) {
    for (const std::uint32_t k : bodies[b].colliders) {
      c().center[k] = bodies[b].pose.position;
      c().pose[k] = bodies[b].pose * c().local[k];
      c().velocity[k] = bodies[b].velocity;
      Aabb box = c().shape[k]->bounds(c().pose[k]);
      box.grow(Real(0.02));
      c().box[k] = box;
    }
  }
  bool awake(std::uint32_t b) { return c().awake[bodies[b].colliders[0]]; }

  void step() {
    if (!planned) {
      plan.clear();
      collide->add_passes(plan);
      plan.add(Rank::wake_touched, "wake", "fake", &FakeWorld::wake, this);
      plan.add(Rank::body_solve, "fake", "fake", &FakeWorld::press, this);
      plan.finish();
      planned = collide->count() > 0;
    }
    events.clear();
    scratch.reset();
    for (std::uint32_t b = 0; b < bodies.size(); ++b) place(b);
    if (touch_all)
      for (std::uint32_t k = 0; k < c().size(); ++k) c().touched.push_back(k);
    plan.run(context);
    store.get<ContactBook>().merge(context.step, objects, events);
    events.finish();
    ++context.step;
    if (planned) collide->validate();
  }

  // Sleepers that something awake came to touch.
  static void wake(void* self, StepContext&) {
    FakeWorld& w = *static_cast<FakeWorld*>(self);
    const auto asleep = [&](std::uint32_t k) { return w.c().motion[k] == ColliderMotion::dynamic && !w.c().awake[k]; };
    for (const ColliderPair& t : w.collide->contacts().arrivals) {
      const bool b_sleeps = w.c().awake[t.a] && asleep(t.b);
      if (!b_sleeps && !(w.c().awake[t.b] && asleep(t.a))) continue;
      const std::uint32_t sleeper = b_sleeps ? t.b : t.a;
      w.wakes.push_back({sleeper, b_sleeps ? t.a : t.b});
      for (const FakeBody& b : w.bodies)
        if (b.object == w.c().object[sleeper])
          for (const std::uint32_t k : b.colliders) w.c().set_awake(k, true);
    }
  }

  // Overlapping points push.
  static void press(void* self, StepContext&) {
    if (static_cast<FakeWorld*>(self)->meanwhile) static_cast<FakeWorld*>(self)->meanwhile();
    if (!static_cast<FakeWorld*>(self)->pressing) return;
    Contacts& contacts = static_cast<FakeWorld*>(self)->collide->contacts();
    for (const std::uint32_t slot : contacts.active)
      for (int k = 0; k < contacts.slots[slot].point_count; ++k) {
        ContactPoint& p = contacts.slots[slot].points[k];
        p.total_impulse = p.normal_impulse = p.separation < 0 ? -p.separation : 0;
      }
  }

  std::vector<Event> of(EventKind kind) const {
    std::vector<Event> found;
    for (const Event& e : events.list())
      if (e.kind == kind) found.push_back(e);
    return found;
  }

  Store store;
  Objects objects{kBodyKind};
  Events events{store.arena("events")};
  JobPool jobs;
  Scratch scratch;
  Params options, world_options;
  NoSystems finder;
  bool structure_changed = false;
  CommandLog commands;
  std::unique_ptr<Collide> collide;
  StepPlan plan;
  bool planned = false;
  bool pressing = true;
  bool touch_all = true;            // tests write colliders as they like; else they say what they touched
  std::function<void()> meanwhile;  // between narrow phase and touches
  StepContext context;
  std::vector<FakeBody> bodies;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> wakes;
};

inline std::uint32_t below(Rng& rng, std::uint32_t n) { return static_cast<std::uint32_t>(rng.unit() * n); }
inline Vec3 random_point(Rng& rng, Real r) { return {rng.uniform(-r, r), rng.uniform(-r, r), rng.uniform(-r, r)}; }

}  // namespace feder
