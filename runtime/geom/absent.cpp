// The makers of shapes that FEDER_WITHOUT left out: scene mistakes, so that whoever can make any shape still links.
#include "base/error.h"
#include "geom/shape.h"

namespace feder {
namespace {

[[noreturn, maybe_unused]] ShapePtr absent(const char* kind) {
  throw SceneError(std::string("shape: this build has no ") + kind);
}

}  // namespace

#ifdef FEDER_WITHOUT_GEOM_SPHERE
ShapePtr make_sphere(Real) { absent("sphere"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_BOX
ShapePtr make_box(Real, Real, Real) { absent("box"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_CAPSULE
ShapePtr make_capsule(Real, Real) { absent("capsule"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_CYLINDER
ShapePtr make_cylinder(Real, Real) { absent("cylinder"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_CONE
ShapePtr make_cone(Real, Real) { absent("cone"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_HULL
ShapePtr make_hull(std::span<const Vec3>) { absent("hull"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_PLANE
ShapePtr make_plane(const Vec3&, Real) { absent("plane"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_MESH
ShapePtr make_mesh(std::span<const Vec3>, std::span<const std::uint32_t>) { absent("mesh"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_CIRCLE
ShapePtr make_circle(Real) { absent("circle"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_POLYGON
ShapePtr make_polygon(std::span<const Vec2>, Real) { absent("polygon"); }
#endif
#ifdef FEDER_WITHOUT_GEOM_COMPOUND
ShapePtr make_compound(std::vector<CompoundPart>) { absent("compound"); }
std::span<const CompoundPart> compound_parts(const Shape&) { return {}; }
#endif

}  // namespace feder
