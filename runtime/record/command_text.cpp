// Goes through the arguments by the letters of the signature (state/command_codec.h).
#include "record/command_text.h"

namespace feder {
namespace {

constexpr std::uint64_t kMaxListed = 4;

class TextReader {
 public:
  TextReader(std::string_view arguments, const Objects& objects) : in_(shapes_), objects_(objects) {
    in_.read_from(arguments);
  }

  // The argument whose letters begin at `s`, which is moved behind them. Not kept: `out` null.
  void read(std::string_view& s, std::string* out) {
    const char letter = s[0];
    s.remove_prefix(1);
    switch (letter) {
      case 'b': return put(out, in_.whole() ? "true" : "false");
      case 'u': return put(out, std::to_string(in_.whole()));
      case 'i': return put(out, std::to_string(signed_whole()));
      case 'n': return put(out, print_number(in_.number()));
      case 't':
      case 'c': return put(out, '"' + in_.text() + '"');
      case 'o': return object(out);
      case 'v': return numbers(3, out);
      case 'q': return numbers(4, out);
      case 'p': return numbers(7, out);
      case 's': return shape(out);
      case 'S': return content(out);
      case '?': {
        if (in_.whole()) return read(s, out);
        s.remove_prefix(1);
        return put(out, "nil");
      }
      case '*': return list(s, out);
      case 'm': return options(out);
      case '{': return fields(s, out);
      default: throw SceneError("recording: a signature has the unknown letter '" + std::string(1, letter) + "'");
    }
  }

 private:
  static void put(std::string* out, const std::string& text) {
    if (out) *out += text;
  }

  std::int64_t signed_whole() {
    std::int64_t x = 0;
    command::read(in_, x);
    return x;
  }

  void object(std::string* out) {
    ObjectId id;
    command::read(in_, id);
    if (out) *out += id ? objects_.describe(id) : "none";
  }

  void numbers(int count, std::string* out) {
    std::string text = "(";
    for (int k = 0; k < count; ++k) text += (k ? ", " : "") + print_number(in_.number());
    put(out, text + ")");
  }

  // Its kind where it is new; numbers of known ones mean nothing to a reader of one line.
  void shape(std::string* out) {
    const std::uint64_t number = in_.whole();
    if (number > 0) return put(out, "shape #" + std::to_string(number));
    if (in_.whole() == 0) return put(out, "nil");
    content(out);
  }

  void content(std::string* out) {
    put(out, in_.text());
    const auto pass = [&](std::string_view letters) {
      while (!letters.empty()) read(letters, nullptr);
    };
    pass("*nv*v*u");
    for (std::uint64_t n = in_.count(); n > 0; --n) shape(nullptr), pass("pu");
    pass("*{nnnnbvt}*u{tttu}t");
  }

  void list(std::string_view& s, std::string* out) {
    const std::uint64_t count = in_.count();
    put(out, "[");
    std::string_view behind = s;
    for (std::uint64_t k = 0; k < count; ++k) {
      behind = s;
      if (s[0] == 'm') in_.text();  // its name
      if (k < kMaxListed && k > 0) put(out, ", ");
      read(behind, k < kMaxListed ? out : nullptr);
    }
    if (count > kMaxListed) put(out, ", ... " + std::to_string(count) + " in all");
    if (count == 0) skip(behind);
    s = behind;
    put(out, "]");
  }

  // Behind the letters of one argument.
  static void skip(std::string_view& s) {
    int depth = 0;
    do {
      const char letter = s[0];
      s.remove_prefix(1);
      depth += letter == '{' ? 1 : letter == '}' ? -1 : 0;
      if (letter == '*' || letter == '?') {
        skip(s);
        if (depth == 0) return;
      }
    } while (depth > 0);
  }

  void options(std::string* out) {
    static constexpr std::string_view kLetters[] = {"b", "n", "t", "*n"};
    put(out, "{");
    for (std::uint64_t n = in_.count(); n > 0; --n) {
      put(out, " " + in_.text() + " = ");
      const std::uint64_t kind = in_.whole();
      if (kind >= std::size(kLetters)) throw SceneError("recording: an option is of an unknown type");
      std::string_view letters = kLetters[kind];
      read(letters, out);
    }
    put(out, " }");
  }

  void fields(std::string_view& s, std::string* out) {
    put(out, "{");
    for (bool first = true; s[0] != '}'; first = false) {
      if (!first) put(out, ", ");
      read(s, out);
    }
    s.remove_prefix(1);
    put(out, "}");
  }

  std::vector<ShapePtr> shapes_;
  CommandReader in_;
  const Objects& objects_;
};

}  // namespace

std::string command_text(const std::string& name, const std::string& signature, std::string_view arguments,
                         const Objects& objects) {
  std::string out = name;
  TextReader reader(arguments, objects);
  std::string_view rest = signature;
  for (bool first = true; !rest.empty(); first = false) {
    out += first ? " " : ", ";
    reader.read(rest, &out);
  }
  return out;
}

}  // namespace feder
