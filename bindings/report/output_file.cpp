#include "report/output_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace feder::report {

namespace fs = std::filesystem;

bool is_replaceable(const fs::path& file) {
  std::error_code ignored;
  const fs::file_status status = fs::symlink_status(file, ignored);
  return !fs::exists(status) || fs::is_regular_file(status);
}

fs::path side_file(const fs::path& file) { return fmt::format("{}.{}.part", file.string(), getpid()); }

void fail_to_write(const fs::path& file) {
  const int why = errno;
  throw std::runtime_error(file.string() + ": cannot be written" + (why ? std::string(": ") + std::strerror(why) : ""));
}

OutputFile::OutputFile(fs::path file)
    : file_(std::move(file)), side_(is_replaceable(file_) ? side_file(file_) : file_) {
  errno = 0;
  // a file that must not be written is not replaced either
  std::error_code ignored;
  if (side_ != file_ && fs::exists(file_, ignored) && access(file_.c_str(), W_OK) != 0) fail_to_write(file_);
  out_.open(side_, std::ios::binary | std::ios::trunc);
  if (!out_) fail_to_write(file_);
}

OutputFile::~OutputFile() {
  if (!out_.is_open()) return;
  out_.close();
  std::error_code ignored;
  if (side_ != file_) fs::remove(side_, ignored);
}

void OutputFile::close() {
  std::error_code error;
  errno = 0;
  out_.close();
  if (out_ && side_ != file_) {
    if (fs::exists(file_, error)) fs::permissions(side_, fs::status(file_).permissions(), error);  // those stay
    fs::rename(side_, file_, error);
  }
  if (out_ && !error) return;
  if (error) errno = error.value();
  const int why = errno;
  if (side_ != file_) fs::remove(side_, error);
  errno = why;
  fail_to_write(file_);
}

void write_text(const std::string& file, const std::string& text) {
  OutputFile out(file);
  out.stream() << text;
  out.close();
}

}  // namespace feder::report
