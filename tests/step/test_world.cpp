// The world with systems made up for the test: plan order, systems on demand, couplings, snapshots, absence.
#include <cmath>
#include <limits>

#include "feder/world.h"
#include "support/aborts.h"
#include "support/catch.h"

using namespace feder;

namespace {

std::vector<std::string> trace;  // what ran, in order

struct Counts {
  explicit Counts(Arena& a) : values(&a) {}
  Array<double> values;
};

template <int Which>
class Fake final : public System {
 public:
  static constexpr const char* kName = Which == 0 ? "alpha" : Which == 1 ? "beta" : "alpha_beta";

  explicit Fake(SystemSetup& setup) : counts_(setup.store.need<Counts>(kName)) {
    counts_.values.assign(10, setup.options.number({"start", "", {0, 100}}, 1));
  }
  void add_passes(StepPlan& plan) override {
    plan.add<&Fake::solve>(Place(Rank::body_solve, 1 - Which), "solve", kName, this);
    plan.add<&Fake::before>(Rank::gather_bodies, "before", kName, this);
    plan.add<&Fake::after>(Rank::restitution, "after", kName, this);
    plan.add<&Fake::bounds>(Rank::body_bounds, "bounds", kName, this);
  }
  std::size_t count() const override { return counts_.values.size(); }
  // numbers that are finite, and an energy that is not
  Energy energy(const Vec3&) const override {
    return {counts_.values[0] == 99 ? std::numeric_limits<double>::infinity() : 0, 0, 0};
  }
  void hash(Hash& h) const override {
    for (const double v : counts_.values) h.add(v);
  }
  void save(Writer& w) const override { w.list(counts_.values); }
  void load(Reader& r) override { r.list(counts_.values); }

 private:
  void note(const char* row) { trace.push_back(std::string(kName) + "." + row); }
  void before(StepContext&) { note("before"); }
  void bounds(StepContext&) { note("bounds"); }
  void solve(StepContext& c) {
    note("solve");
    counts_.values[0] += c.h;
  }
  void after(StepContext&) { note("after"); }
  Counts& counts_;
};

template <int Which>
std::unique_ptr<System> make_fake(SystemSetup& s) {
  return std::make_unique<Fake<Which>>(s);
}

constexpr ObjectKind kBody{"body", "bodies"}, kNet{"net", "nets"};

const char* const kJoins[2] = {"alpha", "beta"};
const char* const kNeedsMissing[1] = {"gamma"};
const SystemDescriptor kAlpha{.name = "alpha", .units = "things", .make = &make_fake<0>};
const SystemDescriptor kBeta{.name = "beta", .units = "things", .make = &make_fake<1>};
const SystemDescriptor kAlphaBeta{.name = "alpha_beta", .units = "pairs", .joins = kJoins, .make = &make_fake<2>};
const SystemDescriptor kDelta{.name = "delta", .units = "things", .needs = kNeedsMissing, .make = &make_fake<0>};
const SystemDescriptor* const kCatalog[] = {&kAlpha, &kBeta, &kAlphaBeta, &kDelta};

WorldDesc two_substeps() {
  WorldDesc d;
  d.substeps = 2;
  return d;
}

}  // namespace

TEST_CASE("a world without systems has a plan of its own two passes and no system bytes", "[world]") {
  World world(two_substeps(), kCatalog);
  world.step();
  CHECK(world.plan().nodes().size() == 2);
  CHECK(world.report().empty());
  CHECK(world.absent().size() == 4);
  CHECK(world.step_count() == 1);
  CHECK(world.time() == Approx(1.0 / 60));
}

TEST_CASE("the time is right after ten million steps", "[world]") {
  World world(two_substeps(), kCatalog);
  constexpr int kSteps = 10000000;
  for (int k = 0; k < kSteps; ++k) world.step();
  CHECK(world.step_count() == kSteps);
  CHECK(std::fabs(world.time() * 60 / kSteps - 1) < 1e-9);
}

TEST_CASE("a world whose energy is not finite is not finite", "[world]") {
  WorldDesc d = two_substeps();
  World calm(d, kCatalog);
  calm.need<Fake<0>>();
  CHECK(calm.is_finite());
  d.systems["alpha"].set("start", 99.0);
  World wild(d, kCatalog);
  wild.need<Fake<0>>();
  CHECK_FALSE(wild.is_finite());
}

