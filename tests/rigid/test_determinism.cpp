// The same scene gives the same bits whatever the number of threads, and the same as the stored hashes: compilers and
// optimisation levels are compared through tests/golden/hashes.txt, one line per scalar type, scene and solver. A
// change of physics changes them: FEDER_WRITE_GOLDEN=1 prints the new lines.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <sstream>
#include <thread>

#include "base/rng.h"
#include "feder/error.h"
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

// Boxes, spheres, capsules and cylinders fall on each other around a bridge of hinges.
void fill(ClosedScene& s) {
  Rng rng(7);
  s.rigid().add_body(ground_of(Real(0.6)));
  const ShapePtr shapes[] = {make_box(Real(0.6), Real(0.4), Real(0.5)), make_sphere(Real(0.3)),
                             make_capsule(Real(0.2), Real(0.8)), make_cylinder(Real(0.3), Real(0.5))};
  for (int i = 0; i < 40; ++i) {
    Vec3 at = draw(rng, 1);
    at[1] = Real(2.5) + Real(0.5) * Real(i);
    const Real mass = rng.uniform(1, 3);
    BodyDesc d = body_of(shapes[i % 4], at, mass, Real(0.5));
    const Vec3 axis = draw(rng, 1);
    d.rotation = from_axis_angle(axis, rng.uniform(0, 3));
    d.angular_velocity = draw(rng, 2);
    d.restitution = i % 5 == 0 ? Real(0.5) : Real(0);
    s.rigid().add_body(d);
  }
  ObjectId last;
  for (int i = 0; i <= 8; ++i) {
    ObjectId plank;
    if (i < 8)
      plank = s.rigid().add_body(
          body_of(make_box(Real(0.45), Real(0.1), 1), Vec3(Real(-1.75 + 0.5 * i), Real(1.5), 0), 2, Real(0.5)));
    JointDesc j;
    j.type = "hinge";
    j.a = last;
    j.b = plank;
    if (!j.a) std::swap(j.a, j.b);
    j.anchor_a = j.anchor_b = Vec3(Real(-2 + 0.5 * i), Real(1.5), 0);
    s.rigid().add_joint(j);
    last = plank;
  }
}

std::uint64_t run(const char* solver, int threads) {
  ClosedScene s(solver);
  s.desc.threads = threads;
  s.desc.sleeping = true;
  fill(s);
  for (int i = 0; i < 240; ++i) s.world().step();
  return s.world().hash();
}

std::string stored(const std::string& key) {
  std::ifstream file(FEDER_SOURCE_DIR "/tests/golden/hashes.txt");
  std::string line;
  while (std::getline(file, line))
    if (line.compare(0, key.size() + 1, key + " ") == 0) return line.substr(key.size() + 1);
  return {};
}

}  // namespace

TEST_CASE("hashes do not depend on threads, compiler or optimisation", "[rigid][determinism][threads][heavy]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  const std::uint64_t one = run(solver, 1);
  CHECK(run(solver, 1) == one);
  CHECK(run(solver, 2) == one);
  CHECK(run(solver, 4) == one);
  char hash[32];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(one));
  const std::string key = std::string(kRealName) + " rigid_pile " + solver;
  if (std::getenv("FEDER_WRITE_GOLDEN")) std::printf("%s %s\n", key.c_str(), hash);
  const std::string golden = stored(key);
  if (golden.empty())
    WARN("no stored hash for '" << key << "', got " << hash);
  else
    CHECK(golden == hash);
}

// What orders a solve (islands, colours, trees, lists, axes, recycled contacts) is kept between steps, but is a
// function of the state: made anew in every step, or restored now and then, it gives the same bits, whatever was made,
// destroyed, put to sleep and woken meanwhile.
TEST_CASE("what is kept between steps is in the state or follows from it",
          "[rigid][once][determinism][threads][heavy]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  enum class Way { plain, rebuilt, restored };
  const auto hashes = [&](Way way, int threads) {
    ClosedScene s(solver);
    s.desc.sleeping = true;
    s.desc.threads = threads;
    s.desc.rebuild = way == Way::rebuilt;
    fill(s);
    const ShapePtr box = make_box(Real(0.5), Real(0.5), Real(0.5));
    std::vector<ObjectId> towers;
    for (int i = 0; i < 30; ++i)
      towers.push_back(s.rigid().add_body(
          body_of(box, Vec3(Real(5 + i / 6), Real(0.25) + Real(0.5) * Real(i % 6), 0), 1, Real(0.5))));
    std::vector<std::uint64_t> all;
    for (int step = 0; step < 300; ++step) {
      if (step % 50 == 20) {  // one of each tower goes; one is made in its place, and wakes it
        const auto k = static_cast<std::size_t>(step / 50) * 5 % towers.size();
        const Vec3 at = s.position(towers[k]) + Vec3(0, Real(0.1), 0);
        s.rigid().destroy_body(towers[k], "test");
        towers[k] = s.rigid().add_body(body_of(box, at, 2, Real(0.5)));
      }
      if (step == 200) s.rigid().sleep(towers[7]);
      if (step == 230) s.rigid().wake(towers[7]);
      if (way == Way::restored && step % 10 == 0) s.world().restore(s.world().snapshot());
      s.world().step();
      all.push_back(s.world().hash());
    }
    return all;
  };
  const std::vector<std::uint64_t> expected = hashes(Way::plain, 1);
  CHECK(hashes(Way::rebuilt, 1) == expected);
  CHECK(hashes(Way::rebuilt, 2) == expected);
  CHECK(hashes(Way::restored, 2) == expected);
}

// Tasks of a host: a queue that two threads empty.
TEST_CASE("a host's threads give the same bits, and helpers may outlive the world",
          "[rigid][once][determinism][threads][heavy]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  std::mutex lock;
  std::vector<Helper> tasks, kept;
  std::atomic<bool> stop{false};
  std::atomic<int> helped{0};
  Executor executor;
  executor.threads = 3;
  executor.call = [&](const Helper& helper, int helpers) {
    const std::lock_guard<std::mutex> guard(lock);
    for (; helpers > 0; --helpers) tasks.push_back(helper);
    if (kept.empty()) kept.push_back(helper);
  };
  const auto work = [&] {
    while (!stop) {
      std::vector<Helper> task;
      {
        const std::lock_guard<std::mutex> guard(lock);
        if (!tasks.empty()) task.push_back(tasks.back()), tasks.pop_back();
      }
      if (task.empty())
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      else if (task[0].help())
        ++helped;
    }
  };
  std::thread first(work), second(work);
  const auto hash_of_wall = [&](const Executor& with) {  // the pile is too small for others to be asked
    ClosedScene s(solver);
    s.executor = with;
    s.rigid().add_body(ground_of(Real(0.6)));
    const ShapePtr box = make_box(1, 1, 1);
    for (int i = 0; i < 600; ++i)
      s.rigid().add_body(body_of(box, Vec3(Real(1.1 * (i % 30)), Real(0.5 + i / 30), 0), 1, Real(0.5)));
    for (int i = 0; i < 20; ++i) s.world().step();
    return s.world().hash();
  };
  const std::uint64_t expected = hash_of_wall({});
  CHECK(hash_of_wall(executor) == expected);
  stop = true;
  first.join(), second.join();
  REQUIRE(kept.size() == 1);
  CHECK_FALSE(kept[0].help());
  executor.threads = 0;
  CHECK_THROWS_AS(World(WorldDesc{}, {}, executor), SceneError);
}
