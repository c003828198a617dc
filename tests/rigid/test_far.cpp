// Far from the origin places are so far apart that slow motion gets lost: that is said, once, by name.
#include "rigid/closed_scene.h"

using namespace feder;

TEST_CASE("motion that gets lost far from the origin is said once, by name", "[rigid][far]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const Real share = GENERATE(Real(1e-4), Real(1));  // of the place where numbers are about 1 m apart
  const bool sleeping = GENERATE(false, true);
  CAPTURE(solver, share, sleeping);
  ClosedScene s(solver);
  s.desc.sleeping = sleeping;
  const Real away = share / kEpsilon;
  BodyDesc d = body_of(make_box(1, 1, 1), Vec3(away, 0, 0));
  d.name = "lost";
  d.velocity = Vec3(0, 0, 1);
  s.rigid().add_body(d);
  d.velocity = Vec3(1, 0, 0);
  d.position = Vec3(-away, 0, 0);
  const ObjectId body = s.rigid().add_body(d);
  int warned = 0;
  std::string message;
  for (int k = 0; k < 20; ++k) {
    s.world().step();
    for (const Event& e : s.world().events().list())
      if (e.kind == EventKind::warning && s.world().events().warning_code(e) == "far")
        ++warned, message = s.world().events().warning_message(e);
  }
  const bool moved = s.rigid().pose(body).position[0] != -away;
  CHECK(moved == (share < 1));
  CHECK(warned == (share < 1 ? 0 : 1));
  if (share == 1) CHECK_THAT(message, Catch::Contains("\"lost\"") && Catch::Contains("m/s gets lost"));
}
