// Labels: glyphs as textured squares in pixels, placed where the camera sees their points.
#include <cmath>
#include <cstddef>

#include "view/font.h"
#include "view/layers.h"
#include "view/shaders.h"

namespace feder::view {
namespace {

constexpr float kSize = 15;  // pixels

// Baked once for all renderers of the process: it never changes.
const Font& font() {
  static const Font baked(kSize);
  return baked;
}

}  // namespace

TextLayer::TextLayer(const Gl& gl)
    : gl_(gl), program_(make_program(gl, "text", kTextVertex, kTextFragment, false)),
      atlas_(gl.GenTextures, gl.DeleteTextures), glyphs_(gl), array_(gl) {
  gl_.BindTexture(GL_TEXTURE_2D, atlas_.id());
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, font().atlas_width(), font().atlas_height(), 0, GL_RED, GL_UNSIGNED_BYTE,
                 font().atlas().data());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl_.BindTexture(GL_TEXTURE_2D, 0);
}

void TextLayer::add(std::string_view text, float x, float y, float scale, Color color) {
  for (const char c : text) {
    const Font::Glyph& g = font().glyph(c);
    list_.push_back({{x + scale * g.left, y + scale * g.top, x + scale * g.right, y + scale * g.bottom},
                     {g.u0, g.v0, g.u1, g.v1},
                     color});
    x += scale * g.advance;
  }
}

void TextLayer::upload(const Frame& f, const Camera& camera, const Target& target, float scale) {
  list_.clear();
  for (const Label& label : f.labels) {
    float x = 0, y = 0;
    if (!camera.project(label.position, target.width, target.height, x, y)) continue;
    const std::string_view text = label.text;
    x = std::floor(x - 0.5f * scale * font().width(text)), y = std::floor(y - 0.5f * scale * font().line_height());
    // a pale rim first, so that text is read on any colour
    const Color rim{255, 255, 255, 150};
    for (const auto& [dx, dy] : {std::pair{-1.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, -1.0f}, {0.0f, 1.0f}})
      add(text, x + scale * dx, y + scale * dy, scale, rim);
    add(text, x, y, scale, label.color);
  }
  glyphs_.fill(list_, GL_STREAM_DRAW);
}

void TextLayer::draw(const Pass& pass) {
  if (list_.empty()) return;
  program_->use();
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, atlas_.id());
  array_.bind();
  glyphs_.bind();
  array_.attributes<Glyph>(
      {{0, 4, offsetof(Glyph, box)}, {1, 4, offsetof(Glyph, uv)}, {2, kColor, offsetof(Glyph, color)}}, 0, 1);
  pass.draw_squares(list_.size());
  gl_.BindTexture(GL_TEXTURE_2D, 0);
}

}  // namespace feder::view
