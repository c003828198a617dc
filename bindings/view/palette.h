// Default colours: stable per object, pleasant beside each other, readable in light and shadow.
#pragma once
#include <cstdint>
#include <string_view>

#include "view/frame.h"

namespace feder::view {

Color rgb(std::uint32_t hex);  // 0xrrggbb
// Objects of one group (material, tag or name without its number) share a hue; `number` varies it a little, so that
// neighbours in a stack can be told apart.
Color group_color(std::string_view group, std::uint32_t number);
// Name without trailing digits, spaces, '_', '-' and '#'.
std::string_view name_stem(std::string_view name);
Color fixed_color(std::uint32_t number);  // static bodies: warm greys
Color asleep(Color c);                    // greyer
Color mixed(Color a, Color b, float t);   // t = 0: a
// Blue (compressed) over grey (at rest) to red (stretched); `strain` -1..1 of full scale.
Color strain_color(float strain);
float to_linear(float srgb);  // 0 .. 1
// Perceptual ramp for scalars, t in 0..1: deep blue, teal, green, yellow.
Color ramp_color(float t);

}  // namespace feder::view
