// Validation: a world in which everything meets everything is in order after each step, and each kind of damage that
// can be done from outside is found. Only where asserts are on.
#include <algorithm>
#include <functional>

#include "contact/surface_contact.h"
#include "couple/fluid_parts.h"
#include "state/cloth_vertices.h"
#include "state/contact_book.h"
#include "support/aborts.h"
#include "support/catch.h"

using namespace feder;
using test::aborts;

namespace {

// Two sheets on each other, a ball and water on the upper one, a net with faces beside them with a box attached, that
// catches water too, a floor, and a sensor in the path of the water.
struct Mixed {
  World w{WorldDesc{}, mixed_catalog()};
  Cloth& cloth = w.need<Cloth>();
  Rigid& rigid = w.need<Rigid>();
  Springs& springs = w.need<Springs>();
  Fluid& fluid = w.need<Fluid>();
  ObjectId sheets[2], net, water, jet, ball, box;

  Mixed() {
    const Real d = Real(0.05);
    BodyDesc floor;
    floor.type = BodyType::fixed;
    floor.shape = make_plane(Vec3(0, 1, 0), -1);
    rigid.add_body(floor);
    for (int k = 0; k < 2; ++k) {
      ClothDesc s = square(9, k ? Real(0.5) : Real(0.6), k == 0);
      s.pose.position = Vec3(0, k ? Real(0.012) : Real(0), 0);
      sheets[k] = cloth.add_cloth(s);
    }
    BodyDesc b;
    b.shape = make_sphere(Real(0.06));
    b.mass = 1;
    b.position = Vec3(Real(0.02), Real(0.09), 0);
    ball = rigid.add_body(b);
    NetDesc n = mat(7, Real(0.6), 2, 2000);
    for (Vec3& x : n.points) x += Vec3(1, 0, 0);
    n.radius = Real(0.02);
    net = springs.add_net(n);
    for (std::size_t i = 0; i < 7; ++i) springs.pin(net, i), springs.pin(net, 42 + i);
    b.shape = make_box(Real(0.1), Real(0.1), Real(0.1));
    b.position = Vec3(1, Real(-0.3), 0);
    box = rigid.add_body(b);
    springs.attach(net, 24, box, Vec3(0, Real(0.3), 0));
    BodyDesc eye;
    eye.type = BodyType::fixed;
    eye.sensor = true;
    eye.shape = make_box(2, Real(0.3), 2);
    rigid.add_body(eye);
    FluidDesc f;
    f.spacing = d;
    water = fluid.add_fluid(f);
    fluid.fill(water, block(3, 2, 3, d, Vec3(Real(-0.1), Real(0.08), 0)), Vec3::Zero());
    fluid.fill(water, block(3, 2, 3, d, Vec3(1, Real(0.1), Real(0.1))), Vec3::Zero());
    EmitterDesc e;
    e.position = Vec3(Real(-0.1), Real(0.4), Real(0.1));
    e.radius = Real(0.06);
    jet = fluid.add_emitter(water, e);
    // each validates; the ball bounces on the sheet: to a step in which it touches
    for (int k = 0; k < 40 || (k < 200 && w.need<SurfaceRigid>().count() == 0); ++k) w.step();
  }
};

}  // namespace

TEST_CASE("what everything does to everything leaves all structures in order", "[couple][cloth][fluid][springs]") {
  Mixed m;
  CHECK(m.w.need<SurfaceRigid>().count() > 0);
  CHECK(m.w.need<SurfaceContact>().count() > 0);
  CHECK(m.w.need<FluidCloth>().count() > 0);
  CHECK(m.w.need<FluidRigid>().count() > 0);
  CHECK(m.w.need<FluidSprings>().count() > 0);
  CHECK(m.w.need<SpringsRigid>().count() > 0);
  const std::string image = m.w.snapshot();
  for (int k = 0; k < 20; ++k) m.w.step();
  m.w.restore(image);
  for (int k = 0; k < 20; ++k) m.w.step();
  m.cloth.destroy_cloth(m.sheets[0], "");
  for (int k = 0; k < 5; ++k) m.w.step();
  m.rigid.destroy_body(m.ball, ""), m.rigid.destroy_body(m.box, "");
  for (int k = 0; k < 5; ++k) m.w.step();
  m.fluid.destroy_fluid(m.water, "");
  for (int k = 0; k < 5; ++k) m.w.step();
  m.springs.destroy_net(m.net, "");
  for (int k = 0; k < 5; ++k) m.w.step();
  CHECK(m.w.is_finite());
}

