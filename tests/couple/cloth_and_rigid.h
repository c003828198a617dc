// The systems of a world with cloth and rigid bodies.
#pragma once
#include "contact/surface_contact.h"
#include "couple/cloth_rigid.h"
#include "couple/surface_rigid.h"
#include "feder/world.h"

namespace feder {

inline const SystemDescriptor* const kClothAndRigid[] = {&Collide::descriptor(),        &Rigid::descriptor(),
                                                         &SurfaceContact::descriptor(), &SurfaceRigid::descriptor(),
                                                         &Cloth::descriptor(),          &ClothRigid::descriptor()};

}  // namespace feder
