#include "view/font.h"

#include <imgui.h>

#include <cmath>
#include <filesystem>

namespace feder::view {

std::string dejavu_file(bool mono) {
  const std::string name = mono ? "/DejaVuSansMono.ttf" : "/DejaVuSans.ttf";
  std::error_code ignored;
  for (const char* folder : {"truetype/dejavu", "TTF", mono ? "dejavu-sans-mono-fonts" : "dejavu-sans-fonts"}) {
    const std::string file = std::string("/usr/share/fonts/") + folder + name;
    if (std::filesystem::exists(file, ignored)) return file;
  }
  return "";
}

Font::Font(float pixels) {
  ImFontAtlas atlas;
  ImFontConfig config;
  config.SizePixels = pixels;
  config.OversampleH = config.OversampleV = 1;  // a texel is a pixel
  config.PixelSnapH = true;
  const std::string file = dejavu_file(false);
  const ImFont* font =
      file.empty() ? atlas.AddFontDefault(&config) : atlas.AddFontFromFileTTF(file.c_str(), pixels, &config);
  unsigned char* grey = nullptr;
  atlas.GetTexDataAsAlpha8(&grey, &width_, &atlas_height_);
  atlas_.assign(grey, grey + static_cast<std::size_t>(width_) * static_cast<std::size_t>(atlas_height_));
  height_ = font->FontSize;
  for (char c = ' '; c <= '~'; ++c) {
    const ImFontGlyph* g = font->FindGlyph(static_cast<ImWchar>(c));
    glyphs_.push_back({g->X0, g->Y0, g->X1, g->Y1, g->U0, g->V0, g->U1, g->V1, g->AdvanceX});
  }
}

const Font::Glyph& Font::glyph(char c) const {
  return glyphs_[static_cast<std::size_t>((c < ' ' || c > '~' ? '?' : c) - ' ')];
}

float Font::width(std::string_view text) const {
  float sum = 0;
  for (const char c : text) sum += glyph(c).advance;
  return sum;
}

void Font::draw(Image& image, float x, float y, std::string_view text, std::uint32_t rgb) const {
  for (const char c : text) {
    const Glyph& g = glyph(c);
    const int left = static_cast<int>(std::lround(x + g.left)), top = static_cast<int>(std::lround(y + g.top));
    const int u = static_cast<int>(std::lround(g.u0 * static_cast<float>(width_)));
    const int v = static_cast<int>(std::lround(g.v0 * static_cast<float>(atlas_height_)));
    const int w = static_cast<int>(std::lround((g.u1 - g.u0) * static_cast<float>(width_)));
    const int h = static_cast<int>(std::lround((g.v1 - g.v0) * static_cast<float>(atlas_height_)));
    for (int j = 0; j < h; ++j)
      for (int i = 0; i < w; ++i) {
        const int px = left + i, py = top + j;
        if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
        const int a = atlas_[static_cast<std::size_t>(v + j) * static_cast<std::size_t>(width_) +
                             static_cast<std::size_t>(u + i)];
        std::uint8_t* p = image.pixel(px, py);
        for (int k = 0; k < 3; ++k)
          p[k] = static_cast<std::uint8_t>((p[k] * (255 - a) + static_cast<int>(rgb >> (16 - 8 * k) & 255) * a) / 255);
      }
    x += g.advance;
  }
}

}  // namespace feder::view
