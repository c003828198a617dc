// Particles of fluids against moving triangles (cloth, faces of nets): shared by the couplings with thin solids. A face
// stands for a solid of half its thickness on both sides. Two things keep a particle on its side:
//  - the screen: the density term of a face at a particle near it, as of a boundary. Without it the fluid would crowd
//  at a
//    sheet as at its free surface. It exerts no force: it is one number per particle and substep;
//  - contacts: a particle keeps half a spacing from the face. The coupling solves them with the masses of both sides,
//  by
//    equal and opposite impulses.
// So pressure reaches a sheet as the push of the layer of particles that lies on it. (Pressing on light sheets from
// inside the fluid's iterations, as on bodies, either moves the sheet away from under the fluid or, with the sheet
// fixed, exchanges impulses explicitly, which diverges as soon as the fluid is heavier: Causin, Gerbeau & Nobile 2005.)
// The side is that at the start of the substep. What the contacts leave is projected: by continuous collision detection
// of each particle's path against the faces' (geom/swept_triangle.h), so that nothing passes as long as sheets do not
// pass through themselves, however fast particles come, however light the sheet is and however it folds. Kept between
// calls: screens and origins, in the pools. Weak spot: particles between layers of a sheet that lie closer together
// than its clearance have no room.
#pragma once
#include <algorithm>

#include "bounds/box_tree.h"
#include "feder/fluid.h"
#include "feder/plan.h"
#include "fluid/pool.h"

namespace feder {

// Triangles of one object. Indices of points are those of the coupling's system.
struct FaceSurface {
  ObjectId object;
  std::uint32_t first = 0;                   // added to the indices in `triangles`
  std::span<const std::uint32_t> triangles;  // three each
  Real half = 0;                             // of the thickness, m
  std::uint32_t group = 1, mask = 0xffffffffu;
  std::uint32_t index = 0;  // of the object, for the coupling
  bool solid = false;       // nothing belongs inside
};

// Candidate contact of a particle and a face in this substep.
struct FaceContact {
  std::uint32_t pool = 0, particle = 0, surface = 0;
  std::uint32_t vertex[3] = {};
  Real weight[3] = {};         // of the nearest point, as predicted for the end of the substep
  Vec3 normal = Vec3::Zero();  // from there to the particle, to the side at the start of the substep
  Real distance = 0;           // along it, at the start of the substep, m
  Real rest = 0;               // least distance wanted, m
};

// Where a particle met a face.
struct FaceHit {
  Real weight[3] = {};           // of the face's points
  Vec3 normal = Vec3::Zero();    // to the side it started from
  Vec3 position = Vec3::Zero();  // allowed position, m
};

class FluidFaces {
 public:
  explicit FluidFaces(Arena& a) : start(&a), end(&a), contacts(&a), faces_(&a), box_(&a), tree_(a) {}

  std::vector<FaceSurface> surfaces;  // filled by the coupling; they do not change within a step
  Array<Vec3> start, end;             // by point: at the start of the substep, and predicted for its end, m
  Array<FaceContact> contacts;        // by pool and particle

