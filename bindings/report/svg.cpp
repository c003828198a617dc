#include "report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "report/xml.h"

namespace feder::report {
namespace {

constexpr const char* kFonts = "'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";

std::string stroke_text(const Stroke& s) {
  std::string out = fmt::format(" stroke=\"{}\" stroke-width=\"{}\"", s.color, px(s.width));
  if (!s.dash.empty()) out += fmt::format(" stroke-dasharray=\"{}\"", s.dash);
  if (s.opacity < 1) out += fmt::format(" stroke-opacity=\"{}\"", px(s.opacity));
  return out;
}

std::string class_text(const std::string& kind) { return kind.empty() ? "" : fmt::format(" class=\"{}\"", kind); }

std::string box_text(const Box& b) {
  return fmt::format(" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"", px(b.left), px(b.top), px(b.width), px(b.height));
}

std::string close(const char* tag, const std::string& title) {
  if (title.empty()) return "/>\n";
  return "><title>" + xml_escape(title, true) + "</title></" + tag + ">\n";
}

std::string pair_list(std::span<const XY> points) {
  std::string out;
  for (const XY& p : points) out += (out.empty() ? "" : " ") + px(p.x) + "," + px(p.y);
  return out;
}

// "a^{b}c" with b raised.
std::string raised(const std::string& words, double size) {
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t open = words.find("^{", at);
    const std::size_t shut = open == std::string::npos ? open : words.find('}', open);
    if (shut == std::string::npos) return out + xml_escape(words.substr(at));
    const std::string up = px(size * 0.36);
    out += xml_escape(words.substr(at, open - at));
    out += "<tspan dy=\"-" + up + "\" font-size=\"" + px(size * 0.75) + "\">" +
           xml_escape(words.substr(open + 2, shut - open - 2)) + "</tspan>";
    at = shut + 1;
    if (at >= words.size()) return out;
    // the first letter behind comes back down
    std::size_t next = at + 1;
    while (next < words.size() && (static_cast<unsigned char>(words[next]) & 0xC0) == 0x80) ++next;
    out += "<tspan dy=\"" + up + "\">" + xml_escape(words.substr(at, next - at)) + "</tspan>";
    at = next;
  }
}

std::string hatch_shape(Hatch kind, const std::string& color) {
  const std::string pen = "\" stroke=\"" + color + "\" stroke-width=\"1.2\" fill=\"none\"/>";
  switch (kind) {
    case Hatch::rising: return "<path d=\"M-1 1L1 -1M0 8L8 0M7 9L9 7" + pen;
    case Hatch::falling: return "<path d=\"M-1 7L1 9M0 0L8 8M7 -1L9 1" + pen;
    case Hatch::crossed: return "<path d=\"M0 0L8 8M0 8L8 0" + pen;
    case Hatch::dots: return "<circle cx=\"4\" cy=\"4\" r=\"1.3\" fill=\"" + color + "\"/>";
    case Hatch::level: return "<path d=\"M0 4H8" + pen;
    case Hatch::upright: return "<path d=\"M4 0V8" + pen;
  }
  return "";
}

}  // namespace

Svg::Svg(const std::string& name, double width, double height, const std::string& title)
    : title_(title), width_(width), height_(height) {
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') name_ += c;
}

void Svg::line(XY a, XY b, const Stroke& s) {
  body_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"{}/>\n", px(a.x), px(a.y), px(b.x), px(b.y),
                       stroke_text(s));
}

void Svg::polyline(std::span<const XY> points, const Stroke& s, const std::string& title) {
  if (points.size() < 2) return;
  body_ += "<polyline points=\"" + pair_list(points) + "\" fill=\"none\" stroke-linejoin=\"round\"" + stroke_text(s) +
           close("polyline", title);
}

void Svg::polygon(std::span<const XY> points, const std::string& fill, const Stroke& s) {
  body_ += "<polygon points=\"" + pair_list(points) + "\" fill=\"" + fill + "\"" + stroke_text(s) + "/>\n";
}

