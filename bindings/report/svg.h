// A drawing as SVG text: lines, boxes, words and hatchings in the order they were added. One attribute order and one
// number format, so that equal drawings are equal bytes. Ids carry the drawing's name: several fit into one page.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace feder::report {

inline constexpr const char* kInk = "#1f2328";    // words
inline constexpr const char* kQuiet = "#59636e";  // words that stand back
inline constexpr const char* kFrame = "#8b949e";
inline constexpr const char* kGrid = "#d9dee3";
inline constexpr const char* kFaintGrid = "#f0f2f4";

struct XY {
  double x = 0, y = 0;  // px, y downwards
};

struct Box {
  double left = 0, top = 0, width = 0, height = 0;  // px
  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

struct Stroke {
  std::string color = kInk;
  double width = 1;
  std::string dash = {};  // "6 3"; empty: solid
  double opacity = 1;
};

struct Words {
  double size = 12;              // px
  const char* anchor = "start";  // start, middle, end
  std::string color = kInk;
  bool bold = false;
  double turn = 0;    // degrees
  bool halo = false;  // white behind the letters, for words over lines
};

enum class Hatch { rising, falling, crossed, dots, level, upright };

class Svg {
 public:
  // `name` goes into ids: letters, digits and '_' of it. `title` is what a screen reader says.
  Svg(const std::string& name, double width, double height, const std::string& title);

  void line(XY a, XY b, const Stroke& stroke);
  void polyline(std::span<const XY> points, const Stroke& stroke, const std::string& title = "");
  void polygon(std::span<const XY> points, const std::string& fill, const Stroke& stroke);
  void rect(const Box& box, const std::string& fill, const std::string& stroke = "none", const std::string& title = "",
            const std::string& kind = "");
  // Any path; `kind` becomes its class, which tests and readers of the file count by.
  void path(const std::string& d, const std::string& fill, const Stroke& stroke, const std::string& title = "",
            const std::string& kind = "");
  // "10^{-3}" is written with a raised -3.
  void text(XY at, const std::string& words, const Words& style = {});

  // What follows is cut at the box, until end().
  void begin_clip(const Box& box);
  void end();

  // A fill "url(#...)"; equal ones share a definition.
  std::string hatch(Hatch kind, const std::string& color, const std::string& ground = "none");

  // The whole file; `inline_page`: without the XML line, for HTML.
  std::string text(bool inline_page = false) const;

 private:
  std::string name_, title_;
  double width_, height_;
  std::string defs_, body_;
  std::vector<std::string> hatches_;  // keys in the order of their ids
  int clips_ = 0;
};

// Width of words in the fonts of the drawings, px: a careful estimate, because no font is at hand.
double words_width(const std::string& words, double size);

// `words` cut to `width` px with an ellipsis.
std::string words_cut(const std::string& words, double size, double width);

}  // namespace feder::report
