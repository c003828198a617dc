// A font baked into a grey picture, for labels and for the captions of contact sheets: DejaVu Sans where it is
// installed, else the one that Dear ImGui carries.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "view/image.h"

namespace feder::view {

// DejaVu Sans where distributions put it; "" when it is not installed.
std::string dejavu_file(bool mono);

class Font {
 public:
  struct Glyph {
    float left, top, right, bottom;  // pixels from the pen, y down from the top of the line
    float u0, v0, u1, v1;
    float advance;
  };
  explicit Font(float pixels);
  const Glyph& glyph(char c) const;  // '?' for what is not ASCII
  float line_height() const { return height_; }
  float width(std::string_view text) const;
  int atlas_width() const { return width_; }
  int atlas_height() const { return atlas_height_; }
  const std::vector<std::uint8_t>& atlas() const { return atlas_; }
  // Blends text into a picture; (x, y) is the top left corner.
  void draw(Image& image, float x, float y, std::string_view text, std::uint32_t rgb) const;

 private:
  int width_ = 0, atlas_height_ = 0;
  float height_ = 0;
  std::vector<std::uint8_t> atlas_;
  std::vector<Glyph> glyphs_;  // from ' ' to '~'
};

}  // namespace feder::view
