// Links over several edges: no two points of a cloth that cannot stretch are farther apart than the way along it at
// rest, however it lies. A sweep of links carries a force across a row or two; one of long links across eight, so that
// large sheets keep their size with few solver substeps. They follow edges straight on, and act from a limit on, in
// opposite directions at both ends, which keeps momentum. Kim, Chentanez and Mueller-Fischer 2012 tie vertices to
// anchors for the same end; between free vertices, Mueller 2008 has a hierarchy of meshes. Private to the module.
#pragma once
#include <span>
#include <vector>

#include "cloth/mesh.h"
#include "feder/types.h"

namespace feder {

struct LongLink {
  std::uint32_t a, b;
  Real rest;  // m, along the edges
};

// Long links of a mesh in its rest shape, from points of which no two share a link, and from all near borders; none of
// a small mesh.
std::vector<LongLink> long_links(const ClothMesh& mesh, const Vec3* rest, std::uint32_t points);

}  // namespace feder
