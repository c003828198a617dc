// A palette picked in OKLCH (even lightness and chroma, twelve hues) so that no group of objects shouts.
// B. Ottosson, "A perceptual color space for image processing", 2020, for the conversion.
#include "view/palette.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace feder::view {
namespace {

struct Lab {
  float l, a, b;
};

float to_srgb(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f; }
std::uint8_t byte(float x) { return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0f, 1.0f) * 255)); }

Color from_lab(const Lab& c, std::uint8_t alpha = 255) {
  const float l = c.l + 0.3963377774f * c.a + 0.2158037573f * c.b;
  const float m = c.l - 0.1055613458f * c.a - 0.0638541728f * c.b;
  const float s = c.l - 0.0894841775f * c.a - 1.2914855480f * c.b;
  const float l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
  return {byte(to_srgb(4.0767416621f * l3 - 3.3077115913f * m3 + 0.2309699292f * s3)),
          byte(to_srgb(-1.2684380046f * l3 + 2.6097574011f * m3 - 0.3413193965f * s3)),
          byte(to_srgb(-0.0041960863f * l3 - 0.7034186147f * m3 + 1.7076147010f * s3)), alpha};
}

Lab to_lab(Color c) {
  const float r = to_linear(c.r / 255.0f), g = to_linear(c.g / 255.0f), b = to_linear(c.b / 255.0f);
  const float l = std::cbrt(0.4122214708f * r + 0.5363325363f * g + 0.0514459929f * b);
  const float m = std::cbrt(0.2119034982f * r + 0.6806995451f * g + 0.1073969566f * b);
  const float s = std::cbrt(0.0883024619f * r + 0.2817188376f * g + 0.6299787005f * b);
  return {0.2104542553f * l + 0.7936177850f * m - 0.0040720468f * s,
          1.9779984951f * l - 2.4285922050f * m + 0.4505937099f * s,
          0.0259040371f * l + 0.7827717662f * m - 0.8086757660f * s};
}

Color from_lch(float lightness, float chroma, float hue_degrees) {
  const float h = hue_degrees * 0.01745329252f;
  return from_lab({lightness, chroma * std::cos(h), chroma * std::sin(h)});
}

std::uint32_t mixed_bits(std::uint32_t x) {  // finaliser of MurmurHash3
  x ^= x >> 16, x *= 0x85ebca6bu, x ^= x >> 13, x *= 0xc2b2ae35u;
  return x ^ x >> 16;
}
float unit(std::uint32_t bits) { return static_cast<float>(bits & 0xffff) / 65535.0f; }

// Hues that stay apart beside each other: amber, teal, coral, blue, green, violet, ochre, cyan, rose, indigo.
constexpr float kHues[] = {72, 195, 32, 252, 145, 305, 95, 225, 5, 275};

}  // namespace

float to_linear(float srgb) { return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f); }

Color rgb(std::uint32_t hex) {
  return {static_cast<std::uint8_t>(hex >> 16 & 255), static_cast<std::uint8_t>(hex >> 8 & 255),
          static_cast<std::uint8_t>(hex & 255), 255};
}

Color group_color(std::string_view group, std::uint32_t number) {
  std::uint32_t h = 2166136261u;
  for (const char c : group) h = (h ^ static_cast<unsigned char>(c)) * 16777619u;
  const std::uint32_t bits = mixed_bits(number + 1);
  const float hue = kHues[mixed_bits(h) % std::size(kHues)] + 18 * (unit(bits) - 0.5f);
  return from_lch(0.70f + 0.10f * (unit(bits >> 16) - 0.5f), 0.105f, hue);
}

std::string_view name_stem(std::string_view name) {
  std::size_t end = name.size();
  while (end > 0 && std::string_view("0123456789 _-#.,").find(name[end - 1]) != std::string_view::npos) --end;
  return name.substr(0, end);
}

Color fixed_color(std::uint32_t number) {
  const std::uint32_t bits = mixed_bits(number + 7);
  return from_lch(0.66f + 0.05f * (unit(bits) - 0.5f), 0.012f, 80);
}

Color asleep(Color c) {
  const Lab lab = to_lab(c);
  return from_lab({0.7f * lab.l + 0.3f * 0.60f, 0.42f * lab.a, 0.42f * lab.b}, c.a);
}

Color mixed(Color a, Color b, float t) {
  const Lab x = to_lab(a), y = to_lab(b);
  return from_lab({x.l + t * (y.l - x.l), x.a + t * (y.a - x.a), x.b + t * (y.b - x.b)},
                  static_cast<std::uint8_t>(std::lround(a.a + t * (b.a - a.a))));
}

Color strain_color(float strain) {
  static const auto table = [] {
    std::array<Color, 65> t;
    for (int i = 0; i < 65; ++i) {
      const float s = static_cast<float>(i - 32) / 32;
      t[static_cast<std::size_t>(i)] =
          s < 0 ? mixed(rgb(0x7d8188), rgb(0x2f6fd0), -s) : mixed(rgb(0x7d8188), rgb(0xd8402c), s);
    }
    return t;
  }();
  const float s = std::isfinite(strain) ? std::clamp(strain, -1.0f, 1.0f) : 1.0f;
  return table[static_cast<std::size_t>(std::lround((s + 1) * 32))];
}

Color ramp_color(float t) {
  constexpr std::uint32_t stops[] = {0x25458f, 0x2478b0, 0x27a6a4, 0x6fc47a, 0xe9dd6a};
  const float at = (std::isfinite(t) ? std::clamp(t, 0.0f, 1.0f) : 1.0f) * 4;
  const int i = std::min(static_cast<int>(at), 3);
  return mixed(rgb(stops[i]), rgb(stops[i + 1]), at - static_cast<float>(i));
}

}  // namespace feder::view
