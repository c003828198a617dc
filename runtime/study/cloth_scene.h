// Sheets of the maps of cloth. Private to the module.
#pragma once
#include "cloth/solver.h"
#include "contact/surface_contact.h"
#include "couple/cloth_rigid.h"
#include "couple/surface_rigid.h"
#include "study/worlds.h"

namespace feder {

inline Catalog cloth_catalog() {
  static const SystemDescriptor* const catalog[] = {&Collide::descriptor(),        &Rigid::descriptor(),
                                                    &SurfaceContact::descriptor(), &SurfaceRigid::descriptor(),
                                                    &Cloth::descriptor(),          &ClothRigid::descriptor()};
  return catalog;
}

// A square of 1 m with `points` by `points` vertices, level.
inline ClothDesc square_sheet(int points, double stiffness) {
  ClothDesc d;
  d.nx = d.ny = points;
  d.stretch = static_cast<Real>(stiffness);
  d.damping = Real(0.02);
  return d;
}

// The same, upright and pinned by the border `side`.
inline ClothDesc upright_sheet(int points, double stiffness, const char* side) {
  ClothDesc d = square_sheet(points, stiffness);
  d.self_collision = false;
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 2);
  d.pin_names = {side};
  return d;
}

struct HungSheet {
  ObjectId cloth, bar;
  std::size_t top, low;  // middle vertices of the upper and the lower border
};

// An upright sheet with a bar of `mass`, kg, attached to its lower border; the bar touches nothing.
inline HungSheet hang_sheet(World& w, const ClothDesc& sheet, double mass) {
  Cloth& cloth = w.need<Cloth>();
  Rigid& rigid = w.need<Rigid>();
  const auto points = static_cast<std::size_t>(sheet.nx), first = points * (points - 1);
  HungSheet out{cloth.add_cloth(sheet), {}, points / 2, first + points / 2};
  BodyDesc bar;
  bar.shape = make_box(1, Real(0.05), Real(0.05)), bar.mass = static_cast<Real>(mass), bar.group = 0;
  bar.position = cloth.point(out.cloth, out.low);
  out.bar = rigid.add_body(bar);
  for (std::size_t i = first; i < points * points; ++i)
    cloth.attach(out.cloth, i, out.bar, to_local(rigid.pose(out.bar), cloth.point(out.cloth, i)));
  return out;
}

// Length of a hung sheet along its middle, m.
inline double hung_length(const Cloth& cloth, const HungSheet& s) {
  return static_cast<double>(length(cloth.point(s.cloth, s.low) - cloth.point(s.cloth, s.top)));
}

}  // namespace feder
