// Worlds with every narrow phase by name: the same bits for any number of threads and after a restore, stacks that
// stand, no allocation.
#include "narrow/narrow_phase.h"
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

std::vector<std::string> names() {
  std::vector<std::string> all{"auto", "gjk"};
  for (const NarrowMethod& method : narrow_methods()) all.push_back(method.name);
  return all;
}

ShapePtr random_stone(Rng& rng) {
  std::vector<Vec3> points;
  for (int i = 0; i < 16; ++i) {
    const Vec3 p = draw(rng, 1);
    points.push_back(p * (Real(0.35) / length(p)));
  }
  return make_hull(points);
}

// Stones and boxes fall into a bin.
void fill_bin(ClosedScene& s) {
  Rng rng(19);
  s.rigid().add_body(ground_of(Real(0.6)));
  for (int k = 0; k < 4; ++k) {
    BodyDesc d = body_of(k < 2 ? make_box(Real(0.2), 3, 4) : make_box(4, 3, Real(0.2)), Vec3::Zero(), 1, Real(0.5));
    d.type = BodyType::fixed;
    d.position =
        Vec3(k < 2 ? Real(k) * 3 - Real(1.5) : Real(0), Real(1.5), k < 2 ? Real(0) : Real(k - 2) * 3 - Real(1.5));
    s.rigid().add_body(d);
  }
  for (int i = 0; i < 60; ++i) {
    BodyDesc d = body_of(i % 3 ? random_stone(rng) : make_box(Real(0.5), Real(0.4), Real(0.3)),
                         Vec3(Real(i % 3) * Real(0.8) - Real(0.8), Real(0.5) + Real(0.8) * Real(i / 9),
                              Real(i / 3 % 3) * Real(0.8) - Real(0.8)),
                         1, Real(0.5));
    d.rotation = from_axis_angle(draw(rng, 1), rng.uniform(0, 3));
    s.rigid().add_body(d);
  }
}

}  // namespace

TEST_CASE("every narrow phase gives the same bits for any threads and after a restore",
          "[rigid][narrow][determinism][threads]") {
  const std::string name = GENERATE(from_range(names()));
  CAPTURE(name);
  enum class Way { plain, restored, rebuilt };
  const auto hashes = [&](int threads, Way way) {
    ClosedScene s("soft_step");
    s.desc.threads = threads;
    s.desc.rebuild = way == Way::rebuilt;
    s.desc.sleeping = true;
    s.desc.options.set("narrow_phase", name);
    fill_bin(s);
    std::vector<std::uint64_t> all;
    for (int i = 0; i < 200; ++i) {
      if (way == Way::restored && i % 7 == 3) s.world().restore(s.world().snapshot());
      s.world().step();
      all.push_back(s.world().hash());
    }
    return all;
  };
  const std::vector<std::uint64_t> one = hashes(1, Way::plain);
  CHECK(hashes(2, Way::plain) == one);
  CHECK(hashes(4, Way::plain) == one);
  CHECK(hashes(2, Way::restored) == one);
  CHECK(hashes(1, Way::rebuilt) == one);
}

TEST_CASE("stacks of boxes, of hulls and of polygons stand with every narrow phase", "[rigid][narrow]") {
  const std::string name = GENERATE(from_range(names()));
  const int kind = GENERATE(0, 1, 2);
  CAPTURE(name, kind);
  ClosedScene s("soft_step", 1.0 / 60, 4, kind == 2 ? 2 : 3);
  s.desc.sleeping = true;
  s.desc.options.set("narrow_phase", name);
  s.rigid().add_body(ground_of(Real(0.6)));
  std::vector<Vec3> corners;
  for (int k = 0; k < 12; ++k) {
    const Real c = std::cos(Real(k) * kPi / 6), d = std::sin(Real(k) * kPi / 6);
    corners.push_back(Vec3(c / 2, Real(0.5), d / 2)), corners.push_back(Vec3(c / 2, Real(-0.5), d / 2));
  }
  const ShapePtr block = kind == 1 ? make_hull(corners) : make_box(1, 1, 1);
  std::vector<ObjectId> tower;
  for (int i = 0; i < 10; ++i)
    tower.push_back(s.rigid().add_body(body_of(block, Vec3(0, Real(i) + Real(0.5), 0), 1, Real(0.6))));
  s.run(8);
  for (std::size_t i = 0; i < tower.size(); ++i) {
    const Vec3 p = s.position(tower[i]);
    CAPTURE(i, p.transpose());
    CHECK(std::abs(p[0]) < 2e-3);
    CHECK(std::abs(p[2]) < 2e-3);
    CHECK(std::abs(p[1] - Real(i) - Real(0.5)) < 0.01 * (double(i) + 1));
  }
  CHECK(s.world().need<Collide>().max_penetration() < 0.01);
}

TEST_CASE("a pile of stones comes to rest in its bin with every narrow phase, without allocation", "[rigid][narrow]") {
  const std::string name = GENERATE(from_range(names()));
  CAPTURE(name);
  ClosedScene s("soft_step");
  s.desc.options.set("narrow_phase", name);
  fill_bin(s);
  s.run(6);
  const std::uint64_t before = s.world().allocations();
  s.run(1);
  CHECK(s.world().allocations() == before);
  CHECK(s.world().need<Collide>().max_penetration() < 0.02);
  const Bodies& bodies = s.rigid().bodies();
  Real fastest = 0;
  for (std::uint32_t i = 5; i < 65; ++i) {
    CHECK(bodies.position[i][1] > Real(0.05));
    fastest = std::max(fastest, length(bodies.velocity[i]));
  }
  CHECK(fastest < Real(0.2));
  // pairs of round stones have no features that lead in circles
  double handed_on = -1;
  for (const Residual& r : s.world().residuals())
    if (std::string(r.name) == "collide.handed_on") handed_on = r.value;
  CHECK(handed_on == (s.world().need<Collide>().narrow().method() ? 0 : -1));
}