TEST_CASE("passes run by rank, in their loop; a coupling appears with its partners", "[world]") {
  World world(two_substeps(), kCatalog);
  world.need<Fake<0>>();
  CHECK(world.find<Fake<2>>() == nullptr);
  world.need<Fake<1>>();
  CHECK(world.find<Fake<2>>() != nullptr);
  trace.clear();
  world.step();
  const std::vector<std::string> expected = {"alpha.bounds", "beta.bounds",       "alpha_beta.bounds", "alpha.before",
                                             "beta.before",  "alpha_beta.before", "alpha_beta.solve",  "beta.solve",
                                             "alpha.solve",  "alpha_beta.solve",  "beta.solve",        "alpha.solve",
                                             "alpha.after",  "beta.after",        "alpha_beta.after"};
  CHECK(trace == expected);
  for (const PlanNode& n : world.plan().nodes()) CHECK(n.counter.calls == (n.loop == Loop::substep ? 2u : 1u));
}

TEST_CASE("a system that needs an absent module says so", "[world]") {
  World world(two_substeps(), kCatalog);
  CHECK_THROWS_WITH(world.need_system("delta"), Catch::Contains("delta") && Catch::Contains("gamma"));
  CHECK_THROWS_WITH(world.need_system("omega"), Catch::Contains("omega"));
  CHECK(world.report().empty());
}

TEST_CASE("system options are read, and unknown ones refused", "[world]") {
  WorldDesc d = two_substeps();
  d.systems["alpha"].set("start", 5.0);
  World world(d, kCatalog);
  world.need<Fake<0>>();
  CHECK(world.store().get<Counts>().values[1] == 5.0);

  d.systems["alpha"].set("strat", 5.0);
  World other(d, kCatalog);
  CHECK_THROWS_WITH(other.need<Fake<0>>(), Catch::Contains("strat") && Catch::Contains("start"));
}

TEST_CASE("restore brings everything back, and refuses what does not fit", "[world]") {
  World world(two_substeps(), kCatalog);
  world.need<Fake<0>>();
  for (int i = 0; i < 3; ++i) world.step();
  const std::string image = world.snapshot();
  const std::uint64_t at_three = world.hash();
  for (int i = 0; i < 4; ++i) world.step();
  const std::uint64_t at_seven = world.hash();
  CHECK(at_seven != at_three);

  world.restore(image);
  CHECK(world.hash() == at_three);
  CHECK(world.step_count() == 3);
  for (int i = 0; i < 4; ++i) world.step();
  CHECK(world.hash() == at_seven);

  CHECK_THROWS_AS(world.restore(image.substr(0, image.size() / 2)), SceneError);
  CHECK_THROWS_AS(world.restore("nonsense"), SceneError);
  CHECK(world.hash() == at_seven);
  World other(two_substeps(), kCatalog);
  CHECK_THROWS_WITH(other.restore(image), Catch::Contains("another world"));
}

TEST_CASE("world options out of range are refused by name", "[world]") {
  const auto with = [](auto&& change) {
    WorldDesc d;
    change(d);
    World world(d, kCatalog);
  };
  CHECK_THROWS_WITH(with([](WorldDesc& d) { d.dt = 0; }), Catch::Contains("dt"));
  CHECK_THROWS_WITH(with([](WorldDesc& d) { d.dt = std::numeric_limits<double>::quiet_NaN(); }), Catch::Contains("dt"));
  CHECK_THROWS_WITH(with([](WorldDesc& d) { d.substeps = 0; }), Catch::Contains("substeps"));
  CHECK_THROWS_WITH(with([](WorldDesc& d) { d.dimension = 4; }), Catch::Contains("dimension"));
  CHECK_THROWS_WITH(with([](WorldDesc& d) { d.threads = 1000; }), Catch::Contains("threads"));
  CHECK_THROWS_WITH(with([](WorldDesc& d) { d.gravity[1] = kInfinity; }), Catch::Contains("gravity"));
}

