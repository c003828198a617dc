// Soft bodies against themselves: whatever finds the candidates, the same happens, and no point ends within a
// tetrahedron that it is no corner of.
#include <set>

#include "bounds/box_search.h"
#include "soft_contact.h"

namespace feder::test {
namespace {

// Points within tetrahedra of which they are no corners, of all soft bodies, by brute force; both tests for each.
struct Within {
  std::size_t points = 0, disagreements = 0;
};

Within points_within(const Soft& soft) {
  Within found;
  for (std::size_t n = 0; n < soft.soft_count(); ++n) {
    const ObjectId id = soft.info(n).object;
    for (std::size_t k = 0; k < soft.tetrahedron_count(id); ++k) {
      const auto t = soft.tetrahedron(id, k);
      Corners x;
      Aabb box;
      for (std::size_t c = 0; c < 4; ++c) x[c] = wide(soft.point(id, t[c])), box.include(soft.point(id, t[c]));
      for (std::size_t m = 0; m < soft.soft_count(); ++m) {
        const std::span<const Vec3> points = soft.info(m).points;
        for (std::uint32_t i = 0; i < points.size(); ++i) {
          if (m == n && (i == t[0] || i == t[1] || i == t[2] || i == t[3])) continue;
          if (!overlaps(box, {points[i], points[i]})) continue;
          const bool in = within_by_weights(x, wide(points[i]));
          found.points += in, found.disagreements += in != within_by_faces(x, wide(points[i]));
        }
      }
    }
  }
  return found;
}

// A strip whose ends are thrown at each other, over its middle.
ObjectId add_folding(Soft& soft, const std::string& self, double speed, bool self_collision = true) {
  SoftDesc d = soft_box(vec3(Real(1.2), Real(0.06), Real(0.12)), 40);
  d.young = Real(2e4), d.self = self, d.self_collision = self_collision;
  d.pose.position = Vec3(0, 1, 0);
  const ObjectId id = soft.add_soft(d);
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const double x = number(soft.rest_point(id, i)[0]) / 0.6;  // -1 to 1
    soft.set_velocity(id, i, vec3(static_cast<Real>(-speed * x * std::fabs(x)), static_cast<Real>(speed * x * x), 0));
  }
  return id;
}

// A closed tube of square cells along a trefoil knot on a torus of 2 m and 1 m, `width` wide.
SoftDesc trefoil(double scale, double width, std::uint32_t cells) {
  SoftDesc d;
  for (std::uint32_t n = 0; n < cells; ++n) {
    const double t = 6.283185307179586 * n / cells;
    const double c2 = std::cos(2 * t), s2 = std::sin(2 * t), c3 = std::cos(3 * t), s3 = std::sin(3 * t);
    const Double3 at{(2 + c3) * c2, (2 + c3) * s2, s3}, normal{c3 * c2, c3 * s2, s3};
    const Double3 along{-3 * s3 * c2 - 2 * (2 + c3) * s2, -3 * s3 * s2 + 2 * (2 + c3) * c2, 3 * c3};
    const Double3 side = (1 / length(cross(along, normal))) * cross(along, normal);
    for (int k = 0; k < 4; ++k) {
      const double a = (k == 1 || k == 2 ? 0.5 : -0.5) * width, b = (k >= 2 ? 0.5 : -0.5) * width;
      const Double3 p = scale * at + a * normal + b * side;
      d.points.push_back(narrow({p.x, p.z, p.y}));  // lies flat
    }
  }
  // six tetrahedra about the diagonal of each cell
  for (std::uint32_t n = 0; n < cells; ++n) {
    const auto corner = [&](int k) {  // 0..3 of this section, 4..7 of the next, as the corners of a cube by bits
      const int of[8] = {0, 1, 3, 2, 4, 5, 7, 6};
      const auto c = static_cast<std::uint32_t>(of[k]);
      return 4 * ((n + c / 4) % cells) + c % 4;
    };
    const int round[6] = {1, 3, 2, 6, 4, 5};  // the other corners, from one to the next along edges
    for (int k = 0; k < 6; ++k)
      for (const std::uint32_t v : {corner(0), corner(round[k]), corner(round[(k + 1) % 6]), corner(7)})
        d.tetrahedra.push_back(v);
  }
  return d;
}

}  // namespace

