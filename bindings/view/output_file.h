// Files that are written in one go.
#pragma once
#include <filesystem>
#include <fstream>

#include "feder/error.h"

namespace feder::view {

// Calls write(stream). SceneError when the file cannot be opened or written.
template <class F>
void write_file(const std::filesystem::path& file, F&& write) {
  std::ofstream out(file, std::ios::binary);
  if (out) write(out);
  out.close();
  if (!out) throw SceneError(file.string() + ": cannot be written");
}

}  // namespace feder::view
