// Lines with a width in pixels: OpenGL 3.3 core has only thin ones, so each is a rectangle on the screen.
#include <cstddef>

#include "view/layers.h"
#include "view/shaders.h"

namespace feder::view {

LineLayer::LineLayer(const Gl& gl)
    : gl_(gl), program_(make_program(gl, "lines", kLineVertex, kLineFragment, false)), lines_(gl), overlay_(gl),
      array_(gl) {}

void LineLayer::upload(const Frame& f) {
  lines_.fill(f.lines, GL_STREAM_DRAW);
  overlay_.fill(f.overlay_lines, GL_STREAM_DRAW);
}

void LineLayer::draw(const Frame& f, const Pass& pass) {
  const bool over = pass.stage == Stage::overlay;
  const std::vector<Line>& lines = over ? f.overlay_lines : f.lines;
  if (lines.empty() || (!over && pass.stage != Stage::translucent)) return;
  program_->use();
  array_.bind();
  (over ? overlay_ : lines_).bind();
  array_.attributes<Line>({{0, 3, offsetof(Line, a)},
                           {1, 3, offsetof(Line, b)},
                           {2, kColor, offsetof(Line, color_a)},
                           {3, kColor, offsetof(Line, color_b)},
                           {4, 1, offsetof(Line, width)}},
                          0, 1);
  pass.draw_squares(lines.size());
}

}  // namespace feder::view
