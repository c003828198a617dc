// A world to draw, and one headless renderer for all tests of a program: a driver is slow to start.
#pragma once
#include "feder/lua.h"
#include "feder/net.h"
#include "feder/rigid.h"
#include "support/catch.h"
#include "view/renderer_host.h"

namespace feder::test {

inline ObjectId add_box(World& world, const Vec3& size, const Vec3& at, BodyType type = BodyType::dynamic,
                        const std::string& name = "") {
  BodyDesc d;
  d.name = name, d.type = type, d.position = at;
  d.shape = make_box(size[0], size[1], size[2]);
  return world.need<Rigid>().add_body(d);
}

inline ObjectId add_ground(World& world) {
  BodyDesc d;
  d.type = BodyType::fixed;
  d.shape = make_plane(vec3(0, 1, 0), 0);
  return world.need<Rigid>().add_body(d);
}

inline view::Frame collected(World& world, const view::Toggles& toggles = {}) {
  view::Collector collector;
  view::Frame frame;
  collector.collect(world, nullptr, toggles, frame);
  return frame;
}

}  // namespace feder::test
