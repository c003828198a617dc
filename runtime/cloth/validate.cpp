// Validation of cloths after a step: vertices, meshes, batches of the solvers, ties and attachments, each visited
// once, in time proportional to their size. That a list contains each element of another once is checked by the hash of
// a multiset, a sum that does not depend on the order (Bellare and Micciancio 1997). Kept between calls: marks by
// vertex, so that a step allocates nothing.
#include <algorithm>
#include <bit>

#include "cloth/batches.h"
#include "cloth/impl.h"

namespace feder {
namespace {

std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ x >> 27) * 0x94d049bb133111ebull;
  return x ^ x >> 31;
}
std::uint64_t mixed(std::uint32_t a, std::uint32_t b) { return mixed((std::uint64_t(a) << 32 | b) + 1); }
std::uint64_t link_key(std::uint32_t a, std::uint32_t b, Real rest) {
  return mixed(mixed(a, b) + std::bit_cast<std::uint64_t>(static_cast<double>(rest)));
}
std::uint64_t hinge_key(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return mixed(mixed(a, b) + 3 * mixed(c, d));
}

struct Elements {
  std::uint64_t sum = 0;  // of their keys
  std::size_t count = 0;
};

// Colours cover all batches in order; a lane is an element or empty; no two elements of a colour share a vertex.
// end(batch, k, lane) is the k-th vertex of an element.
template <int kEnds, class Batches, class Colors, class End, class Key>
Elements walk_colors(const Batches& batches, const Colors& colors, std::uint32_t spare, Array<std::uint64_t>& marks,
                     End&& end, Key&& key) {
  Elements all;
  std::fill(marks.begin(), marks.end(), 0);
  std::size_t next = 0;
  std::uint64_t color = 0;
  for (const auto& c : colors) {
    FEDER_ASSERT(c.first == next && c.last > c.first && c.last <= batches.size());
    next = c.last, ++color;
    for (unsigned n = c.first; n < c.last; ++n)
      for (int i = 0; i < kLanes; ++i) {
        const auto& b = batches[n];
        const bool empty = end(b, 0, i) == spare;
        for (int k = 0; k < kEnds; ++k) {
          const unsigned v = end(b, k, i);
          FEDER_ASSERT(v <= spare && (v == spare) == empty);
          FEDER_ASSERT(empty || marks[v] != color);  // a vertex twice in a colour
        }
        if (empty) continue;
        for (int k = 0; k < kEnds; ++k) marks[end(b, k, i)] = color;
        all.sum += key(b, i), ++all.count;
      }
  }
  FEDER_ASSERT(next == batches.size());
  return all;
}

}  // namespace

void ClothBatches::validate(const ClothView& v) const {
  if (version_ != v.version || rests_ != v.rests) return;  // torn or flowed in this step: built anew in the next
  const std::uint32_t spare = v.total - 1;
  FEDER_ASSERT(used_.size() == v.total);
  const Elements links = walk_colors<2>(
      links_, link_colors_, spare, used_, [](const LinkBatch& b, int k, int i) { return k ? b.b[i] : b.a[i]; },
      [](const LinkBatch& b, int i) { return link_key(b.a[i], b.b[i], b.rest.v[i]); });
  std::uint64_t sum = 0;
  for (const ClothLink& l : v.mesh->links) sum += link_key(l.a, l.b, l.rest);
  FEDER_ASSERT(links.count == v.mesh->links.size());
  FEDER_ASSERT(links.sum == sum);  // each link of the mesh is in one lane

  const Elements hinges = walk_colors<4>(
      hinges_, hinge_colors_, spare, used_, [](const HingeBatch& b, int k, int i) { return b.v[k][i]; },
      [](const HingeBatch& b, int i) { return hinge_key(b.v[0][i], b.v[1][i], b.v[2][i], b.v[3][i]); });
  sum = 0;
  for (const ClothHinge& h : v.mesh->hinges) sum += hinge_key(h.v[0], h.v[1], h.v[2], h.v[3]);
  FEDER_ASSERT(hinges.count == v.mesh->hinges.size());
  FEDER_ASSERT(hinges.sum == sum);
  FEDER_ASSERT(damping_.empty() || damping_.size() == hinges_.size());
}

