// Input of the sums over neighbours, and the table of these functions of one kernel. Plain data: included by files
// compiled twice.
#pragma once
#include "base/simd.h"

namespace feder {

struct SweepInput {
  const WideReal* points = nullptr;     // x, y, z (m) and a weight w per particle; the one after the last lies far away
  const WideReal* velocity = nullptr;   // four numbers likewise, m/s
  const unsigned* neighbors = nullptr;  // `stride` per particle
  const unsigned* rounded = nullptr;    // number in use, in whole lanes
  unsigned stride = 0;
  WideReal inv_support = 0;  // 1/m
  WideReal soft = 0;         // m^2, keeps 1/r^2 finite
  WideReal damping = 0;      // of push_damped
  WideReal near = 0;         // of push_near: 1 / value(u) at the distance at rest
};

// Eight particles whose images particle i sees, and which see its images: gradients of a density by a position, over
// the factor of slopes. Half a kilobyte for each particle near a solid: read in order, and each sum reads only its own.
struct ImageBlock {
  Lane8x3 gradient;
  unsigned other[kLanes];
};
// Of all images that a particle sees.
struct ImageSum {
  WideReal gradient[3] = {0, 0, 0};  // by its own position
  WideReal value = 0, squares = 0;   // sum of value(u); of the squared gradients by the positions of others
};
// Images of the particles behind solids, see fluid/images.h.
struct ImageInput {
  static constexpr unsigned long kPush = 6;
  const WideReal* faces = nullptr;    // by contact: normal out of the solid, distance of its particle, m
  const unsigned* shapes = nullptr;   // by contact
  const unsigned* first = nullptr;    // contacts of a particle; one more than there are
  const WideReal* nearest = nullptr;  // by particle: least distance, m; the support where there is none
  const unsigned* counts = nullptr;   // of neighbours
  const WideReal* shares = nullptr;   // by particle: what it counts; null: one, of each
  unsigned far_face = 0, far_particle = 0;
  WideReal support = 0;               // m
  WideReal corner = 0, opposite = 0;  // cosines: up to which two planes form a corner; of normals on opposite sides
  bool moments = false;               // of the pushes are asked for
  // Blocks of a particle. Those of a call of Sweeps::images lie close together, from block_first of its first particle.
  unsigned* block_first = nullptr;
  ImageBlock* back = nullptr;   // of the others by the position of i; as well what they add to that of i by its own
  ImageBlock* there = nullptr;  // of i by the positions of the others
  unsigned* block_count = nullptr;
  ImageSum* sums = nullptr;
  WideReal* pushes = nullptr;  // by contact: the gradient by a motion of the solid, and its moment about the particle
};

// Sums over the neighbours j of the particles i in [first, last); x = x_i - x_j, g = slope(u). Four numbers per
// particle where the output is called out4.
struct Sweeps {
  void (*values)(const SweepInput&, unsigned first, unsigned last, WideReal* out);  // value(u)
  // g x, value(u); and (g u)^2
  void (*slopes)(const SweepInput&, unsigned first, unsigned last, WideReal* out4, WideReal* squares);
  void (*push)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);         // (w_i + w_j) g x
  void (*push_damped)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);  // the same, with damping
  // (w_i + w_j) g y, with y = y_i - y_j for other positions y, given instead of the velocities
  void (*push_from)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);
  // push, times the fourth power of in.near value(u): of close pairs
  void (*push_near)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);
  // g x . (v_i - v_j), positive where they approach
  void (*growth)(const SweepInput&, unsigned first, unsigned last, WideReal* out);
  void (*curl)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);    // g (v_i - v_j) cross x
  void (*climb)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);   // (w_j - w_i) g x
  void (*cohere)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);  // cohesion(u) x / u
  // values and push with the kernel of the colour field, 1 - u^2.
  void (*colors)(const SweepInput&, unsigned first, unsigned last, WideReal* out);
  void (*draw)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);
  void (*viscous)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);  // see Kernel::radial_viscosity
  // Of mixtures: w_j (g u)^2; w_j value(u); w_j times the term of cohere.
  void (*squares_by)(const SweepInput&, unsigned first, unsigned last, WideReal* out);
  void (*values_by)(const SweepInput&, unsigned first, unsigned last, WideReal* out);
  void (*cohere_by)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);
  // With the kernel of the colour field: w_j value(u); w_j g x.
  void (*colors_by)(const SweepInput&, unsigned first, unsigned last, WideReal* out);
  void (*draw_by)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);
  // The harmonic mean of w_i and w_j times the term of viscous.
  void (*viscous_by)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);
  void (*images)(const SweepInput&, const ImageInput&, unsigned first, unsigned last);  // fills its outputs
  // What images add to growth and push: the sums of their gradients with velocities and weights.
  void (*image_growth)(const SweepInput&, const ImageInput&, unsigned first, unsigned last, WideReal* out);
  void (*image_push)(const SweepInput&, const ImageInput&, unsigned first, unsigned last, WideReal* out4);
};

}  // namespace feder
