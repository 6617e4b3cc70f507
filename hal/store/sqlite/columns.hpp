// Converts a record to a row of its table and back: the columns of its fields, followed by its checksum.
#pragma once

#include "fsw/records/field.hpp"

struct sqlite3_stmt;

namespace ilp {

/// Binds the values of all columns, beginning at the statement's first parameter.
void bind_record(sqlite3_stmt* statement, const RecordInfo& info, const void* record);
/// Reads the current row. Returns false if a value does not fit its field, or if the checksum is wrong; the content of
/// `record` is then invalid.
[[nodiscard]] bool read_record(sqlite3_stmt* statement, const RecordInfo& info, void* record);

}  // namespace ilp
