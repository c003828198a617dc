// Tearing: an edge stretched beyond `tear_strain` splits the cloth at one of its ends. The plane through that vertex
// across the edge divides the triangles round it; each connected fan of them beyond the first gets a vertex of its own
// with the same position and velocity, so momentum is kept, and no vertex is shared by fans that meet in a point only.
// Elements are made anew; where a torn cell distributes its mass differently, mass takes its velocity along. At most
// kTearsPerStep edges tear in a step, the most strained first; allocates when it happens. Kept between steps: nothing.
#include <algorithm>

#include "cloth/impl.h"

namespace feder {
namespace {
constexpr int kTearsPerStep = 16;
}

// Adds a copy of `vertex` for the triangles of the list; returns its index within the cloth.
std::uint32_t Cloth::Impl::split_vertex(Sheet& s, std::uint32_t vertex, const std::vector<std::uint32_t>& list) {
  FEDER_ASSERT(!list.empty() && vertex < s.points && vertices.inv_mass[s.first + vertex] != 0);
  const std::uint32_t added = s.points, at = s.first + added;
  ClothVertices::each_array(vertices, [&](auto& array) {
    auto copy = array[s.first + vertex];
    array.insert(array.begin() + at, copy);
  });
  vertices.script_force[at] = Vec3::Zero();
  vertices.mass[at] = 0;  // until share_mass
  ++s.points, ++s.total;
  for (auto& o : sheets)
    if (o->first > s.first) ++o->first, ++o->version;
  for (Attachment& a : attachments)
    if (a.vertex >= at) ++a.vertex;
  for (ClothGhost& g : s.mesh.ghosts) ++g.vertex;
  for (const std::uint32_t t : list)
    for (int k = 0; k < 3; ++k) {
      std::uint32_t& v = s.mesh.triangles[3 * t + static_cast<std::uint32_t>(k)];
      if (v == vertex) v = added;
    }
  FEDER_ASSERT(s.total == s.points + s.mesh.ghosts.size() + 1);
  return added;
}

// The vertex that was split, or kNone.
std::uint32_t Cloth::Impl::tear_at(Sheet& s, std::uint32_t link, StepContext& c) {
  FEDER_ASSERT(link < s.mesh.edges.size());  // links along edges come first
  const ClothLink l = s.mesh.links[link];
  const Vec3* x = vertices.position.data() + s.first;
  const Vec3 along = x[l.b] - x[l.a];
  const Real strain = length(along) / l.rest - 1;
  for (int end = 0; end < 2; ++end) {
    const std::uint32_t v = end ? l.b : l.a;
    if (vertices.inv_mass[s.first + v] == 0) continue;
    const Vec3 middle = x[v];
    // triangles round v, and the side of the plane that they lie on
    std::vector<std::uint32_t> round, fan;
    std::vector<char> side;
    for (std::uint32_t t = 0; t < s.mesh.triangles.size() / 3; ++t) {
      const std::uint32_t* k = &s.mesh.triangles[3 * t];
      if (k[0] != v && k[1] != v && k[2] != v) continue;
      round.push_back(t);
      side.push_back(dot(x[k[0]] + x[k[1]] + x[k[2]] - 3 * middle, along) > 0);
    }
    // fans: triangles of one side that are connected over edges at v
    fan.assign(round.size(), kNone);
    std::uint32_t fans = 0;
    for (std::size_t i = 0; i < round.size(); ++i) {
      if (fan[i] != kNone) continue;
      fan[i] = fans;
      for (bool grown = true; grown;) {
        grown = false;
        for (std::size_t a = 0; a < round.size(); ++a)
          for (std::size_t b = 0; b < round.size() && fan[a] == fans; ++b) {
            if (fan[b] != kNone || side[a] != side[b]) continue;
            int common = 0;
            for (int p = 0; p < 3; ++p)
              for (int q = 0; q < 3; ++q)
                common += s.mesh.triangles[3 * round[a] + std::uint32_t(p)] ==
                          s.mesh.triangles[3 * round[b] + std::uint32_t(q)];
            if (common >= 2) fan[b] = fans, grown = true;
          }
      }
      ++fans;
    }
    FEDER_ASSERT(std::find(fan.begin(), fan.end(), kNone) == fan.end());
    if (fans < 2) continue;
    // the event, and a new vertex for each fan but the first
    const Real tension = l.stiffness * strain * l.rest;
    c.events->add({.kind = kTear, .a = s.object, .b = {}, .index = v, .point = middle, .force = tension});
    for (std::uint32_t f = 1; f < fans; ++f) {
      std::vector<std::uint32_t> list;
      for (std::size_t i = 0; i < round.size(); ++i)
        if (fan[i] == f) list.push_back(round[i]);
      split_vertex(s, v, list);
    }
    return v;
  }
  return kNone;
}

// Lumps masses anew. Mass that a vertex loses, and its momentum, go to the vertices that gain.
void Cloth::Impl::share_mass(Sheet& s) {
  const std::vector<Real> mass_before(vertices.mass.begin() + s.first, vertices.mass.begin() + s.first + s.points);
  const Real all = s.mass;
  lump_mass(s);
  FEDER_ASSERT(nearly_equal(double(s.mass), double(all)));
  Vec3 carried = Vec3::Zero();
  Real given = 0;
  for (std::uint32_t i = 0; i < s.points; ++i) {
    const Real less = mass_before[i] - vertices.mass[s.first + i];
    if (less > 0) carried += less * vertices.velocity[s.first + i], given += less;
  }
  for (std::uint32_t i = 0; i < s.points; ++i) {
    const Real more = vertices.mass[s.first + i] - mass_before[i];
    Vec3& v = vertices.velocity[s.first + i];
    if (more > 0 && given > 0) v = (mass_before[i] * v + more / given * carried) / vertices.mass[s.first + i];
  }
  for (std::uint32_t i = s.first; i < s.first + s.points; ++i)
    if (vertices.inv_mass[i] != 0) vertices.inv_mass[i] = 1 / vertices.mass[i];
}

void Cloth::Impl::tear(StepContext& c) {
  bool torn = false;
  for (auto& p : sheets) {
    Sheet& s = *p;
    if (!s.active() || !(s.settings.tear_strain < kInfinity)) continue;
    for (int n = 0; n < kTearsPerStep; ++n) {
      // the most strained edge that can split at one of its ends
      std::vector<std::pair<Real, std::uint32_t>> worst;
      const Vec3* x = vertices.position.data() + s.first;
      for (std::uint32_t k = 0; k < s.mesh.edges.size(); ++k) {
        const ClothLink& l = s.mesh.links[k];
        const Real strain = length(x[l.b] - x[l.a]) / l.rest - 1;
        if (strain > s.settings.tear_strain) worst.push_back({strain, k});
      }
      if (worst.empty()) break;
      std::sort(worst.begin(), worst.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first > b.first : a.second < b.second;
      });
      FlowBefore before_tear;
      if (s.settings.flows()) {
        before_tear.links.assign(s.mesh.links.begin(), s.mesh.links.end());
        before_tear.hinges.assign(s.mesh.hinges.begin(), s.mesh.hinges.end());
      }
      const std::uint32_t points_before = s.points;
      std::uint32_t split = kNone;
      for (std::size_t k = 0; k < worst.size() && split == kNone; ++k) split = tear_at(s, worst[k].second, c);
      if (split == kNone) break;
      torn = true;
      s.state.suspect_steps = Sheet::kSuspectSteps;
      ++s.version;
      s.paths_stale = true;
      std::vector<Vec3> rest(vertices.rest.begin() + s.first, vertices.rest.begin() + s.first + s.total);
      make_elements(s.mesh, rest, s.settings.stiffness);
      if (s.settings.flows()) keep_flow(s, before_tear, points_before, split);
      share_mass(s);
    }
  }
  if (!torn) return;
  // indices of vertices have changed: surfaces that name them are made anew in the next step
  surfaces.forget();
  *structure_changed = true;
}

}  // namespace feder
