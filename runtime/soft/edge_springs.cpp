// Stiffnesses of springs along edges, so that together they resist strain as an isotropic material does. Lloyd, Szekely
// and Harders ("Identification of Spring Parameters for Deformable Object Simulation", TVCG 2007) compare the stiffness
// matrix of springs with that of finite elements, which for one regular tetrahedron gives all edges the same; here the
// tensors of elasticity are compared, by the star of each point. Springs of stiffness k and length L along n have the
// tensor sum k L^2 n n n n over the volume: symmetric in all indices (the relations of Cauchy), so the isotropic one
// nearest to it has lame = mu, Poisson's ratio 1/4, and any other ratio takes a force against volume beside them. With
// w = k L^2 shared by both ends of an edge, V the volume of a point and S the tensor of lame = mu = 1, it is
//   sum over points |sum w/2 n n n n - V S|^2/V -> min,  (n n n n):(m m m m) = (n.m)^4,  S:(n n n n) = 3,
// by sweeps over edges from a start that shares the volume of tetrahedra evenly. Nothing is kept. Weak spot: an edge
// gets no less than a part of its start, so the stars of rough meshes stay askew.
#include "soft/edge_springs.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "feder/error.h"
#include "soft/elasticity.h"

namespace feder {
namespace {

constexpr int kFitSweeps = 60;
constexpr double kLeastShare = 0.4;  // of the weight that an edge starts with
constexpr double kTrace = 15;        // S_iijj of lame = mu = 1
constexpr double kUniaxial = 3;      // S:(n n n n)

struct FittedEdge {
  std::uint32_t i, j;
  Double3 n;         // direction at rest
  double length, w;  // m; stiffness times length squared, m^3
};

void fit_springs(std::vector<FittedEdge>& edges, const std::vector<double>& volume) {
  // edges by point
  std::vector<std::uint32_t> first(volume.size() + 1, 0), at(2 * edges.size());
  for (const FittedEdge& e : edges) ++first[e.i + 1], ++first[e.j + 1];
  for (std::size_t p = 0; p < volume.size(); ++p) first[p + 1] += first[p];
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t k = 0; k < edges.size(); ++k) at[next[edges[k].i]++] = k, at[next[edges[k].j]++] = k;
  std::vector<double> least;
  for (const FittedEdge& e : edges) least.push_back(kLeastShare * e.w);
  for (int sweep = 0; sweep < kFitSweeps; ++sweep)
    for (std::size_t k = 0; k < edges.size(); ++k) {
      FittedEdge& e = edges[k];
      double slope = 0, curve = 0;
      for (const std::uint32_t p : {e.i, e.j}) {
        double sum = 0;
        for (std::uint32_t m = first[p]; m < first[p + 1]; ++m) {
          const double c = dot(e.n, edges[at[m]].n);
          sum += edges[at[m]].w / 2 * c * c * c * c;
        }
        slope += (sum - kUniaxial * volume[p]) / (2 * volume[p]), curve += 1 / (4 * volume[p]);
      }
      e.w = std::fmax(e.w - slope / curve, least[k]);
    }
}

}  // namespace

void SoftSprings::build(const SoftMesh& mesh, std::uint32_t points) {
  const auto corner = [](const TetrahedronPoints& t, int c) { return t[static_cast<std::size_t>(c)]; };
  const auto earlier = [](const FittedEdge& a, const FittedEdge& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; };
  const auto edge_of = [&](const TetrahedronPoints& t, const int(&pair)[2]) {
    const std::uint32_t a = corner(t, pair[0]), b = corner(t, pair[1]);
    return FittedEdge{std::min(a, b), std::max(a, b), {0, 0, 0}, 0, 0};
  };
  std::vector<FittedEdge> edges;
  for (const TetrahedronPoints& t : mesh.tetrahedra)
    for (const auto& pair : kCornerPairs) edges.push_back(edge_of(t, pair));
  std::sort(edges.begin(), edges.end(), earlier);
  edges.erase(std::unique(edges.begin(), edges.end(),
                          [](const FittedEdge& a, const FittedEdge& b) { return a.i == b.i && a.j == b.j; }),
              edges.end());
  for (FittedEdge& e : edges) {
    const Double3 d = wide(mesh.rest[e.j]) - wide(mesh.rest[e.i]);
    e.length = length(d), e.n = (1 / e.length) * d;
  }
  std::vector<double> volume(points, 0), traces(points, 0);
  cells.clear();
  for (std::size_t k = 0; k < mesh.tetrahedra.size(); ++k) {
    const TetrahedronPoints& t = mesh.tetrahedra[k];
    SoftCell c{};
    std::copy(t.begin(), t.end(), c.v);
    c.volume = mesh.volume[k];
    for (std::size_t n = 0; n < 3; ++n) {
      const Real* g = &mesh.inverse[9 * k + 3 * n];
      c.gradient[n] = Vec3(g[0], g[1], g[2]);
    }
    for (int n = 0; n < 6; ++n) {
      const auto at = std::lower_bound(edges.begin(), edges.end(), edge_of(t, kCornerPairs[n]), earlier);
      at->w += kTrace / 6 * double(c.volume);
      c.edge[n] = static_cast<std::uint32_t>(at - edges.begin());
    }
    for (const std::uint32_t i : t) volume[i] += double(c.volume) / 4;
    cells.push_back(c);
  }
  fit_springs(edges, volume);
  springs.clear();
  for (const FittedEdge& e : edges) {
    traces[e.i] += e.w / 2, traces[e.j] += e.w / 2;
    springs.push_back({e.i, e.j, static_cast<Real>(e.length), static_cast<Real>(e.w / (e.length * e.length))});
  }
  for (SoftCell& c : cells) {
    double bulk = 0;
    for (const std::uint32_t i : c.v) bulk += traces[i] / (9 * volume[i]) / 4;
    c.bulk = static_cast<Real>(bulk);
  }
}

}  // namespace feder
