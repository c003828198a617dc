// A contact sheet: small pictures of many scenes, title and command below each.
#include <fmt/format.h>

#include <algorithm>

#include "cli/picture.h"
#include "cli/stop.h"
#include "view/font.h"

namespace feder::cli {
namespace {

constexpr int kColumns = 4, kGap = 18, kTitle = 19, kCommand = 14, kCaption = kTitle + kCommand + 16;
constexpr std::uint32_t kPaper = 0xfbfaf7, kInk = 0x22262b, kFaint = 0x6a7078, kWrong = 0xb3261e;

void fill(view::Image& image, int x0, int y0, int w, int h, std::uint32_t rgb) {
  for (int y = y0; y < y0 + h; ++y)
    for (int x = x0; x < x0 + w; ++x)
      for (int k = 0; k < 3; ++k) image.pixel(x, y)[k] = static_cast<std::uint8_t>(rgb >> (16 - 8 * k) & 255);
}

void paste(view::Image& to, const view::Image& from, int x0, int y0) {
  for (int y = 0; y < from.height; ++y)
    std::copy_n(from.pixel(0, y), static_cast<std::size_t>(4 * from.width), to.pixel(x0, y0 + y));
}

// As much of the text as fits.
std::string fitted(const view::Font& font, std::string text, float width) {
  if (font.width(text) <= width) return text;
  while (!text.empty() && font.width(text + "...") > width) text.pop_back();
  return text + "...";
}

// Breaks anywhere: error messages hold long paths.
void write_block(view::Image& image, const view::Font& font, std::string text, int x, int y, int width, int lines) {
  for (int line = 0; line < lines && !text.empty(); ++line) {
    std::size_t n = text.size();
    while (n > 1 && font.width(std::string_view(text).substr(0, n)) > static_cast<float>(width)) --n;
    font.draw(image, static_cast<float>(x), static_cast<float>(y + line * (kCommand + 4)), text.substr(0, n), kWrong);
    text.erase(0, n);
  }
}

}  // namespace

view::Image contact_sheet(const std::vector<std::string>& scenes, const Options& options, const PictureWish& wish,
                          const std::function<void(const std::string&, const std::string&)>& done) {
  const int columns = std::min(kColumns, static_cast<int>(scenes.size()));
  const int rows = (static_cast<int>(scenes.size()) + columns - 1) / columns;
  const int w = wish.width, h = wish.height, cell_w = w + kGap, cell_h = h + kCaption + kGap;
  view::Image sheet(columns * cell_w + kGap, rows * cell_h + kGap);
  fill(sheet, 0, 0, sheet.width, sheet.height, kPaper);
  view::RendererHost renderer(w, h);
  const view::Font title_font(kTitle), font(kCommand);
  for (std::size_t i = 0; i < scenes.size() && !stop_flag(); ++i) {
    const int x = kGap + static_cast<int>(i) % columns * cell_w, y = kGap + static_cast<int>(i) / columns * cell_h;
    std::string title = scenes[i], error;
    try {
      Session session(silent_host_options(options), nullptr, scenes[i]);
      title = session.title();
      run_to(session, wish.at >= 0 ? wish.at : thumbnail_time(session.script()));
      paste(sheet, take_picture(renderer, session, wish), x, y);
    } catch (const Failure& e) {
      error = e.what();
    } catch (const SceneError& e) {
      error = e.what();
    }
    if (stop_flag()) break;  // the error is that
    if (!error.empty()) {
      fill(sheet, x, y, w, h, 0xf3e6e4);
      write_block(sheet, font, error, x + 10, y + 10, w - 20, 8);
    }
    title_font.draw(sheet, static_cast<float>(x), static_cast<float>(y + h + 6),
                    fitted(title_font, title, static_cast<float>(w)), kInk);
    font.draw(sheet, static_cast<float>(x), static_cast<float>(y + h + 10 + kTitle),
              fitted(font, "scripts/run view " + scenes[i], static_cast<float>(w)), kFaint);
    done(scenes[i], error);
  }
  return sheet;
}

}  // namespace feder::cli
