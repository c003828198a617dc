// Distance fields of triangles, kept from run to run in a folder: $XDG_CACHE_HOME/feder/fields, ~/.cache/feder/fields
// where that is not set. What cannot be read, or is not what was written, is made again; what cannot be written is
// not kept. The oldest go when the folder has more than kMostBytes. Fields of another build are not used.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "feder/sdf.h"

namespace feder::cli {

class FieldCache {
 public:
  static constexpr std::uint64_t kMostBytes = std::uint64_t(512) << 20;
  static constexpr double kWorthKeeping = 0.05;  // s that making a field takes at least to be kept

  // `stamp`: of the program; entries of others are not found.
  FieldCache(std::filesystem::path folder, std::string stamp);
  // make_sdf, or what that gave in an earlier run.
  ShapePtr make(const SdfDesc& desc) const;

 private:
  std::filesystem::path file_of(const SdfDesc& desc) const;
  void keep(const std::filesystem::path& file, const Shape& field) const;
  void make_room() const;

  std::filesystem::path folder_;
  std::string stamp_;
};

// For a look at what a scene has: four times as coarse, unless it cannot be.
ShapePtr sketch_field(const SdfDesc& desc);

std::filesystem::path field_cache_folder();  // empty: there is no place for one
std::string program_stamp();                 // changes with every build; empty where that cannot be known

}  // namespace feder::cli
