// Candidates of self-contact by a search that the surface asks for (bounds/box_search.h), over the same swept boxes
// that the trees of near.cpp take. Kept between calls: memory.
#include "contact/impl.h"

namespace feder {

BoxSearch* SurfaceContact::Impl::search_of(const Surface& s) {
  if (!s.search) return nullptr;
  for (SearchOf& k : all_searches)
    if (k.object == s.object && k.kind == s.search) return k.search.get();
  all_searches.push_back({s.object, s.search, s.search->make(arena, Params())});
  return all_searches.back().search.get();
}

void SurfaceContact::Impl::find_own_pairs(NearSearch& near, std::uint32_t n, Real time) {
  const Surface& s = list[n];
  BoxSearch& search = *own_search[n];
  own_triangle_box.resize(s.triangles.size() / 3), own_edge_box.resize(s.edges.count);
  const auto triangle = [&](std::uint32_t t) { return &s.triangles[3 * std::size_t(t)]; };
  const auto ends = [&](std::uint32_t e) { return s.edges.ends + std::size_t(s.edges.stride) * e; };
  for (std::uint32_t t = 0; t < own_triangle_box.size(); ++t) {
    const std::uint32_t* v = triangle(t);
    own_triangle_box[t] = box_of(s.first + v[0], s.first + v[1], s.first + v[2]);
  }
  for (std::uint32_t e = 0; e < s.edges.count; ++e)
    own_edge_box[e] = box_of(s.first + ends(e)[0], s.first + ends(e)[1], s.first + ends(e)[1]);
  // points against triangles
  search.between({vertex_box.data() + s.first, s.count}, {own_triangle_box.data(), own_triangle_box.size()}, own_pairs);
  for (const BoxPair& p : own_pairs) {
    const std::uint32_t* v = triangle(p.b);
    if (v[0] != p.a && v[1] != p.a && v[2] != p.a)
      offer_pair(near, {s.first + p.a, s.first + v[0], s.first + v[1], s.first + v[2]}, false, time);
  }
  // edges against later edges
  search.within({own_edge_box.data(), own_edge_box.size()}, own_pairs);
  for (const BoxPair& p : own_pairs) {
    const std::uint32_t *a = ends(p.a), *b = ends(p.b);
    if (a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1])
      offer_pair(near, {s.first + a[0], s.first + a[1], s.first + b[0], s.first + b[1]}, true, time);
  }
}

}  // namespace feder
