// Particles of fluids against triangles that move (cloth, faces of nets): what the couplings with thin things share.
// A face stands for a solid of half its thickness on both sides. Two things keep a particle on its side:
//  - the screen: what a face near a particle adds to its density, as if it were a wall. Without it the fluid would
//    crowd at a sheet as at its free surface. It pushes nobody: it is one number per particle and substep;
//  - contacts: a particle keeps half a spacing from the face. The coupling solves them with the masses of both sides,
//    so what one side gets the other gives.
// So pressure reaches a sheet as the push of the layer of particles that lies on it. (Pressing on light sheets from
// inside the fluid's iterations, as on bodies, either moves the sheet away from under the fluid or, with the sheet
// held, exchanges impulses explicitly, which diverges as soon as the fluid is heavier: Causin, Gerbeau & Nobile 2005.)
// The side is that of the substep's start, contacts and guard look along the way since. Weak spot: where particles come
// with several spacings in a substep and fold the faces over each other, some find a gap: of 1500 in a jet on a pinned
// sheet of 0.2 kg/m2 with cells of three spacings, 1 to 3 at 20 to 30 m/s and 11 to 41 at 40 to 80 m/s; none up to
// 50 m/s at 0.5 kg/m2.
#pragma once
#include "bounds/box_tree.h"
#include "feder/fluid.h"
#include "feder/plan.h"
#include "fluid/pool.h"

namespace feder {

// Triangles of one thing. Points are numbered in arrays of the coupling's system.
struct FaceSurface {
  ObjectId object;
  std::uint32_t first = 0;                   // added to the numbers in `triangles`
  std::span<const std::uint32_t> triangles;  // three each
  Real half = 0;                             // of the thickness, m
  std::uint32_t group = 1, mask = 0xffffffffu;
  std::uint32_t index = 0;  // of the thing, for the coupling
};

// A particle that may touch a face in this substep.
struct FaceContact {
  std::uint32_t pool = 0, particle = 0, surface = 0;
  std::uint32_t vertex[3] = {};
  Real weight[3] = {};         // of the nearest point, at the start of the substep
  Vec3 normal = Vec3::Zero();  // from there to the particle, then
  Real distance = 0;           // then, m
  Real rest = 0;               // wanted at least, m
};

// Where a particle was caught.
struct FaceHit {
  Real when = 2;
  Real weight[3] = {};           // of the face's points
  Vec3 normal = Vec3::Zero();    // to the side it began on
  Vec3 position = Vec3::Zero();  // where it may be, m
};

class FluidFaces {
 public:
  explicit FluidFaces(Arena& a) : start(&a), end(&a), contacts(&a), faces_(&a), box_(&a), tree_(a) {}

  std::vector<FaceSurface> surfaces;  // filled by the coupling; they do not change within a step
  Array<Vec3> start, end;       // by point: at the start of the substep, and where it will be (as far as known), m
  Array<FaceContact> contacts;  // by pool and particle

  // At the start of a substep, before the fluid moves: notes where particles are and sets their screens. `start` is
  // filled.
  void screen(Fluid& fluid, const StepContext& c);
  // After the fluid has moved: who may touch whom. `end` is filled.
  void find(Fluid& fluid);
  // Points came to other places than `end` said: corrects it, and lists anew who may touch whom where that matters.
  template <class Point>
  void follow(Fluid& fluid, Point&& point) {
    Real far = 0;
    for (std::uint32_t i = 0; i < end.size(); ++i) {
      const Vec3 now = point(i), d = now - end[i];
      far = std::max(far, dot(d, d));
      end[i] = now;
    }
    if (far > allowed_ * allowed_) find(fluid);
  }
  // Calls hit(contact, FaceHit) for particles that ended beyond a face or too near, once each: the first face they
  // passed. `point(i)`: where points are now.
  template <class Point, class F>
  void project(Fluid& fluid, Point&& point, F&& hit) const {
    for (std::size_t n = 0; n < contacts.size();) {
      const FaceContact& first = contacts[n];
      FEDER_ASSERT(n == 0 || contacts[n - 1].pool < first.pool || contacts[n - 1].particle < first.particle);
      const FluidPool& p = fluid.pool_at(first.pool);
      const FaceContact* by = nullptr;
      FaceHit best;
      for (; n < contacts.size() && contacts[n].pool == first.pool && contacts[n].particle == first.particle; ++n) {
        const FaceContact& k = contacts[n];
        const Vec3 now[3] = {point(k.vertex[0]), point(k.vertex[1]), point(k.vertex[2])};
        FaceHit h;
        if (!caught(k, p.origin[k.particle].vec(), p.x[k.particle].vec(), now, h)) continue;
        if (!by || h.when < best.when) by = &k, best = h;
      }
      if (by) hit(*by, best);
    }
  }
  // Is any particle within `margin` of a face of this thing, where `start` is?
  bool near(Fluid& fluid, const FaceSurface& s, Real margin) const;
  // Did the particle, going from its origin to `to` while the face went from `start` to `now`, pass it, or does it end
  // too near to it? Then `when` (0 to 1, 2: did not pass) and where it has to be.
  bool caught(const FaceContact& k, const Vec3& from, const Vec3& to, const Vec3 (&now)[3], FaceHit& hit) const;
  void validate() const;

 private:
  struct Face {
    std::uint32_t v[3] = {};
    std::uint32_t surface = 0;
  };
  void list_faces();
  static bool meets(const FluidPool& p, const FaceSurface& s) {
    return (p.desc.group & s.mask) && (s.group & p.desc.mask);
  }

  Array<Face> faces_;
  Array<Aabb> box_;
  BoxTree tree_;
  Real allowed_ = 0;  // m, by which points may miss `end` before lists are made anew
};

// Barycentric weights of the point of the plane of a, b, c nearest to x.
void plane_weights(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, Real (&w)[3]);

}  // namespace feder
