// Lines with a width in pixels: OpenGL 3.3 core has only thin ones, so each is a rectangle on the screen.
#include <cstddef>

#include "view/layers.h"
#include "view/shaders.h"

namespace feder::view {

LineLayer::LineLayer(const Gl& gl)
    : gl_(gl), program_(make_program(gl, "lines", kLineVertex, kLineFragment, false)), lines_(gl), overlay_(gl),
      array_(gl) {}

void LineLayer::upload(const Frame& f, DrawStats& stats) {
  if (!f.lines.empty()) lines_.fill(f.lines.data(), f.lines.size() * sizeof(Line), GL_STREAM_DRAW);
  if (!f.overlay_lines.empty())
    overlay_.fill(f.overlay_lines.data(), f.overlay_lines.size() * sizeof(Line), GL_STREAM_DRAW);
  stats.bytes_uploaded += (f.lines.size() + f.overlay_lines.size()) * sizeof(Line);
}

void LineLayer::draw(const Frame& f, const Pass& pass) {
  const bool over = pass.stage == Stage::overlay;
  const std::vector<Line>& lines = over ? f.overlay_lines : f.lines;
  if (lines.empty() || (!over && pass.stage != Stage::translucent)) return;
  program_->use();
  array_.bind();
  (over ? overlay_ : lines_).bind();
  array_.floats(0, 3, sizeof(Line), offsetof(Line, a), 1);
  array_.floats(1, 3, sizeof(Line), offsetof(Line, b), 1);
  array_.bytes(2, sizeof(Line), offsetof(Line, color_a), 1);
  array_.bytes(3, sizeof(Line), offsetof(Line, color_b), 1);
  array_.floats(4, 1, sizeof(Line), offsetof(Line, width), 1);
  gl_.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(lines.size()));
  ++pass.stats.draw_calls;
  pass.stats.triangles += 2 * lines.size();
}

}  // namespace feder::view
