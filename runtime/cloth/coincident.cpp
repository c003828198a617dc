// Layers that lie exactly in one place: contact has no side to push them to, so they stay there. Looked for when a
// cloth takes its first step; a warning names it, the other and how many triangles. Where cloths are sewn together,
// rows of their vertices lie in one place, but no triangles.
#include <algorithm>
#include <array>
#include <cmath>

#include "cloth/impl.h"

namespace feder {
namespace {
constexpr double kSame = 1e-5;  // thicknesses: contact takes no normal from less
}

void Cloth::Impl::warn_of_coincident(StepContext& c) {
  Real thickness = kInfinity;
  bool any = false;
  for (const auto& s : sheets) {
    any = any || (s->state.fresh && s->active());
    thickness = std::min(thickness, s->settings.thickness);
  }
  if (!any || !(thickness > 0)) return;
  // vertices in the order of their places
  places.clear();
  for (std::uint32_t n = 0; n < sheets.size(); ++n)
    for (std::uint32_t i = sheets[n]->first; i < sheets[n]->first + sheets[n]->points; ++i) {
      Place p{{}, n, i};
      for (int k = 0; k < 3; ++k) p.at[k] = std::round(double(vertices.position[i][k]) / (kSame * double(thickness)));
      places.push_back(p);
    }
  std::sort(places.begin(), places.end(),
            [](const Place& a, const Place& b) { return a.at != b.at ? a.at < b.at : a.vertex < b.vertex; });
  const auto meet = [&](std::uint32_t a, std::uint32_t b) {
    const ClothSettings &p = sheets[a]->settings, &q = sheets[b]->settings;
    return a == b ? p.self_collision != 0 : (p.group & q.mask) && (q.group & p.mask);
  };
  other_sheet.assign(vertices.size(), kNone);
  for (std::size_t from = 0, to = 0; from < places.size(); from = to) {
    while (to < places.size() && places[to].at == places[from].at) ++to;
    for (std::size_t i = from; i < to; ++i)
      for (std::size_t j = from; j < to && other_sheet[places[i].vertex] == kNone; ++j)
        if (i != j && meet(places[i].sheet, places[j].sheet)) other_sheet[places[i].vertex] = places[j].sheet;
  }
  for (std::uint32_t n = 0; n < sheets.size(); ++n) {
    const Sheet& s = *sheets[n];
    if (!s.state.fresh || !s.active()) continue;
    std::size_t count = 0;
    std::uint32_t other = kNone;
    for (std::size_t t = 0; t < s.mesh.triangles.size(); t += 3) {
      const auto of = [&](std::size_t k) { return other_sheet[s.first + s.mesh.triangles[t + k]]; };
      if (of(0) == kNone || of(1) == kNone || of(2) == kNone) continue;
      if (count++ == 0) other = of(0);
    }
    if (count == 0) continue;
    c.events->warn("coincident",
                   objects.describe(s.object) + ": " + std::to_string(count) + " triangles lie exactly in " +
                       (other == n ? "others of its own" : objects.describe(sheets[other]->object)) +
                       ", and contact cannot tell which is on which side: they stay in one place; put them apart by " +
                       "some of the thickness",
                   s.object);
  }
}

}  // namespace feder
