// Blocks of a recording: a letter, the length of what follows, the bytes, and a checksum over all of it.
#pragma once
#include <string>
#include <string_view>

namespace feder::recording {

inline constexpr char kHeader = 'H';  // scalar type, facts
inline constexpr char kFacts = 'F';   // more of them
inline constexpr char kWorld = 'W';   // its number and description
inline constexpr char kItems = 'I';   // the number of its world, the steps in it, items of a command log
inline constexpr char kEnd = 'E';     // how it ended, and the number of blocks

// The line that a recording begins with.
std::string first_line();
std::string block(char kind, std::string_view content);

struct Block {
  char kind = 0;
  std::string_view content;
};

// Goes through the blocks behind the first line. SceneError: not a recording, of another format, damaged or truncated.
class Blocks {
 public:
  explicit Blocks(std::string_view bytes);
  bool at_end() const { return rest_.empty(); }
  Block next();
  std::size_t count() const { return count_; }  // read so far

 private:
  std::string_view rest_;
  std::size_t count_ = 0, total_ = 0;
};

}  // namespace feder::recording
