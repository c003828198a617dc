// What a step costs each broad phase, counted: nodes and cells looked at, boxes compared, ends that changed places, in
// a gas of cubes at one density whose number grows.
#include <cmath>
#include <string>
#include <vector>

#include "base/rng.h"
#include "broad/broad_phase.h"
#include "feder/params.h"
#include "support/catch.h"

using namespace feder;

namespace {

constexpr int kSteps = 4;
constexpr double kCrowd = 0.25;  // cubes of 1 m per m^3

// Of a mean step. speed: most that a cube moves along an axis in it, m.
struct Work {
  double looked = 0, swaps = 0;
};
Work work_of(const Variant<BroadPhase>& kind, std::uint32_t count, double speed) {
  Rng rng(5);
  const double room = std::cbrt(count / kCrowd);
  std::vector<Vec3> at(count), way(count);
  for (std::uint32_t i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k)
      at[i][k] = static_cast<Real>(room * rng.unit()), way[i][k] = static_cast<Real>(2 * rng.unit() - 1);
  std::vector<Aabb> boxes(count);
  const std::vector<BoxMotion> motion(count, BoxMotion::moving);
  std::vector<std::uint32_t> touched(count);
  for (std::uint32_t i = 0; i < count; ++i) touched[i] = i;
  Arena arena("broad");
  JobPool jobs(1);
  Array<IndexPair> pairs(&arena);
  const std::unique_ptr<BroadPhase> broad = kind.make(arena, Params());
  Work sum;
  for (int step = 0; step <= kSteps; ++step) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vec3 middle = at[i] + static_cast<Real>(speed * step) * way[i];
      boxes[i] = {middle - Vec3::Constant(Real(0.5)), middle + Vec3::Constant(Real(0.5))};
    }
    broad->find_pairs(boxes, motion, touched, pairs, jobs);
    if (step == 0) continue;
    const BroadWork w = broad->work();
    sum.looked += static_cast<double>(w.visits + w.tests) / kSteps, sum.swaps += static_cast<double>(w.swaps) / kSteps;
  }
  return sum;
}

// Exponent of the growth from `few` to `many`.
double growth(double few, double many, double ratio) { return std::log(many / few) / std::log(ratio); }

void check_growth(std::uint32_t few, std::uint32_t many) {
  for (const Variant<BroadPhase>& kind : broad_phases()) {
    const std::string name = kind.name;
    const bool sweeps = name == "sweep_prune", all = name == "brute_force";
    if (all || (name == "cullide")) continue;
    // cubes leave their fat boxes in some steps; ends pass few others, so that the order is mended and not made anew
    const double speed = sweeps ? 0.001 : 0.1;
    const Work a = work_of(kind, few, speed), b = work_of(kind, many, speed);
    const double ratio = static_cast<double>(many) / few;
    CAPTURE(name, a.looked / few, b.looked / many, a.swaps / few, b.swaps / many);
    CHECK(a.looked > 0);
    if (sweeps)
      CHECK(growth(a.swaps, b.swaps, ratio) == Approx(5.0 / 3).margin(0.05));
    else
      CHECK(growth(a.looked, b.looked, ratio) <= 1.15);
  }
}

}  // namespace

TEST_CASE("searches grow hardly faster than the boxes of a gas, sweeping as their number to the 5/3", "[broad]") {
  check_growth(1000, 64000);
}

TEST_CASE("ends change places in proportion to the speed of boxes", "[broad]") {
  const Variant<BroadPhase>& kind = find_variant(broad_phases(), "sweep_prune", "broad phase");
  const double slow = work_of(kind, 4000, 0.001).swaps;
  CHECK(slow > 1000);
  for (const double times : {2.0, 4.0})
    CHECK(work_of(kind, 4000, 0.001 * times).swaps / slow == Approx(times).epsilon(0.1));
}

TEST_CASE("where nothing moves trees look at nothing but candidates, and sweeping swaps nothing", "[broad]") {
  for (const char* name : {"tree", "sweep_prune"}) {
    const Work w = work_of(find_variant(broad_phases(), name, "broad phase"), 1000, 0);
    CAPTURE(name, w.looked);
    CHECK(w.swaps == 0);
    CHECK(w.looked < 4000);
  }
}
