// The systems of a world with nets, cloth and rigid bodies.
#pragma once
#include "couple/cloth_and_rigid.h"
#include "couple/springs_rigid.h"

namespace feder {

inline const SystemDescriptor* const kAllButFluid[] = {
    &Collide::descriptor(),      &Rigid::descriptor(), &Springs::descriptor(),      &SurfaceContact::descriptor(),
    &SurfaceRigid::descriptor(), &Cloth::descriptor(), &SpringsRigid::descriptor(), &ClothRigid::descriptor()};

}  // namespace feder
