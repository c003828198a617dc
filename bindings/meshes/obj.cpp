// Wavefront OBJ through tinyobjloader, line by line: the library reads the lines and the forms of faces (v, v/vt,
// v//vn, v/vt/vn), but knows no errors (what is no number is 0) and reads numbers by pow(), whose last digit is the
// machine's. So each line is checked before it is handed over, coordinates are taken from there, and what a face says
// is checked when it comes back. Free-form curves, lines, points and materials are left out.
#include <tiny_obj_loader.h>

#include <charconv>
#include <cmath>
#include <istream>
#include <streambuf>

#include "meshes/builder.h"

namespace feder::meshes {
namespace {

constexpr std::string_view kBlank = " \t\r";

// The first word of a text, which goes on behind it.
std::string_view take_word(std::string_view& text) {
  const std::size_t start = std::min(text.find_first_not_of(kBlank), text.size());
  const std::size_t end = std::min(text.find_first_of(kBlank, start), text.size());
  const std::string_view word = text.substr(start, end - start);
  text.remove_prefix(end);
  return word;
}

std::string quoted(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) >= 127) c = '?';
  return "'" + text + "'";
}

// Finite; too small for a Real is 0.
bool read_real(std::string_view word, Real& out) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  if (word.empty() || end != word.data() + word.size()) return false;
  if (error == std::errc()) return std::isfinite(out);
  out = 0;
  return word.find("e-") != word.npos || word.find("E-") != word.npos || word.find("0.0") != word.npos;
}

// Of a corner of a face, before its first slash: a whole number but 0.
bool is_index(std::string_view word) {
  word = word.substr(0, word.find('/'));
  int x = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), x);
  return error == std::errc() && end == word.data() + word.size() && x != 0;
}

// The file, one line in view at a time, so that its number is known while the library works on it.
class Lines final : public std::streambuf {
 public:
  explicit Lines(const lua::MeshFile& file) : file_(file), rest_(file.content) {}

  std::size_t number() const { return number_; }  // of the line in view, from 1
  const Vec3& vertex() const { return vertex_; }  // that it has

 protected:
  int_type underflow() override {
    if (gptr() < egptr()) return traits_type::to_int_type(*gptr());
    if (rest_.empty()) return traits_type::eof();
    next_line();
    line_ += '\n';
    setg(line_.data(), line_.data(), line_.data() + line_.size());
    return traits_type::to_int_type(*gptr());
  }

 private:
  // A line that ends with a backslash goes on in the next.
  void next_line() {
    line_.clear();
    number_ += pieces_, pieces_ = 0;
    bool more = true;
    while (more && !rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      std::string_view piece = rest_.substr(0, end);
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      while (piece.ends_with('\r')) piece.remove_suffix(1);
      more = piece.ends_with('\\');
      if (more) piece.remove_suffix(1);
      line_ += piece;
      if (more) line_ += ' ';
      ++pieces_;
    }
    check();
  }

  void check() {
    std::string_view text = line_;
    const std::string_view key = take_word(text);
    for (char& c : line_)
      if (c == '\r') c = ' ';  // which the library takes for the end of a line
    if (line_.find('\0') != std::string::npos) fail_file(file_, "expected text, got a byte 0", number_);
    if (key == "v") return check_vertex(text);
    // whatever else is there says nothing of triangles
    if (key == "f")
      check_face(text);
    else
      line_.clear();
  }

  void check_vertex(std::string_view text) {
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = take_word(text);
      if (!read_real(word, vertex_[k]))
        fail_file(file_,
                  word.empty() ? "expected three coordinates, got " + std::to_string(k)
                               : "expected a finite number, got " + quoted(word),
                  number_);
    }
  }

  void check_face(std::string_view text) {
    std::size_t corners = 0;
    for (std::string_view word = take_word(text); !word.empty() && word[0] != '#'; word = take_word(text), ++corners)
      if (!is_index(word)) fail_file(file_, "expected the number of a vertex, got " + quoted(word), number_);
    if (corners < 3)
      fail_file(file_, "expected a face of at least three vertices, got " + std::to_string(corners), number_);
    line_.resize(std::min(line_.find('#'), line_.size()));
  }

  const lua::MeshFile& file_;
  std::string_view rest_;
  std::string line_;
  std::size_t number_ = 1, pieces_ = 0;  // of the line in view; lines that it takes in the file
  Vec3 vertex_ = Vec3::Zero();
};

struct ObjReading {
  const lua::MeshFile& file;
  Lines& lines;
  Builder& builder;
  std::vector<std::uint32_t> corners = {};
};

void take_vertex(void* user_data, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t) {
  auto& r = *static_cast<ObjReading*>(user_data);
  r.builder.add_vertex(r.lines.vertex());
}

// Counts from 1, or from -1 backwards.
void take_face(void* user_data, tinyobj::index_t* indices, int count) {
  auto& r = *static_cast<ObjReading*>(user_data);
  r.corners.clear();
  const auto known = static_cast<std::int64_t>(r.builder.vertex_count());
  for (int i = 0; i < count; ++i) {
    const std::int64_t given = indices[i].vertex_index, index = given < 0 ? known + given : given - 1;
    if (index < 0 || index >= known)
      fail_file(r.file, "names vertex " + std::to_string(given) + "; there are " + std::to_string(known) + " so far",
                r.lines.number());
    r.corners.push_back(static_cast<std::uint32_t>(index));
  }
  r.builder.add_polygon(r.corners);
}

}  // namespace

void read_obj(const lua::MeshFile& file, Builder& builder) {
  Lines lines(file);
  std::istream stream(&lines);
  stream.exceptions(std::ios::badbit);  // or errors of a line would end in the stream
  ObjReading reading{file, lines, builder};
  tinyobj::callback_t callback;
  callback.vertex_cb = take_vertex;
  callback.index_cb = take_face;
  std::string warning, error;
  if (!tinyobj::LoadObjWithCallback(stream, callback, &reading, nullptr, &warning, &error))
    fail_file(file, error.empty() ? "cannot be read" : error);
}

}  // namespace feder::meshes
