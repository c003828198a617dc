// VTK XML files (VTK file formats, Kitware 2024): arrays are inline, each the base64 text of its size in bytes (UInt64)
// and of its bytes, so numbers come back as they were and the file is XML that any parser reads.
#include "report/vtk.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "report/output_file.h"
#include "report/states.h"
#include "report/xml.h"

namespace feder::report {
namespace {

static_assert(std::endian::native == std::endian::little);

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= count ? kDigits[three >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

template <class T>
std::string type_name() {
  return fmt::format("{}{}", std::is_floating_point_v<T> ? "Float" : "Int", 8 * sizeof(T));
}

template <class T>
void put_array(std::ostream& out, const char* name, int components, const std::vector<T>& values) {
  const std::uint64_t size = values.size() * sizeof(T);
  std::string bytes(reinterpret_cast<const char*>(&size), sizeof size);
  bytes.append(reinterpret_cast<const char*>(values.data()), size);
  out << fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">", type_name<T>(),
                     name, components)
      << base64(bytes) << "</DataArray>\n";
}

// Cells of `corners` points each.
void put_cells(std::ostream& out, const char* name, std::int64_t corners, const std::vector<std::int64_t>& points) {
  std::vector<std::int64_t> offsets;
  for (auto end = corners; end <= static_cast<std::int64_t>(points.size()); end += corners) offsets.push_back(end);
  out << "<" << name << ">\n";
  put_array(out, "connectivity", 1, points);
  put_array(out, "offsets", 1, offsets);
  out << "</" << name << ">\n";
}

constexpr const char* kOpening = R"(<?xml version="1.0"?>
<VTKFile type="{}" version="1.0" byte_order="LittleEndian" header_type="UInt64">
)";

// The points of all objects one after another.
class PolyData {
 public:
  explicit PolyData(World& world) {
    ObjectState state;
    for (const StateReader& reader : state_readers()) {
      if (reader.rigid) continue;
      world.objects().for_each(reader.kind, [&](ObjectId id) {
        state.clear();
        reader.read(world, id, state);
        if (reader.read_fields) reader.read_fields(world, id, state);
        add(world, id, state);
      });
    }
  }

  std::size_t size() const { return object_.size(); }

  void write(std::ostream& out, double time) const {
    out << fmt::format(kOpening, "PolyData") << comments_ << "<PolyData>\n<FieldData>\n"
        << fmt::format(
               "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n",
               time)
        << fmt::format(
               "</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" "
               "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<PointData Vectors=\"velocity\">\n",
               size(), vertices_.size(), lines_.size() / 2, triangles_.size() / 3);
    put_array(out, "object", 1, object_);
    put_array(out, "velocity", 3, velocity_);
    put_array(out, "radius", 1, radius_);
    put_array(out, "density", 1, density_);
    put_array(out, "pressure", 1, pressure_);
    out << "</PointData>\n<Points>\n";
    put_array(out, "Points", 3, position_);
    out << "</Points>\n";
    put_cells(out, "Verts", 1, vertices_), put_cells(out, "Lines", 2, lines_), put_cells(out, "Polys", 3, triangles_);
    out << "</Piece>\n</PolyData>\n</VTKFile>\n";
  }

 private:
  void add(const World& world, ObjectId id, const ObjectState& s) {
    const auto first = static_cast<std::int64_t>(size());
    const std::size_t count = s.positions.size();
    object_.insert(object_.end(), count, static_cast<std::int32_t>(id.slot));
    add_vectors(s.positions, position_), add_vectors(s.velocities, velocity_);
    add_numbers(s.radii, count, radius_), add_numbers(s.densities, count, density_);
    add_numbers(s.pressures, count, pressure_);
    for (const std::uint32_t i : s.lines) lines_.push_back(first + i);
    for (const std::uint32_t i : s.triangles) triangles_.push_back(first + i);
    // a point that nothing else shows
    for (std::size_t i = 0; s.lines.empty() && s.triangles.empty() && i < count; ++i)
      vertices_.push_back(first + static_cast<std::int64_t>(i));
    comments_ += fmt::format("<!-- object {}: {} -->\n", id.slot, xml_comment(world.objects().describe(id)));
  }

  // A comment may not hold two dashes.
  static std::string xml_comment(std::string text) {
    for (std::size_t at; (at = text.find("--")) != std::string::npos;) text[at + 1] = '_';
    return xml_escape(text, true);
  }

  static void add_vectors(const std::vector<Vec3>& from, std::vector<Real>& to) {
    for (const Vec3& v : from) to.insert(to.end(), {v[0], v[1], v[2]});
  }
  static void add_numbers(const std::vector<Real>& from, std::size_t count, std::vector<Real>& to) {
    to.insert(to.end(), from.begin(), from.end());
    if (from.empty()) to.insert(to.end(), count, static_cast<Real>(NAN));
  }

  std::string comments_;
  std::vector<std::int32_t> object_;
  std::vector<Real> position_, velocity_, radius_, density_, pressure_;
  std::vector<std::int64_t> vertices_, lines_, triangles_;
};

}  // namespace

std::size_t write_vtp(World& world, const std::filesystem::path& file) {
  const PolyData data(world);
  if (data.size() == 0) return 0;
  OutputFile out(file);
  data.write(out.stream(), world.time());
  out.close();
  return data.size();
}

void write_pvd(std::span<const SeriesEntry> entries, const std::filesystem::path& file) {
  OutputFile out(file);
  out.stream() << fmt::format(kOpening, "Collection") << "<Collection>\n";
  for (const SeriesEntry& e : entries)
    out.stream() << fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", e.time,
                                xml_escape(e.file, true));
  out.stream() << "</Collection>\n</VTKFile>\n";
  out.close();
}

}  // namespace feder::report
