// Nodes or cells of the broad phase at one level.
#include <cstdio>

#include "feder/query.h"
#include "view/collector.h"

namespace feder::view {
namespace {

constexpr std::size_t kMostCells = 20'000;  // a picture of more shows nothing

class CellSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    const Collide* collide = c.toggles.cells ? c.world.find<Collide>() : nullptr;
    if (!collide) return;
    struct Drawing {
      std::vector<Line>& lines;
      Color color;
      std::size_t count = 0;
    } drawing{c.frame.outlines, rgb(c.toggles.cell_level % 2 == 0 ? 0x2f62d0 : 0x0f7f8f)};
    const auto take = [](void* context, const Aabb& box) {
      Drawing& d = *static_cast<Drawing*>(context);
      if (box.lo.allFinite() && box.hi.allFinite() && d.count++ < kMostCells) add_box(d.lines, box, d.color);
    };
    c.frame.deeper_cells = collide->cells_at(c.toggles.cell_level, take, &drawing);
    if (drawing.count > 0 && drawing.count <= kMostCells) return;
    Note note{};
    const std::string broad = c.world.desc().options.text({"broad_phase"}, "tree");
    if (drawing.count > 0)
      std::snprintf(note.text, sizeof note.text, "%s: the first %zu of %zu cells are drawn", broad.c_str(), kMostCells,
                    drawing.count);
    else
      std::snprintf(note.text, sizeof note.text, "%s: no cells at level %d", broad.c_str(), c.toggles.cell_level);
    c.frame.notes.push_back(note);
  }
};

}  // namespace

Row view_collide_cells() { return {"collide", make_source<CellSource>}; }

}  // namespace feder::view
