// Every broad phase on the seven arrangements of boxes (study/moving_boxes.h) against all pairs, step after step.
#include <string>
#include <vector>

#include "broad/broad_phase.h"
#include "feder/params.h"
#include "study/moving_boxes.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Broad {
  explicit Broad(const Variant<BroadPhase>& kind)
      : name(kind.name), arena(kind.name), phase(kind.make(arena, Params())), pairs(&arena) {}
  std::string name;
  Arena arena;
  std::unique_ptr<BroadPhase> phase;
  Array<IndexPair> pairs;
};

void check_steps(const std::string& arrangement, std::uint32_t count, const MovingBoxes::Options& o, double speed,
                 int steps) {
  const MovingBoxes made(arrangement, count, o);
  JobPool jobs(1);
  std::vector<std::unique_ptr<Broad>> all;
  for (const Variant<BroadPhase>& kind : broad_phases()) all.push_back(std::make_unique<Broad>(kind));
  std::vector<Aabb> boxes(count);
  std::vector<BoxMotion> motion(count);
  std::vector<std::uint32_t> touched;
  std::vector<IndexPair> truth;
  for (int step = 0; step <= steps; ++step) {
    touched.clear(), truth.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      boxes[i] = made.box(i, speed, step), motion[i] = made.moves(i) ? BoxMotion::moving : BoxMotion::still;
      if (step == 0 || made.moves(i)) touched.push_back(i);
    }
    for (std::uint32_t a = 0; a < count; ++a)
      for (std::uint32_t b = a + 1; b < count; ++b)
        if ((made.moves(a) || made.moves(b)) && overlaps(boxes[a], boxes[b])) truth.push_back({a, b});
    for (const std::unique_ptr<Broad>& b : all) {
      CAPTURE(b->name, arrangement, count, o.teleports, o.origin, o.ratio, step);
      b->phase->find_pairs(boxes, motion, touched, b->pairs, jobs);
      REQUIRE((std::vector<IndexPair>(b->pairs.begin(), b->pairs.end()) == truth));
    }
  }
}

std::string any_arrangement() {
  return GENERATE(from_range(std::begin(MovingBoxes::kArrangements), std::end(MovingBoxes::kArrangements)));
}

}  // namespace

TEST_CASE("broad phases find what all pairs find in seven arrangements, also with teleports and far away", "[broad]") {
  const std::string arrangement = any_arrangement();
  const MovingBoxes::Options kinds[] = {
      {}, {.resting = 0.5}, {.ratio = 1e9}, {.teleports = 5}, {.origin = 1e5}, {.origin = 1e6, .teleports = 3}};
  const double speeds[] = {0.02, 0.2, 1};
  for (std::size_t k = 0; k < std::size(kinds); ++k)
    for (const std::uint32_t count : {0u, 1u, 2u, 257u}) check_steps(arrangement, count, kinds[k], speeds[k % 3], 20);
}

TEST_CASE("the same of 4096 boxes over 200 steps", "[broad][.map]") {
  const std::string arrangement = any_arrangement();
  const std::uint32_t count = arrangement == "identical" ? 257 : 4096;
  check_steps(arrangement, count, {.teleports = 97}, 0.2, 200);
}