TEST_CASE("objects: handles go stale, tombstones keep name and place", "[world]") {
  Objects objects{kBody, kNet};
  const ObjectId a = objects.add(kBody, 0, "crate", objects.tag_bit("wood"));
  const ObjectId b = objects.add(kNet, 1, "", 0);
  CHECK(objects.find("crate") == a);
  CHECK(objects.describe(a) == "body \"crate\"");
  CHECK(objects.known_tag("wood") == objects.tags(a));
  CHECK(objects.known_tag("stone") == 0);
  objects.remove(a, "tower.lua:41");
  CHECK_FALSE(objects.alive(a));
  CHECK(objects.alive(b));
  CHECK(objects.name(a) == "crate");
  CHECK(objects.destroyed_at(a) == "tower.lua:41");
  // the slot is not used again at once
  for (int i = 0; i < 32; ++i) objects.remove(objects.add(kBody, 0, "x", 0), "");
  CHECK(objects.name(a) == "crate");
  // names follow their objects when slots are used again
  std::vector<ObjectId> living;
  for (int i = 0; i < 300; ++i) {
    living.push_back(objects.add(kBody, 0, i % 3 ? "" : "n" + std::to_string(i), 0));
    if (i % 2) objects.remove(living.back(), i % 4 == 1 ? "" : "here");
    if (i % 2) living.pop_back();
    objects.validate();
  }
  for (std::size_t k = 0; k < living.size(); ++k)
    CHECK(objects.name(living[k]) == (2 * k % 3 ? "" : "n" + std::to_string(2 * k)));
  for (int i = 0; i < 63; ++i) objects.tag_bit("tag" + std::to_string(i));
  CHECK_THROWS_AS(objects.tag_bit("one too many"), SceneError);
}

TEST_CASE("events are sorted by kind and partners, pending ones included", "[world]") {
  Arena arena("events");
  Objects objects{kBody, kNet};
  const ObjectId a = objects.add(kBody, 0, "a", 0), b = objects.add(kBody, 1, "b", 0);
  Events events(arena);
  Event e;
  e.kind = EventKind::contact_end, e.a = a, e.b = b;
  events.add_pending(e);
  e.kind = EventKind::contact_begin, e.a = b;
  events.add(e);
  e.a = a;
  events.add(e);
  events.warn("stiff", "one");
  events.warn("stiff", "two");
  events.finish();
  REQUIRE(events.list().size() == 4);
  CHECK(events.list()[0].kind == EventKind::contact_begin);
  CHECK(events.list()[0].a == a);
  CHECK(events.list()[1].a == b);
  CHECK(events.list()[2].kind == EventKind::contact_end);
  CHECK(events.warning_message(events.list()[3]) == "one");
  events.clear();
  events.finish();
  CHECK(events.list().empty());
}

TEST_CASE("a system that names two passes alike is found when the plan is built", "[world][validate]") {
  if constexpr (!kAsserts) return;
  struct Twice final : System {
    void add_passes(StepPlan& plan) override {
      for (int k = 0; k < 2; ++k) plan.add<&Twice::run>(Place(Rank::broad, k), "run", "twice", this);
    }
    void run(StepContext&) {}
    std::size_t count() const override { return 0; }
    void hash(Hash&) const override {}
    void save(Writer&) const override {}
    void load(Reader&) override {}
  };
  const SystemDescriptor descriptor{
      .name = "twice", .units = "things", .make = [](SystemSetup&) -> std::unique_ptr<System> {
        return std::make_unique<Twice>();
      }};
  const SystemDescriptor* const catalog[] = {&descriptor};
  World world(WorldDesc{}, catalog);
  world.need_system("twice");
  CHECK_THAT(failed_assert([&] { world.step(); }), Catch::Contains("world/validate.cpp"));
}

TEST_CASE("validate finds a table of objects and events that went wrong", "[world][validate]") {
  if constexpr (!kAsserts) return;
  Objects objects{kBody, kNet};
  const ObjectId a = objects.add(kBody, 0, "", 0);
  objects.remove(a, "");
  CHECK_THAT(failed_assert([&] { objects.remove(a, ""); }), Catch::Contains("alive"));
  Store store;
  Events events(store.arena("events"));
  Event e;
  e.kind = EventKind::warning;  // without its text
  events.add(e);
  CHECK_THAT(failed_assert([&] { events.validate(); }), Catch::Contains("warnings_"));
}
