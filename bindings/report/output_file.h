// A file that is written in one go: into a side file beside it, renamed when all of it is there, so that a stop, a
// crash or a full disk leaves what was there before. What is there and is no plain file (device, pipe, link) is written
// as it is.
#pragma once
#include <filesystem>
#include <fstream>
#include <string>

namespace feder::report {

class OutputFile {
 public:
  // std::runtime_error "file: cannot be written: why", here and in close().
  explicit OutputFile(std::filesystem::path file);
  ~OutputFile();  // without close() nothing is left
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::ofstream& stream() { return out_; }
  void close();

 private:
  std::filesystem::path file_, side_;  // the same where there is no side file
  std::ofstream out_;
};

// Is it none there, or a plain file? Else nothing can stand beside it and take its place.
bool is_replaceable(const std::filesystem::path& file);
// "file.1234.part": of this process alone, in the same folder.
std::filesystem::path side_file(const std::filesystem::path& file);
[[noreturn]] void fail_to_write(const std::filesystem::path& file);  // says why, by errno

// The whole text.
void write_text(const std::string& file, const std::string& text);

}  // namespace feder::report
