// Fracture, once per step, by Rankine's criterion: the largest principal stress at a point, the mean of the Cauchy
// stresses of the tetrahedra round it by volume, exceeds `fracture_stress`. In each part a crack begins where it does
// so most, in the plane across that stress (O'Brien and Hodgins 1999), and runs on through the points beside it that
// are pulled as much across the same plane: it divides the tetrahedra round each of them (Mueller, McMillan, Dorsey and
// Jagnow 2001). One crack in a part and a step, since it unloads what lies beside it. Each lot of tetrahedra that faces
// connect gets a point of its own, with the same place and velocity, so mass and momentum are kept; so do lots at the
// points round it that hang together by an edge or a point alone. Pins and attachments stay with the largest lot.
// Crumbs, parts of fewer than kCrumb tetrahedra, stay whole. Points keep their numbers, new ones come last. Allocates
// when it happens. Kept between steps: nothing. Weak spot: cracks run between tetrahedra, so their faces are as rough
// as the mesh.
#include <algorithm>
#include <cmath>

#include "soft/impl.h"

namespace feder {
namespace {

constexpr std::uint32_t kCrumb = 24;
constexpr double kFlat = 1e-3;  // of its volume: what is squeezed to less is not torn

// V sigma = V0 P F^T
void add_stress(const SoftBody& b, std::size_t k, StressSum& to) {
  const Mat3d f = b.gradient(k, b.position);
  const double j = determinant(f), rest = double(b.mesh.volume[k]);
  if (!(j > kFlat)) return;
  to.stress.noalias() += (rest * b.share) * (b.law->stress(b.material, f) * f.transpose());
  to.volume += rest * j;
}

Tension largest(const StressSum& s) {
  Tension t;
  if (!(s.volume > 0)) return t;
  double scale = 0;  // in units of the largest entry, so that float does
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) scale = std::fmax(scale, std::fabs(s.stress(i, j)));
  if (!(scale > 0)) return t;
  Mat3 unit;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) unit(i, j) = static_cast<Real>((s.stress(i, j) + s.stress(j, i)) / (2 * scale));
  Vec3 values;
  Mat3 vectors;
  eigen_symmetric(unit, values, vectors);
  t.stress = double(values[2]) * scale / s.volume;
  t.across = vectors.col(2);
  return t;
}

// Along a direction, Pa.
double pulled(const StressSum& s, const Vec3& along) {
  const Vec3d a = along.cast<double>();
  const Vec3d to = s.stress * a;
  return s.volume > 0 ? (a[0] * to[0] + a[1] * to[1] + a[2] * to[2]) / s.volume : 0;
}

bool has(const TetrahedronPoints& t, std::uint32_t i) { return std::find(t.begin(), t.end(), i) != t.end(); }

int common_points(const TetrahedronPoints& a, const TetrahedronPoints& b) {
  int n = 0;
  for (const std::uint32_t i : a) n += has(b, i);
  return n;
}

// Tetrahedra round a point, in lots that faces at the point connect.
struct Round {
  std::vector<std::uint32_t> tetrahedra, lot;
  std::uint32_t lots = 0, largest = 0;

  template <class Side>
  Round(const SoftMesh& m, std::uint32_t i, Side&& side) {
    std::vector<bool> of_side;
    for (std::uint32_t k = 0; k < m.tetrahedra.size(); ++k)
      if (has(m.tetrahedra[k], i)) tetrahedra.push_back(k), of_side.push_back(side(k));
    lot.assign(tetrahedra.size(), kNone);
    std::vector<std::size_t> open;
    double most = 0;
    for (std::size_t first = 0; first < lot.size(); ++first) {
      if (lot[first] != kNone) continue;
      double volume = 0;
      lot[first] = lots, open = {first};
      while (!open.empty()) {
        const std::size_t a = open.back();
        open.pop_back();
        volume += double(m.volume[tetrahedra[a]]);
        for (std::size_t c = 0; c < lot.size(); ++c)
          if (lot[c] == kNone && of_side[c] == of_side[a] &&
              common_points(m.tetrahedra[tetrahedra[a]], m.tetrahedra[tetrahedra[c]]) >= 3)
            lot[c] = lots, open.push_back(c);
      }
      if (volume > most) most = volume, largest = lots;
      ++lots;
    }
  }
};

// Faces at point i between lots, their area, a third of each, m^2.
double separated_area(const SoftBody& b, std::uint32_t i, const Round& r) {
  double sum = 0;
  for (std::size_t p = 0; p < r.lot.size(); ++p)
    for (std::size_t q = p + 1; q < r.lot.size(); ++q) {
      const TetrahedronPoints &s = b.mesh.tetrahedra[r.tetrahedra[p]], &t = b.mesh.tetrahedra[r.tetrahedra[q]];
      if (r.lot[p] == r.lot[q] || common_points(s, t) != 3) continue;
      Double3 e[2] = {{0, 0, 0}, {0, 0, 0}};
      std::size_t n = 0;
      for (const std::uint32_t j : s)
        if (j != i && has(t, j) && n < 2) e[n++] = wide(b.position[j]) - wide(b.position[i]);
      sum += length(cross(e[0], e[1])) / 6;
    }
  return sum;
}

