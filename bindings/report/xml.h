// Text for XML and HTML, and numbers for drawings with a fixed format, so that equal data gives equal bytes.
#pragma once
#include <string>
#include <string_view>

namespace feder::report {

// Escapes & < > and both quotes. XML 1.0 knows few control characters; the others, and bytes that are no UTF-8, become
// '?'. A line feed or tab stays what it is when `keep_lines`, and becomes a character reference otherwise.
std::string xml_escape(std::string_view text, bool keep_lines = false);

// A length of a drawing: two decimals, no trailing zeros, never "-0"; not finite: "0".
std::string px(double value);

// A value for a reader: `digits` significant ones, 1.2e-05 as "1.2e-5"; "inf", "nan".
std::string number_text(double value, int digits = 3);

}  // namespace feder::report
