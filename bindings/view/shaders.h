// GLSL 3.30 sources. kSharedSource holds the uniform block that is filled once per pass.
#pragma once
#include <string_view>

namespace feder::view {

extern const std::string_view kSharedSource;  // first of all
extern const std::string_view kLightSource;   // then, in fragments that are lit
extern const std::string_view kShapeVertex, kShapeFragment;
extern const std::string_view kDepthFragment;  // writes depth only
extern const std::string_view kPointVertex, kPointFragment, kPointDepthFragment;
extern const std::string_view kLineVertex, kLineFragment;
extern const std::string_view kGroundVertex, kGroundFragment;
extern const std::string_view kBackgroundVertex, kBackgroundFragment;
extern const std::string_view kTextVertex, kTextFragment;

// Of liquids (shaders_liquid.cpp).
extern const std::string_view kWaterSource;  // after the light, in fragments that show a liquid
extern const std::string_view kLiquidVertex, kThicknessFragment, kLiquidFragment;
extern const std::string_view kSplatVertex, kBallDepthFragment, kBallWayFragment;
extern const std::string_view kWholeVertex, kSmoothFragment, kSplatFragment, kSheetFragment;

}  // namespace feder::view
