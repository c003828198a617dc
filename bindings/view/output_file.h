// Files that are written in one go.
#pragma once
#include "feder/error.h"
#include "report/output_file.h"

namespace feder::view {

// Calls write(stream); the file is there when all of it is (report/output_file.h). SceneError when it cannot be
// written.
template <class F>
void write_file(const std::filesystem::path& file, F&& write) {
  try {
    report::OutputFile out(file);
    write(out.stream());
    out.close();
  } catch (const SceneError&) {
    throw;
  } catch (const std::runtime_error& e) {
    throw SceneError(e.what());
  }
}

}  // namespace feder::view