TEST_CASE("validation finds damage", "[couple][cloth][fluid][springs]") {
  if (!kAsserts) return;
  Mixed m;
  Store& store = m.w.store();
  auto& vertices = store.get<ClothVertices>();
  auto& points = store.get<Particles>();
  auto& boundary = m.fluid.boundary();
  auto& surfaces = store.get<Surfaces>();
  FluidPool& pool = m.fluid.pool_at(0);
  const auto validate = [&] {
    for (const char* name :
         {"cloth", "fluid", "surface_rigid", "contact", "fluid_rigid", "fluid_cloth", "fluid_springs", "springs_rigid"})
      m.w.need_system(name).validate();
    store.get<ContactBook>().validate(m.w.objects(), m.w.events());
  };
  REQUIRE(!aborts(validate));
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const std::pair<const char*, std::function<void()>> damages[] = {
      // cloth
      {"a velocity that is no number", [&] { vertices.velocity[40][1] = nan; }},
      {"a pinned vertex with a velocity", [&] { vertices.velocity[0][0] = 1; }},
      {"an inverse mass without its mass", [&] { vertices.mass[40] *= 2; }},
      {"a vertex of another cloth", [&] { vertices.cloth[3] = m.sheets[1]; }},
      {"an array that did not grow", [&] { vertices.script_force.pop_back(); }},
      {"a cloth that is no object", [&] { m.w.objects().remove(m.sheets[0], ""); }},
      {"a row of contact on a vertex that is gone", [&] { surfaces.groups[0]->rows.emplace_back().vertex[2] = 1000; }},
      {"a row of a body that outlives its substep", [&] { surfaces.groups[0]->rows.emplace_back().contact_state = 0; }},
      {"a row of a fluid that outlives its substep", [&] { surfaces.groups[0]->rows.emplace_back(); }},
      {"a pair of cloths listed twice",
       [&] {
         surfaces.pairs.insert(surfaces.pairs.end(), 2, SurfacePair{0, 1});
       }},
      // fluid
      {"a particle twice", [&] { pool.id[3] = pool.id[7]; }},
      {"a particle lost", [&] { --pool.count, pool.put_sentinel(); }},
      {"a particle that is no number", [&] { pool.v[2].y = nan; }},
      {"a weight left over from a sweep", [&] { pool.x[5].w = 1; }},
      {"a sentinel that was pushed", [&] { pool.v[pool.count].x = 1; }},
      {"a velocity behind the watchdog's back", [&] { pool.v[4].x += 100; }},
      {"a fluid that is no object", [&] { m.w.objects().remove(m.water, ""); }},
      {"an emitter in the wrong place", [&] { m.w.objects().set_index(m.jet, 1); }},
      // couplings
      {"a wall of another body", [&] { std::swap(boundary.shapes.front().body, boundary.shapes.back().body); }},
      {"a wall that is gone", [&] { boundary.shapes.pop_back(); }},
      {"a contact with a body that is gone", [&] { m.w.objects().remove(m.ball, ""); }},
      {"a point that still has what it carried", [&] { points.inertia[24] *= 2; }},
      {"a point whose collider is another's", [&] { points.collider[10] = points.collider[11]; }},
      {"an attachment to a point that is none", [&] { points.net[24] = ObjectId{}; }},
      {"a net that lost its points", [&] { points.position.resize(0), points.net.resize(0); }},
  };
  for (const auto& [name, damage] : damages) {
    INFO(name);
    CHECK(aborts([&] { damage(), validate(); }));
  }
}
