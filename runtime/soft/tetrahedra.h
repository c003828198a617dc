// The mesh of a soft body: tetrahedra, their skin, and where its points lie unstrained. Private to the module.
#pragma once
#include <array>
#include <span>

#include "feder/memory.h"
#include "feder/soft.h"
#include "geom/tetrahedron.h"

namespace feder {

using TetrahedronPoints = std::array<std::uint32_t, 4>;

struct SoftMesh {
  explicit SoftMesh(Arena& a) : arena(a) {}

  Arena& arena;
  Array<Vec3> rest{&arena};                     // m, unstrained, local
  Array<TetrahedronPoints> tetrahedra{&arena};  // of volume above 0
  // Of what flows (plastic.cpp), nine per tetrahedron: its shape at rest now is that of `rest` times the inverse of it.
  Array<Real> flowed{&arena};
  // follow from those
  Array<std::uint32_t> skin{&arena};                  // triangles, counter-clockwise seen from outside
  Array<std::array<std::uint32_t, 2>> edges{&arena};  // of the skin
  Array<Real> inverse{&arena};            // nine per tetrahedron: columns of its edges at rest, inverted, 1/m
  Array<Real> stiffening{&arena};         // by tetrahedron, of what flows: how much more it answers than before
  Array<Real> volume{&arena};             // m^3, at rest
  std::uint32_t visible = 0;              // points up to the last one of the skin
  double rest_volume = 0, mean_edge = 0;  // m^3; m, of the skin
  double girth = 0;  // m, twice volume over area: the thickness of a plate, two thirds of a ball's radius
  // Parts are what tetrahedra connect, in the order of their first points.
  Array<std::uint32_t> part_of{&arena};      // by point
  Array<std::uint32_t> part_points{&arena};  // part after part
  Array<std::uint32_t> part_first{&arena};   // in part_points, and its size

  Corners rest_corners(std::size_t k) const {
    const TetrahedronPoints& t = tetrahedra[k];
    return {wide(rest[t[0]]), wide(rest[t[1]]), wide(rest[t[2]]), wide(rest[t[3]])};
  }
  void derive();
  void find_parts();
  void shape(std::size_t k);  // inverse and stiffening of tetrahedron k
  std::uint32_t parts() const { return static_cast<std::uint32_t>(part_first.size()) - 1; }
  std::span<const std::uint32_t> part(std::uint32_t n) const {
    return {part_points.data() + part_first[n], part_first[n + 1] - part_first[n]};
  }

  template <class M, class F>
  static void each_saved(M& m, F&& f) {
    f(m.rest), f(m.tetrahedra), f(m.flowed);
  }
};

// Fills in rest and tetrahedra. SceneError, which begins with `owner`, for what is no solid.
void make_tetrahedra(const SoftDesc& desc, const std::string& owner, SoftMesh& mesh);

}  // namespace feder
