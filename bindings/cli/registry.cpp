#include "cli/command.h"

namespace feder::cli {

#include "cli_declare.inc"

std::span<const Row> commands() {
  static const Row rows[] = {
#include "cli_rows.inc"
  };
  return rows;
}

}  // namespace feder::cli
