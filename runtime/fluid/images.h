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
#include <span>

#include "base/jobs.h"
#include "fluid/boundary.h"

namespace feder {

struct FluidPool;

class BoundaryImages {
 public:
  explicit BoundaryImages(Arena& arena)
      : terms_(&arena), back_(&arena), first_(&arena), back_first_(&arena), of_(&arena), pushes_(&arena) {}

  // Gradient of the density ratio of one particle by the position of the other, 1/m, and the index of that other.
  struct Term {
    Real x = 0, y = 0, z = 0;
    std::uint32_t other = 0;
    Vec3 gradient() const { return {x, y, z}; }
  };
  // By particle, from all its images together.
  struct Sum {
    Vec3 gradient = Vec3::Zero();  // of its ratio by its own position, 1/m
    Real value = 0;                // of the ratio
    Real squares = 0;              // of the gradients by the positions of others, 1/m^2
  };
  // By contact: gradient of the ratio of its particle by a motion of the solid, less its sign.
  struct Push {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // 1/m; 1, about the centre of the body
  };

  // For the positions, neighbours and contacts of the pool as they are.
  void build(const FluidPool& p, const Boundary& boundary, JobPool& jobs);

  const Sum& of(std::uint32_t i) const { return of_[i]; }
  const Push& push(std::uint32_t contact) const { return pushes_[contact]; }
  // Of the ratio of i by others' positions.
  std::span<const Term> terms(std::uint32_t i) const { return {&terms_[first_[i]], first_[i + 1] - first_[i]}; }
  // Of the ratios of others by the position of i.
  std::span<const Term> back(std::uint32_t i) const {
    return {&back_[back_first_[i]], back_first_[i + 1] - back_first_[i]};
  }

 private:
  Array<Term> terms_, back_;
  Array<std::uint32_t> first_, back_first_;  // by particle; one more than there are
  Array<Sum> of_;
  Array<Push> pushes_;
};

}  // namespace feder