// Triangles, edges of both of them, links and hinges name each other and visible vertices; each vertex has a triangle.
void Cloth::Impl::validate_mesh(const Sheet& s) const {
  const ClothMesh& m = s.mesh;
  FEDER_ASSERT(m.triangles.size() % 3 == 0 && s.total == s.points + m.ghosts.size() + 1);
  for (std::size_t t = 0; t < m.triangles.size(); t += 3) {
    const std::uint32_t* v = &m.triangles[t];
    FEDER_ASSERT(std::max({v[0], v[1], v[2]}) < s.points && v[0] != v[1] && v[1] != v[2] && v[2] != v[0]);
    for (int k = 0; k < 3; ++k) marks[s.first + v[k]] = s.object.slot;
  }
  for (std::uint32_t i = 0; i < s.points; ++i) FEDER_ASSERT(marks[s.first + i] == s.object.slot);

  std::size_t sides = 0;
  FEDER_ASSERT(m.links.size() >= m.edges.size());
  for (std::size_t k = 0; k < m.edges.size(); ++k) {
    const ClothEdge& e = m.edges[k];
    FEDER_ASSERT(e.a < e.b && e.b < s.points);
    FEDER_ASSERT(k == 0 || m.edges[k - 1].a < e.a || (m.edges[k - 1].a == e.a && m.edges[k - 1].b < e.b));
    FEDER_ASSERT(m.links[k].a == e.a && m.links[k].b == e.b);
    for (int j = 0; j < 2; ++j) {
      if (j == 1 && e.triangle[1] == kNone) break;
      FEDER_ASSERT(e.triangle[j] < m.triangles.size() / 3);
      const std::uint32_t* v = &m.triangles[3 * e.triangle[j]];
      // its corners are the ends of the edge and the opposite vertex
      FEDER_ASSERT(std::count(v, v + 3, e.a) + std::count(v, v + 3, e.b) + std::count(v, v + 3, e.opposite[j]) == 3);
      ++sides;
    }
  }
  FEDER_ASSERT(sides == m.triangles.size());  // each side of a triangle is one of an edge
  for (std::size_t k = m.edges.size(); k < m.links.size(); ++k)
    FEDER_ASSERT(m.links[k].shear && m.links[k].a < m.links[k].b && m.links[k].b < s.points);
  for (const ClothHinge& h : m.hinges)
    FEDER_ASSERT(std::max({h.v[0], h.v[1], h.v[2], h.v[3]}) + 1 < s.total && h.v[0] != h.v[1]);
  for (std::size_t k = 0; k < m.ghosts.size(); ++k)
    FEDER_ASSERT(m.ghosts[k].vertex == s.points + k && std::max(m.ghosts[k].clamped, m.ghosts[k].inner) < s.points);
}

void Cloth::Impl::validate_motion(const Sheet& s) const {
  FEDER_ASSERT(!s.state.asleep || !s.state.frozen);
  FEDER_ASSERT(!s.state.asleep || s.flight().isZero(0));
  FEDER_ASSERT(s.state.substeps >= 1 && !(s.state.load < 0));
  // a tear redistributes mass and velocities: numbers that overflow there are found in the next step
  const bool settled = s.active() && !s.paths_stale;
  Real mass = 0;
  for (std::uint32_t i = s.first; i < s.first + s.total; ++i) {
    const Real w = vertices.inv_mass[i];
    FEDER_ASSERT(vertices.cloth[i] == s.object);
    FEDER_ASSERT(w == 0 || !s.state.frozen);
    // a tear may give a share of velocity even to pinned vertices
    const bool may_move = s.active() && (w != 0 || (s.settings.tear_strain < kInfinity && vertices.mass[i] > 0));
    FEDER_ASSERT(may_move || vertices.velocity[i].isZero(0));  // pinned, hidden, held, asleep
    if (i >= s.first + s.points) {
      FEDER_ASSERT(w == 0 && vertices.mass[i] == 0);
      continue;
    }
    FEDER_ASSERT(!(w > 0) || w == 1 / vertices.mass[i]);
    FEDER_ASSERT(!settled || (is_finite(vertices.position[i]) && is_finite(vertices.velocity[i])));
    mass += vertices.mass[i];
  }
  FEDER_ASSERT(!is_finite(mass) || mass == s.mass);
}

