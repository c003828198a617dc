// What the viewer tells other programs (tests, editors): one JSON object in a file.
#pragma once
#include <string>

#include "view/panel_layout.h"

namespace feder::view {

// Written beside the file and renamed, so that readers never see half of it.
void write_status(PanelLayout& layout, const Target& target, float pixels_per_unit, const std::string& file);

}  // namespace feder::view
