// Cloths and bodies that come, change and go between steps, also while they fly at each other: nothing keeps what is
// gone. Run under asan, this reads no freed memory.
#include <cstdlib>

#include "base/rng.h"
#include "couple/cloth_and_rigid.h"
#include "state/bodies.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Lives {
  explicit Lives(std::uint64_t seed) : rng(seed), w(WorldDesc{}, kClothAndRigid) {}

  Rng rng;
  World w;
  std::vector<ObjectId> bodies, cloths;
  std::string image;

  Vec3 within(Real a) { return Vec3(rng.uniform(-a, a), rng.uniform(-a, a), rng.uniform(-a, a)); }
  std::size_t below(std::size_t n) { return rng.next() % n; }
  ObjectId some(const std::vector<ObjectId>& list) { return list[below(list.size())]; }

  void add_body() {
    BodyDesc b;
    const Real r = rng.uniform(Real(0.05), Real(0.2));
    const ShapePtr shapes[] = {make_sphere(r), make_box(r, 2 * r, r), make_capsule(r / 2, 2 * r),
                               make_compound({{make_sphere(r), {}}, {make_box(r, r, r), {Vec3(r, 0, 0), Quat{}}}})};
    b.shape = shapes[below(4)];
    b.type = below(4) ? BodyType::dynamic : BodyType::kinematic;
    b.position = within(1);
    b.velocity = within(30);
    bodies.push_back(w.need<Rigid>().add_body(b));
  }
  void add_cloth() {
    ClothDesc d;
    d.nx = 3 + static_cast<std::uint32_t>(below(4)), d.ny = 3 + static_cast<std::uint32_t>(below(4));
    d.pose.position = within(Real(0.5));
    d.self_collision = below(4) == 0;
    d.tear_strain = below(4) ? kInfinity : Real(0.3);
    d.max_substeps = 4;
    if (below(2)) d.pin_names = {"left", "right"};
    cloths.push_back(w.need<Cloth>().add_cloth(d));
  }
  void destroy(std::vector<ObjectId>& list, bool cloth) {
    const std::size_t k = below(list.size());
    if (cloth)
      w.need<Cloth>().destroy_cloth(list[k], "");
    else
      w.need<Rigid>().destroy_body(list[k], "");
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(k));
    image.clear();
  }
  void change() {
    Rigid& rigid = w.need<Rigid>();
    Cloth& cloth = w.need<Cloth>();
    const bool body = !bodies.empty(), sheet = !cloths.empty();
    switch (below(12)) {
      case 0:
      case 1:
        if (bodies.size() < 6) add_body();
        image.clear();
        break;
      case 2:
        if (cloths.size() < 3) add_cloth();
        image.clear();
        break;
      case 3:
        if (body) destroy(bodies, false);
        break;
      case 4:
        if (below(3) == 0)
          while (!bodies.empty()) destroy(bodies, false);
        break;
      case 5:
        if (sheet) destroy(cloths, true);
        break;
      case 6:
        if (body) rigid.set_type(some(bodies), below(2) ? BodyType::kinematic : BodyType::dynamic);
        break;
      case 7:
        if (body) rigid.set_velocity(some(bodies), within(40));
        break;
      case 8:
        if (body) rigid.set_pose(some(bodies), {within(1), Quat{}});
        break;
      case 9:
        if (body && sheet) {
          const ObjectId c = some(cloths);
          cloth.attach(c, below(cloth.vertex_count(c)), some(bodies), within(Real(0.1)));
          image.clear();
        }
        break;
      case 10:
        if (sheet) cloth.sleep(some(cloths));
        break;
      default:
        if (image.empty()) {
          image = w.snapshot();
          break;
        }
        try {
          w.restore(image);
        } catch (const SceneError&) {
          image.clear();  // of other objects
        }
    }
  }
};

void live(std::uint64_t seed, int operations) {
  Lives l(seed);
  l.add_cloth(), l.add_body();
  for (int k = 0; k < operations; ++k) {
    l.change();
    if (l.below(3) == 0) l.w.step();
  }
  CHECK(l.w.step_count() > 0);
}

}  // namespace

TEST_CASE("bodies that go while they fly at a sheet are not asked for again", "[couple][cloth]") {
  World w(WorldDesc{}, kClothAndRigid);
  ClothDesc d;
  d.nx = d.ny = 9;
  d.pin_names = {"left", "right"};
  const ObjectId id = w.need<Cloth>().add_cloth(d);
  BodyDesc b;
  b.shape = make_sphere(Real(0.1));
  b.position = Vec3(0, Real(0.5), 0);
  b.velocity = Vec3(0, -20, 0);
  const ObjectId body = w.need<Rigid>().add_body(b);
  for (int k = 0; k < 3; ++k) w.step();
  w.need<Rigid>().destroy_body(body, "");
  for (int k = 0; k < 10; ++k) w.step();
  CHECK(w.is_finite());
  CHECK(w.need<Cloth>().max_strain(id) < 1);
}

TEST_CASE("cloths and bodies come and go at random", "[couple][cloth]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) live(seed, 150);
}

TEST_CASE("cloths and bodies come and go a million times", "[.][map]") {
  const char* given = std::getenv("FEDER_LIVES");
  const int rounds = given ? std::atoi(given) : 2000;
  for (int seed = 1; seed <= rounds; ++seed) live(1000 + static_cast<std::uint64_t>(seed), 500);
}