TEST_CASE("a soft body that folds onto itself does the same whatever finds its candidates", "[soft]") {
  std::set<std::uint64_t> hashes, restored;
  for (const Variant<BoxSearch>& variant : box_searches()) {
    CAPTURE(variant.name);
    World w(free_space(), catalog());
    Soft& soft = w.need<Soft>();
    add_folding(soft, variant.name, 4);
    Within most;
    std::string image;
    for (int k = 0; k < 45; ++k) {
      if (k == 30) image = w.snapshot();
      w.step();
      const Within now = points_within(soft);
      most.points = std::max(most.points, now.points), most.disagreements += now.disagreements;
    }
    CHECK(most.points == 0);
    CHECK(most.disagreements == 0);
    CHECK(w.is_finite());
    hashes.insert(w.hash());
    w.restore(image);  // without what the search had kept
    for (int k = 30; k < 45; ++k) w.step();
    restored.insert(w.hash());
  }
  CHECK(hashes.size() == 1);
  CHECK(restored == hashes);
}

TEST_CASE("the same strip runs through itself where nothing is found", "[soft]") {
  World w(free_space(), catalog());
  Soft& soft = w.need<Soft>();
  add_folding(soft, "", 4, false);
  std::size_t most = 0;
  for (int k = 0; k < 45; ++k) w.step(), most = std::max(most, points_within(soft).points);
  CHECK(most > 10);
}

TEST_CASE("a soft knot that falls and collapses has no point within another tetrahedron after 10 s", "[soft]") {
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  add_ground(w);
  SoftDesc d = trefoil(0.25, 0.08, 90);
  d.young = Real(2e4), d.self = GENERATE("", "sphere_tree");
  d.pose.position = Vec3(0, Real(0.5), 0);
  const ObjectId id = soft.add_soft(d);
  std::size_t most = 0, crossings = 0;
  double lowest = 1;
  for (int k = 0; k < 600; ++k) {
    w.step();
    if (k % 20 != 19) continue;
    const Within now = points_within(soft);
    most = std::max(most, now.points);
    CHECK(now.disagreements == 0);
    Soup skins;
    add_skins(skins, soft);
    crossings += count_crossings(skins);
    lowest = std::min(lowest, number(soft.volume(id) / soft.rest_volume(id)));
  }
  double top = 0;
  for (std::size_t i = 0; i < soft.point_count(id); ++i) top = std::max(top, number(soft.point(id, i)[1]));
  CAPTURE(d.self, top, lowest);
  CHECK(most == 0);
  CHECK(crossings == 0);
  CHECK(top < 0.3);  // of 0.58 unstrained: it lies on itself
  CHECK(lowest > 0.8);
  CHECK(w.is_finite());
}

TEST_CASE("a search of self-contact of a soft body that is not there is named", "[soft]") {
  World w(free_space(), catalog());
  SoftDesc d = soft_box(vec3(1, 1, 1), 2);
  d.self = "sphere_three";
  CHECK_THROWS_WITH(w.need<Soft>().add_soft(d), Catch::Contains("sphere_tree"));
  CHECK(w.need<Soft>().soft_count() == 0);
}

TEST_CASE("two jelly balls dropped on each other have no point within the other", "[soft]") {
  const auto searches = static_cast<int>(box_searches().size());
  const int row = GENERATE_COPY(range(0, searches));
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  add_ground(w);
  SoftDesc d;
  d.shape = make_sphere(Real(0.5)), d.young = Real(5e4), d.resolution = 6;
  d.self = box_searches()[static_cast<std::size_t>(row)].name;
  d.pose.position = vec3(0, Real(0.55), 0);
  soft.add_soft(d);
  d.pose.position = vec3(Real(0.02), Real(1.9), Real(0.01));
  soft.add_soft(d);
  std::size_t most = 0;
  for (int k = 0; k < 90; ++k) w.step(), most = std::max(most, points_within(soft).points);
  CHECK(most == 0);
}

}  // namespace feder::test
