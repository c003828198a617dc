// What shapes that do not say otherwise answer.
#include "feder/shape.h"

#include "feder/error.h"

namespace feder {

Shape::Shape(const char* kind, bool convex, Real radius) : Shape(shape_kind_id(kind), convex, radius) {}

Shape::Shape(int kind_id, bool convex, Real radius)
    : kind_(shape_kinds()[static_cast<std::size_t>(kind_id)].name), kind_id_(kind_id), convex_(convex),
      radius_(radius) {}

Vec3 Shape::support(const Vec3&) const {
  FEDER_ASSERT(!"support: not a convex shape");
  return Vec3::Zero();
}

int Shape::face(const Vec3& direction, Vec3* points) const {
  points[0] = support(direction);
  return 1;
}

void Shape::triangles_in(const Aabb&, void (*)(void*, std::uint32_t), void*) const {}

ShapePtr Shape::solid(const MakeSdf&) const { return nullptr; }

const Triangle& Shape::triangle(std::uint32_t) const {
  static const Triangle none{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  return none;
}

bool Shape::volumes_at(int, bool (*)(void*, const Vec3&, const Vec3&), void*) const { return false; }
bool Shape::back_to_front(const Vec3&, void (*)(void*, std::uint32_t, std::span<const Vec3>), void*) const {
  return false;
}

std::span<const CompoundPart> Shape::parts() const { return {}; }
std::span<const ShapeSurface> Shape::surfaces() const { return {}; }

ShapeArguments Shape::arguments() const { throw SceneError(std::string("shape: this ") + kind_ + " has no arguments"); }

ShapePtr Shape::section() const { throw SceneError(std::string("shape: a ") + kind_ + " has no 2D section"); }

MassProperties transformed(const MassProperties& m, const Pose& pose) {
  const Mat3 r = to_matrix(pose.rotation);
  return {m.mass, to_world(pose, m.center), r * m.inertia * r.transpose()};
}

MassProperties combined(std::span<const MassProperties> parts) {
  MassProperties sum;
  for (const MassProperties& p : parts) sum.mass += p.mass, sum.center += p.mass * p.center;
  if (!(sum.mass > 0)) return {};
  sum.center /= sum.mass;
  // parallel axes (Steiner): I + m (d.d 1 - d d^T)
  for (const MassProperties& p : parts) {
    const Vec3 d = p.center - sum.center;
    sum.inertia += p.inertia + p.mass * (dot(d, d) * Mat3::Identity() - d * d.transpose());
  }
  return sum;
}

}  // namespace feder
