// Points of surfaces held to points of others: equality rows of positions, solved beside the attachments to bodies in
// each solver substep of the group that both are in. Both points take the opposite correction by their masses, so what
// one side loses the other gets; a gap from before the solver substep closes at kLinkSpeed. Features round the two
// points do not collide with each other. Kept between steps: the links (state/surface_links.h). Weak spot: Gauss-Seidel
// between the two sides' own solvers, so a force F leaves a gap of about F h^2/m.
#include <algorithm>
#include <cmath>
#include <string>

#include "contact/impl.h"

namespace feder {
namespace {

constexpr Real kLinkSpeed = 3;        // m/s
constexpr std::uint32_t kMarks = 32;  // in a word

}  // namespace

// Links with objects that are gone end.
void SurfaceContact::Impl::sync_links() {
  SurfaceLinks* links = store.find<SurfaceLinks>();
  if (links)
    std::erase_if(links->list, [&](const SurfaceLink& l) { return !objects.alive(l.a) || !objects.alive(l.b); });
}

// Marks of points: the links whose ends they are, or lie within one edge of.
void SurfaceContact::Impl::mark_rings() {
  link_words = (static_cast<std::uint32_t>(held_links.size()) + kMarks - 1) / kMarks;
  link_marks.assign(std::size_t(surfaces.size()) * link_words, 0);
  link_at.assign(surfaces.size(), kNone), next_at.assign(2 * held_links.size(), kNone);
  const auto mark = [&](std::uint32_t point, std::uint32_t link) {
    link_marks[std::size_t(point) * link_words + link / kMarks] |= 1u << (link % kMarks);
  };
  // ends of links by point, in chains: 2 k and 2 k + 1 are those of link k
  for (std::uint32_t k = 0; k < held_links.size(); ++k)
    for (std::uint32_t side = 0; side < 2; ++side) {
      const std::uint32_t point = side ? held_links[k].q : held_links[k].p;
      next_at[2 * k + side] = link_at[point], link_at[point] = 2 * k + side;
      mark(point, k);
    }
  const auto pass_on = [&](std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t e = link_at[from]; e != kNone; e = next_at[e]) mark(to, e / 2);
  };
  for (std::uint32_t n = 0; n < list.size(); ++n) {
    const Surface& s = list[n];
    if (std::none_of(held_links.begin(), held_links.end(), [&](const HeldLink& h) { return h.a == n || h.b == n; }))
      continue;
    const std::uint32_t* ends = s.edges.ends;
    for (std::uint32_t e = 0; e < s.edges.count; ++e, ends += s.edges.stride)
      pass_on(s.first + ends[0], s.first + ends[1]), pass_on(s.first + ends[1], s.first + ends[0]);
  }
}

std::string SurfaceContact::Impl::point_name(std::uint32_t point, ObjectId of) const {
  return "point " + std::to_string(point + 1) + " of " + objects.describe(of);
}

// A net without a radius has no surface to hold on to, and a point may be one that its object does not have.
void SurfaceContact::Impl::warn_of_nothing(SurfaceLink& l, StepContext& c) {
  if (l.warned) return;
  l.warned = 1;
  c.events->warn(
      "attachment_lost",
      point_name(l.point, l.a) + " is attached to " + point_name(l.other, l.b) +
          ", which nothing can be held to: it takes a point that collides, such as of a net with radius above 0",
      l.a);
}

void SurfaceContact::Impl::connect_links(StepContext& c) {
  sync_links();
  held_links.clear();
  link_gap = 0;
  SurfaceLinks& links = store.get<SurfaceLinks>();
  for (std::uint32_t k = 0; k < links.list.size(); ++k) {
    SurfaceLink& l = links.list[k];
    HeldLink h;
    h.link = k;
    const auto find = [&](ObjectId id) {
      for (std::uint32_t n = 0; n < list.size(); ++n)
        if (list[n].object == id) return n;
      return kNone;
    };
    h.a = find(l.a), h.b = l.to_body ? kNone : find(l.b);
    if (h.a == kNone || l.point >= list[h.a].count + list[h.a].inner) continue;
    if (l.to_body) {
      surfaces.anchors.push_back({h.a, list[h.a].first + l.point, l.b});
      continue;
    }
    if (h.b == kNone || l.other >= list[h.b].count + list[h.b].inner) {
      warn_of_nothing(l, c);
      continue;
    }
    h.p = list[h.a].first + l.point, h.q = list[h.b].first + l.other;
    surfaces.connections.push_back({h.a, h.b, 0});
    held_links.push_back(h);
    const Real gap = length(Vec3(position[h.p] - position[h.q]));
    link_gap = std::max(link_gap, double(gap));
    warn_of_gap(l, surfaces, list[h.a], gap, point_name(l.other, l.b), objects, *c.events);
    // what moves wakes what it is held to
    for (const auto& [sleeper, other] : {std::pair(h.a, h.b), std::pair(h.b, h.a)})
      if (!list[sleeper].active && list[other].active && !list[other].sleep_candidate)
        wake(list[sleeper].object, list[other].object);
  }
  mark_rings();
}

void SurfaceContact::Impl::solve_links(StepContext& c) {
  const SurfaceGroup& g = group(c);
  const Real h = g.step, closed = kLinkSpeed * h;
  for (const HeldLink& k : held_links) {
    if (list[k.a].loop != static_cast<std::uint32_t>(c.inner.group)) continue;
    Row4 &x = delta_position[k.p], &y = delta_position[k.q];
    const Real sum = x.w + y.w;
    if (!(sum > 0)) continue;
    Vec3 error = current_position(k.p) - current_position(k.q);
    Vec3 change = x.vec() - before[k.p].vec() - y.vec() + before[k.q].vec();
    if (before[k.p].w != 0) change += h * velocity[k.p].vec();
    if (before[k.q].w != 0) change -= h * velocity[k.q].vec();
    const Vec3 start = error - change;
    const Real open = length(start);
    if (open > closed) error -= (1 - closed / open) * start;
    const Vec3 push = -error / sum;  // kg m
    x.add(x.w * push), y.add(-y.w * push);
  }
}

// Do features with these points lie round the two ends of a link?
bool SurfaceContact::Impl::linked(const std::uint32_t (&v)[4], bool edges) const {
  const auto marks = [&](std::uint32_t i, std::uint32_t word) {
    return link_marks[std::size_t(v[i]) * link_words + word];
  };
  for (std::uint32_t w = 0; w < link_words; ++w) {
    const std::uint32_t a = marks(0, w) | (edges ? marks(1, w) : 0);
    const std::uint32_t b = marks(2, w) | marks(3, w) | (edges ? 0 : marks(1, w));
    if ((a & b) != 0) return true;
  }
  return false;
}

}  // namespace feder
