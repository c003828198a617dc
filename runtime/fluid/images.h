// Boundary terms of densities by images (ghost particles: Colagrossi & Landrini, JCP 191, 2003): behind a solid lies
// the mirror image of each particle that the kernel reaches there, the particle's own too, with the weight of the
// original. Two particles at distances s and t from the solid see the image of the other at
//   r^2 = |x_i - x_j|^2 + 4 s t,
// exactly so at a plane. With each particle's own distance, not that from the tangent plane of the other, this is
// smooth and symmetric beside any convex solid: the density of i is a function of the positions of fluid and solid
// alone, the gradients here are its exact ones, and forces that follow from them keep momentum and energy. (Images
// behind the tangent plane of i come and go where it sweeps over neighbours: still water at a box boiled at 0.1 m/s.)
// Against a boundary that is a function of the distance (BoundaryTable), pressure that varies along the boundary acts
// in full on the particles beside it: with the table the layer at the boundary gets six tenths of it, lags behind the
// flow and brakes it. Where two planes meet, across or steeply, the image of the image fills the corner likewise.
// Rebuilt wherever the particles have moved. Weak spots: at convex edges images fill more than the solid; planes that
// meet at a blunt angle count twice; three planes that meet leave the outermost eighth of the kernel empty.
#pragma once
#include "base/jobs.h"
#include "fluid/boundary.h"
#include "sph/sweep_table.h"

namespace feder {

struct FluidPool;

class BoundaryImages {
 public:
  explicit BoundaryImages(Arena& arena);

  // By contact: gradient of the ratio of its particle by a motion of the solid, less its sign.
  struct Push {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // 1/m; 1, about the centre of the body, where that may turn
  };

  // For the positions, neighbours and contacts of the pool as they are.
  void build(const FluidPool& p, const Boundary& boundary, JobPool& jobs);

  // For Sweeps::image_growth and image_push; their sums lack the factor of slopes.
  const ImageInput& input() const { return input_; }
  // Of particle i, from all its images together: its density ratio; the gradient of that by its own position, 1/m; the
  // squared gradients by the positions of others, 1/m^2.
  Real value(std::uint32_t i) const { return value_factor_ * sums_[i].value; }
  Vec3 gradient(std::uint32_t i) const {
    const WideReal* g = sums_[i].gradient;
    return slope_factor_ * Vec3(g[0], g[1], g[2]);
  }
  Real squares(std::uint32_t i) const { return slope_factor_ * slope_factor_ * sums_[i].squares; }
  const Push& push(std::uint32_t contact) const { return pushes_[contact]; }

 private:
  // As rows of ImageInput::faces.
  struct Face {
    Real x = 0, y = 0, z = 0, distance = 0;
  };
  void place_faces(const FluidPool& p, const Boundary& boundary, JobPool& jobs);

  Real value_factor_ = 0, slope_factor_ = 0;
  ImageInput input_;
  Array<Face> faces_;  // by contact, and one far away
  Array<std::uint32_t> shapes_;
  Array<Real> moved_;  // by contact: ImageInput::pushes
  Array<Push> pushes_;
  Array<Real> nearest_;  // by particle, these four
  Array<std::uint32_t> block_first_, block_count_;
  Array<ImageSum> sums_;
  Array<ImageBlock> back_, there_;
};

}  // namespace feder
