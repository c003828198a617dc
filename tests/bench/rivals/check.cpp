// What end_state() finds, against states whose figures are known. Prints what is wrong; exit status 1 when anything is.
#include <cmath>
#include <cstdio>

#include "end_state.h"

namespace rivals {
namespace {

class Given final : public Engine {
 public:
  explicit Given(std::vector<BodyState> states) : states_(std::move(states)) {}
  void build(const Scene&) override {}
  void step() override {}
  BodyState state(std::size_t body) const override { return states_[body]; }

 private:
  std::vector<BodyState> states_;
};

int wrong = 0;

void expect(const char* what, double found, double right, double tolerance = 1e-5) {
  if (std::fabs(found - right) <= tolerance) return;
  std::printf("%s: %.9g, not %.9g\n", what, found, right);
  ++wrong;
}

Rotation about_z(float angle) { return {0, 0, std::sin(angle / 2), std::cos(angle / 2)}; }

Scene two_boxes() {
  Scene scene;
  const auto shape = scene.add(Shape{.kind = ShapeKind::box, .half = {.5f, .5f, .5f}});
  scene.add(Body{.motion = Motion::fixed, .shape = shape});
  scene.add(Body{.shape = shape, .position = {0, 1, 0}});
  scene.joints.push_back({0, 1, {0, .5f, 0}});
  return scene;
}

EndState after(BodyState second) {
  const Scene scene = two_boxes();
  return end_state(scene, Given({BodyState{}, second}));
}

void check_boxes() {
  constexpr float kPi = 3.14159265f;
  const EndState face = after({.position = {0, .9f, 0}, .velocity = {3, 0, 4}, .asleep = true});
  expect("faces", face.overlap, .1), expect("sink", face.sink, .1), expect("speed", face.speed, 5);
  expect("asleep", face.asleep, 1), expect("bodies", face.dynamic, 1), expect("joint", face.joint_error, .1);
  expect("moved", face.moved, 0);
  // an edge into a face: half a diagonal reaches below the centre
  const EndState edge = after({.position = {0, 1.1f, 0}, .rotation = about_z(kPi / 4)});
  expect("edge", edge.overlap, .5 + std::sqrt(.5) - 1.1);
  expect("turned joint", edge.joint_error, std::hypot(std::sqrt(.125), .6 - std::sqrt(.125)));
  expect("apart", after({.position = {0, 1.3f, 0}, .rotation = about_z(kPi / 4)}).overlap, 0);
  // corner beside corner: the boxes around them overlap, they do not
  expect("beside", after({.position = {.9f, .9f, 0}, .rotation = about_z(kPi / 4)}).overlap, 0);
}

void check_edges() {
  // an edge along x under one along z: the axis that tells is their cross product, vertical
  constexpr float kQuarter = .78539816f;
  const Scene scene = two_boxes();
  const Rotation about_x{std::sin(kQuarter / 2), 0, 0, std::cos(kQuarter / 2)};
  const auto at = [&](float y) {
    return end_state(scene, Given({{.rotation = about_x}, {.position = {0, y, 0}, .rotation = about_z(kQuarter)}}));
  };
  expect("crossed edges", at(1.4f).overlap, std::sqrt(2.) - 1.4);
  expect("crossed edges, apart", at(1.42f).overlap, 0);
}

void check_places() {
  const EndState far = after({.position = {3, -30, 4}});
  expect("lost", far.lost, 1), expect("drift", far.drift, 5), expect("far", far.moved, 1), expect("top", far.top, -30);
  const EndState bad = after({.position = {0, std::nanf(""), 0}});
  expect("not finite", bad.finite, 0);
  for (const double figure : {bad.sink, bad.top, bad.drift, bad.speed, bad.overlap, bad.joint_error})
    expect("no figure of what is not finite", std::isnan(figure), 1);
}

}  // namespace
}  // namespace rivals

int main() {
  rivals::check_boxes();
  rivals::check_edges();
  rivals::check_places();
  std::printf("end state: %d wrong\n", rivals::wrong);
  return rivals::wrong ? 1 : 0;
}
