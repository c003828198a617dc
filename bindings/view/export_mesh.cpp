// OBJ and PLY of one frame.
#include <fmt/format.h>

#include <map>

#include "view/export.h"
#include "view/output_file.h"
#include "view/solids.h"

namespace feder::view {
namespace {

// OBJ names have no spaces.
std::string obj_name(const Objects& objects, std::uint32_t slot, std::size_t number) {
  std::string name = objects.name(objects.at(slot));
  for (char& c : name)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  return name.empty() ? fmt::format("object{}", number) : name;
}

std::string material_name(Color c) { return fmt::format("color_{:02x}{:02x}{:02x}", c.r, c.g, c.b); }

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void put_vertex(std::string& out, const MeshVertex& v, Color c) { put(out, v), put(out, c); }

}  // namespace

void write_obj(const Frame& frame, const Objects& objects, const std::filesystem::path& file) {
  std::filesystem::path library = file;
  library.replace_extension(".mtl");
  std::map<std::string, Color> materials;
  write_file(file, [&](std::ostream& out) {
    out << "# written by feder; metres, y up\nmtllib " << library.filename().string() << "\n";
    std::size_t first = 1, number = 0;
    for (const Solid& s : solids(frame)) {
      const std::string material = material_name(s.color);
      materials.emplace(material, s.color);
      out << "o " << obj_name(objects, s.object, ++number) << "\nusemtl " << material << "\n";
      for (const auto& [p, n] : s.vertices) out << fmt::format("v {} {} {}\n", p.x, p.y, p.z);
      for (const auto& [p, n] : s.vertices) out << fmt::format("vn {} {} {}\n", n.x, n.y, n.z);
      for (std::size_t t = 0; t + 2 < s.indices.size(); t += 3) {
        const std::size_t a = first + s.indices[t], b = first + s.indices[t + 1], c = first + s.indices[t + 2];
        out << fmt::format("f {}//{} {}//{} {}//{}\n", a, a, b, b, c, c);
      }
      first += s.vertices.size();
    }
  });
  write_file(library, [&](std::ostream& out) {
    for (const auto& [name, c] : materials)
      out << fmt::format("newmtl {}\nKd {:.4f} {:.4f} {:.4f}\nd {:.3f}\n", name, c.r / 255.0, c.g / 255.0, c.b / 255.0,
                         c.a / 255.0);
  });
}

void write_ply(const Frame& frame, const std::filesystem::path& file) {
  std::string vertices, faces;
  std::uint32_t count = 0, triangles = 0;
  for (const Solid& s : solids(frame)) {
    for (const MeshVertex& v : s.vertices) put_vertex(vertices, v, s.color);
    for (std::size_t t = 0; t + 2 < s.indices.size(); t += 3, ++triangles) {
      put(faces, std::uint8_t(3));
      for (std::size_t k = 0; k < 3; ++k) put(faces, static_cast<std::int32_t>(count + s.indices[t + k]));
    }
    count += static_cast<std::uint32_t>(s.vertices.size());
  }
  for (const PointGroup& g : frame.point_groups)
    for (std::uint32_t i = g.first; i < g.first + g.count; ++i, ++count)
      put_vertex(vertices, {frame.points[i].position, {0, 1, 0}}, point_color(g, frame.points[i]));
  write_file(file, [&](std::ostream& out) {
    out << "ply\nformat binary_little_endian 1.0\ncomment written by feder; metres, y up\n";
    out << fmt::format("element vertex {}\n", count);
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) out << "property float " << name << "\n";
    for (const char* name : {"red", "green", "blue", "alpha"}) out << "property uchar " << name << "\n";
    out << fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", triangles) << vertices
        << faces;
  });
}

}  // namespace feder::view
