// Prints the records of one table of a store as lines of text.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "hal/store/store.hpp"

namespace ilp::store_tool {

/// Prints a line with the names of the fields, then a line per record in the order of ids. Values are separated by
/// tabs. Enumerated values are printed as names, arrays with commas, and blobs as their size in bytes. An empty
/// `fields` means all fields. Returns the number of damaged records, which are left out. Throws std::runtime_error for
/// an unknown table or field, and for a fault of the store.
std::int64_t print_rows(Store& store, const std::string& table, const std::vector<std::string>& fields,
                        std::ostream& out);

}  // namespace ilp::store_tool
