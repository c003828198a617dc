// Particles and points as VTK XML files.
#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "feder/world.h"

namespace feder::report {

// PolyData (.vtp, binary in base64): particles of fluids as vertices, springs of nets as lines, faces of nets and
// cloths as triangles. Point data: object (number of its slot; a comment names them), velocity (m/s), radius (m),
// density (kg/m^3) and pressure (Pa), NaN where an object has no such thing; field data: TimeValue (s). Returns the
// number of points; without any, nothing is written. std::runtime_error "file: cannot be written".
std::size_t write_vtp(World& world, const std::filesystem::path& file);

// ParaView's index of a series (.pvd): a file, named as from its own folder, and its time, s.
struct SeriesEntry {
  std::string file;
  double time = 0;
};
void write_pvd(std::span<const SeriesEntry> entries, const std::filesystem::path& file);

}  // namespace feder::report
