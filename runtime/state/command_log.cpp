#include "state/command_log.h"

namespace feder {

void CommandLog::add_name(const char* name, const std::string& signature) {
  items_.whole(static_cast<std::uint64_t>(LogItem::name));
  items_.text(name), items_.text(signature);
  names_.emplace(name, names_.size());
}

void CommandLog::close(const char* name) {
  items_.whole(static_cast<std::uint64_t>(LogItem::command));
  items_.whole(names_.find(name)->second);
  items_.text(arguments_.bytes());
}

void CommandLog::add_forces(const double* numbers, std::size_t count) {
  items_.whole(static_cast<std::uint64_t>(LogItem::forces));
  items_.whole(count);
  for (std::size_t k = 0; k < count; ++k) items_.number(numbers[k]);
}

void CommandLog::add_step(const std::uint64_t* hash) {
  items_.whole(static_cast<std::uint64_t>(LogItem::step));
  items_.whole(hash != nullptr);
  if (hash) items_.whole(*hash);
}

void CommandLog::add_note(std::string_view kind, std::string_view text) {
  items_.whole(static_cast<std::uint64_t>(LogItem::note));
  items_.text(kind), items_.text(text);
}

}  // namespace feder