// Lanes are free vertices, once in a layer, and their anchors pinned ones; ties to bodies name visible vertices.
void Cloth::Impl::validate_ties(const Sheet& s) const {
  const ClothTies& t = s.ties;
  FEDER_ASSERT(t.anchor.size() == t.batches.size() * kLanes && t.rest.size() == t.anchor.size());
  FEDER_ASSERT(t.layers.empty() ? t.batches.empty() : t.layers.back() == t.batches.size());
  if (s.paths_stale || !s.active()) return;  // made anew in the next step
  std::uint32_t first = 0;
  for (std::uint32_t layer = 0; layer < t.layers.size(); ++layer) {
    FEDER_ASSERT(first <= t.layers[layer]);
    std::fill_n(marks.begin() + s.first, s.total, kNone);
    for (std::uint32_t n = first; n < t.layers[layer]; ++n)
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        const std::uint32_t i = t.batches[n].a[k], anchor = t.anchor[n * kLanes + k];
        FEDER_ASSERT((anchor == kNone) == (i == s.total - 1));
        if (anchor == kNone) continue;
        FEDER_ASSERT(i < s.points && anchor < s.points && marks[s.first + i] == kNone);
        FEDER_ASSERT(vertices.inv_mass[s.first + i] != 0 && vertices.inv_mass[s.first + anchor] == 0);
        marks[s.first + i] = layer;
      }
    first = t.layers[layer];
  }
  for (const std::uint32_t i : t.pins) FEDER_ASSERT(i < s.points && vertices.inv_mass[s.first + i] == 0);
  for (const ClothTies::ToBody& b : t.to_body) FEDER_ASSERT(b.vertex < s.points && b.anchor < s.points);
}

void Cloth::Impl::validate_sheet(std::uint32_t n) const {
  Sheet& s = *sheets[n];
  FEDER_ASSERT(objects.alive(s.object) && objects.kind(s.object) == kClothKind && objects.index(s.object) == n);
  validate_mesh(s);
  validate_motion(s);
  validate_ties(s);
  ClothView v;
  v.mesh = &s.mesh;
  v.points = s.points, v.total = s.total;
  v.version = s.version;
  v.rests = s.rests, v.flows = s.settings.flows();
  s.solver->validate(v);
}

void Cloth::validate() const {
  const Impl& m = *impl_;
  const ClothVertices& v = m.vertices;
  ClothVertices::each_array(v, [&](const auto& array) { FEDER_ASSERT(array.size() == v.size()); });
  m.marks.assign(v.size(), kNone);
  std::uint32_t next = 0;
  for (std::uint32_t n = 0; n < m.sheets.size(); ++n) {
    FEDER_ASSERT(m.sheets[n]->first == next && m.sheets[n]->total > m.sheets[n]->points);
    next += m.sheets[n]->total;
    FEDER_ASSERT(next <= v.size());
    m.validate_sheet(n);
  }
  FEDER_ASSERT(next == v.size());

  m.marks.assign(v.size(), kNone);
  for (const Attachment& a : m.attachments) {
    FEDER_ASSERT(m.objects.alive(a.cloth) && a.vertex < v.size() && v.cloth[a.vertex] == a.cloth);
    FEDER_ASSERT(m.marks[a.vertex] == kNone);  // attached once
    m.marks[a.vertex] = a.body.slot;
  }
}

}  // namespace feder
