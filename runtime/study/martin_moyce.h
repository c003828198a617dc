// The delay of the diaphragm of Martin & Moyce's dam break (Phil. Trans. R. Soc. A 244, 1952), which whoever compares
// an instant release with their films adds to his time: 0.1 to 0.2 of T = t sqrt(g/a) by what is said of the
// experiment, 0.175 of t sqrt(2g/a) in comparisons of other codes (Lethe's dam-break example), which is taken here,
// once for all solvers and resolutions. scripts/feder/fluid.lua has the same number for scenes
// (tests/fluid/test_dam_break.cpp).
#pragma once

namespace feder {

inline constexpr double kDiaphragmDelay = 0.124;  // of T: 0.175 / sqrt(2)

}  // namespace feder
