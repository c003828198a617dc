// Line coverage. Lines that have run come from the line hook. Lines with code come from the binary form of the chunk
// (lua_dump, Lua 5.4: ldump.c), since Lua tells them of functions that have been made only.
#include "lua/coverage.h"

#include <cstring>

#include "lua/library.h"

namespace feder::lua {
namespace {

// Reads a dumped chunk, which this process has just written.
class Chunk {
 public:
  Chunk(std::string_view bytes, LineCounts& lines) : in_(bytes), lines_(lines) {}

  void read() {
    skip(4 + 1 + 1 + 6 + 3 + sizeof(lua_Integer) + sizeof(lua_Number) + 1);  // header, number of upvalues
    function();
  }

 private:
  static constexpr signed char kAbsolute = -128;  // a line too far for a byte: it is in a list of its own

  void skip(std::size_t n) { at_ = std::min(in_.size(), at_ + n); }
  unsigned char byte() { return at_ < in_.size() ? static_cast<unsigned char>(in_[at_++]) : 0x80; }
  // 7 bits a byte, the last one marked
  std::size_t number() {
    std::size_t x = 0;
    for (;;) {
      const unsigned char b = byte();
      x = x << 7 | (b & 0x7fu);
      if (b & 0x80u) return x;
    }
  }
  void text() {
    if (const std::size_t size = number()) skip(size - 1);
  }
  template <class F>
  void list(F&& one) {
    for (std::size_t n = number(); n > 0 && at_ < in_.size(); --n) one();
  }

  void constant() {
    switch (byte() & 0x3f) {
      case LUA_TNUMBER:
      case LUA_TNUMBER | 0x10: skip(8); break;
      case LUA_TSTRING:
      case LUA_TSTRING | 0x10: text(); break;
      default: break;
    }
  }

  void function() {
    text();
    const auto first = static_cast<int>(number());
    number();  // last line
    byte();
    const bool variadic = byte() != 0;
    byte();
    skip(number() * 4);  // instructions
    list([&] { constant(); });
    skip(number() * 3);  // upvalues
    list([&] { function(); });
    lines(first, variadic);
    list([&] { text(), number(), number(); });  // local variables
    list([&] { text(); });                      // names of upvalues
  }

  void lines(int line, bool variadic) {
    const std::size_t count = number();
    const std::string_view steps = in_.substr(at_, count);
    skip(count);
    std::vector<std::pair<std::size_t, int>> absolute;
    list([&] {
      const std::size_t pc = number();
      absolute.emplace_back(pc, static_cast<int>(number()));
    });
    std::size_t next = 0;
    for (std::size_t pc = 0; pc < steps.size(); ++pc) {
      const auto step = static_cast<signed char>(steps[pc]);
      if (step != kAbsolute)
        line += step;
      else if (next < absolute.size())
        line = absolute[next++].second;
      // the first instruction of a variadic function belongs to no line of its own
      if (pc > 0 || !variadic) lines_.try_emplace(line, 0);
    }
  }

  std::string_view in_;
  std::size_t at_ = 0;
  LineCounts& lines_;
};

}  // namespace

void cover_chunk(lua_State* L, const std::filesystem::path& file) {
  State& s = state(L);
  if (!s.options.coverage) return;
  const std::string path = file.lexically_normal().generic_string();
  s.covered_files[chunk_name(file)] = path;
  std::string bytes;
  const auto add = [](lua_State*, const void* block, std::size_t size, void* to) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(block), size);
    return 0;
  };
  lua_dump(L, add, &bytes, 0);
  Chunk(bytes, (*s.options.coverage)[path]).read();
}

void cover_line(lua_State* L, lua_Debug* at) {
  State& s = state(L);
  lua_getinfo(L, "S", at);
  const auto file = s.covered_files.find(std::string_view(at->source).substr(at->source[0] == '@'));
  if (file != s.covered_files.end()) ++(*s.options.coverage)[file->second][at->currentline];
}

}  // namespace feder::lua
