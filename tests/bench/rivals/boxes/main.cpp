// Broad phases of feder and of Bullet on the same boxes: a gas, every box given anew in each step, no contacts after
// it.
//   boxes COUNT SPEED STEPS REPEATS: a line for each, with the least time of a step over the repeats
// Bullet's pairs are those of its fattened boxes (dbvt), feder's and those of the axis sweep are exact.
#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <btBulletCollisionCommon.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "broad/broad_phase.h"
#include "feder/params.h"
#include "study/moving_boxes.h"

namespace {

using Frames = std::vector<std::vector<feder::Aabb>>;  // by step

double processor_ms() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

struct Timed {
  double ms = 1e300;  // of a step
  std::size_t pairs = 0;
};

// make() is a broad phase that has seen the start; its call moves all boxes to a step and returns the number of pairs.
template <class Make>
Timed best_of(const Frames& frames, int repeats, Make&& make) {
  Timed best;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    auto phase = make();
    const double begun = processor_ms();
    for (std::size_t k = 1; k < frames.size(); ++k) best.pairs = phase(frames[k]);
    best.ms = std::min(best.ms, (processor_ms() - begun) / static_cast<double>(frames.size() - 1));
  }
  return best;
}

struct Feder {
  Feder(const feder::Variant<feder::BroadPhase>& kind, const std::vector<feder::Aabb>& start)
      : phase(kind.make(arena, feder::Params())), motion(start.size(), feder::BoxMotion::moving) {
    for (std::uint32_t i = 0; i < start.size(); ++i) all.push_back(i);
    step(start);
  }
  std::size_t step(const std::vector<feder::Aabb>& boxes) {
    phase->find_pairs(boxes, motion, all, pairs, jobs);
    return pairs.size();
  }
  feder::Arena arena{"boxes"};
  std::unique_ptr<feder::BroadPhase> phase;
  std::vector<feder::BoxMotion> motion;
  std::vector<std::uint32_t> all;
  feder::Array<feder::IndexPair> pairs{&arena};
  feder::JobPool jobs{1};
};

btVector3 to(const feder::Vec3& v) { return {v[0], v[1], v[2]}; }

struct Bullet {
  Bullet(std::unique_ptr<btBroadphaseInterface> of, const std::vector<feder::Aabb>& start)
      : dispatcher(&configuration), phase(std::move(of)) {
    for (std::size_t i = 0; i < start.size(); ++i)
      proxies.push_back(
          phase->createProxy(to(start[i].lo), to(start[i].hi), BOX_SHAPE_PROXYTYPE, nullptr, 1, 1, &dispatcher));
    phase->calculateOverlappingPairs(&dispatcher);
  }
  ~Bullet() {
    for (btBroadphaseProxy* p : proxies) phase->destroyProxy(p, &dispatcher);
  }
  std::size_t step(const std::vector<feder::Aabb>& boxes) {
    for (std::size_t i = 0; i < boxes.size(); ++i)
      phase->setAabb(proxies[i], to(boxes[i].lo), to(boxes[i].hi), &dispatcher);
    phase->calculateOverlappingPairs(&dispatcher);
    return static_cast<std::size_t>(phase->getOverlappingPairCache()->getNumOverlappingPairs());
  }
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  std::unique_ptr<btBroadphaseInterface> phase;
  std::vector<btBroadphaseProxy*> proxies;
};

void print(const std::string& engine, const char* method, const Timed& t) {
  std::printf("%s %s %.6f %zu\n", engine.c_str(), method, t.ms, t.pairs);
}

}  // namespace

int main(int count_of_words, char** words) {
  if (count_of_words != 5) return std::fprintf(stderr, "usage: boxes COUNT SPEED STEPS REPEATS\n"), 2;
  const auto count = static_cast<std::uint32_t>(std::atoi(words[1]));
  const double speed = std::atof(words[2]);
  const int steps = std::atoi(words[3]), repeats = std::atoi(words[4]);
  const feder::MovingBoxes made("gas", count, {});
  Frames frames(static_cast<std::size_t>(steps) + 1);
  feder::Aabb room;
  for (int k = 0; k <= steps; ++k)
    for (std::uint32_t i = 0; i < count; ++i) {
      frames[static_cast<std::size_t>(k)].push_back(made.box(i, speed, k));
      room.include(frames[static_cast<std::size_t>(k)].back());
    }
  for (const auto& kind : feder::broad_phases()) {
    if (std::string(kind.name) == "brute_force" || std::string(kind.name) == "cullide") continue;
    print("feder", kind.name, best_of(frames, repeats, [&] {
            return [phase = std::make_shared<Feder>(kind, frames[0])](const auto& boxes) { return phase->step(boxes); };
          }));
  }
  const auto bullet = [&](auto&& make) {
    return best_of(frames, repeats, [&] {
      return [phase = std::make_shared<Bullet>(make(), frames[0])](const auto& boxes) { return phase->step(boxes); };
    });
  };
  print("bullet", "dbvt", bullet([] { return std::make_unique<btDbvtBroadphase>(); }));
  print("bullet", "axis_sweep3",
        bullet([&] { return std::make_unique<bt32BitAxisSweep3>(to(room.lo), to(room.hi), count + 1); }));
  return 0;
}
