// Still air on a cloth: its force by triangle (forces/area.h), eight at a time, then by vertex from the triangles round
// it, in their order. Kept between calls: batches and incidences of the mesh, by its version. Private to the module.
#pragma once
#include "base/jobs.h"
#include "cloth/batch.h"
#include "cloth/mesh.h"
#include "feder/memory.h"
#include "state/surface.h"

namespace feder {

class StillAir {
 public:
  explicit StillAir(Arena& a) : batches_(&a), first_(&a), round_(&a), now_(&a), push_(&a), taken_(&a) {}
  void pick(bool wide);  // kernels as the processor has them; else plain, for tests
  struct Flow {
    const Vec3* position = nullptr;  // at the start of the step, m
    const Row4 *delta_position = nullptr, *velocity = nullptr;
    Real density = 0;         // kg/m^3
    Real most = 0;            // 1/s: a triangle stops that much of the mass of its lightest corner
    Real drag = 1, lift = 1;  // shares
  };
  // For a mesh of `points` vertices of which `spare`, beyond them, is in no triangle; does nothing for a version that
  // it has.
  void build(const ClothMesh& mesh, std::uint32_t points, std::uint32_t spare, std::uint64_t version);
  // Forces by vertex, N. Returns the largest of what a triangle asked for over what it may stop.
  Real meet(const Flow& f, Vec3* force, JobPool& jobs);

 private:
  const ClothKernels* kernels_ = &kClothKernelsPlain;
  std::uint64_t version_ = ~std::uint64_t(0);
  std::uint32_t points_ = 0, spare_ = 0;
  Array<AirBatch> batches_;
  Array<std::uint32_t> first_, round_;  // triangles round vertex i: round_[first_[i]] .. round_[first_[i + 1] - 1]
  Array<Row4> now_, push_;              // by vertex: position, m; by triangle: a third of its force, N
  Array<Real> taken_;                   // by block
};

}  // namespace feder
