// The records of one table of a store as lines of text.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "hal/store/store.hpp"

namespace ilp::store_tool {

/// A line with the names of the fields, then a line for each record in the order of ids; the values are separated by
/// tabs. Named values are given by their names, an array by its values with commas between them, a blob by its size in
/// bytes. All fields where `fields` is empty. Returns the number of records that are damaged and left out. Throws
/// std::runtime_error for a table or field that does not exist and for a fault of the store.
std::int64_t print_rows(Store& store, const std::string& table, const std::vector<std::string>& fields,
                        std::ostream& out);

}  // namespace ilp::store_tool