void Svg::rect(const Box& b, const std::string& fill, const std::string& stroke, const std::string& title,
               const std::string& kind) {
  body_ += fmt::format("<rect{}{} fill=\"{}\"", class_text(kind), box_text(b), fill);
  if (stroke != "none") body_ += fmt::format(" stroke=\"{}\"", stroke);
  body_ += close("rect", title);
}

void Svg::path(const std::string& d, const std::string& fill, const Stroke& s, const std::string& title,
               const std::string& kind) {
  body_ +=
      fmt::format("<path{} d=\"{}\" fill=\"{}\"{}", class_text(kind), d, fill, stroke_text(s)) + close("path", title);
}

void Svg::text(XY at, const std::string& words, const Words& s) {
  std::string head =
      fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\"", px(at.x), px(at.y), px(s.size), s.color);
  if (std::string(s.anchor) != "start") head += std::string(" text-anchor=\"") + s.anchor + "\"";
  if (s.bold) head += " font-weight=\"bold\"";
  if (s.turn != 0) head += " transform=\"rotate(" + px(s.turn) + " " + px(at.x) + " " + px(at.y) + ")\"";
  if (s.halo) head += " stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"";
  body_ += head + ">" + raised(words, s.size) + "</text>\n";
}

void Svg::begin_clip(const Box& b) {
  const std::string id = name_ + "_c" + std::to_string(clips_++);
  defs_ += fmt::format("<clipPath id=\"{}\"><rect{}/></clipPath>\n", id, box_text(b));
  body_ += "<g clip-path=\"url(#" + id + ")\">\n";
}

void Svg::end() { body_ += "</g>\n"; }

std::string Svg::hatch(Hatch kind, const std::string& color, const std::string& ground) {
  const std::string key = std::to_string(static_cast<int>(kind)) + color + ground;
  const auto found = std::ranges::find(hatches_, key);
  const std::string id = name_ + "_h" + std::to_string(found - hatches_.begin());
  if (found == hatches_.end()) {
    hatches_.push_back(key);
    defs_ += "<pattern id=\"" + id + "\" width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\">";
    if (ground != "none") defs_ += "<rect width=\"8\" height=\"8\" fill=\"" + ground + "\"/>";
    defs_ += hatch_shape(kind, color) + "</pattern>\n";
  }
  return "url(#" + id + ")";
}

std::string Svg::text(bool inline_page) const {
  const std::string w = px(width_), h = px(height_);
  std::string out = inline_page ? "" : "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  out += fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
      "font-family=\"{2}\">\n<title>{3}</title>\n",
      w, h, kFonts, xml_escape(title_));
  if (!defs_.empty()) out += "<defs>\n" + defs_ + "</defs>\n";
  out += "<rect width=\"" + w + "\" height=\"" + h + "\" fill=\"#ffffff\"/>\n";
  return out + body_ + "</svg>\n";
}

double words_width(const std::string& words, double size) {
  double ems = 0;
  for (const char c : words) {
    if ((static_cast<unsigned char>(c) & 0xC0) == 0x80) continue;  // inside of a UTF-8 letter
    const bool narrow = std::string_view("ijlftrI.,:;|!'()[]/ -").find(c) != std::string_view::npos;
    const bool wide = std::string_view("mwMW@%").find(c) != std::string_view::npos;
    ems += narrow ? 0.34 : wide ? 0.9 : 0.6;
  }
  return ems * size;
}

std::string words_cut(const std::string& words, double size, double width) {
  if (words_width(words, size) <= width) return words;
  std::string out = words;
  while (!out.empty() && words_width(out + "…", size) > width) {
    while (!out.empty() && (static_cast<unsigned char>(out.back()) & 0xC0) == 0x80) out.pop_back();
    if (!out.empty()) out.pop_back();
  }
  return out + "…";
}

}  // namespace feder::report