  // At the start of a substep, before the fluid moves: records the origins of particles and sets their screens. Needs
  // `start`.
  void screen(Fluid& fluid, const StepContext& c);
  // After screen(): calls out(contact, FaceHit) for particles inside a solid surface, with the nearest place outside.
  template <class F>
  void expel(Fluid& fluid, const StepContext& c, F&& out) const {
    for (std::size_t n = 0; n < fluid.pool_count(); ++n) {
      FluidPool& p = fluid.pool_at(n);
      if (!p.active() || p.origin.empty() || !mark_inside(p, c)) continue;
      const auto last = p.inside.begin() + p.count;
      for (auto at = std::find(p.inside.begin(), last, 1); at != last; at = std::find(at + 1, last, 1)) {
        FaceContact k;
        FaceHit way;
        k.pool = static_cast<std::uint32_t>(n), k.particle = static_cast<std::uint32_t>(at - p.inside.begin());
        if (way_out(p, k, way)) out(k, way);
      }
    }
  }
  // After the fluid has moved: finds candidate contacts. Needs `end`.
  void find(Fluid& fluid);
  // After a coupling has moved a particle since find(): m.
  void particle_moved(Real far) { moved_ = std::max(moved_, far); }
  // Sets `end` to the true positions, and finds candidates again where points or particles differ by too much.
  template <class Point>
  void follow(Fluid& fluid, Point&& point) {
    Real far = moved_ * moved_;
    for (std::uint32_t i = 0; i < end.size(); ++i) {
      const Vec3 now = point(i), d = now - end[i];
      far = std::max(far, dot(d, d));
      end[i] = now;
    }
    if (far > allowed_ * allowed_) find(fluid);
  }
  // Non-penetration projection, after follow(): calls hit(contact, FaceHit) for particles that ended beyond a face or
  // too near to one, once each.
  template <class F>
  void project(Fluid& fluid, F&& hit) const {
    for (std::size_t n = 0, next = 0; n < contacts.size(); n = next) {
      const FaceContact& first = contacts[n];
      FEDER_ASSERT(n == 0 || contacts[n - 1].pool < first.pool || contacts[n - 1].particle < first.particle);
      for (next = n + 1; next < contacts.size(); ++next)
        if (contacts[next].pool != first.pool || contacts[next].particle != first.particle) break;
      FaceHit met;
      const FluidPool& p = fluid.pool_at(first.pool);
      const FaceContact* by =
          first_met({&first, next - n}, p.origin[first.particle].vec(), p.x[first.particle].vec(), met);
      if (by) hit(*by, met);
    }
  }
  // A particle may reach a face of this object in this step.
  static bool near(Fluid& fluid, const FaceSurface& s, std::span<const Vec3> points, const StepContext& c);
  bool near_box(const FluidPool& p, const StepContext& c) const;
  void validate() const;

 private:
  struct Face {
    std::uint32_t v[3] = {};
    std::uint32_t surface = 0;
  };
  void list_faces();
  // Marks in FluidPool::inside the particles inside a solid surface that the pool meets; false: none.
  bool mark_inside(FluidPool& p, const StepContext& c) const;
  // Of the solid surface with the smallest number around x; kNone: none is.
  std::uint32_t solid_around(const FluidPool& p, const Vec3& x) const;
  bool way_out(const FluidPool& p, FaceContact& k, FaceHit& way) const;
  void aim(FaceContact& k, const Vec3& from, const Vec3& to) const;
  // The contact with the face that a particle met first on its way from `from` to `to`, or else ends too near to; null:
  // none.
  const FaceContact* first_met(std::span<const FaceContact> of, const Vec3& from, const Vec3& to, FaceHit& hit) const;
  // As far from one point to the other as no face lies between them, but for that of `on`.
  Vec3 clear_of_others(const Vec3& from, const Vec3& to, const FaceContact* on) const;
  static bool meets(const FluidPool& p, const FaceSurface& s) {
    return (p.desc.group & s.mask) && (s.group & p.desc.mask);
  }

  Array<Face> faces_;
  Array<Aabb> box_;
  BoxTree tree_;
  Aabb solids_;       // of all solid surfaces, at the start of the substep
  Real allowed_ = 0;  // m, difference of points from `end` up to which candidates stay valid
  Real moved_ = 0;    // m, the largest of particles since
};

// Against the slip, at most as large as ends it: Coulomb. `response`: 1/kg.
inline Vec3 friction_impulse(const Vec3& slip, Real response, Real most) {
  const Real speed = length(slip);
  if (!(speed > 0) || !(most > 0)) return Vec3::Zero();
  return (-std::min(most, speed / response) / speed) * slip;
}

// The point of the triangle nearest to x, and its weights.
void nearest_weights(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, Vec3& q, Real (&w)[3]);
// Barycentric weights of the point of the plane of a, b, c nearest to x.
void plane_weights(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, Real (&w)[3]);

}  // namespace feder
