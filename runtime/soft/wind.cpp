// Wind on the skin of soft bodies: pressure along and across the normal of each triangle that looks into it
// (forces/area.h), a third to each corner. A sphere has .67 of the drag of its cross-section, a cube across the flow
// all of it. Weak spot: no shadow of other bodies, no suction behind, and still air does nothing.
#include <algorithm>

#include "forces/area.h"
#include "forces/forces.h"
#include "soft/impl.h"

namespace feder {
namespace {
constexpr Real kAlong = Real(0.01);  // sine of the angle between them
}

void Soft::Impl::add_wind(const SoftBody& b, const Force& wind, double time, Real h) {
  const std::uint32_t first = surfaces.list[b.surface].first;
  const Array<std::uint32_t>& skin = b.mesh.skin;
  const auto place = [&](std::uint32_t i) {
    return Vec3(surfaces.position[first + i] + surfaces.delta_position[first + i].vec());
  };
  const auto twice_area = [&](const std::uint32_t* v) {
    const Vec3 a = place(v[0]);
    return cross(Vec3(place(v[1]) - a), Vec3(place(v[2]) - a));
  };
  skin_area.assign(b.size(), Real(0));
  for (std::size_t t = 0; t < skin.size(); t += 3)
    for (int k = 0; k < 3; ++k) skin_area[skin[t + std::size_t(k)]] += Real(0.5) * length(twice_area(&skin[t]));
  const Real share = store.get<Forces>().drag_share() / h;
  for (std::size_t t = 0; t < skin.size(); t += 3) {
    const std::uint32_t* v = &skin[t];
    const Vec3 twice = twice_area(v);
    MassPoint p{};  // one square metre
    p.area = 1, p.mass = kInfinity;
    for (int k = 0; k < 3; ++k) {
      p.position += place(v[k]) / 3, p.velocity += surfaces.velocity[first + v[k]].vec() / 3;
      p.mass = std::min(p.mass, b.mass[v[k]] / skin_area[v[k]]);
    }
    if (!(p.mass < kInfinity)) continue;  // without area
    p.most_drag = share * p.mass;
    Vec3 full = Vec3::Zero();
    wind.add(&p, 1, time, &full);
    // in the lee, or along the wind as far as rounding tells
    if (!(dot(full, twice) < -kAlong * length(full) * length(twice))) continue;
    const Vec3 third = area_force(full, twice, {}) / 3;
    for (int k = 0; k < 3; ++k) forces[v[k]] += third;
  }
}

}  // namespace feder
