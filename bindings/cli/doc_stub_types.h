// Types of LuaCATS by the words of signatures and rows.
#pragma once
#include <map>
#include <string>
#include <vector>

namespace feder::cli {

// Of names of arguments and results; null where the name says nothing.
const std::string* stub_type_of_name(const std::string& name);
// Of the types of rows, where a script writes them otherwise: "number[]" for "vector"; null for others.
const std::string* stub_type_of_row(const std::string& type);
// Of an argument "title(argument)" whose name says too little: what a handler gets. Null for others.
const std::string* stub_type_of_argument(const std::string& title, const std::string& argument);
// One table in place of the arguments from its name on: "limits: number[]" of joint:set_limits. Null for others.
const std::string* stub_table_form(const std::string& title);

// "number", "table" ...: what needs no declaration.
bool is_plain_type(const std::string& type);
// "feder.Body" of "body", "feder.ContactBeginEvent" of "contact_begin" with "Event" behind.
std::string stub_class(const std::string& word, const char* behind = "");
std::string join_types(const std::string& a, const std::string& b);  // "a|b", each type once
// At commas or bars that stand in no braces, parentheses or quotes, without blanks around.
std::vector<std::string> split_top(const std::string& text, char at);

}  // namespace feder::cli
