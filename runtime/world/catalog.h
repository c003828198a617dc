// All systems of this build, in the order of their modules: what couples comes after what it couples. In a library of
// its own (feder::catalog), because it links them all; a host that wants fewer gives World a list of its own.
#pragma once
#include "step/system.h"

namespace feder {

Catalog catalog();

}  // namespace feder