// A point of its own for each lot but the largest; the first of them, or kNone.
std::uint32_t divide(SoftBody& b, std::uint32_t i, const Round& r) {
  std::uint32_t first = kNone;
  for (std::uint32_t lot = 0; lot < r.lots; ++lot) {
    if (lot == r.largest) continue;
    const std::uint32_t added = b.size();
    if (first == kNone) first = added;
    b.mesh.rest.push_back(Vec3(b.mesh.rest[i]));
    for (Array<Vec3>* a : {&b.position, &b.velocity, &b.contact, &b.steady_contact, &b.began})
      a->push_back(Vec3((*a)[i]));
    b.script_force.push_back(Vec3::Zero());
    b.mass.push_back(0), b.inv_mass.push_back(1);  // until share_mass
    for (std::size_t n = 0; n < r.lot.size(); ++n)
      if (r.lot[n] == lot)
        for (std::uint32_t& j : b.mesh.tetrahedra[r.tetrahedra[n]])
          if (j == i) j = added;
  }
  return first;
}

}  // namespace

Tension SoftBody::tension(std::uint32_t i) const {
  StressSum sum;
  for (std::size_t k = 0; k < mesh.tetrahedra.size(); ++k)
    if (has(mesh.tetrahedra[k], i)) add_stress(*this, k, sum);
  return largest(sum);
}

void Soft::Impl::fracture(SoftBody& b) {
  stress.assign(b.size(), StressSum{});
  const double limit = double(b.settings.fracture_stress);
  for (std::size_t k = 0; k < b.mesh.tetrahedra.size(); ++k) {
    StressSum own;
    add_stress(b, k, own);
    for (const std::uint32_t i : b.mesh.tetrahedra[k]) stress[i].stress += own.stress, stress[i].volume += own.volume;
  }
  torn.clear();
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    // no principal stress exceeds the root of the sum of squares
    if (!(stress[i].stress.squaredNorm() > limit * limit * stress[i].volume * stress[i].volume)) continue;
    const Tension t = largest(stress[i]);
    if (t.stress > limit) torn.push_back({t, i});
  }
  if (torn.empty()) return;
  std::sort(torn.begin(), torn.end(), [](const auto& p, const auto& q) {
    return p.first.stress != q.first.stress ? p.first.stress > q.first.stress : p.second < q.second;
  });
  struct Split {
    std::uint32_t point, added;
    double force;
  };
  std::vector<Split> splits;
  std::vector<std::uint32_t> size(b.mesh.parts(), 0);  // tetrahedra of each part
  for (const TetrahedronPoints& t : b.mesh.tetrahedra) ++size[b.mesh.part_of[t[0]]];
  std::vector<bool> seen(b.size(), false), cracked(b.mesh.parts(), false);
  std::vector<std::uint32_t> front, beside;
  const auto none = [](std::uint32_t) { return false; };
  for (const auto& [tension, start] : torn) {
    const std::uint32_t part = b.mesh.part_of[start];
    if (cracked[part] || (size.size() > 1 && size[part] < kCrumb)) continue;
    const Vec3 across = tension.across, at = b.position[start];
    const auto beyond = [&](std::uint32_t k) {
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t j : b.mesh.tetrahedra[k]) sum += b.position[j] - at;
      return dot(sum, across) > 0;
    };
    front = {start};
    while (!front.empty()) {
      const std::uint32_t i = front.back();
      front.pop_back();
      const Round round(b.mesh, i, beyond);
      if (round.lots < 2) continue;
      beside.clear();
      for (const std::uint32_t k : round.tetrahedra)
        for (const std::uint32_t j : b.mesh.tetrahedra[k])
          if (j != i && std::find(beside.begin(), beside.end(), j) == beside.end()) beside.push_back(j);
      const double area = separated_area(b, i, round);
      splits.push_back({i, divide(b, i, round), pulled(stress[i], across) * area});
      cracked[part] = true;
      for (const std::uint32_t j : beside) {
        if (const Round left(b.mesh, j, none); left.lots > 1) divide(b, j, left);
        if (j >= seen.size() || seen[j]) continue;
        seen[j] = true;
        if (pulled(stress[j], across) > limit) front.push_back(j);
      }
    }
  }
  if (splits.empty()) return;
  b.share_mass();
  for (std::uint32_t i = 0; i < b.size(); ++i)
    if (b.inv_mass[i] != 0) b.inv_mass[i] = 1 / b.mass[i];
  b.derive();
  for (const Split& s : splits)
    events.add({.kind = kFracture,
                .a = b.object,
                .b = {},
                .index = s.point,
                .point = b.position[s.point],
                .force = static_cast<Real>(s.force),
                .part = b.mesh.part_of[s.added]});
  // points have changed: surfaces that name them are made anew in the next step
  surfaces.forget();
  *structure_changed = true;
}

}  // namespace feder
