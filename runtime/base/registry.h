// Options that tables of variants (feder/params.h) take: which row, and what each row reads.
#pragma once
#include "feder/memory.h"
#include "feder/params.h"

namespace feder {

// The options of each row of the table, as its maker reads them: `of` is the row's name.
template <class T>
std::vector<OptionInfo> variant_options(std::span<const Variant<T>> table) {
  std::vector<OptionInfo> all;
  for (const Variant<T>& row : table) {
    Arena arena("reference");
    const Params none;
    row.make(arena, none);
    for (OptionInfo& info : none.rows()) info.of = row.name, all.push_back(std::move(info));
  }
  return all;
}

// The row of the table that an option names: `name` when it is absent, as above.
template <class Row>
const Row& variant_option(const Params& options, const OptionRow& row, std::span<const Row> table,
                          std::string_view name, const char* what) {
  return find_variant(table, options.text(row, default_variant(table, name), variant_names(table)), what);
}

}  // namespace feder
